"""Paths of the tip in jobs: arcs, splines, screws, and corners that are rounded instead of stops."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mafsil.errors import JobError
from mafsil.geometry import pose
from mafsil.job.driving.arrival import arrivals
from mafsil.job.language.reading import parse_job
from mafsil.job.planning.planned_remarks import driving_limits
from mafsil.job.solve import solve
from mafsil.trajectory import check
from tests.job.test_job_planning import PANDA, complaint, planned, refused

START = "[[move]]\npose = { position = [0.4, -0.2, 0.4], rpy = [3.141592653589793, 0, 0] }\n"
ARC = '[[move]]\npose = { position = [0.4, 0.2, 0.4] }\npath = "arc"\nvia = [{ position = [0.55, 0.0, 0.4] }]\n'
SPLINE = """[[move]]
pose = { position = [0.4, 0.2, 0.4] }
path = "spline"
via = [{ position = [0.5, -0.1, 0.45] }, { position = [0.5, 0.1, 0.35], rpy = [3.141592653589793, 0, 0.3] }]
"""
SCREW = '[[move]]\npose = { position = [0.45, 0.1, 0.45], rpy = [3.141592653589793, 0, 0.5] }\npath = "screw"\n'
CORNER = np.array([0.5, -0.2, 0.4])


def corner(blend: float) -> str:
    return (
        f'[[move]]\npose = {{ position = {CORNER.tolist()} }}\npath = "line"\nblend = {blend}\n'
        '[[move]]\npose = { position = [0.5, 0.0, 0.4] }\npath = "line"\n'
    )


def moved(moves: str, leg: int = 1):
    """The robot, the limits, the tip's poses (k, 4, 4) and the times of one leg."""
    text = PANDA + START + moves
    robot, plan = planned(text)
    limits, _ = driving_limits(parse_job(text), robot)
    motion = plan.legs[leg].trajectory
    assert check(motion, limits, tolerance=1e-6)
    t = np.linspace(0.0, motion.duration, 4001)
    return robot, plan, np.asarray(robot.forward_kinematics(motion.at(t).u)), t


def tip_speeds(T, t):
    return np.linalg.norm(np.gradient(T[:, :3, 3], t, axis=0), axis=1)


@pytest.mark.parametrize("profile", ["", 'profile = "time_optimal"\n', 'profile = "double_s"\n'])
def test_an_arc_is_round_passes_its_point_and_keeps_the_bounds_of_the_tip(profile):
    _, plan, T, t = moved(ARC + profile)
    p = T[:, :3, 3]
    # The circle through (0.4, -0.2), (0.55, 0), (0.4, 0.2).
    centre = np.array([0.55 - (0.15**2 + 0.2**2) / (2 * 0.15), 0.0, 0.4])
    np.testing.assert_allclose(np.linalg.norm(p - centre, axis=1), 0.55 - centre[0], atol=1e-6)
    assert np.linalg.norm(p - [0.55, 0.0, 0.4], axis=1).min() < 1e-4
    assert np.abs(T[:, :3, :3] - T[0, :3, :3]).max() < 1e-6
    speed = tip_speeds(T, t)
    assert speed.max() <= 0.25 * (1 + 1e-4)
    acceleration = np.gradient(np.gradient(p, t, axis=0), t, axis=0)[5:-5]
    assert np.linalg.norm(acceleration, axis=1).max() <= 1.0 * (1 + 5e-3)
    assert plan.legs[1].kind == "arc"


def test_a_spline_passes_its_points_and_their_orientations():
    _, plan, T, t = moved(SPLINE)
    p = T[:, :3, 3]
    for point in ([0.5, -0.1, 0.45], [0.5, 0.1, 0.35]):
        assert np.linalg.norm(p - point, axis=1).min() < 1e-4
    at = np.linalg.norm(p - [0.5, 0.1, 0.35], axis=1).argmin()
    turned = pose.error(T[at], np.asarray(T[0]) @ np.eye(4))[:3]
    assert np.linalg.norm(turned) == pytest.approx(0.3, abs=1e-3)
    speed = tip_speeds(T, t)
    assert speed[200:-200].min() > 0.01, "it never stops on the way"
    assert speed.max() <= 0.25 * (1 + 1e-4)
    assert any(remark.key == "job.decided_by" for remark in plan.remarks)


def test_a_screw_has_one_axis():
    _, _, T, _ = moved(SCREW)
    way = pose.error(np.broadcast_to(T[0], T.shape), T)
    direction = way[-1] / np.linalg.norm(way[-1])
    assert np.linalg.norm(way - (way @ direction)[:, None] * direction, axis=1).max() < 1e-6


@pytest.mark.parametrize("blend", [0.002, 0.01])
def test_a_corner_is_rounded_within_its_distance_and_without_a_stop(blend):
    _, plan, T, t = moved(corner(blend))
    p = T[:, :3, 3]
    near = np.linalg.norm(p - CORNER, axis=1).min()
    assert 0.2 * blend < near <= blend + 1e-6
    assert tip_speeds(T, t)[100:-100].min() > 0.01
    assert [leg.kind for leg in plan.legs[:2]] == ["joint", "blended"]
    stops = planned(PANDA + START + corner(blend).replace(f"blend = {blend}\n", 'profile = "time_optimal"\n'))[1]
    assert plan.legs[1].trajectory.duration < stops.legs[1].trajectory.duration + stops.legs[2].trajectory.duration
    # Off the corner it is the two lines.
    first, second = p[:, 0] < CORNER[0] - 8 * blend, p[:, 1] > CORNER[1] + 8 * blend
    assert np.abs(p[first, 1] - CORNER[1]).max() < 1e-6
    assert np.abs(p[second, 0] - CORNER[0]).max() < 1e-6


@pytest.mark.parametrize("moves", [ARC, SCREW, SPLINE, corner(0.05)], ids=["arc", "screw", "spline", "corner"])
def test_jerk_is_limited_on_every_path(moves):
    _, quick, _, _ = moved(moves.replace('path = "', 'profile = "time_optimal"\npath = "'))
    smooth = moves.replace('path = "', 'profile = "jerk_limited"\npath = "')
    robot, plan, _, t = moved(smooth)
    limits, _ = driving_limits(parse_job(PANDA + START + smooth), robot)
    motion = plan.legs[1].trajectory
    assert (np.abs(motion.jerk(t)) / limits.jerk).max() <= 1 + 1e-6
    assert (np.abs(np.diff(motion.at(t).a, axis=0)) / (limits.jerk * t[1])).max() <= 1 + 1e-4
    assert motion.duration > quick.legs[1].trajectory.duration * (1 + 1e-4)


def test_a_move_that_goes_nowhere_has_no_corner():
    again = '[[move]]\npose = { position = [0.4, -0.2, 0.4] }\npath = "line"\nblend = 0.01\n'
    _, plan, T, _ = moved(again + '[[move]]\npose = { position = [0.5, -0.2, 0.4] }\npath = "line"\n')
    assert plan.legs[1].index == 2
    np.testing.assert_allclose(T[-1, :3, 3], [0.5, -0.2, 0.4], atol=1e-6)


@pytest.mark.parametrize(
    ("moves", "key"),
    [
        (ARC.replace("via = [{ position = [0.55, 0.0, 0.4] }]\n", ""), "job.arc_via"),
        (ARC.replace("}]", "}, { position = [0.5, 0.1, 0.4] }]"), "job.arc_via"),
        (ARC.replace("[{ position = [0.55, 0.0, 0.4] }]", "[[0, 0, 0, 0, 0, 0, 0]]"), "job.via_pose"),
        (SPLINE + 'profile = "quintic"\n', "job.via_profile"),
        ('[[move]]\npose = { position = [0.4, 0.2, 0.4] }\npath = "spline"\n', "job.spline_via"),
        (SCREW + "via = [{ position = [0.4, 0.1, 0.3] }]\n", "job.line_via"),
        ('[[move]]\njoints = [0, 0, 0, -1, 0, 1, 0]\npath = "arc"\n', "job.line_pose"),
        ("[[move]]\njoints = [0, 0, 0, -1, 0, 1, 0]\nvia = [{ position = [0.4, 0.1, 0.3] }]\n", "job.via_joints"),
        (SCREW + "blend = 0.01\n", "job.blend_next"),
        (SCREW + "blend = 0.01\n[[move]]\npause = 1.0\n" + SCREW, "job.blend_next"),
        (corner(0.01).replace("blend", 'profile = "quintic"\nblend'), "job.blend_profile"),
        (corner(0.01) + "duration = 3\n", "job.blend_duration"),
        (corner(0.01).replace("0.4] }\npath = \"line\"\nblend", "0.4], task = \"axis\" }\npath = \"line\"\nblend"),
         "job.blend_task"),
        ('[[move]]\njoints = [0, 0, 0, -1, 0, 1, 0]\nblend = 0.01\n', "job.blend_next"),
        (ARC.replace("position = [0.55, 0.0, 0.4]", "position = [0.55, 0.0, 0.4], rpi = [0, 0, 0]"),
         "job.unknown_key_close"),
    ],
)  # fmt: skip
def test_what_does_not_go_together_is_named_with_its_line(moves, key):
    error = complaint(PANDA + START + moves)
    assert error.key == key
    assert "x.toml" in error.message("en")


def test_an_arc_over_points_of_a_line_is_refused_with_the_reason():
    refusal = refused(PANDA + START + ARC.replace("[0.55, 0.0, 0.4]", "[0.4, 0.0, 0.4]"))
    assert "line" in refusal.explain("en")


def drawing(count):
    """A curve in lines of some millimetres, as a drawing program exports it: (count, 3) points and the job."""
    angle = 0.03 * np.arange(1, count + 1)
    points = np.stack([0.45 + 0.05 * np.sin(angle), 0.08 * np.sin(angle / 2), np.full(count, 0.3)], axis=1)
    head = 'robot = "panda"\n[start]\npose = { position = [0.45, 0, 0.3], rpy = [3.14159265358979, 0, 0] }\n'
    moves = [
        f'[[move]]\npath = "line"\npose = {{ position = {point.round(9).tolist()} }}\n'
        + ("blend = 0.0005\n" if k + 1 < count else "")
        for k, point in enumerate(points)
    ]
    return points, head + "[limits]\ntip_speed = 0.1\n" + "".join(moves)


def test_many_short_lines_keep_to_the_drawing_at_full_speed():
    points, text = drawing(120)
    _, plan = planned(text)
    (line,) = (one for one in plan.legs if one.kind == "blended")
    t = np.linspace(0.0, line.trajectory.duration, 4000)
    tip = np.asarray(line.load.robot.forward_kinematics(line.trajectory.at(t).u))[:, :3, 3]
    speed = np.linalg.norm(np.diff(tip, axis=0), axis=1) / np.diff(t)
    assert speed.max() < 0.1 * (1 + 1e-3)
    assert np.median(speed) > 0.099, "and mostly at full speed"
    whole = np.concatenate([[[0.45, 0.0, 0.3]], points])
    begin, along = whole[:-1], np.diff(whole, axis=0)
    share = np.einsum("tkj,kj->tk", tip[:, None] - begin, along) / (along**2).sum(axis=1)
    off = tip[:, None] - begin - share.clip(0.0, 1.0)[..., None] * along
    assert np.linalg.norm(off, axis=2).min(axis=1).max() < 0.0005 + 1e-6


ZONES = """
robot = "%s"
[start]
joints = %s
[[move]]
joints = %s
blend = 0.05
[[move]]
pose = { position = [0.45, 0.1, 0.3], rpy = [3.141592653589793, 0, 0] }
blend = 0.02
[[move]]
path = "line"
pose = { position = [0.45, 0.1, 0.15], rpy = [3.141592653589793, 0, 0] }
tip_speed = 0.1
"""
STARTS = {
    "ur5e": ([0.0, -1.5, 1.5, -1.5, -1.5, 0.0], [0.5, -1.4, 1.5, -1.7, -1.5, 0.0]),
    "panda": ([0.0, -0.3, 0.0, -1.8, 0.0, 1.6, 0.7], [0.5, -0.2, 0.0, -1.8, 0.0, 1.6, 0.7]),
}


@pytest.mark.parametrize("name", STARTS)
def test_zones_of_joint_moves_and_lines(name):
    text = ZONES % (name, *STARTS[name])
    robot, plan = planned(text)
    leg = plan.legs[0]
    assert (leg.kind, leg.index) == ("blended", 2)
    limits, _ = driving_limits(parse_job(text), robot)
    t = np.linspace(0.0, leg.trajectory.duration, 8001)
    u, v, a = leg.trajectory.at(t)
    for found, most in ((v, limits.velocity), (a, limits.acceleration)):
        assert (np.abs(found) <= most * (1 + 1e-5)).all()
    if name == "panda":
        assert (np.abs(leg.trajectory.jerk(t)) <= robot.limits.jerk * (1 + 1e-4)).all()
    p = robot.forward_kinematics(u)[:, :3, 3]
    passed = [np.linalg.norm(p - robot.forward_kinematics(q)[:3, 3], axis=1).min() for q in leg.goals[:2]]
    assert (0.0 < np.array(passed)).all()
    assert (np.array(passed) < [0.05, 0.02]).all()
    low = (p[:, 2] < 0.28) & (t > t[-1] / 2)
    assert np.abs(p[low, :2] - [0.45, 0.1]).max() < 1e-6
    assert np.linalg.norm(np.gradient(p, t, axis=0), axis=1)[low].max() < 0.1 * (1 + 1e-3)
    _, stopping = planned(text.replace("blend = 0.05", "").replace("blend = 0.02", ""))
    assert plan.cycle < stopping.cycle


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ('path = "line"', 'path = "screw"', "job.blend_mixed"),
        ("blend = 0.05", "blend = 0.05\nduration = 3.0", "job.blend_duration"),
        ("blend = 0.02", "blend = 0.02\n[[move]]\npause = 1", "job.blend_next"),
    ],
)
def test_zones_that_cannot_be_are_refused(old, new, key):
    with pytest.raises(JobError) as caught:
        planned((ZONES % ("ur5e", *STARTS["ur5e"])).replace(old, new, 1))
    assert caught.value.key == key


def test_a_zone_before_a_goal_in_joints_is_judged_there():
    text = (ZONES % ("ur5e", *STARTS["ur5e"])).replace(
        "tip_speed = 0.1", "blend = 0.03\n[[move]]\njoints = [0.2, -1.4, 1.5, -1.7, -1.5, 0.0]"
    )
    run = solve(parse_job(text), text, Path())
    assert run, run.explain("en")
    assert [one.goal for one in arrivals(run.job, run.plan, run.recording)] == ["joints"]


@pytest.mark.parametrize(("place", "number"), [([0.45, 0.1, 0.14], 3), ([0.53, 0.2, 0.5], 2)])
def test_a_collision_without_a_stop_is_said_of_the_move_under_way(place, number):
    ball = f'[[obstacle]]\nname = "ball"\nsphere = 0.05\nposition = {place}\n'
    said = refused(ZONES % ("panda", *STARTS["panda"]) + ball).explain("en")
    assert said.startswith(f"move {number} "), said
    assert "ball" in said
