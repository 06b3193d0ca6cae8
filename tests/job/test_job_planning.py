"""Plans of jobs: configurations, slow places of lines, small arms, units, starts; every no with its line and remedy."""

import json
import re
from functools import cache
from pathlib import Path

import msgspec
import numpy as np
import pytest

from mafsil.cli.main import main
from mafsil.errors import FileError, JobError
from mafsil.ik import solve_ik
from mafsil.job import Refusal, Run, parse_job, schema, solve
from mafsil.job.judging.judgement import summary
from mafsil.job.language import JobFile
from mafsil.job.planning.plan import Plan
from mafsil.job.solve import prepare
from mafsil.messages import say
from mafsil.robot import Robot

HERE = Path(__file__).parent
DOCS = HERE.parents[1] / "docs"
PANDA = 'robot = "panda"\n[start]\njoints = [0, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]\n'
SLOW = """
robot = "panda"
[tool]
offset = { position = [0, 0, 0.1034], rpy = [0, 0, -0.785398163397] }
[start]
joints = [-1.824, -0.371, 1.092, -2.348, 0.38, 2.129, -0.187]
[[move]]
name = "down"
path = "line"
pose = { position = [0.36796872, -0.3, 0.139410612], quaternion = [-1.09494382e-06, 0.999984855, 0.000199078686, -0.00549997216] }
"""  # noqa: E501
VIA = "joints = [0.3, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]\nvia = [[0.1, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]]\n"


@cache  # several tests look at the plan of one text
def planned(text: str, folder: Path = HERE) -> tuple[Robot, Plan]:
    answer = prepare(parse_job(text, "x.toml"), text, folder, source="x.toml")
    assert not isinstance(answer, Refusal), answer.explain()
    return answer


def refused(text: str) -> Refusal:
    answer = prepare(parse_job(text, "x.toml"), text, HERE, source="x.toml")
    assert isinstance(answer, Refusal)
    assert any("\u0600" <= c <= "\u06ff" for c in answer.explain("ar"))
    return answer


def complaint(text: str) -> JobError:
    with pytest.raises(JobError) as caught:
        prepare(parse_job(text, "x.toml"), text, HERE, source="x.toml")
    assert any("\u0600" <= c <= "\u06ff" for c in caught.value.message("ar"))
    return caught.value


@pytest.mark.parametrize(
    ("move", "key", "words"),
    [
        ("pause = 1\nduration = 2", "job.no_effect", ["x.toml:6", "move[1].duration", "pause", "name"]),
        ("pause = 1\nhold = 2", "job.no_effect", ["move[1].hold"]),
        ("pick = { mass = 1 }\nspeed = 0.5", "job.no_effect", ["move[1].speed", "pick", "hold"]),
        ("place = true\nvia = [[0, 0, 0, 0, 0, 0, 0]]", "job.no_effect", ["move[1].via", "place"]),
        ('place = true\nprofile = "quintic"', "job.no_effect", ["move[1].profile"]),
        ('pick = { mass = 1 }\npath = "line"', "job.no_effect", ["move[1].path"]),
        ("joints = [0, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]\nhold = 1", "job.no_effect", ["move[1].hold", "via"]),
        (VIA + 'profile = "trapezoid"', "job.via_profile", ["x.toml:7", "move[1].profile"]),
        ('pose = { position = [1, 0, 0], rpy = [0, 0, 0], task = "position" }', "job.free_orientation", ["rpy"]),
        ("joints = [0, 1]", "job.joint_count", ["x.toml:5", "move[1].joints", "7", "joint1"]),
        ("joints = [0, -0.2, 0.1, -1.8, 0.1, 1.7, 9]", "job.outside_limits_degrees", ["x.toml:5", "joint7", "9 rad"]),
        ("joints = [0, -0.2, 0.1, -1.8, 0.1, 1.7, 3]", "job.outside_limits", ["x.toml:5", "3 rad", "-2.897 rad"]),
        ("place = true", "job.nothing_carried", ["x.toml:5", "move[1].place"]),
        ("pick = { mass = 1 }\n[[move]]\npick = { mass = 1 }", "job.already_carried", ["x.toml:7", "move[2].pick"]),
        ("pause = 1\n[controller]\nrate = 300", "job.rate_not_whole", ["x.toml:7", "controller.rate", "250", "333.3"]),
        ("pause = 1\n[tolerance]\njoints = [1, 2]", "job.list_count", ["x.toml:7", "tolerance.joints", "7"]),
        (
            'pause = 1\n[controller]\nkind = "pd_gravity"\nkp = [1, 2]',
            "job.list_count",
            ["x.toml:8", "controller.kp"],
        ),
    ],
)
def test_what_does_nothing_or_does_not_fit_is_refused_with_its_line(move: str, key: str, words: list[str]) -> None:
    error = complaint(PANDA + f"[[move]]\n{move}\n")
    assert error.key == key
    for word in words:
        assert word in error.message("en")


def test_two_starts_are_refused() -> None:
    text = PANDA + "pose = { position = [0.4, 0, 0.4] }\n[[move]]\npause = 1\n"
    assert complaint(text).key == "job.two_starts"
    assert "x.toml:4" in complaint(text).message("en")


def test_types_are_named_for_people_in_both_languages() -> None:
    error = complaint(PANDA + '[[move]]\npause = "long"\n')
    assert "must be a number, got 'long'" in error.message("en")
    assert "عددًا" in error.message("ar")
    assert "float" not in error.message("ar")


@pytest.mark.parametrize(
    ("text", "key", "line"),
    [
        ('robot = "a\n', "string", 1),
        ("a = 1\na = 2\n", "twice", 2),
        ("a = 1\n[b\n", "header", 2),
        ("a = fast\n", "value", 1),
        ("a = 1 b = 2\n", "newline", 1),
        ("a 1\n", "equals", 1),
    ],
)
def test_sentences_of_the_parser_are_our_own_in_both_languages(text: str, key: str, line: int) -> None:
    with pytest.raises(FileError) as caught:
        parse_job(text, "x.toml")
    assert f"x.toml:{line}:" in caught.value.message("en")
    for language in ("en", "ar"):
        assert say(f"job.toml_{key}", language=language) in caught.value.message(language)
    assert not any(word in caught.value.message("ar") for word in ("Invalid", "Expected", "Cannot", "line"))


def test_a_duration_holds_with_via_points() -> None:
    _, free = planned(PANDA + "[[move]]\n" + VIA)
    shortest = free.legs[0].trajectory.duration
    robot, slow = planned(PANDA + "[[move]]\n" + VIA + "duration = 9\n")
    curve = slow.legs[0].trajectory
    assert curve.duration == pytest.approx(9.0)
    passed = curve.at(np.linspace(0.0, 9.0, 9001)).u
    assert np.abs(passed - [0.1, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]).max(axis=1).min() < 1e-4
    answer = refused(PANDA + "[[move]]\n" + VIA + "duration = 0.001\n")
    assert answer.key == "job.too_fast"
    assert "move 1 (line 4)" in answer.explain("en")
    said = float(str(answer.details["shortest"]))
    assert shortest <= said <= shortest + 1e-3
    again, tight = planned(PANDA + "[[move]]\n" + VIA + f"duration = {said}\n")
    v = tight.legs[0].trajectory.at(np.linspace(0.0, said, 5001)).v
    assert (np.abs(v) <= 0.7 * robot.limits.velocity * (1 + 1e-6)).all()
    assert again.n == robot.n


def test_a_curve_that_leaves_the_range_between_its_points_says_where_with_units() -> None:
    near = "[[move]]\njoints = [2.89, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]\n"
    text = PANDA + near + "[[move]]\njoints = [0.3, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]\n"
    text += "via = [[2.8, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6], [2.89, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]]\n"
    answer = refused(text)
    assert answer.key == "job.leaves_range"
    for word in ("move 2 (line 6)", "joint1", "166°"):
        assert word in answer.explain("en")


@pytest.mark.parametrize("profile", ["quintic", "trapezoid"])
def test_too_short_joint_moves_and_lines_say_the_shortest_duration(profile: str) -> None:
    goals = ("joints = [0.3, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]", 'pose = { position = [0.5, 0.1, 0.5] }\npath = "line"')
    for goal in goals:
        text = PANDA + f'[[move]]\n{goal}\nprofile = "{profile}"\n'
        answer = refused(text + "duration = 0.001\n")
        said = float(str(answer.details["shortest"]))
        shortest = planned(text)[1].legs[0].trajectory.duration
        assert shortest <= said <= shortest + 1e-3
        assert planned(text + f"duration = {said}\n")[1].legs[0].trajectory.duration == pytest.approx(said)


def test_one_near_singular_point_slows_a_line_only_there() -> None:
    robot, motion = planned(SLOW)
    leg = motion.legs[0].trajectory
    # Time-optimal along the same path without a bound of jerk (TOPP-RA, on its grid): 1.29 s; slowed evenly: 49.8 s.
    assert 1.24 < leg.duration <= 1.29
    u = leg.at(np.arange(0.0, leg.duration, 1e-3))
    assert (np.abs(u.v) <= 0.7 * robot.limits.velocity * (1 + 1e-6)).all()
    acceleration = np.array([15, 7.5, 10, 12.5, 15, 20, 20]) * 0.7
    assert (np.abs(u.a) <= acceleration * (1 + 1e-6)).all()
    tip = robot.forward_kinematics(u.u)[:, :3, 3]
    assert np.linalg.norm(np.diff(tip, axis=0), axis=1).max() <= 0.25e-3 * (1 + 1e-6)
    along = (tip[-1] - tip[0]) / np.linalg.norm(tip[-1] - tip[0])
    assert np.abs((tip - tip[0]) - np.outer((tip - tip[0]) @ along, along)).max() < 1e-5
    (remark,) = [one for one in motion.remarks if one.key.startswith("job.slow_line")]
    sentence = remark.sentence("en")
    for word in ("move 1 'down' (line 7)", "joint3", "65.2 %", "44.9", "1.25 s"):
        assert word in sentence
    place = float(str(remark.details["place"]).removesuffix(" %")) / 100
    k = int(np.abs(np.linalg.norm(tip - tip[0], axis=1) / np.linalg.norm(tip[-1] - tip[0]) - place).argmin())
    margins = np.linalg.svd(robot.jacobian_body(u.u), compute_uv=False)[:, -1]
    assert margins[k] == pytest.approx(float(str(remark.details["margin"])), rel=0.3)
    assert any("\u0600" <= c <= "\u06ff" for c in remark.sentence("ar"))


def test_a_long_duration_stretches_the_line_evenly() -> None:
    _, motion = planned(SLOW + "duration = 60\n")
    leg = motion.legs[0].trajectory
    assert leg.duration == pytest.approx(60.0)
    u = leg.at(np.linspace(0.0, 60.0, 60001))
    assert len(np.unique(np.round(u.v, 12), axis=0)) > 1000


CYCLE = """
[[move]]
pose = { position = [0.45, -0.3, 0.3], rpy = [3.14159265358979, 0, 0] }
[[move]]
pose = { position = [0.45, -0.3, 0.2], rpy = [3.14159265358979, 0, 0] }
path = "line"
[[move]]
pose = { position = [0.3, 0.4, 0.3], rpy = [3.14159265358979, 0, 1.2] }
"""


def test_the_same_pose_is_taken_in_the_same_posture_each_cycle() -> None:
    _, motion = planned(PANDA + CYCLE * 4)
    ends = np.array([leg.trajectory.at(leg.trajectory.duration).u for leg in motion.legs if leg.index >= 0])
    for first in range(3):
        np.testing.assert_allclose(ends[first::3], np.broadcast_to(ends[first], (4, 7)), atol=1e-9)


def test_a_goal_in_joints_frees_the_posture() -> None:
    pose = "[[move]]\npose = { position = [0.45, -0.3, 0.3], rpy = [3.14159265358979, 0, 0] }\n"
    other = "[[move]]\njoints = [1.2, 0.5, -1.2, -2.0, 0.4, 2.0, 0.1]\n"
    _, motion = planned(PANDA + pose + other + pose)
    ends = [leg.trajectory.at(leg.trajectory.duration).u for leg in motion.legs]
    assert np.abs(ends[0] - ends[2]).max() > 0.05


def test_postures_are_chosen_so_that_the_next_line_runs() -> None:
    """From here the next line is impossible in the nearest configuration, and as fast as its tip in another."""
    start = [1.2, 0.27, 1.94, -1.12, 0.0, 0.59, -0.05]
    above, below = (f"pose = {{ position = [0.34, -0.29, {z}], rpy = [3.14159265358979, 0, 0] }}\n" for z in (0.4, 0.1))
    line = f'[[move]]\npath = "line"\n{below}'
    robot, motion = planned(f'robot = "panda"\n[start]\njoints = {start}\n[[move]]\n{above}{line}')
    target = motion.legs[0].target
    assert target is not None
    nearest = solve_ik(robot, target, start).q.tolist()
    assert refused(f'robot = "panda"\n[start]\njoints = {nearest}\n{line}').key == "job.no_path"
    shortest = 0.3 / 0.25 + 0.25 / 1.0
    assert shortest < motion.legs[1].trajectory.duration < 1.002 * shortest, "and a few milliseconds of limited jerk"


@pytest.mark.parametrize(
    ("robot", "start", "pose", "found"),
    [
        ("cobra600", "[0.3, 0.6, 0.05, 0.2]", "position = [0.4, 0.3, 0.3], rpy = [3.14159, 0, 0.5]", 2.65e-6),
        ("cobra600", "[0.3, 0.6, 0.05, 0.2]", "position = [0.4, 0.3, 0.3], rpy = [3.1406, 0, 0.5]", 1e-3),
    ],
)
def test_rounded_poses_of_small_arms_are_met_within_the_tolerance(
    robot: str, start: str, pose: str, found: float
) -> None:
    text = f'robot = "{robot}"\n[start]\njoints = {start}\n[[move]]\npose = {{ {pose} }}\n'
    arm, motion = planned(text)
    T = arm.forward_kinematics(motion.legs[0].trajectory.at(motion.legs[0].trajectory.duration).u)
    wanted = motion.legs[0].target
    assert wanted is not None
    off = np.arccos(np.clip((np.trace(T[:3, :3].T @ wanted[:3, :3]) - 1) / 2, -1, 1))
    assert off == pytest.approx(found, rel=0.01)
    np.testing.assert_allclose(T[:3, 3], wanted[:3, 3], atol=1e-9)
    told = [one for one in motion.remarks if one.key == "job.nearly_met"]
    assert len(told) == (found > 1e-4)
    run = solve(parse_job(text), text, HERE)
    assert isinstance(run, Run)
    assert not summary(run).not_reached


def test_a_tilt_beyond_the_tolerance_is_refused_with_the_remedy_and_allowed_by_it() -> None:
    text = 'robot = "cobra600"\n[start]\njoints = [0.3, 0.6, 0.05, 0.2]\n[[move]]\n'
    tilted = "position = [0.4, 0.3, 0.3], rpy = [3.1, 0, 0.5]"
    answer = refused(text + f"pose = {{ {tilted} }}\n")
    assert answer.key == "job.unreachable_few_pose"
    assert "move 1 (line 4)" in answer.explain("en")
    assert "2.38°" in answer.explain("en")
    assert 'task = "position"' in answer.explain("en")
    planned(text + f"pose = {{ {tilted} }}\ntolerance = {{ orientation = 0.05 }}\n")
    planned(text + 'pose = { position = [0.4, 0.3, 0.3], task = "position" }\n')


def test_planar_arms_are_given_points_and_lines() -> None:
    text = 'robot = "planar2r"\n[start]\njoints = [0.2, 0.9]\n'
    text += '[[move]]\npose = { position = [1.2, 0.8, 0], task = "position" }\n'
    text += '[[move]]\npath = "line"\npose = { position = [1.0, 1.0, 0], task = "position" }\n'
    arm, motion = planned(text)
    line = motion.legs[1].trajectory
    p = arm.forward_kinematics(line.at(np.linspace(0, line.duration, 200)).u)[:, :3, 3]
    np.testing.assert_allclose(p[0], [1.2, 0.8, 0], atol=1e-9)
    np.testing.assert_allclose(p[-1], [1.0, 1.0, 0], atol=1e-9)
    np.testing.assert_allclose(p[:, 0] + p[:, 1], 2.0, atol=1e-6)
    run = solve(parse_job(text), text, HERE)
    assert isinstance(run, Run)
    assert summary(run).targets == 2
    assert not summary(run).not_reached
    assert refused(text.replace(', task = "position" }\n[[move]]\npath', " }\n[[move]]\npath")).key.endswith("few_pose")


def test_an_axis_leaves_the_turn_about_it_to_the_arm() -> None:
    text = PANDA + '[[move]]\npose = { position = [0.5, 0.2, 0.4], rpy = [3.14159265358979, 0, 0], task = "axis" }\n'
    arm, motion = planned(text)
    T = arm.forward_kinematics(motion.legs[0].trajectory.at(motion.legs[0].trajectory.duration).u)
    np.testing.assert_allclose(T[:3, 2], [0, 0, -1], atol=1e-8)
    np.testing.assert_allclose(T[:3, 3], [0.5, 0.2, 0.4], atol=1e-8)
    run = solve(parse_job(text), text, HERE)
    assert isinstance(run, Run)
    assert not summary(run).not_reached


def test_angles_that_look_like_degrees_are_reported() -> None:
    text = 'robot = "ur5e"\n[start]\njoints = [0.3, -1.6, 1.8, -1.77, -1.57, 0]\n'
    text += "[[move]]\npose = { position = [-0.45, -0.3, 0.3], rpy = [180, 0, 90] }\n"
    (remark,) = [one for one in planned(text)[1].remarks if one.key.startswith("job.degrees_suspected")]
    assert remark.level == "warning"
    for word in ("line 5", "move[1].pose.rpy", "180 rad", 'angles = "degrees"'):
        assert word in remark.sentence("en")
    right = text.replace("[180, 0, 90]", "[3.14159, 0, 1.5708]")
    assert not [one for one in planned(right)[1].remarks if one.key.startswith("job.degrees_suspected")]


def test_limits_are_said_in_the_unit_of_the_job() -> None:
    error = complaint('robot = "panda"\nangles = "degrees"\n[[move]]\njoints = [200, -20, 10, -100, 10, 100, 30]\n')
    assert error.key == "job.outside_limits"
    assert "200°" in error.message("en")
    assert "-166° .. 166°" in error.message("en")


def test_positions_in_millimetres_are_recognised() -> None:
    answer = refused(PANDA + "[[move]]\npose = { position = [400, 100, 300] }\n")
    assert answer.key == "job.unreachable_millimetres"
    assert refused(PANDA + "[[move]]\npose = { position = [4, 1, 3] }\n").key == "job.unreachable"


@pytest.mark.parametrize("name", ["ur3e", "ur5e", "ur10e", "panda", "fr3", "iiwa7", "puma560", "planar3r"])
def test_the_default_start_is_regular(name: str) -> None:
    robot, motion = planned(f'robot = "{name}"\n[[move]]\npause = 1\n')
    margin = np.linalg.svd(robot.jacobian_body(motion.start), compute_uv=False)[-1]
    assert margin > 0.02
    low, high = robot.limits.lower, robot.limits.upper
    assert ((motion.start >= low) & (motion.start <= high)).all()


def test_a_line_can_begin_at_the_default_start_of_a_stretched_arm() -> None:
    robot, motion = planned('robot = "ur5e"\n[[move]]\npause = 1\n')
    p = np.round(robot.forward_kinematics(motion.start)[:3, 3] * 0.9, 3).tolist()
    planned(f'robot = "ur5e"\n[[move]]\npath = "line"\npose = {{ position = {p} }}\n')


def test_joints_can_be_held() -> None:
    text = (
        'robot = "panda"\nangles = "degrees"\nlock = { joint3 = 30 }\n[start]\njoints = [0, -20, -100, 10, 100, 30]\n'
    )
    text += "[[move]]\njoints = [10, -20, -100, 10, 100, 30]\n"
    robot, motion = planned(text)
    assert robot.joint_names == ("joint1", "joint2", "joint4", "joint5", "joint6", "joint7")
    whole, other = planned(
        'robot = "panda"\nangles = "degrees"\n[start]\njoints = [0, -20, 30, -100, 10, 100, 30]\n[[move]]\npause = 1\n'
    )
    np.testing.assert_allclose(
        robot.forward_kinematics(motion.start), whole.forward_kinematics(other.start), atol=1e-12
    )


def test_the_schema_of_the_docs_is_that_of_the_code_and_accepts_the_examples() -> None:
    written = json.loads((DOCS / "job.schema.json").read_text(encoding="utf-8"))
    assert written == schema(), "run python docs/make_job_schema.py"
    job = schema()["$defs"]["JobFile"]
    assert set(job["required"]) == {"robot", "move"}
    assert job["additionalProperties"] is False
    assert set(job["properties"]) == {field.name for field in msgspec.structs.fields(JobFile)}


def test_a_dry_run_plans_and_writes_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "slow.toml"
    path.write_text(SLOW, encoding="utf-8")
    assert main(["run", str(path), "--dry-run", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    motion = planned(SLOW)[1]
    assert data["cycle"] == pytest.approx(motion.legs[0].trajectory.duration)
    assert data["moves"][0]["name"] == "down"
    assert [one["code"] for one in data["findings"]] == [remark.key for remark in motion.remarks]
    path.write_text(f"{PANDA}[[move]]\n{VIA}", encoding="utf-8")
    assert main(["run", str(path), "--dry-run"]) == 0
    assert "planned, not simulated" in capsys.readouterr().out
    path.write_text(PANDA + "[[move]]\npose = { position = [4, 1, 3] }\n", encoding="utf-8")
    assert main(["run", str(path), "--dry-run"]) == 1
    assert list(tmp_path.iterdir()) == [path]


def test_files_of_many_points_are_read() -> None:
    points = "".join(f"[[move]]\npose = {{ position = [0.4, {k / 1e6}, 0.3] }}\n" for k in range(30_000))
    assert len(points) > 1_000_000
    assert len(parse_job(PANDA + points).move) == 30_000


BLOCKS = [
    block
    for page in ("job_files.md", "job_files.ar.md")
    for block in re.findall(r"```toml\n(.*?)```", (DOCS / page).read_text(encoding="utf-8"), flags=re.S)
]


@pytest.mark.parametrize("text", BLOCKS)
def test_jobs_of_the_docs_can_be_planned(text: str) -> None:
    planned(text, DOCS)


def test_a_limit_that_many_moves_come_near_to_is_one_finding():
    """The move that comes nearest is named, and how many do."""
    joints = [[0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 2.88 - 0.001 * k] for k in range(4)]
    text = 'robot = "panda"\n' + "".join(f"[[move]]\njoints = {each}\n" for each in joints)
    _, plan = planned(text)
    (remark,) = (one for one in plan.remarks if one.key.startswith("job.tight_limit"))
    assert remark.key == "job.tight_limits"
    assert remark.details["count"] == 4
    assert "move 1 " in remark.sentence("en")
    assert "joint7" in remark.sentence("ar")


@pytest.mark.parametrize(("pan", "said"), [(300, True), (120, False), (0.5, False)])
def test_a_move_whose_tip_goes_more_than_twice_as_far_as_straight_is_said_with_why(pan, said):
    text = f"""
robot = "ur5e"
angles = "degrees"
[start]
joints = [0, -90, 90, -90, -90, 0]
[[move]]
joints = [{pan}, -90, 90, -90, -90, 0]
"""
    plan = prepare(parse_job(text), text, Path())[1]
    found = [remark.sentence("en") for remark in plan.remarks if remark.key == "job.long_way_joints"]
    assert bool(found) == said
    assert all("shoulder_pan_joint turns by 300°" in sentence for sentence in found)


def test_another_configuration_is_taken_where_the_move_to_the_nearest_is_blocked():
    text = """
robot = "ur5e"
angles = "degrees"
[tool]
offset = { position = [0, 0, 0.18], rpy = [0, 0, 0] }
[start]
joints = [0, -90, 90, -90, -90, 0]
[[move]]
pose = { position = [0.4, -0.08, 0.15], rpy = [180, 0, 0] }
"""
    plan = prepare(parse_job(text), text, Path())
    assert plan, plan.explain("en")
    leg = plan[1].legs[0]
    assert leg.way is None
    T = leg.load.robot.forward_kinematics(leg.trajectory.at(leg.trajectory.duration).u)
    np.testing.assert_allclose(T[:3, 3], [0.4, -0.08, 0.15], atol=1e-8)
