"""Parts: what they weigh, where they lie, are put and are taken again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.collision import Box, Checker, Obstacle, Scene
from mafsil.errors import JobError
from mafsil.job import Refusal, Run, parse_job, solve
from mafsil.job.judging.clearances import clearances
from mafsil.job.solve import prepare
from mafsil.messages.quantities import quantity
from mafsil.report.replay import part_tracks

HEAD = """
robot = "planar3r"
[collision]
clearance = 0.01
avoid = AVOID
self_collision = false
[part.block]
mass = 0.3
size = [0.3, 0.3, 0.3]
offset = [0.2, 0, 0]
[start]
joints = [0.9, 0.3, 0.2]
[simulation]
settle = 0.05
"""
# A block is carried to where the outstretched arm passes later, and left there.
LEAVE = """
[[move]]
pick = "block"
[[move]]
name = "there"
joints = [0.0, 0.3, 0.2]
[[move]]
place = true
[[move]]
name = "away"
joints = [0.5, 0.3, 0.2]
"""
CROSS = """
[[move]]
name = "across"
joints = [-0.9, 0.3, 0.2]
"""
TAKE = """
[[move]]
name = "back"
joints = [0.0, 0.3, 0.2]
[[move]]
pick = "block"
[[move]]
name = "home"
joints = [0.9, 0.3, 0.2]
[[move]]
place = true
[[move]]
name = "away"
joints = [1.2, 0.8, 0.3]
"""


def planned(text, avoid="false"):
    text = text.replace("AVOID", avoid)
    return prepare(parse_job(text), text, Path())


def ended(text):
    text = text.replace("AVOID", "false")
    found = solve(parse_job(text), text, Path())
    assert isinstance(found, Run), found
    return found


def own_check(plan, leg):
    """Whether a leg is free of the block where it was put down: by a checker made here."""
    place = next(each for each in plan.legs if each.kind == "place")
    tip = np.asarray(place.load.robot.forward_kinematics(place.trajectory.at(0.0).u))
    block = np.eye(4)
    block[:3, 3] = [0.2, 0, 0]
    checker = Checker(
        plan.surroundings._mechanism,
        Scene([Obstacle(Box((0.3, 0.3, 0.3)), tip @ block, "block")]),
        self_collision=False,
    )
    return checker.free(leg.trajectory.at(np.linspace(0.0, leg.trajectory.duration, 2000)).u).all()


def test_what_was_put_down_is_met_and_gone_round():
    no = planned(HEAD + LEAVE + CROSS)
    assert isinstance(no, Refusal)
    for language in ("en", "ar"):
        assert "block 1" in no.explain(language)
        assert "across" in no.explain(language)
    _, plan = planned(HEAD + LEAVE + CROSS, "true")
    (leg,) = (each for each in plan.legs if each.name == "across")
    assert leg.way is not None
    assert own_check(plan, leg)
    assert [part.body.name for part in leg.parts] == ["block 1"]
    free = planned(HEAD + CROSS)
    assert free, "without the block the same move is free"


def test_the_moves_that_leave_and_take_it_are_free_to_touch_it():
    _, plan = planned(HEAD + LEAVE + TAKE)
    parts = {k: len(leg.parts) for k, leg in enumerate(plan.legs)}
    kinds = [leg.kind for leg in plan.legs]
    assert kinds == ["pick", "joint", "place", "joint", "joint", "pick", "joint", "place", "joint", "settle"]
    assert [parts[k] for k in (1, 3, 4, 6, 8)] == [0, 0, 0, 0, 0]


def test_what_is_taken_again_leaves_the_scene():
    """Then the way across is free, and the block is the same thing all the time, in the replay too."""
    run = ended(HEAD + LEAVE + TAKE + CROSS.replace("-0.9", "-0.3"))
    assert run, run.explain("en")
    picks = [leg.thing for leg in run.plan.legs if leg.kind == "pick"]
    assert picks == [0, 0]
    t = run.recording.t
    (track,) = part_tracks(run, t)
    starts, legs = run.plan.starts, run.plan.legs
    second = next(k for k in range(1, len(legs)) if legs[k].kind == "pick")
    waits = (t > starts[3]) & (t < starts[second + 1])
    assert np.ptp(track.track[waits, :3, 3], axis=0).max() == 0.0, "it lies where it was put"
    steps = np.linalg.norm(np.diff(track.track[:, :3, 3], axis=0), axis=1)
    assert steps.max() < 5e-3, "and never jumps"
    assert steps.sum() > 1.0


def test_the_clearance_over_time_counts_it():
    text = HEAD.replace("clearance = 0.01", "clearance = 0.0") + LEAVE + "[[move]]\njoints = [0.25, 0.3, 0.2]\n"
    run = ended(text)
    found = clearances(run)
    assert "block 1" in {*found.first, *found.second}
    without = clearances(ended(text.replace("[[move]]\nplace = true\n", "")))
    assert found.distance[-1] < without.distance[-1]


@pytest.mark.parametrize(("offset", "taken"), [(0.05, True), (0.4, False)])
def test_a_part_is_taken_where_its_centre_lies_in_the_box(offset, taken):
    text = HEAD + LEAVE + TAKE.replace('pick = "block"', f"pick = {{ mass = 0.1, offset = [{0.2 + offset}, 0, 0] }}")
    plan = planned(text.replace("clearance = 0.01", f"clearance = {0.0 if taken else 0.06}"))
    if taken:
        assert [leg.thing for leg in plan[1].legs if leg.kind == "pick"] == [0, 0]
    else:
        assert isinstance(plan, Refusal)
        assert "block 1" in plan.explain("en")


def test_parts_have_names_of_their_own():
    text = HEAD + '[[obstacle]]\nname = "block 1"\nsphere = 0.1\nposition = [0, 0, 5]\n' + LEAVE + CROSS
    assert "block 2" in planned(text).explain("en")


def test_what_is_carried_counts_smaller_and_the_sentence_says_so():
    """The distance that is said belongs to the smaller box: by how much stands beside it, in the results too."""
    text = (
        HEAD
        + '[[obstacle]]\nname = "post"\nsphere = 0.1\nposition = [2.45, 0.05, 0]\n'
        + LEAVE.split('[[move]]\nname = "away"')[0]
    )
    run = ended(text)
    found = clearances(run)
    assert {found.first[found.least], found.second[found.least]} == {"block", "post"}
    assert found.smaller[found.least] == pytest.approx(0.01 + 1e-4)
    (said,) = (one for one in run.remarks if one.key.startswith("job.least_clearance"))
    assert said.key == "job.least_clearance_carried"
    assert "count 10.1 mm more" in said.sentence("en")
    carried = next(leg for leg in run.plan.legs if leg.name == "there")
    q = carried.trajectory.at(np.linspace(0.0, carried.trajectory.duration, 1500)).u
    block = np.eye(4)
    block[:3, 3] = [0.2, 0, 0]
    poses = np.asarray(carried.load.robot.forward_kinematics(q)) @ block
    centre = np.einsum("kji,kj->ki", poses[:, :3, :3], np.array([2.45, 0.05, 0.0]) - poses[:, :3, 3])
    whole = np.linalg.norm(np.maximum(np.abs(centre) - 0.15, 0.0), axis=1).min() - 0.1
    assert whole + 0.01 <= found.distance.min() + 1e-3 <= whole + 0.0101 * 3**0.5 + 2e-3


@pytest.mark.capability("11-39")
@pytest.mark.parametrize(("apart", "free"), [(0.001, True), (-0.005, False)])
def test_corners_of_what_is_carried_pass_through_nothing(apart, free):
    """A box that is smaller by the clearance on all sides, kept clear of all by that, leaves out the corners."""
    carrying = LEAVE.split("[[move]]\nplace")[0]
    _, plan = planned(HEAD.replace("clearance = 0.01", "clearance = 0.1") + carrying)
    q = np.array([0.9, 0.3, 0.2])
    checker = plan.surroundings.checker(plan.legs[-1].load)
    post = np.eye(4)
    post[:2, 3] = 0.35 + 0.1 + apart, 0.15 + 0.1 + apart
    tip = plan.surroundings.robot.forward_kinematics(q)
    assert bool(checker.with_scene([Obstacle(Box((0.2, 0.2, 0.2)), tip @ post, "post")]).free(q)) is free


def lies(x, y, more="", text=LEAVE):
    """The block lies in the grip of the start, or as far beside it as asked."""
    arm = mf.load("planar3r")
    centre = arm.fk([0.9, 0.3, 0.2]) @ [0.2, 0, 0, 1] + [x, y, 0, 0]
    return planned(HEAD.replace("offset =", f"at = {{ position = {centre[:3].tolist()} }}\noffset =") + more + text)


@pytest.mark.parametrize("far", [0.0, 0.9e-3, 1.1e-3, 0.2, 3.0])
def test_a_pick_is_judged_by_the_distance_between_grip_and_part(far):
    found = lies(far, 0.0)
    assert bool(found) is (far < 1e-3)
    if far > 1e-3:
        assert found.key == "job.none_here"
        assert str(found.details["distance"]) == str(quantity(far, "m"))
        assert lies(far, 0.0, f"[tolerance]\nposition = {1.01 * far}\n") or far > 0.1


def test_a_part_with_a_place_is_one_thing_wherever_it_is_put():
    _, plan = lies(0.0, 0.0, text=LEAVE + TAKE)
    assert [leg.thing for leg in plan.legs if leg.kind == "pick"] == [0, 0]
    assert not any(remark.key == "job.new_parts" for remark in plan.remarks)
    elsewhere = TAKE.replace("joints = [0.0, 0.3, 0.2]", "joints = [0.8, 0.3, 0.2]")
    assert lies(0.0, 0.0, text=LEAVE + elsewhere).key == "job.none_here"
    # Without a place it is another part, and that is said.
    (said,) = (one for one in planned(HEAD + LEAVE + elsewhere)[1].remarks if one.key == "job.new_parts")
    assert said.details["count"] == 1


def test_a_pattern_gives_one_part_at_each_place_and_no_more():
    rows = "[pattern.tray]\nposition = [0.5, 0, 0]\ncount = [2]\npitch = [-0.1]\n"
    pick = '[[move]]\npose = { frame = "tray", task = "position" }\n[[move]]\npick = "nut"\n'
    pick += "[[move]]\njoints = [2.0, 0.5]\n"
    head = 'robot = "planar2r"\n[part.nut]\nmass = 0.1\nsize = [0.02, 0.02, 0.02]\nat = "tray"\n' + rows
    loop = '[[move]]\neach = "tray"\n' + (pick + "[[move]]\nplace = true\n").replace("[[move]]", "[[move.do]]")
    assert planned(head + loop)
    again = planned(head + loop + loop)
    assert again.key == "job.none_here", "they were put down elsewhere"
    assert "nut" in again.explain("ar")


PART_HEAD = """
robot = "puma560"
[simulation]
friction = false
[start]
joints = [0.3, -0.5, 0.4, 0.1, 0.6, 0.2]
[part.gear]
mass = 1.2
size = [0.1, 0.06, 0.04]
offset = [0, 0, 0.05]
com = [0.02, -0.01, 0.005]
inertia = [0.004, 0.005, 0.006, 0.0005, -0.0002, 0.0001]
"""
MOVES = """
[[move]]
pick = "gear"
[[move]]
joints = [-0.3, -0.3, 0.1, 0.4, 0.2, -0.5]
[[move]]
place = true
"""


def solved(text: str) -> Run:
    found = solve(parse_job(text), text, Path())
    assert isinstance(found, Run)
    return found


def test_a_part_by_name_moves_as_a_body_of_its_inertia():
    run = solved(PART_HEAD + MOVES)
    assert run
    xx, yy, zz, xy, xz, yz = 0.004, 0.005, 0.006, 0.0005, -0.0002, 0.0001
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    loaded = mf.load("puma560").with_payload(1.2, com=(0.02, -0.01, 0.055), inertia=inertia)
    carried = next(each for each in run.driven if each.carried is not None)
    assert carried.carried is not None
    assert carried.carried.name == "gear"
    q, qd, qdd = np.random.default_rng(0).normal(size=(3, 20, 6))
    ours = carried.scenario.true_plant.robot.inverse_dynamics(q, qd, qdd)
    np.testing.assert_allclose(ours, loaded.inverse_dynamics(q, qd, qdd), atol=1e-12)


def test_millimetres_are_metres():
    text = PART_HEAD.replace("robot =", 'lengths = "millimetres"\nrobot =').replace(
        "[0.1, 0.06, 0.04]", "[100, 60, 40]"
    )
    text = text.replace("[0, 0, 0.05]", "[0, 0, 50]").replace("[0.02, -0.01, 0.005]", "[20, -10, 5]")
    own, other = (parse_job(each + MOVES).move[0].pick for each in (PART_HEAD, text))
    assert own is not None
    assert other is not None
    np.testing.assert_allclose([*own.size, *own.offset, *own.com], [*other.size, *other.offset, *other.com])
    assert own.inertia == other.inertia


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ('pick = "gear"', 'pick = "wheel"', r"\[part\] wheel; known: gear"),
        ("0.004, 0.005, 0.006", "0.004, 0.005, 0.016", "triangle"),
        ("0.004, 0.005, 0.006", "-0.004, 0.005, 0.006", "<text>:12: no body"),
        (", -0.0002, 0.0001]", "]", "inertia"),
        ("mass = 1.2", "mass = 1.2\nweight = 3", "weight"),
    ],
)
def test_what_is_wrong_with_a_part_is_said(before, after, said):
    with pytest.raises(JobError, match=said):
        parse_job((PART_HEAD + MOVES).replace(before, after))
