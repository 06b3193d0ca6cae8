"""Jobs wipe round surfaces, open doors, insert pegs, slide along guides; reports say what became of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mafsil.cli.main import main
from mafsil.errors import JobError
from mafsil.job import Run, parse_job, solve, solve_file
from mafsil.job.driving.laws import kinds_for
from mafsil.job.driving.tip_laws import Face
from mafsil.job.judging.judgement import summary
from mafsil.job.language.reading import schema
from mafsil.job.planning.stretch import grips
from mafsil.report.contents import page
from mafsil.report.replay import replay_scene
from mafsil.simulation import RigidSurface

EXAMPLES = Path(__file__).parents[2] / "examples" / "jobs"
HEAD = """
robot = "puma560"
angles = "degrees"
[tolerance]
position = 0.01
orientation = 2.0
[simulation]
friction = false
settle = 0.1
"""
PIPE = """
[start]
pose = { position = [0.5, 0.1, 0.005], rpy = [180, 0, 0] }
[controller]
kind = "hybrid"
normal_force = 10
[[surface]]
name = "pipe"
point = [0.5, 0.0, -0.2]
cylinder = 0.223606797749979
axis = [1, 0, 0]
stiffness = 2e4
damping = 150
[[move]]
path = "line"
pose = { position = [0.5, 0.1, -0.001], rpy = [180, 0, 0] }
[[move]]
path = "arc"
via = [{ position = [0.5, 0.0, 0.0226], rpy = [180, 0, 0] }]
pose = { position = [0.5, -0.1, -0.001], rpy = [180, 0, 0] }
duration = 1.6
"""
PEG = """
[start]
pose = { position = [0.5, 0.1, 0.005], rpy = [180, 0, 0] }
[controller]
kind = "impedance"
tip_stiffness = 400
rotational_stiffness = 20
[[hole]]
mouth = [0.501, 0.1, 0.0]
axis = [0, 0, 1]
clearance = 2e-4
depth = 0.03
chamfer = 3e-3
peg = 0.015
[[move]]
path = "line"
pose = { position = [0.5, 0.1, -0.035], rpy = [180, 0, 0] }
duration = 1.2
"""
RAIL = """
[start]
pose = { position = [0.5, 0.1, 0.2], rpy = [180, 0, 0] }
[controller]
kind = "impedance"
tip_stiffness = 300
[[guide]]
name = "ruler"
point = [0.5, 0.1, 0.2]
direction = [0, 1, 0]
stiffness = 2e4
damping = 300
[[move]]
path = "line"
pose = { position = [0.52, 0.2, 0.2], rpy = [180, 0, 0] }
duration = 1.0
"""


def run(text):
    found = solve(parse_job(text), text, Path())
    assert isinstance(found, Run)
    return found


def remark(found, key):
    return next(each for each in found.remarks if each.key == key)


@pytest.mark.capability("10-74")
@pytest.mark.parametrize("press", [6.0, 12.0])
def test_a_pipe_is_wiped_with_the_same_force_all_round(press):
    found = run(HEAD + PIPE.replace("normal_force = 10", f"normal_force = {press}"))
    tape = found.recording
    assert found.status.succeeded
    R = found.robot.forward_kinematics(tape.q)[:, :3, :3]
    force = (R @ tape.contact_wrench[:, 3:, None])[..., 0]
    sliding = (tape.t > 0.6) & (tape.t < 1.8)
    p = found.robot.forward_kinematics(tape.q)[:, :3, 3]
    outward = p - [0.5, 0.0, -0.2]
    outward[:, 0] = 0.0
    outward /= np.linalg.norm(outward, axis=1)[:, None]
    assert np.ptp(np.degrees(np.arctan2(outward[sliding, 1], outward[sliding, 2]))) > 30.0, "the normal turns"
    pressed = (force * outward).sum(axis=1)[sliding]
    assert np.abs(pressed - press).max() < 0.12 * press
    assert abs(pressed.mean() - press) < 0.02 * press
    assert np.abs(force - (force * outward).sum(axis=1)[:, None] * outward)[sliding].max() < 1e-6, (
        "there is no friction"
    )


@pytest.mark.parametrize(
    "surface",
    [
        RigidSurface.sphere([0.1, 0.2, 0.3], 0.4), RigidSurface.sphere([0.1, 0.2, 0.3], 0.4, hollow=True),
        RigidSurface.cylinder([0.1, 0.2, 0.3], [0.3, -0.2, 0.9], 0.4), RigidSurface.plane([0, 0, 0], [1, 2, 3]),
    ],
)  # fmt: skip
def test_the_rate_of_the_constraint_is_that_of_its_normal(surface):
    rng = np.random.default_rng(3)
    face = Face(surface, (0, 1, 2, 3, 4, 5))
    for _ in range(20):
        T, V, h = np.eye(4), rng.normal(size=6), 1e-6
        T[:3, 3] = rng.normal(size=3)
        ahead, behind = T.copy(), T.copy()
        ahead[:3, 3] += h * V[3:]
        behind[:3, 3] -= h * V[3:]
        A, rate = face.constraint(T, V)
        np.testing.assert_allclose(A[0], face.along(T), atol=0)
        np.testing.assert_allclose(rate[0], (face.along(ahead) - face.along(behind)) / (2 * h), atol=1e-7)


@pytest.mark.capability("10-68", "10-79")
def test_a_soft_hand_opens_a_door_that_is_not_where_it_takes_it_to_be():
    found = solve_file(EXAMPLES / "open_a_door_puma560.toml")
    assert found.status.succeeded
    door = grips(found.job, found.plan)[0].door
    tips = found.robot.forward_kinematics(found.recording.q)
    angle = np.degrees(door.angle(tips))
    assert 28.0 < angle[-1] < 31.0
    radius = np.linalg.norm(tips[:, :2, 3] - [0.51, 0.51], axis=1)
    assert np.ptp(radius) < 1e-3, "the handle goes round the hinge, not round where it is taken to be"
    said = remark(found, "job.door_opened")
    assert "29" in said.sentence("en") or "30" in said.sentence("en")
    assert said.sentence("ar") != said.sentence("en")
    bodies = [one.body.name for one in replay_scene(found).carried]
    assert bodies == ["door"]


def test_a_peg_finds_its_hole_by_the_chamfer_and_a_rail_leads_the_tip():
    found = run(HEAD + PEG)
    said = remark(found, "job.hole_reached")
    assert float(str(said.details["depth"]).split()[0]) == pytest.approx(30.0, abs=0.5)
    off = found.robot.forward_kinematics(found.recording.q[-1])[:2, 3] - [0.501, 0.1]
    assert np.linalg.norm(off) < 4e-4, "the plan goes 1 mm beside the axis"
    beside = run(HEAD + PEG.replace("0.501", "0.51"))
    assert remark(beside, "job.hole_missed").level == "warning"
    led = run(HEAD + RAIL)
    aside = led.robot.forward_kinematics(led.recording.q)[:, 0, 3] - 0.5
    free = led.plan.tips(np.array([1.0]), led.recording.q_ref[-1:])[0, 0, 3] - 0.5
    assert free == pytest.approx(0.02, abs=1e-6)
    assert np.abs(aside).max() < 1.5e-3, "a rail of 2e4 N/m against a hand of 300 N/m"
    assert remark(led, "job.guide_left").sentence("en").count("ruler") == 1
    assert page(led, summary(led), "ar").findings


def test_millimetres_are_metres():
    metres, millimetres = HEAD + PEG, HEAD + PEG
    for old, new in (
        ("[0.5, 0.1, 0.005]", "[500, 100, 5]"), ("[0.501, 0.1, 0.0]", "[501, 100, 0]"), ("2e-4", "0.2"),
        ("depth = 0.03", "depth = 30"), ("3e-3", "3"), ("peg = 0.015", "peg = 15"), ("0.1, -0.035]", "100, -35]"),
        ("[0.5, 100", "[500, 100"), ("position = 0.01", "position = 10"),
    ):  # fmt: skip
        millimetres = millimetres.replace(old, new)
    one, other = parse_job(metres), parse_job('lengths = "millimetres"' + millimetres)
    first, second = one.hole[0], other.hole[0]
    np.testing.assert_allclose(first.mouth, second.mouth)
    for name in ("clearance", "depth", "chamfer", "peg", "stiffness", "damping"):
        assert getattr(first, name) == pytest.approx(getattr(second, name))


@pytest.mark.parametrize(
    ("text", "old", "new", "word"),
    [
        (PIPE, "cylinder = 0.223606797749979", "cylinder = 0.2\nsphere = 0.2", "exactly one"),
        (PIPE, "cylinder = 0.223606797749979", "", "exactly one"),
        (PIPE, "axis = [1, 0, 0]", "", "axis"),
        (PIPE, "axis = [1, 0, 0]", "axis = [0, 0, 0]", "axis"),
        (PIPE, "cylinder = 0.223606797749979\naxis = [1, 0, 0]", "normal = [0, 0, 1]\nhollow = true", "hollow"),
        (PEG, "axis = [0, 0, 1]", "axis = [0, 0, 0]", "axis"),
        (PEG, "clearance = 2e-4", "clearance = -1", "clearance"),
        (RAIL, "direction = [0, 1, 0]", "direction = [0, 1, 0]\nnormal = [0, 0, 1]", "exactly one"),
        (RAIL, "[[guide]]", "[[door]]\nhinge = [0, 0, 0]\naxis = [0, 0, 1]\n[[guide]]", None),
        (RAIL, "rpy = [180, 0, 0] }\n[controller]", "task = 'position' }\n[controller]\n", None),
    ],
)
def test_what_makes_no_sense_is_refused_by_its_place(text, old, new, word):
    assert old in text
    changed = HEAD + text.replace(old, new)
    if word is None:
        parse_job(changed)
        return
    with pytest.raises(JobError) as caught:
        parse_job(changed)
    assert word in caught.value.message("en")
    assert caught.value.message("ar") != caught.value.message("en")


def test_a_door_needs_a_whole_pose_to_start_from():
    door = "\n[[door]]\nhinge = [0, 0, 0]\naxis = [0, 0, 1]\n"
    for start in ("joints = [0, 0, 0, 0, 0, 0]", "pose = { position = [0.5, 0.1, 0.2] }"):
        text = RAIL.replace("pose = { position = [0.5, 0.1, 0.2], rpy = [180, 0, 0] }", start, 1) + door
        with pytest.raises(JobError, match="handle"):
            parse_job(HEAD + text)


def test_schema_check_and_bench_know_them(tmp_path, capsys):
    tables = schema()["$defs"]
    assert {"Hole", "Door", "Guide", "Surface"} <= set(tables)
    file = tmp_path / "peg.toml"
    file.write_text(HEAD + PEG)
    assert main(["check-job", str(file)]) == 0
    capsys.readouterr()
    assert "impedance" in kinds_for(parse_job(HEAD + PEG))
    assert "hybrid" not in kinds_for(parse_job(HEAD + PEG))
    assert "hybrid" in kinds_for(parse_job(HEAD + PIPE))


GRIPPED = """
robot = "puma560"
[start]
pose = { position = [0.5, 0.05, 0.2], rpy = [3.14159265358979, 0, 0] }
[tolerance]
position = 0.03
orientation = 0.3
[controller]
kind = "impedance"
tip_stiffness = 3000
rotational_stiffness = 60
[simulation]
friction = false
[[door]]
name = "flap"
hinge = [0.5, 0.4, 0.2]
axis = [0, 0, 1]
grip = "pull"
release = "pull"
[[move]]
name = "come"
path = "line"
pose = { position = [0.5, 0.1, 0.2], rpy = [3.14159265358979, 0, 0] }
[[move]]
name = "pull"
path = "line"
pose = { position = [0.4, 0.12, 0.2], rpy = [3.14159265358979, 0, 0] }
[[move]]
name = "go"
path = "line"
pose = { position = [0.4, 0.02, 0.2], rpy = [3.14159265358979, 0, 0] }
"""


@pytest.mark.capability("10-68", "10-79")
def test_a_door_is_held_from_one_move_to_another_and_stays_where_it_was_let_go():
    found = solve(parse_job(GRIPPED), GRIPPED, Path())
    assert found.status.succeeded, found.explain()
    (grip,) = grips(found.job, found.plan)
    tape, tips = found.recording, found.robot.forward_kinematics(found.recording.q)
    ends = np.cumsum([leg.trajectory.duration for leg in found.plan.legs])
    assert (grip.start, grip.end) == (pytest.approx(ends[0]), pytest.approx(ends[1]))
    np.testing.assert_allclose(grip.door.handle[:3, 3], [0.5, 0.1, 0.2], atol=1e-6)
    held = (tape.t > grip.start + 0.05) & (tape.t < grip.end - 1e-6)
    radius = np.linalg.norm(tips[:, :2, 3] - [0.5, 0.4], axis=1)
    assert np.ptp(radius[held]) < 1e-3, "the handle goes round the hinge"
    assert radius[-1] > 0.35, "and the tip does not any more"
    pulled = np.abs(tape.contact_wrench).max(axis=1) if tape.contact_wrench is not None else np.zeros(len(tape.t))
    assert pulled[held].max() > 1.0
    assert not pulled[(tape.t < grip.start - 1e-6) | (tape.t > grip.end + 2e-3)].any()
    (part,) = [one for one in replay_scene(found).carried if one.body.name == "flap"]
    opened = remark(found, "job.door_opened").sentence("en")
    x, y = tips[np.searchsorted(tape.t, grip.end - 1e-9), :2, 3] - [0.5, 0.4]
    assert f"by {np.degrees(np.arctan2(x, -y)):.3g}° in the end" in opened
    moments = np.linspace(0.0, tape.t[-1], len(part.poses))
    before, after = part.poses[moments < grip.start - 0.05], part.poses[moments > grip.end + 0.05]
    assert np.ptp(before, axis=0).max() < 1e-6
    assert np.ptp(after, axis=0).max() < 1e-6
    assert np.abs(after[0] - before[0]).max() > 0.1


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ('grip = "pull"', 'grip = "push"', "no move is called"),
        ('release = "pull"', 'release = "come"', "before it is taken"),
    ],
)
def test_moves_of_a_door_exist_and_are_in_order(old, new, word):
    with pytest.raises(JobError, match=word):
        parse_job(GRIPPED.replace(old, new))
