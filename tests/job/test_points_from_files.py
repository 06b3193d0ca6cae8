"""Places from CSV files, splines through them, loops over them; poses that look at a point."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mafsil as mf
from mafsil.errors import FileError, JobError, MafsilError
from mafsil.geometry import rotation
from mafsil.job import parse_job
from mafsil.job.language.units import facing
from mafsil.job.solve import prepare

HEAD = 'robot = "ur5e"\n{top}\n[start]\njoints = {start}\n[pattern.seam]\n{pattern}\n'
START = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]
SPLINE = '[[move]]\npose = { position = [0.4, -0.1, 0.3], rpy = %s }\n[[move]]\npath = "spline"\nthrough = "seam"\n'
POINTS = np.array([[0.42, 0.0, 0.3], [0.45, 0.1, 0.32], [0.42, 0.2, 0.3], [0.4, 0.25, 0.28]])
DOWN = [np.pi, 0.0, 0.0]


def written(path: Path, points: np.ndarray, head: str = "x,y,z") -> None:
    np.savetxt(path, points, delimiter=",", header=head, comments="")


def legs(text: str, folder: Path):
    found = prepare(parse_job(text, folder=folder), text, folder)
    assert isinstance(found, tuple), found
    return found[1].legs


def passes(leg, points: np.ndarray) -> float:
    """The largest distance of a point from the way of the tip [m]."""
    t = np.linspace(0.0, leg.trajectory.duration, 4001)
    way = np.asarray(leg.load.robot.forward_kinematics(leg.trajectory.at(t).u))[:, :3, 3]
    return float(np.linalg.norm(way[:, None] - points, axis=2).min(axis=0).max())


@pytest.mark.parametrize(
    ("top", "unit", "angle"), [("", 1.0, 1.0), ('angles = "degrees"\nlengths = "millimetres"', 1e3, 180 / np.pi)]
)
def test_a_spline_passes_through_the_rows_of_a_file(top: str, unit: float, angle: float, tmp_path: Path) -> None:
    written(tmp_path / "seam.csv", unit * POINTS)
    turn = (angle * np.array(DOWN)).tolist()
    text = HEAD.format(top=top, start=(angle * np.array(START)).tolist(), pattern=f'file = "seam.csv"\nrpy = {turn}')
    text += (SPLINE % turn).replace("[0.4, -0.1, 0.3]", str((unit * np.array([0.4, -0.1, 0.3])).tolist()))
    leg = legs(text, tmp_path)[1]
    assert leg.kind == "spline"
    assert passes(leg, POINTS) < 1e-4
    end = np.asarray(leg.load.robot.forward_kinematics(leg.trajectory.at(leg.trajectory.duration).u))
    np.testing.assert_allclose(end[:3, 3], POINTS[-1], atol=1e-6)
    np.testing.assert_allclose(end[:3, :3], rotation.from_rpy(np.array(DOWN)), atol=1e-6)


def test_a_spline_may_begin_where_a_line_to_its_first_row_has_ended(tmp_path: Path) -> None:
    written(tmp_path / "seam.csv", POINTS)
    text = HEAD.format(top="", start=START, pattern=f'file = "seam.csv"\nrpy = {DOWN}') + SPLINE % DOWN
    to_it = f'[[move]]\npath = "line"\npose = {{ position = {POINTS[0].tolist()} }}\n'
    first, second = text.rsplit("[[move]]", 1)
    way = legs(first + to_it + "[[move]]" + second, tmp_path)[-2]
    assert way.kind == "spline"
    assert passes(way, POINTS) < 1e-4


def test_rows_stand_in_the_frame_of_the_pattern_and_may_turn(tmp_path: Path) -> None:
    yaw = [0.0, 0.2, 0.4, 0.6]
    angles = np.column_stack([np.full(4, np.pi), np.zeros(4), yaw])
    written(tmp_path / "seam.csv", np.column_stack([POINTS - [0.4, 0.0, 0.1], angles]), "x,y,z,roll,pitch,yaw")
    top = "[frame.table]\nposition = [0.4, 0.0, 0.1]"
    leg = legs(
        HEAD.format(top=top, start=START, pattern='file = "seam.csv"\nframe = "table"') + SPLINE % DOWN, tmp_path
    )[1]
    assert passes(leg, POINTS) < 1e-4
    end = np.asarray(leg.load.robot.forward_kinematics(leg.trajectory.at(leg.trajectory.duration).u))
    np.testing.assert_allclose(end[:3, :3], rotation.from_rpy(angles[-1]), atol=1e-6)


def test_a_loop_goes_to_every_row(tmp_path: Path) -> None:
    written(tmp_path / "holes.csv", POINTS)
    loop = '[[move]]\neach = "seam"\n[[move.do]]\npose = { frame = "seam", position = [0, 0, 0] }\n'
    found = legs(HEAD.format(top="", start=START, pattern=f'file = "holes.csv"\nrpy = {DOWN}') + loop, tmp_path)
    ends = [
        np.asarray(leg.load.robot.forward_kinematics(leg.trajectory.at(leg.trajectory.duration).u))[:3, 3]
        for leg in found
        if leg.target is not None
    ]
    np.testing.assert_allclose(ends, POINTS, atol=1e-6)


def test_a_cell_in_another_folder_has_its_file_beside_it(tmp_path: Path) -> None:
    (tmp_path / "cells").mkdir()
    written(tmp_path / "cells" / "seam.csv", POINTS)
    (tmp_path / "cells" / "cell.toml").write_text(f'[pattern.seam]\nfile = "seam.csv"\nrpy = {DOWN}\n')
    text = f'robot = "ur5e"\ninclude = "cells/cell.toml"\n[start]\njoints = {START}\n' + SPLINE % DOWN
    assert passes(legs(text, tmp_path)[1], POINTS) < 1e-4


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (None, "absent.csv"),
        ("x,y\n1,2\n", "z"),
        ("x,y,z\n0.4,0.1\n", "line 2"),
        ("x,y,z\n0.4,0.1,up\n", "up"),
        ("x,y,z,roll\n0.4,0.1,0.3,0\n", "pitch"),
        ("x,y,z\n", ""),
    ],
)
def test_a_file_that_is_no_table_of_places_is_refused_by_name(rows: str | None, said: str, tmp_path: Path) -> None:
    name = "absent.csv" if rows is None else "seam.csv"
    if rows is not None:
        (tmp_path / name).write_text(rows)
    with pytest.raises(FileError, match=said) as caught:
        legs(HEAD.format(top="", start=START, pattern=f'file = "{name}"') + SPLINE % DOWN, tmp_path)
    assert name in str(caught.value)


@pytest.mark.parametrize(
    ("pattern", "move", "key"),
    [
        ('file = "seam.csv"\ncount = [2]\npitch = [0.1]', SPLINE, "job.pattern_file"),
        ('order = "rows"', SPLINE, "job.pattern_pitch"),
        ('file = "seam.csv"', SPLINE.replace('path = "spline"\n', ""), "job.through"),
        ('file = "seam.csv"', SPLINE.replace('through = "seam"', 'through = "rim"'), "job.unknown_name"),
        ('file = "one.csv"', SPLINE, "job.through"),
        ('file = "seam.csv"', SPLINE.replace('through = "seam"', 'through = "seam"\nvia = ["a"]'), "job.through"),
    ],
)
def test_what_asks_for_two_things_is_refused(pattern: str, move: str, key: str, tmp_path: Path) -> None:
    written(tmp_path / "seam.csv", POINTS)
    written(tmp_path / "one.csv", POINTS[:1])
    text = HEAD.format(top="", start=START, pattern=pattern) + move % DOWN
    with pytest.raises(JobError) as caught:
        parse_job(text, folder=tmp_path)
    assert caught.value.key == key


def test_the_whole_job_runs(tmp_path: Path) -> None:
    written(tmp_path / "seam.csv", POINTS)
    text = HEAD.format(top="", start=START, pattern=f'file = "seam.csv"\nrpy = {DOWN}') + SPLINE % DOWN
    (tmp_path / "job.toml").write_text(text)
    try:
        run = mf.job.solve_file(tmp_path / "job.toml", plant="kinematic")
    except MafsilError as fault:
        pytest.fail(str(fault))
    assert run


LOOK = 'robot = "ur5e"\n{top}\n[start]\njoints = [0, -1.57, 1.57, -1.57, -1.57, 0]\n'
coordinate = st.floats(-3.0, 3.0)


@given(st.tuples(coordinate, coordinate, coordinate).filter(lambda d: np.linalg.norm(d) > 1e-3))
def test_z_points_there_and_x_is_level(direction: tuple[float, float, float]) -> None:
    R = facing(np.array(direction))
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)
    np.testing.assert_allclose(R[:, 2], direction / np.linalg.norm(direction), atol=1e-12)
    assert abs(R[2, 0]) < 1e-9
    assert R[2, 1] <= 1e-9  # y never looks up


def reached(move: str, top: str = "") -> np.ndarray:
    text = LOOK.format(top=top) + move
    found = prepare(parse_job(text), text, Path())
    assert isinstance(found, tuple)
    leg = found[1].legs[0]
    return np.asarray(leg.load.robot.forward_kinematics(leg.trajectory.at(leg.trajectory.duration).u))


@pytest.mark.parametrize(
    ("top", "pose"),
    [
        ("", "position = [0.45, 0.2, 0.5], look_at = [0.6, 0.3, 0.0]"),
        ('lengths = "millimetres"', "position = [450, 200, 500], look_at = [600, 300, 0]"),
        (
            "[frame.desk]\nposition = [0.4, 0.1, 0.1]",
            'position = [0.05, 0.1, 0.4], look_at = [0.2, 0.2, -0.1], frame = "desk"',
        ),
        ("[pose.here]\nposition = [0.45, 0.2, 0.5]\nlook_at = [0.6, 0.3, 0.0]", None),
    ],
)
def test_a_move_ends_where_it_looks_at_the_point(top: str, pose: str | None) -> None:
    goal = '"here"' if pose is None else f"{{ {pose} }}"
    T = reached(f"[[move]]\npose = {goal}\n", top)
    np.testing.assert_allclose(T[:3, 3], [0.45, 0.2, 0.5], atol=1e-6)
    to = np.array([0.6, 0.3, 0.0]) - T[:3, 3]
    np.testing.assert_allclose(T[:3, 2], to / np.linalg.norm(to), atol=1e-6)


def test_an_axis_alone_is_enough() -> None:
    T = reached('[[move]]\npose = { position = [0.45, 0.2, 0.5], look_at = [0.6, 0.3, 0.0], task = "axis" }\n')
    to = np.array([0.6, 0.3, 0.0]) - T[:3, 3]
    np.testing.assert_allclose(T[:3, 2], to / np.linalg.norm(to), atol=1e-6)


@pytest.mark.parametrize(
    ("pose", "key"),
    [
        ("position = [0.4, 0.2, 0.5], look_at = [0.4, 0.2, 0.5]", "job.look_at"),
        ("position = [0.4, 0.2, 0.5], look_at = [0.6, 0.2, 0.5], rpy = [0, 0, 0]", "job.two_orientations"),
        ('position = [0, 0, 0.1], look_at = [0.6, 0.2, 0.5], relative = "tool"', "job.look_at"),
        ('position = [0.4, 0.2, 0.5], look_at = [0.6, 0.2, 0.5], task = "position"', "job.free_orientation"),
        ("position = [0.4, 0.2, 0.5], look_at = [0.6, 0.2]", "job.length"),
        ("position = [0.4, 0.2, 0.5], look_at = [0.6, 0.2, nan]", "job.not_finite"),
    ],
)
def test_what_says_no_direction_is_refused(pose: str, key: str) -> None:
    with pytest.raises(JobError) as caught:
        reached(f"[[move]]\npose = {{ {pose} }}\n")
    assert caught.value.key == key
