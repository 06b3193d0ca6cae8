"""Moves on frames that move: catching up, staying, leaving; and what acts on the way."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import JobError
from mafsil.geometry import rotation
from mafsil.job import Refusal, Run, parse_job, solve
from mafsil.job.judging.holding import planned_overloads
from mafsil.job.solve import prepare

BELT = """
robot = "ur5e"
angles = "degrees"
[tool]
offset = { position = [0, 0, 0.15], rpy = [0, 0, 0] }
[start]
joints = [0, -90, 90, -90, -90, 0]
[input.eye]
changes = [[0.4, true], [0.5, false]]
every = 3.0
[frame.belt]
position = [0.45, 0.3, 0.1]
rpy = [180, 0, 0]
velocity = [0, -0.1, 0]
since = "eye"
[frame.grip]
frame = "belt"
position = [0.02, 0, 0]
[[move]]
wait = { eye = true }
[[move]]
pose = { frame = "grip", position = [0, 0, -0.1] }
[[move]]
pose = { frame = "grip" }
path = "line"
[[move]]
pick = { mass = 0.4, size = [0.05, 0.05, 0.05] }
[[move]]
pose = { relative = "space", position = [0, 0, 0.1] }
path = "line"
[[move]]
joints = [0, -90, 90, -90, -90, 0]
[[move]]
place = true
"""
TABLE = """
robot = "ur5e"
angles = "degrees"
[start]
joints = [0, -90, 90, -90, -90, 0]
[frame.table]
position = [0.5, 0, 0.2]
angular_speed = 20
[[move]]
pose = { frame = "table", position = [0, -0.06, 0.08], rpy = [180, 0, 0] }
[[move]]
pose = { frame = "table", position = [0, 0.06, 0.08], rpy = [180, 0, 0] }
via = [{ frame = "table", position = [0.06, 0, 0.08] }]
path = "arc"
[[move]]
pause = 0.5
[[move]]
joints = [0, -90, 90, -90, -90, 0]
"""
CAN = """
[part.can]
mass = 0.4
size = [0.05, 0.05, 0.05]
at = { frame = "grip", position = [0, AWAY, 0] }
"""
GLUE = """
robot = "ur5e"
angles = "degrees"
lengths = "millimetres"
[tool]
offset = { position = [0, 0, 150], rpy = [0, 0, 0] }
mass = 1
[start]
pose = { position = [400, -150, 260], rpy = [180, 0, 0] }
[output]
glue = false
gun = 0.0
[[move]]
path = "line"
pose = { position = [400, 0, 260] }
blend = 10
outputs = [{ distance = 20, set = { glue = true } }, { share = 0.5, set = { gun = 3 } }]
[[move]]
path = "line"
pose = { position = [500, 0, 260] }
outputs = [{ distance = -20, set = { glue = false } }, { after = 0.1, set = { gun = 1 } }]
"""


def planned(text):
    found = prepare(parse_job(text, "job.toml"), text, Path())
    return found if isinstance(found, Refusal) else found[1]


def tips(leg, count=40):
    t = np.linspace(0.0, leg.trajectory.duration, count)
    return t, np.asarray(leg.load.robot.forward_kinematics(leg.trajectory.at(t).u))


def test_a_belt_is_followed_from_its_signal_on():
    plan = planned(BELT)
    legs, starts = plan.legs, plan.starts
    assert [leg.frame for leg in legs] == ["", "belt", "belt", "belt", "belt", "", "", ""]
    for leg, start in zip(legs[2:5], starts[2:5], strict=True):
        t, T = tips(leg)
        belt = np.array([0.45, 0.3, 0.1]) + (start + t - 0.4)[:, None] * np.array([0.0, -0.1, 0.0])
        away = T[:, :3, 3] - belt - np.array([0.02, 0.0, 0.0])
        assert np.abs(away[:, :2]).max() < 1e-6
        assert np.abs(T[:, :3, :3] - np.diag([1.0, -1.0, -1.0])).max() < 1e-6
    t, T = tips(legs[3])
    assert np.abs(T[:, 2, 3] - 0.1).max() < 1e-6


FREE_SPIN = (
    TABLE.partition("[[move]]")[0]
    + """
[[move]]
pose = { frame = "table", position = [0.1, 0, 0.05], rpy = [180, 0, 0], task = "axis" }
[[move]]
path = "line"
pose = { frame = "table", position = [0.1, 0, 0], rpy = [180, 0, 0] }
[[move]]
pause = 0.2
[[move]]
joints = [0, -90, 90, -90, -90, 0]
"""
)


@pytest.mark.parametrize("text", [BELT, TABLE, FREE_SPIN])
def test_positions_velocities_and_accelerations_are_continuous_from_move_to_move(text):
    for before, after in pairwise(leg.trajectory for leg in planned(text).legs):
        end, start = before.at(before.duration), after.at(0.0)
        for one, other in zip(end[:2], start[:2], strict=True):
            np.testing.assert_allclose(one, other, atol=1e-9)


def test_a_turntable_turns_what_is_given_in_it():
    plan = planned(TABLE)
    for leg, start in zip(plan.legs[1:3], plan.starts[1:3], strict=True):
        t, T = tips(leg)
        turn = rotation.exp((start + t)[:, None] * np.radians([0.0, 0.0, 20.0]))
        inside = np.einsum("kji,kj->ki", turn, T[:, :3, 3] - np.array([0.5, 0.0, 0.2]))
        np.testing.assert_allclose(np.hypot(inside[:, 0], inside[:, 1]), 0.06, atol=1e-6)
        np.testing.assert_allclose(inside[:, 2], 0.08, atol=1e-6)


@pytest.mark.parametrize(("away", "said"), [("0.0", None), ("0.03", "30 mm")])
def test_a_part_on_a_belt_is_picked_where_it_is_by_then(away, said):
    text = BELT.replace("[[move]]", CAN.replace("AWAY", away) + "[[move]]", 1)
    found = planned(text.replace("pick = { mass = 0.4, size = [0.05, 0.05, 0.05] }", 'pick = "can"'))
    assert isinstance(found, Refusal) == bool(said)
    assert said is None or said in found.explain("en")


def test_a_part_on_a_belt_is_not_picked_from_where_the_belt_is_not():
    head = BELT[: BELT.index("[[move]]")] + CAN.replace("AWAY", "0")
    assert isinstance(planned(head + '[[move]]\npick = "can"\n'), Refusal)


def test_an_arm_that_is_driven_on_a_belt_grips_there():
    run = solve(parse_job(BELT, "job.toml"), BELT, Path())
    assert isinstance(run, Run)
    assert run, run.explain("en")
    assert not any(remark.level == "failure" for remark in run.remarks)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('[[move]]\nwait = { eye = true }\n', "", "did not come before; wait for it first"),
        ("velocity = [0, -0.1, 0]", "velocity = [0, 2.5, 0]", "move 2"),
        ('joints = [0, -90, 90, -90, -90, 0]\n[[move]]\nplace = true\n', "pause = 0.2\n", "add a move that leaves it"),
        ('position = [0, 0, -0.1] }\n', 'position = [0, 0, -0.1] }\npath = "line"\n', "these do not apply: path"),
        ('pose = { frame = "grip" }\n', 'pose = { frame = "grip" }\nprofile = "quintic"\n', "do not apply: profile"),
    ],
)  # fmt: skip
def test_what_does_not_go_with_a_moving_frame_is_refused(old, new, said):
    head, tail = BELT.split("[[move]]", 1)
    text = head.replace(old, new, 1) + ("[[move]]" + tail).replace(old, new, 1)
    found = planned(text)
    assert isinstance(found, Refusal)
    assert said in found.explain("en")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('since = "eye"', 'since = "ey"', "is no digital input; known: eye"),
        ("velocity = [0, -0.1, 0]\n", "", "has no effect on a frame that stands still"),
        ("position = [0.02, 0, 0]", "position = [0.02, 0, 0]\nangular_speed = 3", "'belt' moves"),
        ("[[move]]\nwait", '[[obstacle]]\nsphere = 0.1\nframe = "grip"\n[[move]]\nwait', "'grip' moves"),
    ],
)
def test_wrong_moving_frames_are_refused_with_their_line(old, new, said):
    with pytest.raises(JobError, match=r"job\.toml:") as caught:
        parse_job(BELT.replace(old, new, 1), "job.toml")
    assert said in str(caught.value)


def test_outputs_on_the_way_change_at_their_places():
    plan = planned(GLUE)
    leg = plan.legs[0]
    t, T = tips(leg, 20001)
    changes = {(c.signal, c.value): c.time for c in plan.signals.timeline(10.0, 100) if c.time > 0.0}
    p = T[:, :3, 3]
    assert 0.0 <= changes["glue", True] - np.interp(-0.13, p[:, 1], t) < 1.1e-3
    assert 0.0 <= changes["glue", False] - np.interp(0.48, p[:, 0], t) < 1.1e-3
    corner = leg.ends[0]
    assert changes["gun", 1.0] == pytest.approx(corner + 0.1, abs=1.1e-3)
    assert np.linalg.norm(p[np.searchsorted(t, corner)] - [0.4, 0.0, 0.26]) == pytest.approx(0.01, rel=0.01)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("distance = 20,", "distance = 20, share = 0.2,", "exactly one says where"),
        ("set = { gun = 3 }", "set = { gum = 3 }", "no signal 'gum'"),
        ("set = { gun = 3 }", "set = { gun = true }", "gun"),
    ],
)
def test_wrong_outputs_on_the_way_are_refused_with_their_line(old, new, said):
    with pytest.raises(JobError, match=r"job\.toml:") as caught:
        parse_job(GLUE.replace(old, new, 1), "job.toml")
    assert said in str(caught.value)


def test_an_output_beyond_its_path_is_refused():
    found = planned(GLUE.replace("distance = 20,", "distance = 220,"))
    assert isinstance(found, Refusal)
    assert "beyond the path" in found.explain("en")


def test_the_force_of_a_process_pushes_during_its_move_alone():
    known = GLUE.replace("blend = 10\n", "process_wrench = [0, 0, 0, 0, 0, -40]\n")
    held = solve(parse_job(known, "job.toml"), known, Path())
    assert np.abs(held.recording.q - held.recording.q_ref).max() < 5e-4
    text = known.replace("process_wrench", "process_known = false\nprocess_wrench", 1)
    run = solve(parse_job(text, "job.toml"), text, Path())
    off = np.abs(run.recording.q - run.recording.q_ref).max(axis=1)
    end = run.plan.starts[1]
    assert off[(run.recording.t > 0.3) & (run.recording.t < end)].max() > 1e-2
    assert off[run.recording.t > end + 0.5].max() < 2e-4
    still = solve(parse_job(GLUE, "job.toml"), GLUE, Path())
    assert np.abs(still.recording.q - still.recording.q_ref).max() < 2e-4


def test_a_force_beyond_the_motors_is_said_before_the_run():
    text = GLUE.replace("blend = 10\n", "process_wrench = [0, 0, 0, 0, 0, -900]\n")
    job = parse_job(text, "job.toml")
    plan = planned(text)
    (over,) = planned_overloads(job, plan)
    robot, leg = plan.legs[0].load.robot, plan.legs[0]
    q = leg.trajectory.at(np.linspace(0.0, leg.trajectory.duration, 40, endpoint=False)).u
    held = robot.gravity_torque(q) - robot.jacobian_body(q).swapaxes(1, 2) @ [0.0, 0, 0, 0, 0, -900]
    assert over.pressed
    assert over.share == pytest.approx((np.abs(held) / robot.limits.effort).max(), rel=0.05)
    assert not planned_overloads(parse_job(GLUE), planned(GLUE))


def test_the_force_of_a_process_needs_forces():
    text = 'simulation = { plant = "kinematic" }\n' + GLUE.replace(
        "blend = 10\n", "process_wrench = [0, 0, 0, 0, 0, -40]\n"
    )
    with pytest.raises(JobError, match="process_wrench"):
        planned(text)


TRACK = """
robot = "ur5e"
angles = "degrees"
lengths = "millimetres"
[[track]]
direction = [0, 2, 0]
range = [0, 3000]
speed = 1000
acceleration = 2000
[[track]]
direction = [0, 0, 1]
range = [-100, 400]
speed = 500
[start]
joints = [0, 0, 0, -90, 90, -90, -90, 0]
[[move]]
pose = { position = [-400, 2000, 500], rpy = [180, 0, 0] }
[[move]]
path = "line"
pose = { relative = "space", position = [0, -600, 0] }
[[move]]
joints = [1500, 200, 0, -90, 90, -90, -90, 0]
"""


def test_an_arm_on_two_linear_axes_reaches_along_them_within_their_limits():
    run = solve(parse_job(TRACK, "job.toml"), TRACK, Path())
    assert run, run.explain("en")
    assert run.robot.joint_names[:2] == ("track", "track_2")
    end = run.robot.forward_kinematics(run.plan.legs[-2].trajectory.at(99.0).u)
    there = mf.load("ur5e").forward_kinematics(np.radians([0, -90, 90, -90, -90, 0]))
    np.testing.assert_allclose(end[:3, 3] - there[:3, 3], [0.0, 1.5, 0.2], atol=1e-9)
    for leg in run.plan.legs:
        t = np.linspace(0.0, leg.trajectory.duration, 500)
        assert np.abs(leg.trajectory.at(t).v[:, :2]).max(axis=0)[0] <= 0.7 + 1e-6
        assert np.abs(leg.trajectory.at(t).a[:, 0]).max() <= 1.4 + 1e-6


def test_a_turntable_under_an_arm_turns_it_about_its_axis():
    axis = "axis = [0, 0, 1]\npoint = [500, 0, 0]\nrange = [-180, 180]\nspeed = 60\nacceleration = 90\n"
    head, _, rest = TRACK.partition("direction")
    moves = "[[track]]" + rest.partition("[[track]]")[2]
    text = head + axis + moves.replace("[1500, 200,", "[90, 200,").replace("[-400, 2000, 500]", "[700, 500, 500]")
    plan = planned(text.replace("[0, -600, 0]", "[0, -200, 0]"))
    robot = plan.legs[0].load.robot
    end = robot.forward_kinematics(plan.legs[-1].trajectory.at(99.0).u)
    x, y, z = mf.load("ur5e").forward_kinematics(np.radians([0, -90, 90, -90, -90, 0]))[:3, 3]
    np.testing.assert_allclose(end[:3, 3], [0.5 - y, x - 0.5, z + 0.2], atol=1e-9)
    assert np.degrees(robot.limits.velocity[0]) == pytest.approx(60.0)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("direction = [0, 2, 0]", "", "direction, axis"),
        ("[0, 3000]", "[3000, 0]", "the least one first"),
        ("[0, 2, 0]", "[0, 0, 0]", "direction"),
    ],
)
def test_wrong_tracks_are_refused_with_their_line(old, new, said):
    with pytest.raises(JobError, match=r"job\.toml:") as caught:
        parse_job(TRACK.replace(old, new, 1), "job.toml")
    assert said in str(caught.value)
