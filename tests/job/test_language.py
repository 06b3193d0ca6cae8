"""The language of job files against jobs that say the same in plain moves, and its mistakes with their lines."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from mafsil.errors import JobError
from mafsil.geometry import rotation
from mafsil.job.language import description, statements
from mafsil.job.language.reading import parse_job
from mafsil.job.language.units import LENGTHS, goal_matrix, pose_matrix
from tests.job.test_job_planning import planned

HEAD = 'robot = "panda"\n'


def ends_of(plan):
    return np.array([leg.trajectory.at(leg.trajectory.duration).u for leg in plan.legs])


def poses(job):
    degrees = job.angles == "degrees"
    return [pose_matrix(move.pose, degrees=degrees) for move in job.move if move.pose is not None]


def test_frames_in_frames_are_products_of_poses():
    rng = np.random.default_rng(0)
    p, a = rng.uniform(-1, 1, (3, 3)), rng.uniform(-1, 1, (3, 3))
    job = parse_job(
        HEAD
        + f"""
[frame.cell]
position = {p[0].tolist()}
rpy = {a[0].tolist()}
[frame.part]
frame = "cell"
position = {p[1].tolist()}
rpy = {a[1].tolist()}
[[move]]
pose = {{ frame = "part", position = {p[2].tolist()}, rpy = {a[2].tolist()} }}
[[move]]
pose = {{ frame = "part" }}
[[move]]
pose = {{ frame = "part", position = [0, 0, 0.1], task = "position" }}
[[obstacle]]
frame = "cell"
sphere = 0.01
"""
    )
    T = [np.eye(4) for _ in range(3)]
    for each, place, angle in zip(T, p, a, strict=True):
        each[:3, :3], each[:3, 3] = rotation.from_rpy(angle), place
    found = poses(job)
    np.testing.assert_allclose(found[0], T[0] @ T[1] @ T[2], atol=1e-12)
    np.testing.assert_allclose(found[1], T[0] @ T[1], atol=1e-12)
    assert job.move[2].pose.quaternion is None
    np.testing.assert_allclose(job.move[2].pose.position, (T[0] @ T[1] @ [0, 0, 0.1, 1])[:3], atol=1e-12)
    np.testing.assert_allclose(pose_matrix(job.obstacle[0], degrees=False), T[0], atol=1e-12)


def test_displacements_are_along_the_axes_that_are_named():
    job = parse_job(
        HEAD
        + """
angles = "degrees"
[frame.table]
rpy = [0, 0, 90]
[[move]]
pose = { relative = "tool", position = [0, 0, 0.1], rpy = [0, 0, 30] }
[[move]]
pose = { relative = "space", position = [0, 0, 0.1] }
[[move]]
pose = { relative = "table", position = [0.1, 0, 0], rpy = [20, 0, 0] }
"""
    )
    here = np.eye(4)
    here[:3, :3], here[:3, 3] = rotation.from_rpy([3.0, 0.2, -0.4]), [0.4, 0.1, 0.3]
    tool, space, table = (goal_matrix(move.pose, here, degrees=True) for move in job.move)
    turn = np.eye(4)
    turn[:3, :3], turn[:3, 3] = rotation.from_rpy(np.radians([0, 0, 30])), [0, 0, 0.1]
    np.testing.assert_allclose(tool, here @ turn, atol=1e-12)
    np.testing.assert_allclose(space[:3, 3], [0.4, 0.1, 0.4], atol=1e-12)
    np.testing.assert_allclose(space[:3, :3], here[:3, :3], atol=1e-12)
    np.testing.assert_allclose(table[:3, 3], [0.4, 0.2, 0.3], atol=1e-12)
    about_y = rotation.from_rpy(np.radians([0, 20, 0]))
    np.testing.assert_allclose(table[:3, :3], about_y @ here[:3, :3], atol=1e-12)


def test_a_pallet_is_its_places_in_order():
    text = (
        HEAD
        + """
[frame.table]
position = [0.4, 0.1, 0.0]
rpy = [0, 0, 0.5]
[pattern.pallet]
frame = "table"
position = [0, 0, 0.02]
count = [3, 2, 2]
pitch = [0.07, 0.06, 0.05]
order = "{order}"
[[move]]
each = "pallet"
do = [ {{ name = "over", pose = {{ frame = "pallet", position = [0, 0, 0.1] }} }}, {{ pose = {{ frame = "pallet" }} }} ]
"""
    )
    T = pose_matrix(description.Pose(position=(0.4, 0.1, 0.0), rpy=(0, 0, 0.5)), degrees=False)
    for order in ("rows", "snake"):
        job = parse_job(text.format(order=order))
        assert len(job.move) == 24
        expected = []
        for row, (k, j) in enumerate([(0, 0), (0, 1), (1, 0), (1, 1)]):
            columns = range(3) if order == "rows" or row % 2 == 0 else reversed(range(3))
            expected += [((i, j, k), T @ [0.07 * i, 0.06 * j, 0.02 + 0.05 * k, 1]) for i in columns]
        for (index, place), over, down in zip(expected, job.move[::2], job.move[1::2], strict=True):
            np.testing.assert_allclose(down.pose.position, place[:3], atol=1e-12)
            np.testing.assert_allclose(over.pose.position, place[:3] + np.array([0, 0, 0.1]), atol=1e-12)
            label = "pallet " + ",".join(str(k + 1) for k in index)
            assert (over.name, down.name) == (f"over ({label})", label)


def test_loops_in_loops_and_patterns_side_by_side():
    job = parse_job(
        HEAD
        + """
[configuration]
home = [0, -0.3, 0, -2.2, 0, 2, 0.8]
[pose.high]
position = [0.4, 0, 0.6]
rpy = [3.14, 0, 0]
[pattern.source]
position = [0.4, 0.2, 0.1]
count = [2]
pitch = [0.1]
[pattern.target]
position = [0.4, -0.2, 0.1]
count = [1, 2]
pitch = [0.1, 0.05]
[[move]]
repeat = 2
[[move.do]]
each = ["source", "target"]
[[move.do.do]]
pose = { frame = "source" }
[[move.do.do]]
pose = { frame = "target" }
[[move.do]]
joints = "home"
[[move]]
pose = "high"
"""
    )
    places = [move.pose.position if move.pose else "home" for move in job.move]
    once = [(0.4, 0.2, 0.1), (0.4, -0.2, 0.1), (0.5, 0.2, 0.1), (0.4, -0.15, 0.1), "home"]
    assert len(places) == 11
    for found, expected in zip(places, [*once, *once, (0.4, 0, 0.6)], strict=True):
        assert found == expected if expected == "home" else np.allclose(found, expected, atol=1e-12)
    assert job.move[4].joints == (0, -0.3, 0, -2.2, 0, 2, 0.8)
    assert job.move[2].name == "source 2 target 1,2"
    assert job.origins[4] == ("move", 0, "do", 1)
    assert job.origins[-1] == ("move", 1)


MILLIMETRES = """
robot = "{robot}"
lengths = "{unit}"
[tool]
mass = 0.1
com = [0, 0, {small}]
offset = {{ position = [0, 0, {small}] }}
[limits]
tip_speed = {speed}
[tolerance]
position = {tolerance}
[collision]
clearance = {tolerance}
[[obstacle]]
box = [{small}, {small}, {small}]
position = [{far}, 0, 0]
[pattern.row]
position = [{x}, 0, {z}]
rpy = [3.141592653589793, 0, 0]
count = [2]
pitch = [{pitch}]
[[move]]
each = "row"
[[move.do]]
pose = {{ frame = "row" }}
[[move.do]]
pick = {{ mass = 0.1, size = [{small}, {small}, {small}] }}
[[move.do]]
place = true
[[move]]
pose = {{ relative = "space", position = [0, 0, {small}] }}
path = "line"
[[move]]
pose = {{ relative = "space", position = [{small}, 0, 0] }}
path = "line"
blend = {blend}
[[move]]
pose = {{ relative = "space", position = [0, {small}, 0] }}
path = "line"
"""
METRES = {"small": 0.05, "pitch": 0.2, "speed": 0.3, "tolerance": 0.001, "far": 2.0, "x": 0.4, "z": 0.3, "blend": 0.01}


def test_a_file_in_millimetres_is_the_same_job():
    metres = MILLIMETRES.format(robot="panda", unit="metres", **METRES)
    millimetres = MILLIMETRES.format(
        robot="panda", unit="millimetres", **{name: 1000 * value for name, value in METRES.items()}
    )
    (one, first), (_, second) = planned(metres), planned(millimetres)
    assert first.duration == pytest.approx(second.duration, rel=1e-9)
    np.testing.assert_allclose(ends_of(first), ends_of(second), atol=1e-9)
    assert one.n == 7
    jobs = [msgspec.to_builtins(parse_job(text)) for text in (metres, millimetres)]
    for job in jobs:
        del job["lengths"]
    assert_alike(*jobs)


def assert_alike(one, other):
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for name in one:
            assert_alike(one[name], other[name])
    elif isinstance(one, list | tuple):
        for each, same in zip(one, other, strict=True):
            assert_alike(each, same)
    elif isinstance(one, float):
        assert one == pytest.approx(other, rel=1e-12, abs=1e-15)
    else:
        assert one == other


def test_every_length_of_a_job_is_known_as_one():
    """Fields whose documentation speaks of metres are converted; those of joints are, with the robot."""
    of_joints = {
        "lock",
        "joints",
        "velocity",
        "acceleration",
        "jerk",
        "position",
        "stiffness",
        "wrench",
        "tip_angular_speed",
        "range",
        "speed",
    }
    for kind in (*vars(description).values(), *vars(statements).values()):
        if not (isinstance(kind, type) and issubclass(kind, description.Part)) or kind is description.Noise:
            continue
        known = {name for base, names in LENGTHS.items() if issubclass(kind, base) for name in names}
        for line in (kind.__doc__ or "").splitlines():
            name, _, text = line.strip().partition(": ")
            for each in name.split(", "):
                if each in kind.__struct_fields__ and "[m" in text and "kg" not in text:
                    assert each in known | of_joints, (kind.__name__, each)


def test_prismatic_joints_are_in_millimetres_too():
    text = 'robot = "stanford_arm"\nlengths = "{}"\n[[move]]\njoints = [0.1, 0.2, {}, 0, 0.3, 0]\n'
    (robot, first), (_, second) = (planned(text.format(*each)) for each in (("metres", 0.4), ("millimetres", 400)))
    np.testing.assert_allclose(ends_of(first), ends_of(second), atol=1e-12)
    assert robot.n == 6


@pytest.mark.capability("02-11", "02-12")
def test_the_pallet_of_the_examples_is_planned_to_its_places():
    path = Path(__file__).parents[2] / "examples" / "jobs" / "pallet_panda.toml"
    text = path.read_text("utf-8")
    assert len([line for line in text.splitlines() if line.strip()]) < 30
    robot, plan = planned(text)
    down = [k for k, leg in enumerate(plan.legs) if leg.name.startswith("down (pallet")][1::2]
    tips = robot.forward_kinematics(ends_of(plan)[down])
    expected = [[0.4 + 0.07 * i, -0.35 - 0.06 * j, 0.05] for j in range(4) for i in range(3)]
    np.testing.assert_allclose(tips[:, :3, 3], expected, atol=1e-9)


MISTAKES = {
    "job.unknown_frame": ('[[move]]\npose = { frame = "tabel", position = [0, 0, 0] }', 2, "tabel"),
    "job.frame_circle": ('[frame.a]\nframe = "b"\n[frame.b]\nframe = "a"\n[[move]]\npause = 1', None, "a -> b -> a"),
    "job.frame_name": ("[frame.tool]\n[[move]]\npause = 1", 1, "tool"),
    "job.pattern_pitch": ("[pattern.p]\ncount = [2, 3]\npitch = [0.1]\n[[move]]\npause = 1", 1, "2"),
    "job.pattern_outside": ('[pattern.p]\ncount = [2]\npitch = [0.1]\n[[move]]\npose = { frame = "p" }', 5, "each"),
    "job.unknown_name": ('[[move]]\njoints = "home"', 2, "configuration"),
    "job.relative_frame": ('[frame.a]\n[[move]]\npose = { frame = "a", relative = "tool" }', 3, "relative"),
    "job.relative_start": ('[start]\npose = { relative = "tool" }\n[[move]]\npause = 1', 2, "start"),
    "job.loop_empty": ("[[move]]\ndo = [{ pause = 1 }]", 1, "repeat"),
    "job.too_many_moves": (
        "[[move]]\nrepeat = 90000\n[[move.do]]\nrepeat = 90000\n[[move.do.do]]\npause = 1", 5, "200000"
    ),
    "job.too_many_places": (
        "[pattern.p]\ncount = [9000, 9000, 9000]\npitch = [1, 1, 1]\n[[move]]\npause = 1", 2, "729000000000"
    ),
    "job.uneven_patterns": (
        '[pattern.p]\ncount = [2]\npitch = [0.1]\n[pattern.q]\ncount = [3]\npitch = [0.1]\n'
        '[[move]]\neach = ["p", "q"]\ndo = [{ pause = 1 }]', 8, "p: 2",
    ),
    "job.no_effect": ("[[move]]\nrepeat = 2\nspeed = 0.5\ndo = [{ pause = 1 }]", 3, "do"),
    "job.missing_key": ("[[move]]\npose = { rpy = [0, 0, 0] }", 2, "position"),
    "job.move_many": ("[[move]]\nrepeat = 2\npause = 1\ndo = [{ pause = 1 }]", 1, "do"),
    "job.unknown_key_close": ("[[move]]\nrepeat = 2\ndo = [{ paus = 1 }]", 3, "pause"),
}  # fmt: skip


@pytest.mark.parametrize("key", MISTAKES)
def test_each_mistake_has_its_sentence_and_its_line(key):
    text, line, mentioned = MISTAKES[key]
    with pytest.raises(JobError) as caught:
        parse_job(HEAD + text, "cell.toml")
    assert caught.value.key == key
    said = caught.value.message("en")
    assert mentioned in said
    assert caught.value.message("ar") != said
    if line is not None:
        assert said.startswith(f"cell.toml:{line + 1}:")


def test_a_move_of_a_loop_that_is_impossible_is_called_by_its_place():
    from mafsil.job.remark import Refusal

    text = (
        HEAD
        + """
[pattern.row]
position = [0.5, 0, 0.3]
rpy = [3.14, 0, 0]
count = [3]
pitch = [0.6]
[[move]]
name = "before"
pause = 0.1
[[move]]
each = "row"
do = [ { name = "to", pose = { frame = "row" } } ]
"""
    )
    from mafsil.job.solve import prepare

    found = prepare(parse_job(text), text, Path())
    assert isinstance(found, Refusal)
    said = found.explain()
    assert "to (row 2)" in said
    assert "line 13" in said
