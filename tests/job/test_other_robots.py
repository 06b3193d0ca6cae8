"""Other robots of a job: standing ones are obstacles, moving ones are planned past it, both proved and reported."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.collision import ArmMount, Checker, MultiArmCell
from mafsil.errors import FileError, JobError
from mafsil.geometry import pose
from mafsil.job.judging.clearances import clearances
from mafsil.job.judging.judgement import summary
from mafsil.job.language.reading import parse_job, read_job
from mafsil.job.planning.placed_parts import Stay
from mafsil.job.remark import Refusal
from mafsil.job.solve import prepare, solve
from mafsil.planning import TimedArm
from mafsil.report.contents import page as page_of
from mafsil.report.replay import replay_scene
from mafsil.report.results import as_data
from mafsil.trajectory import quintic
from mafsil.trajectory.profiles import rest
from tests.collision.arms import LISTED, TOUCHING

EXAMPLE = Path(__file__).parents[2] / "examples" / "jobs" / "two_arms.toml"
HEAD = """
robot = "ur5"
angles = "degrees"
[start]
joints = [140, -35, 60, -25, -90, 0]
[collision]
clearance = 0.01
[[move]]
joints = [220, -35, 60, -25, -90, 0]
"""
RIGHT = """
[[other_robot]]
name = "right"
robot = "ur5"
position = [1.2, 0, 0]
rpy = [0, 0, 180]
joints = [180, -35, 60, -25, -90, 0]
"""


def planned(text):
    return prepare(parse_job(text), text, Path())


@pytest.fixture(scope="module")
def run():
    text = EXAMPLE.read_text("utf-8")
    return solve(read_job(EXAMPLE), text, EXAMPLE.parent)


@pytest.mark.capability("11-45", "11-46")
def test_two_arms_run_on_one_clock_and_nothing_meets(run):
    """Looked at densely, by arms mounted here; the second waits, and ends where its moves say."""
    assert run, run.explain("en")
    (beside,) = run.plan.neighbours
    assert beside.motion.waiting > 0.5
    robot, other = run.robot, beside.neighbour.robot
    t = np.linspace(0.0, run.plan.duration, 6000)
    main = np.concatenate([leg.trajectory.at(t[(t >= a) & (t <= b)] - a).u for leg, a, b in _legs(run.plan)])
    times = np.concatenate([t[(t >= a) & (t <= b)] for _, a, b in _legs(run.plan)])
    q = beside.motion.at(times)
    assert max(np.abs(np.diff(q, axis=0)).max(), np.abs(np.diff(main, axis=0)).max()) < 2e-3
    mechanisms = [run.plan.surroundings._mechanism, other.mechanism]
    cell = MultiArmCell(
        [ArmMount(name, each, self_collision=False) for name, each in zip(("a", "b"), mechanisms, strict=True)]
    )
    gap = cell.distance(np.concatenate([main, q], axis=1)).distance
    assert gap.min() > 0.01
    goals = np.radians([[180, -35, 60, -25, -90, 0], [100, -70, 60, -25, -90, 0]])
    for goal in goals:
        assert np.abs(q - goal).max(axis=1).min() < 1e-3
    np.testing.assert_allclose(q[-1], goals[-1], atol=1e-9)
    assert robot.n == other.n == 6


def _legs(plan):
    starts = plan.starts
    return [(leg, a, b) for leg, a, b in zip(plan.legs, starts[:-1], starts[1:], strict=True)]


@pytest.mark.capability("11-45")
def test_the_clock_of_the_replay_names_moves_of_the_job_alone(run):
    """The table has the moves of both; bands of plots and the name above the replay follow the robot of the job."""
    steps = page_of(run, summary(run), "en").steps
    assert [step.beside for step in steps] == sorted(step.beside for step in steps)
    ends = [step.end for step in steps if not step.beside]
    assert len(ends) == len(run.plan.legs)
    assert ends == sorted(ends)
    assert any(step.beside for step in steps)


@pytest.mark.capability("11-45")
def test_both_stand_in_the_replay_and_in_the_clearance(run):
    found = clearances(run)
    names = {*found.first, *found.second}
    assert any(name.startswith("right/") for name in names)
    assert any(name.startswith("job/") for name in names)
    assert found.distance.min() > 0.005
    drawn = replay_scene(run)
    (beside,) = run.plan.neighbours
    assert len(drawn.carried) == len(beside.neighbour.robot.mechanism.links)
    assert len(drawn.fixed) == 1, "the table"
    poses = beside.poses(drawn.times)
    for k, each in enumerate(drawn.carried):
        np.testing.assert_allclose(each.poses[:, :3], poses[:, k, :3, 3], atol=1e-12)
    assert np.ptp(drawn.carried[-1].poses[:, :3], axis=0).max() > 0.3
    sentences = [remark.sentence("en") for remark in run.remarks]
    assert any("right moves at the same time" in each for each in sentences)


@pytest.mark.capability("11-45")
def test_a_robot_that_only_stands_there_is_gone_round():
    """Its body is met by the straight way; with avoid the way leads round, else the job is refused by its name."""
    refused = planned(HEAD + RIGHT)
    assert isinstance(refused, Refusal)
    assert "right/" in refused.explain("en")
    text = HEAD.replace("clearance = 0.01", "clearance = 0.01\navoid = true") + RIGHT
    _, plan = planned(text)
    leg = plan.legs[0]
    assert plan.surroundings.checker(leg.load).free(leg.trajectory.at(np.linspace(0, plan.duration, 3000)).u).all()
    (beside,) = plan.neighbours
    assert beside.neighbour.stands
    np.testing.assert_allclose(beside.motion.at([0.0, 5.0]), np.radians([[180, -35, 60, -25, -90, 0]] * 2))


@pytest.mark.capability("11-45")
def test_a_move_without_a_way_is_refused_by_name():
    """The robot of the job ends where the other one is to go."""
    text = HEAD.replace("[220,", "[180,") + RIGHT.replace("joints = [180, -35", "joints = [100, -70")
    text += "[[other_robot.move]]\njoints = [177, -35, 60, -25, -90, 0]\n"
    refused = planned(text)
    assert isinstance(refused, Refusal)
    assert refused.explain("en").startswith("right, move 1")
    assert "job/" in refused.explain("en")
    assert refused.explain("ar") != refused.explain("en")


@pytest.mark.parametrize(
    ("words", "change"),
    [
        ("exactly one of", "[[other_robot.move]]\nspeed = 0.5\n"),
        ("exactly one of", "[[other_robot.move]]\npause = 1\njoints = [0, 0, 0, 0, 0, 0]\n"),
        ("has 3 numbers", "[[other_robot.move]]\njoints = [0, 0, 0]\n"),
        ("would be at 900°, outside its limits", "[[other_robot.move]]\njoints = [900, 0, 0, 0, 0, 0]\n"),
        ("not a name of another robot", RIGHT),
        ("unknown key", "[[other_robot.move]]\njoint = [0]\n"),
        ("rpy, quaternion", "quaternion = [1, 0, 0, 0]\n"),
    ],
)
def test_what_is_refused_names_the_line(words, change):
    with pytest.raises(JobError, match=words) as caught:
        planned(HEAD + RIGHT + change)
    assert "<text>:" in str(caught.value)


def test_a_robot_that_is_not_known_is_named_with_the_line_that_names_it():
    with pytest.raises(FileError, match=r"<text>:13: other_robot\[1\].robot: ur6: .*did you mean: ur5"):
        planned(HEAD + RIGHT.replace('"ur5"', '"ur6"'))


def test_lengths_and_files_of_other_robots():
    text = HEAD.replace('angles = "degrees"', 'angles = "degrees"\nlengths = "millimetres"').replace("0.01", "10")
    job = parse_job(text + RIGHT.replace("[1.2, 0, 0]", "[1200, 0, 0]"))
    assert job.other_robot[0].position == (1.2, 0.0, 0.0)


def test_pairs_of_another_robot_are_left_out_by_its_file_or_by_name(tmp_path):
    (tmp_path / "touching.urdf").write_text(TOUCHING)
    (tmp_path / "touching.srdf").write_text(LISTED)
    moves = "joints = [0, 0]\n{}[[other_robot.move]]\njoints = [60, 0]\n"
    beside = '[[other_robot]]\nname = "right"\nrobot = "touching.urdf"\nposition = [5, 0, 0]\n' + moves

    def solved(more):
        text = HEAD + beside.format(more)
        return prepare(parse_job(text), text, tmp_path)

    assert not solved("")
    assert solved('srdf = "touching.srdf"\n')
    assert solved('skip = [["base", "end"]]\n')
    with pytest.raises(FileError, match=r"other_robot\[1\].srdf.*none.srdf"):
        solved('srdf = "none.srdf"\n')


@pytest.mark.capability("11-45")
def test_another_robot_goes_to_a_pose_in_space():
    """With the orientation that its tip has; through the inverse kinematics, a configuration that is free."""
    text = HEAD + RIGHT.replace("joints = [180, -35", "joints = [100, -70")
    text += "[[other_robot.move]]\npose = { position = [1.5, 0.3, 0.3] }\n"
    _, plan = planned(text)
    (beside,) = plan.neighbours
    robot, motion = beside.neighbour.robot, beside.motion
    first, last = robot.forward_kinematics(motion.at([0.0, motion.duration]))
    np.testing.assert_allclose(last[:3, 3], [1.5, 0.3, 0.3], atol=1e-8)
    np.testing.assert_allclose(last[:3, :3], first[:3, :3], atol=1e-8)
    far = text.replace("[1.5, 0.3, 0.3]", "[9.0, 0.3, 0.3]")
    assert "no configuration was found" in planned(far).explain("en")


TALK = """
robot = "ur5"
angles = "degrees"
[start]
joints = [140, -35, 60, -25, -90, 0]
[collision]
clearance = 0.01
[output]
left_out = false
right_done = false
[[move]]
name = "mine"
joints = [180, -35, 60, -25, -90, 0]
[[move]]
joints = [220, -35, 60, -25, -90, 0]
[[move]]
set = { left_out = true }
[[move]]
wait = { right_done = true }
[[move]]
joints = [180, -35, 60, -25, -90, 0]
[simulation]
settle = 0.05
[[other_robot]]
name = "right"
robot = "ur5"
position = [1.2, 0, 0]
rpy = [0, 0, 180]
joints = [100, -70, 60, -25, -90, 0]
[[other_robot.move]]
wait = { left_out = true }
[[other_robot.move]]
joints = [180, -35, 60, -25, -90, 0]
[[other_robot.move]]
joints = [100, -70, 60, -25, -90, 0]
[[other_robot.move]]
set = { right_done = true }
[[other_robot.move]]
joints = [100, -60, 60, -25, -90, 0]
"""


@pytest.fixture(scope="module")
def talk():
    found = solve(parse_job(TALK), TALK, Path())
    assert found, found.explain("en")
    return found


@pytest.mark.capability("11-45")
def test_two_arms_shake_hands(talk):
    """The second enters when the first has left, the first goes on when the second is done; each in its own time."""
    (beside,) = talk.plan.neighbours
    starts, legs = talk.plan.starts, talk.plan.legs
    left, done = ({c.signal: c.time for c in talk.plan.signals.timeline(99.0, 99) if c.time > 0.0}[name]
                  for name in ("left_out", "right_done"))  # fmt: skip
    steps = beside.steps
    assert [step.kind for step in steps] == ["wait", "joint", "joint", "set", "joint"]
    assert left == pytest.approx(starts[3], abs=1e-9)
    assert left <= steps[0].end <= left + 2e-3, "the other one sees it at its next tick"
    assert done == steps[3].end
    assert legs[3].kind == "wait"
    assert done - 1e-9 <= starts[4] <= done + 2e-3
    t = np.linspace(0.0, talk.plan.duration, 3000)
    q = beside.motion.at(t)
    assert np.ptp(q[t < left], axis=0).max() == 0.0, "it stands until then"
    np.testing.assert_allclose(beside.motion.at(steps[1].end), np.radians([180, -35, 60, -25, -90, 0]), atol=1e-9)
    assert clearances(talk).distance.min() > 0.01 - 1e-6
    assert any(one.kind == "joint" and one.end > starts[4] for one in steps), "both move in the end"


def test_report_and_results_show_the_moves_of_both(talk):
    for language in ("en", "ar"):
        page = page_of(talk, summary(talk), language)
        rows = [step for step in page.steps if step.name.startswith(("right,", "right،"))]
        assert [row.text for row in rows] == ["left_out = true", "", "", "right_done = true", ""]
        plot = next(each for each in page.plots if each.column == "signals")
        assert plot.values[:, plot.names.index("right_done")].max() == 1.0
    (other,) = as_data(talk, summary(talk))["other_robots"]
    assert [step["kind"] for step in other["steps"]] == ["wait", "joint", "joint", "set", "joint"]
    assert all(np.isnan(one.saved) or one.saved == 0.0 for one in talk.limits), "what others would do is not known"


@pytest.mark.parametrize("language", ["en", "ar"])
def test_robots_that_wait_for_each_other_are_named(language):
    no = planned(TALK.replace("set = { left_out = true }", "pause = 0.1"))
    assert no.key == "job.deadlock"
    said = no.explain(language)
    assert all(words in said for words in ("right_done = true", "left_out = true", "right", "4"))
    assert "{" not in said


def test_waits_that_never_end_are_refused_by_name():
    no = planned(TALK.replace("set = { right_done = true }", "pause = 0.1"))
    assert no.key == "job.wait_never"
    assert "right_done is false" in no.explain("en")
    alone = TALK.replace("set = { left_out = true }", "pause = 0.1").replace(
        "wait = { right_done = true }", "pause = 1"
    )
    no = planned(alone)
    assert no.key == "job.other_wait_never"
    assert no.explain("en").startswith("right, move 1: waits from")
    late = alone.replace("wait = { left_out = true }", "wait = { clock = true }\ntimeout = 0.5")
    no = planned(late + "[input.clock]\nchanges = [[3.0, true]]\n")
    assert no.key == "job.other_wait_late"
    assert "500 ms" in no.explain("en")
    assert "3 s" in no.explain("en")


def test_two_others_that_wait_for_each_other_are_named():
    far = 'robot = "planar2r"\njoints = [0, 10]\n'
    text = 'robot = "planar2r"\nangles = "degrees"\n[output]\na = false\nb = false\n[[move]]\njoints = [10, 20]\n'
    for k, (wanted, given) in enumerate((("b", "a"), ("a", "b")), start=1):
        text += f'[[other_robot]]\nname = "arm {k}"\nposition = [0, 0, {k}]\n{far}'
        text += (
            f"[[other_robot.move]]\nwait = {{ {wanted} = true }}\n[[other_robot.move]]\nset = {{ {given} = true }}\n"
        )
    no = planned(text)
    assert no.key == "job.other_standstill"
    assert "arm 1, move 1, waits" in no.explain("en")
    assert "arm 2, move 1, waits" in no.explain("en")
    _, plan = planned(text.replace("wait = { b = true }", "pause = 0.2"))
    times = {each.neighbour.name: each.steps[-1].end for each in plan.neighbours}
    assert times["arm 1"] == pytest.approx(0.201, abs=1e-9)
    assert times["arm 1"] < times["arm 2"] < times["arm 1"] + 3e-3


def test_a_choice_may_look_at_what_another_robot_sets():
    text = """
robot = "planar2r"
[output]
gone = false
[[move]]
joints = [0.1, 0.3]
[[move]]
pause = 0.5
[[move]]
if = { gone = true }
then = [{ pause = 0.1, name = "yes" }]
else = [{ pause = 0.1, name = "no" }]
[[other_robot]]
name = "far"
robot = "planar2r"
position = [0, 0, 2]
[[other_robot.move]]
pause = PAUSE
"""
    text += "[[other_robot.move]]\nset = { gone = true }\n[[other_robot.move]]\njoints = [0.4, 0.4]\n"
    for pause, name in (("0.3", "yes"), ("3.0", "no")):
        _, plan = planned(text.replace("PAUSE", pause))
        assert name in [leg.name for leg in plan.legs]
        assert [step.kind for step in plan.neighbours[0].steps] == ["pause", "set", "joint"]


def test_who_stands_in_the_way_after_a_hand_shake_is_named():
    """The other one sets its signal inside the zone and stays, or leaves it too late; then no proof is claimed."""
    stays = TALK.replace("[[other_robot.move]]\njoints = [100, -70, 60, -25, -90, 0]\n", "", 1)
    stays = stays.replace("[[other_robot.move]]\njoints = [100, -60, 60, -25, -90, 0]\n", "")
    refused = planned(stays)
    assert isinstance(refused, Refusal)
    assert refused.key == "job.other_meets"
    assert "job/" in refused.explain("en")
    assert "right/" in refused.explain("ar")
    late = stays + "[[other_robot.move]]\npause = 9\n[[other_robot.move]]\njoints = [100, -60, 60, -25, -90, 0]\n"
    assert planned(late).key == "job.other_no_way"
    in_time = stays + "[[other_robot.move]]\njoints = [100, -60, 60, -25, -90, 0]\n"
    assert planned(in_time.replace("wait = { right_done = true }", "wait = { right_done = true }\n[[move]]\npause = 1"))


@pytest.mark.parametrize(
    ("key", "change"),
    [
        ("job.signal_owner", ("set = { right_done = true }", "set = { left_out = true }")),
        ("job.signal_unknown", ("set = { right_done = true }", "set = { done = true }")),
        ("job.signal_digital", ("wait = { left_out = true }", "wait = { left_out = 1 }")),
        ("job.other_move", ("wait = { left_out = true }", "wait = { left_out = true }\npause = 1")),
        ("job.unknown_key_close", ("wait = { left_out = true }", "wiat = { left_out = true }")),
    ],
)
@pytest.mark.parametrize("language", ["en", "ar"])
def test_wrong_signals_of_other_robots_are_named(key, change, language):
    with pytest.raises(JobError) as caught:
        parse_job(TALK.replace(*change))
    assert caught.value.key == key
    assert "<text>:" in caught.value.message(language)


CRATE = """
robot = "ur5"
angles = "degrees"
[collision]
clearance = 0.01
[start]
joints = [140, -35, 60, -25, -90, 0]
[[move]]
pick = { name = "crate", mass = 0.5, size = [0.1, 0.1, 0.2], offset = [0, 0, 0.15] }
[[move]]
joints = [180, -35, 60, -25, -90, 0]
[[move]]
place = true
[[move]]
joints = [80, -70, 60, -25, -90, 0]
[[other_robot]]
name = "right"
robot = "ur5"
position = [1.2, 0, 0]
rpy = [0, 0, 180]
joints = [140, -35, 60, -25, -90, 0]
[[other_robot.move]]
pause = 5
[[other_robot.move]]
joints = [240, -35, 60, -25, -90, 0]
"""


@pytest.mark.capability("11-45", "11-46")
def test_other_robots_go_round_parts_that_were_put_down():
    """The straight way leads 9 cm through the crate; the robot that has put it down is far away by then."""
    plan = planned(CRATE)[1]
    (beside,) = plan.neighbours
    around, _, (stay,) = plan.surroundings._others
    assert (stay.put, stay.taken) == (plan.starts[2], np.inf)
    check = Checker(beside.neighbour.robot, [stay.body], self_collision=False)
    start, goal = beside.neighbour.start, beside.steps[-1].q
    assert check.distance(start + np.linspace(0.0, 1.0, 101)[:, None] * (goal - start)).distance.min() < -0.08
    assert check.distance(beside.motion.at(np.linspace(0.0, beside.motion.duration, 3000))).distance.min() > 0.01
    t = np.linspace(0.0, beside.motion.duration, 300)
    near = plan.surroundings.clearances_beside(plan.start[None].repeat(len(t), axis=0), t)
    crate = np.array([each.second == "crate 1" for each in near])
    assert crate[t > stay.put].any(), "the nearest on the way round it"
    assert not crate[t < stay.put].any(), "it stands there from its time on"

    def straight(begin):
        part = quintic(start, goal, 2.0)
        return TimedArm(
            (rest(start, begin), part), np.array([0.0, begin, begin + 2.0]), (True, False), np.full(6, 10.0)
        )

    time, contact = around.near_part("right", straight(5.0), stay)
    assert 5.0 < time < 7.0
    assert "crate 1" in (contact.first, contact.second)
    assert around.near_part("right", straight(5.0), Stay(stay.body, 8.0)) is None, "it has passed by then"
    assert around.near_part("right", straight(5.0), Stay(stay.body, 1.0, 5.2)) is None, "it is taken before"
    inside = TimedArm((rest(straight(5.0).at(time + 0.1), 1.0),), np.array([0.0, 1.0]), (True,), np.full(6, 10.0))
    assert around.near_part("right", inside, Stay(stay.body, 8.0))[0] == 8.0, "who stands there when it comes"


@pytest.mark.parametrize("language", ["en", "ar"])
def test_what_comes_too_near_is_said_in_words(language):
    stays = TALK.replace("[[other_robot.move]]\njoints = [100, -70, 60, -25, -90, 0]\n", "", 1)
    stays = stays.replace("[[other_robot.move]]\njoints = [100, -60, 60, -25, -90, 0]\n", "")
    said = planned(stays).explain(language)
    assert "Contact(" not in said
    assert "mm" in said or "مم" in said


CHOICES = """
robot = "ur5"
angles = "degrees"
[variables]
kind = "b"
[output]
done = false
[input.camera]
start = true
changes = [[1.5, false]]
[start]
joints = [140, -35, 60, -25, -90, 0]
[[move]]
wait = { done = true }
[[move]]
joints = [150, -35, 60, -25, -90, 0]
[[other_robot]]
name = "right"
robot = "ur5"
position = [1.6, 0, 0]
rpy = [0, 0, 180]
joints = [100, -70, 60, -25, -90, 0]
[[other_robot.move]]
while = { camera = true }
repeat = 4
do = [{ joints = [120, -70, 60, -25, -90, 0] }, { joints = [100, -70, 60, -25, -90, 0] }]
[[other_robot.move]]
if = { kind = "a" }
then = [{ joints = [130, -70, 60, -25, -90, 0] }]
else = [{ joints = [90, -70, 60, -25, -90, 0] }, { if = { camera = false }, then = [{ set = { done = true } }] }]
[[other_robot.move]]
joints = [100, -70, 60, -25, -90, 0]
"""


@pytest.mark.capability("11-45")
def test_programs_of_other_robots_have_loops_and_choices():
    plan = planned(CHOICES)[1]
    (beside,) = plan.neighbours
    steps = beside.steps
    kinds = [step.kind for step in steps]
    assert kinds == ["if", "joint", "joint", "if", "joint", "joint", "if", "if", "joint", "if", "set", "joint"]
    chosen = [step for step in steps if step.kind == "if"]
    assert [step.decision.holds for step in chosen] == [True, True, False, False, True]
    # Each looks at the next tick, and the camera changes at 1.5 s.
    assert all(
        1e-3 - 1e-9 <= step.end - step.start < 2e-3 and abs(step.end * 1e3 - round(step.end * 1e3)) < 1e-6
        for step in chosen
    )
    assert [step.decision.holds for step in chosen[:3]] == [step.end < 1.5 for step in chosen[:3]]
    assert "kind is" in chosen[3].decision.explain(language="en")
    assert [step.number for step in steps] == [1] * 7 + [2] * 4 + [3]
    (done,) = (change.time for change in plan.signals.timeline(99.0, 99) if change.signal == "done" and change.time > 0)
    assert plan.starts[1] == pytest.approx(done + 1e-3, abs=1.1e-3)
    said = [remark.key for remark in plan.remarks]
    assert said.count("job.then_never") == 1, "of the choice with an `else` that was always taken"
    assert beside.steps[9].to_dict()["choice"]["holds"] is True
    other = planned(CHOICES.replace('kind = "b"', 'kind = "a"'))
    assert other.key == "job.other_wait_never" or "done" in other.explain("en"), "nobody sets it on that way"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("repeat = 4\n", ""), "other_robot.1..move.1.: a loop with `while` has `repeat`"),
        (("then = [{ joints = [130", "thn = [{ joints = [130"), "did you mean: then"),
        (('if = { kind = "a" }\n', ""), "other_robot.1..move.2..: give exactly one of"),
        (('if = { kind = "a" }', "if = { kind = 1 }"), "a text is compared with a text"),
        (("if = { camera", "if = { camra"), "no signal and no variable 'camra'; known: camera"),
        (("[90, -70", "[900, -70"), "move.2..else.1..joints.*900°, outside its limits"),
        (("repeat = 4", "repeat = 100000"), "more than 200000 moves"),
        (("repeat = 4\ndo", "do = []\nrepeat = 1\n# do"), "a loop of another robot has moves in `do`"),
        (("set = { done = true }", "set = { gone = true }"), "no signal 'gone'"),
    ],
)
def test_wrong_programs_of_other_robots_are_named(change, words):
    assert change[0] in CHOICES
    with pytest.raises(JobError, match=words) as caught:
        planned(CHOICES.replace(*change))
    assert str(caught.value).startswith("<text>:")


HANDOVER = """
robot = "ur5"
angles = "degrees"
[output]
holds = false
taken = false
[start]
joints = [180, -75, 60, -75, -90, 0]
[[other_robot]]
name = "holder"
robot = "ur5"
position = [1.4, 0.0, 0.0]
rpy = [0, 0, 180]
joints = [150, -70, 70, -90, 90, 0]
[[other_robot.move]]
joints = [180, -70, 70, 0, 90, 0]
[[other_robot.move]]
set = { holds = true }
[[other_robot.move]]
wait = { taken = true }
[[other_robot.move]]
joints = [150, -70, 70, -90, 90, 0]
[frame.held]
robot = "holder"
position = [0, 0, 0.1]
[part.gear]
mass = 0.3
size = [0.04, 0.04, 0.04]
at = { frame = "held" }
[[move]]
wait = { holds = true }
[[move]]
name = "before"
pose = { frame = "held", position = [0, 0, 0.1], rpy = [180, 0, 0] }
[[move]]
path = "line"
pose = { frame = "held", rpy = [180, 0, 0] }
[[move]]
pick = "gear"
[[move]]
path = "line"
pose = { relative = "tool", position = [0, 0, -0.1] }
[[move]]
set = { taken = true }
[[move]]
joints = [180, -75, 60, -75, -90, 0]
[[move]]
place = true
"""


def test_a_part_is_taken_from_the_tip_of_another_robot():
    plan = prepare(parse_job(HANDOVER), HANDOVER, Path())[1]
    other = np.diag([-1.0, -1.0, 1.0, 1.0])
    other[0, 3] = 1.4
    held = other @ mf.load("ur5").fk([180, -70, 70, 0, 90, 0], degrees=True) @ pose.from_translation([0, 0, 0.1])
    line = plan.legs[2]
    end = line.load.robot.forward_kinematics(line.trajectory.at(line.trajectory.duration).u)
    np.testing.assert_allclose(end, held @ np.diag([1.0, -1, -1, 1]), atol=1e-6)
    assert plan.legs[-2].kind == "place"


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("wait = { taken = true }", "pause = 0.2", "job.frame_robot_moves"),
        ('frame = "held", rpy', 'frame = "held", position = [0.03, 0, 0], rpy', "job.none_here"),
    ],
)
def test_a_pose_on_another_robot_holds_while_that_stands(old: str, new: str, key: str):
    text = HANDOVER.replace(old, new)
    found = prepare(parse_job(text), text, Path())
    assert isinstance(found, Refusal)
    assert found.key == key


@pytest.mark.parametrize("new", ["robot = 'nobody'", "robot = 'holder'\nvelocity = [0.1, 0, 0]"])
def test_wrong_frames_on_other_robots_are_refused_with_their_line(new: str):
    with pytest.raises(JobError, match=r"job\.toml:\d+"):
        parse_job(HANDOVER.replace('robot = "holder"', new), "job.toml")
