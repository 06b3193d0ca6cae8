"""Jobs planned and driven: goals reached, limits kept, loads felt, reasons given."""

from pathlib import Path

import numpy as np
import pytest

from mafsil.errors import JobError, MafsilError
from mafsil.job import Refusal, Run, parse_job, solve
from mafsil.job.judging.judgement import summary
from mafsil.job.language.units import pose_matrix
from mafsil.job.planning.equipment import equipment_of
from mafsil.job.planning.move_planner import plan_moves
from mafsil.job.planning.plan import Plan
from mafsil.trajectory import check

JOBS = Path(__file__).parents[2] / "examples" / "jobs"
NAMES = ("pick_and_place_panda", "pick_and_place_puma560", "pick_and_place_ur5_urdf")
TWO_MOVES = """
robot = "panda"
[start]
joints = [0, -0.4, 0, -2.0, 0, 1.8, 0.8]
[simulation]
step = 0.002
[[move]]
name = "there"
joints = [0.3, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]
"""


def solved(text: str) -> Run:
    run = solve(parse_job(text), text, JOBS)
    assert isinstance(run, Run), run.explain()
    return run


@pytest.mark.capability("02-12")
@pytest.mark.parametrize("name", NAMES)
def test_examples_reach_every_target_within_limits(name: str) -> None:
    path = JOBS / f"{name}.toml"
    text = path.read_text(encoding="utf-8")
    run = solve(parse_job(text), text, path.parent)
    assert isinstance(run, Run)
    assert run.stopped is None
    job, tape = run.job, run.recording
    targets = [move for move in job.move if move.pose is not None]
    legs = [leg for leg in run.plan.legs if leg.target is not None]
    assert len(targets) == len(legs)
    for move, leg in zip(targets, legs, strict=True):
        assert move.pose is not None
        reached = run.robot.forward_kinematics(leg.trajectory.at(leg.trajectory.duration).u)
        np.testing.assert_allclose(reached, pose_matrix(move.pose, degrees=True), atol=1e-9)
    numbers = summary(run)
    assert not numbers.not_reached
    assert len(numbers.arrivals) == numbers.targets
    assert all(remark.level != "failure" for remark in run.remarks)
    limits = run.robot.limits
    assert (tape.q >= limits.lower - 1e-6).all()
    assert (tape.q <= limits.upper + 1e-6).all()
    assert (np.abs(tape.tau) <= limits.effort + 1e-12).all()


@pytest.mark.parametrize("name", NAMES)
def test_plans_are_continuous_at_rest_and_within_speed_limits(name: str) -> None:
    path = JOBS / f"{name}.toml"
    job = parse_job(path.read_text(encoding="utf-8"))
    tools = equipment_of(job, path.parent)
    robot, motion = tools[0].robot, plan_moves(job, tools)
    assert isinstance(motion, Plan)
    q = motion.start
    for leg in motion.legs:
        begin, end = leg.trajectory.at(0.0), leg.trajectory.at(leg.trajectory.duration)
        np.testing.assert_allclose(begin.u, q, atol=1e-9)
        np.testing.assert_allclose([begin.v, end.v], 0.0, atol=1e-6)
        assert check(leg.trajectory, robot.limits, robot.joint_names, tolerance=1e-6)
        q = end.u


def test_lines_are_straight() -> None:
    path = JOBS / "pick_and_place_panda.toml"
    job = parse_job(path.read_text(encoding="utf-8"))
    tools = equipment_of(job, path.parent)
    robot, motion = tools[0].robot, plan_moves(job, tools)
    assert isinstance(motion, Plan)
    for leg in motion.legs:
        if leg.kind != "line":
            continue
        p = robot.forward_kinematics(leg.trajectory.at(np.linspace(0, leg.trajectory.duration, 400)).u)[:, :3, 3]
        along = (p[-1] - p[0]) / np.linalg.norm(p[-1] - p[0])
        across = (p - p[0]) - np.outer((p - p[0]) @ along, along)
        assert np.linalg.norm(across, axis=1).max() < 1e-5


@pytest.mark.row("D1")
def test_same_job_same_bits() -> None:
    text = TWO_MOVES.replace("step = 0.002", "step = 0.002\nnoise = { position = 1e-4, velocity = 1e-3, seed = 5 }")
    first, second = solved(text).recording, solved(text).recording
    for name, array in first.arrays().items():
        assert array.tobytes() == second.arrays()[name].tobytes(), name


def test_unknown_load_is_felt_and_known_load_is_not() -> None:
    errors = {}
    for known in ("true", "false"):
        pick = f"\n[[move]]\npick = {{ mass = 2.0, known = {known} }}\n"
        pick += "[[move]]\njoints = [0, -0.4, 0, -2.0, 0, 1.8, 0.8]\n"
        errors[known] = summary(solved(TWO_MOVES + pick)).joint_error.max()
    assert errors["true"] < 1e-3
    assert errors["false"] > 20 * errors["true"]


def test_push_moves_the_arm() -> None:
    push = "\n[[disturbance]]\nstart = 0.2\nduration = 0.1\nwrench = [0, 0, 0, 0, 0, 60]\n"
    assert summary(solved(TWO_MOVES + push)).tip_error > 10 * summary(solved(TWO_MOVES)).tip_error


def test_time_axis_is_even_across_loads() -> None:
    text = (JOBS / "pick_and_place_panda.toml").read_text(encoding="utf-8")
    t = solved(text).recording.t
    np.testing.assert_allclose(np.diff(t), 0.001, atol=1e-9)


def test_durations_given_are_kept_or_refused() -> None:
    assert solved(TWO_MOVES + "duration = 3.0\n").plan.legs[0].trajectory.duration == 3.0
    answer = solve(parse_job(TWO_MOVES + "duration = 0.01\n"), "", JOBS)
    assert isinstance(answer, Refusal)
    assert "move 1 'there'" in answer.explain("en")


@pytest.mark.parametrize(
    ("pose", "word"),
    [
        ("pose = { position = [5.0, 0.0, 0.3] }", "reach"),
        ("pose = { position = [0.0, 0.0, 0.3], rpy = [0, 3.1, 0] }", ""),
        ('pose = { position = [5.0, 0.0, 0.3] }\npath = "line"', "of its length"),
    ],
)
def test_impossible_goals_are_refused_with_the_move_and_a_reason(pose: str, word: str) -> None:
    answer = solve(parse_job(TWO_MOVES + f'[[move]]\nname = "far"\n{pose}\n'), "", JOBS)
    assert isinstance(answer, Refusal)
    assert "move 2 'far'" in answer.explain("en")
    assert word in answer.explain("en")
    assert any("\u0600" <= c <= "\u06ff" for c in answer.explain("ar"))


@pytest.mark.parametrize(
    ("text", "key"),
    [
        (TWO_MOVES.replace("[0.3, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]", "[0.3]"), "job.joint_count"),
        (TWO_MOVES.replace("[0.3, -0.2,", "[3.3, -0.2,"), "job.outside_limits"),
        (TWO_MOVES.replace("[0.3, -0.2,", "[17, -0.2,"), "job.outside_limits_degrees"),
        (TWO_MOVES + "[[move]]\nplace = true\n", "job.nothing_carried"),
        (TWO_MOVES + "[[move]]\npick = { mass = 1 }\n" * 2, "job.already_carried"),
        (TWO_MOVES + '[controller]\nkind = "pd_gravity"\nkp = [1.0, 2.0]\n', "job.list_count"),
    ],
)
def test_numbers_that_do_not_fit_the_robot(text: str, key: str) -> None:
    with pytest.raises(JobError) as caught:
        solve(parse_job(text), text, JOBS)
    assert caught.value.key == key
    assert caught.value.message("en") != caught.value.message("ar")


def test_no_such_robot() -> None:
    for robot in ("pandda", "absent.urdf"):
        with pytest.raises(MafsilError):
            solve(parse_job(TWO_MOVES.replace('"panda"', f'"{robot}"')), "", JOBS)


def test_robot_without_masses_is_refused_where_forces_are_asked_for(tmp_path: Path) -> None:
    urdf = '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint></robot>'  # noqa: E501
    (tmp_path / "r.urdf").write_text(urdf, encoding="utf-8")
    text = 'robot = "r.urdf"\n[simulation]\nplant = "mafsil"\n[[move]]\njoints = [1.0]\n'
    with pytest.raises(JobError) as caught:
        solve(parse_job(text), text, tmp_path)
    assert caught.value.key == "job.no_mass"


def test_remarks_name_joints_at_their_limits() -> None:
    text = TWO_MOVES.replace("[0.3, -0.2,", "[2.89, -0.2,")
    keys = {remark.key for remark in solved(text).remarks}
    assert "job.tight_limit" in keys
    late = TWO_MOVES + "[[disturbance]]\nstart = 99\nduration = 1\nwrench = [0, 0, 0, 0, 0, 1]\n"
    assert "job.late_disturbance" in {remark.key for remark in solved(late).remarks}


def test_a_wild_controller_is_reported_not_hidden() -> None:
    text = TWO_MOVES + '[controller]\nkind = "pd_gravity"\nkp = 1e9\nkd = 1e9\n'
    run = solved(text)
    assert any(remark.level == "failure" for remark in run.remarks)
    for remark in run.remarks:
        assert remark.sentence("en")
        assert remark.sentence("ar")
