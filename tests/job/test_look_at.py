"""Poses by the point that the tip looks at: cameras, torches, spray guns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mafsil.errors import JobError
from mafsil.job import parse_job
from mafsil.job.language.units import facing
from mafsil.job.solve import prepare

HEAD = 'robot = "ur5e"\n{top}\n[start]\njoints = [0, -1.57, 1.57, -1.57, -1.57, 0]\n'
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
    text = HEAD.format(top=top) + move
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
