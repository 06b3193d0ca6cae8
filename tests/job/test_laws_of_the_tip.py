"""Jobs touch surfaces: laws of the tip press, give way and let go; recording, report, bench say what they touched."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import TaskCoordinates, Wall, task_dynamics
from mafsil.control.contact import CombinedEnvironment, TipForceSensor
from mafsil.control.laws import TipOfJoints
from mafsil.control.laws.task_coordinates import null_space_feedback
from mafsil.errors import JobError
from mafsil.job import Run, bench_laws, parse_job, solve, solve_file
from mafsil.job.driving.laws import KINDS
from mafsil.job.judging.judgement import summary
from mafsil.messages import say
from mafsil.report.results import as_data, write_results
from mafsil.simulation import Recording
from mafsil.trajectory import quintic
from tests.job.test_job_planning import planned

EXAMPLE = Path(__file__).parents[2] / "examples" / "jobs" / "polish_a_plate_puma560.toml"
STIFFNESS, DEPTH = 2e4, 0.002
PRESSING = f"""
robot = "puma560"
[start]
pose = {{{{ position = [0.5, 0.1, 0.02], rpy = [3.14159265358979, 0, 0] }}}}
[tolerance]
position = 0.01
[controller]
kind = "{{kind}}"
{{gains}}
[simulation]
friction = false
plant = "{{plant}}"
settle = 1.5
[[surface]]
point = [0, 0, 0]
normal = [0, 0, 2]
stiffness = {STIFFNESS}
damping = 150
[[move]]
path = "line"
pose = {{{{ position = [0.5, 0.1, {-DEPTH}], rpy = [3.14159265358979, 0, 0] }}}}
"""


def run(kind, gains="", plant="mafsil"):
    text = PRESSING.format(kind=kind, gains=gains, plant=plant)
    found = solve(parse_job(text), text, Path())
    assert isinstance(found, Run)
    return found


@pytest.fixture(scope="module")
def polished():
    found = solve_file(EXAMPLE)
    assert isinstance(found, Run)
    return found


@pytest.mark.capability("10-74", "10-2", "02-12")
def test_a_plate_is_polished_with_the_force_that_is_asked_for(polished, tmp_path):
    assert polished.status.succeeded
    tape = polished.recording
    force = np.linalg.norm(tape.contact_wrench[:, 3:], axis=-1)
    sliding = (tape.t > 1.0) & (tape.t < 2.6)
    normal = force / np.hypot(1.0, 0.2)
    assert np.abs(normal[sliding].mean() - 15.0) < 0.5
    assert np.abs(normal[sliding] - 15.0).max() < 1.5
    found = summary(polished).touching
    assert found.contacts == 1
    assert found.peak == force.max()
    assert not force[tape.t > 3.0].any()
    assert as_data(polished, summary(polished))["contact"]["contacts"] == 1
    assert "Contact force" in write_results(polished, tmp_path / "out").read_text()
    again = Recording.load(tmp_path / "out" / "recording")
    assert np.array_equal(again.contact_wrench, tape.contact_wrench)
    assert "contact_wrench[fz]" in (tmp_path / "out" / "recording.csv").read_text().split("\n", 1)[0]


@pytest.mark.capability("10-78", "10-79")
@pytest.mark.parametrize("kind", ["impedance", "admittance"])
@pytest.mark.parametrize("plant", ["mafsil", "mujoco"])
def test_two_springs_in_series_share_the_depth(kind, plant):
    soft = 1000.0
    found = run(kind, f"tip_stiffness = {soft}", plant)
    pressed = np.linalg.norm(found.recording.contact_wrench[-1, 3:])
    assert pressed == pytest.approx(DEPTH * soft * STIFFNESS / (soft + STIFFNESS), rel=2e-3)
    assert found.recording


@pytest.mark.capability("10-74")
def test_hybrid_control_presses_as_asked_and_motion_control_as_deep_as_it_can():
    pressed = run("hybrid", "normal_force = 25.0").recording.contact_wrench[-1, 3:]
    assert np.linalg.norm(pressed) == pytest.approx(25.0, rel=1e-3)
    found = run("task_computed_torque")
    assert 0.0 < np.linalg.norm(found.recording.contact_wrench[-1, 3:]) < DEPTH * STIFFNESS


@pytest.mark.parametrize("robot", ["panda", "planar2r"])
def test_arms_of_more_and_fewer_joints_have_laws_of_the_tip(robot):
    goal = [0.2, 0.9] if robot == "planar2r" else [0.2, -0.3, 0.1, -1.8, 0.1, 1.9, 0.3]
    for kind in ("impedance", "admittance", "task_computed_torque"):
        text = f'robot = "{robot}"\n[controller]\nkind = "{kind}"\n[start]\njoints = {[x + 0.2 for x in goal]}\n'
        text += f"[simulation]\nfriction = false\nsettle = 1.0\n[[move]]\njoints = {goal}\n"
        found = solve(parse_job(text), text, Path())
        assert isinstance(found, Run)
        assert found.status.succeeded, found.explain()
        assert found.recording.contact_wrench is None


def test_joints_beside_the_task_do_not_move_the_tip():
    robot = mf.load("panda")
    q, qd = np.array([0.2, -0.3, 0.1, -1.8, 0.1, 1.9, 0.3]), np.linspace(-0.2, 0.3, 7)
    path = quintic(np.zeros(7), np.ones(7), 1.0)
    effort = null_space_feedback(robot)(0.3, q, qd, path.at(0.3))
    now = task_dynamics(robot, q, qd)
    pushed = now.J @ np.linalg.solve(robot.mass_matrix(q), effort)
    assert np.abs(effort).max() > 0.1
    assert np.abs(pushed).max() < 1e-9
    tip, h = TipOfJoints(robot, path), 1e-6
    ahead, back, here = tip(0.3 + h), tip(0.3 - h), tip(0.3)
    assert np.abs((ahead.velocity - back.velocity) / (2 * h) - here.acceleration).max() < 1e-6
    assert np.abs((ahead.pose - back.pose)[:3, 3] / (2 * h) - here.velocity[3:]).max() < 1e-8


def test_a_force_sensor_reads_the_same_twice_and_noise_by_its_seed():
    arm, wall = mf.load("planar2r"), Wall(np.array([0, 5.0, 0]), np.array([0, 1.0, 0]), 100.0)
    both, task = CombinedEnvironment((wall, wall)), TaskCoordinates(rows=(3, 4))
    q, qd = np.array([0.3, 0.4]), np.zeros(2)
    exact = TipForceSensor(arm, both, task)(q, qd)
    assert exact[1] == pytest.approx(-2 * 100.0 * (5.0 - arm.forward_kinematics(q)[1, 3]))
    noisy = [TipForceSensor(arm, both, task, 0.5, seed) for seed in (1, 1, 2)]
    a, b, c = (sensor(q, qd) for sensor in noisy)
    assert np.array_equal(a, b)
    assert not np.array_equal(a, c)
    assert noisy[0](q, qd) is a


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("[[surface]]\npoint = [0, 0, 0]\nnormal = [0, 0, 2]\nstiffness = 20000.0\ndamping = 150\n", "", "[[surface]]"),
        ("normal = [0, 0, 2]", "normal = [0, 0, 0]", "normal"),
        ("normal_force = 5", "tip_stiffness = 5", "normal_force"),
        ("damping = 150", "damping = -150", "damping"),
    ],
)
def test_what_cannot_be_pressed_is_refused(old, new, word):
    text = PRESSING.format(kind="hybrid", gains="normal_force = 5", plant="mafsil")
    assert old in text
    with pytest.raises(JobError) as caught:
        parse_job(text.replace(old, new))
    assert word in caught.value.message("en")
    assert caught.value.message("ar") != caught.value.message("en")


@pytest.mark.capability("10-2")
def test_the_bench_compares_contact_forces():
    text = PRESSING.format(kind="hybrid", gains="normal_force = 5", plant="mafsil").replace(
        "settle = 1.5", "settle = 0.2"
    )
    job, (robot, plan) = parse_job(text), planned(text)
    found = bench_laws(job, text, robot, plan, ("hybrid", "pd_gravity"))
    forces = {each.kind: each.peak_force for each in found}
    assert 4.0 < forces["hybrid"] < 20.0
    head, rows = found.columns()
    assert "force" in head
    assert all(len(row) == len(head) for row in rows)
    free = text.replace('kind = "hybrid"\nnormal_force = 5', "")
    free = free[: free.index("[[surface]]")] + free[free.index("[[move]]") :]
    job, (robot, plan) = parse_job(free), planned(free)
    with pytest.raises(JobError, match="surface"):
        bench_laws(job, free, robot, plan, ("hybrid",))


@pytest.mark.parametrize("kind", KINDS)
def test_every_law_has_a_name_in_reports(kind):
    assert say(f"report.controller_{kind}", language="en") != say(f"report.controller_{kind}", language="ar")


CORNER = """
robot = "puma560"
[start]
pose = { position = [0.5, 0.18, 0.01], rpy = [3.14159265358979, 0, 0] }
[tolerance]
position = 0.02
[controller]
kind = "hybrid"
normal_force = 20
[simulation]
friction = false
step = 2e-3
settle = 0.0
[[surface]]
name = "never met"
point = [0, 0, 0.5]
normal = [0, 0, -1]
KIND
[[surface]]
name = "wall"
point = [0, 0.2, 0]
normal = [0, -1, 0]
KIND
[[surface]]
name = "floor"
point = [0, 0, 0]
normal = [0, 0, 1]
KIND
[[move]]
path = "line"
pose = { position = [0.5, 0.18, -0.001], rpy = [3.14159265358979, 0, 0] }
[[move]]
pause = 0.1
[[move]]
path = "line"
pose = { position = [0.5, 0.201, -0.001], rpy = [3.14159265358979, 0, 0] }
[[move]]
pause = 0.2
[[move]]
path = "line"
pose = { position = [0.5, 0.201, 0.02], rpy = [3.14159265358979, 0, 0] }
[[move]]
pause = 0.2
"""


@pytest.mark.capability("10-74", "10-70")
@pytest.mark.parametrize("kind", ["stiffness = 2e4\ndamping = 150", "rigid = true"])
def test_hybrid_control_presses_on_every_surface_that_the_plan_is_on(kind):
    text = CORNER.replace("KIND", kind)
    found = solve(parse_job(text), text, Path())
    assert isinstance(found, Run)
    assert found.status.succeeded, found.explain()
    tape, legs = found.recording, [leg.trajectory.duration for leg in found.plan.legs]
    ends = np.cumsum(legs)
    turned = tape.contact_wrench[:, 3:] * [1.0, -1.0, -1.0]  # the tip looks down
    for leg, wanted in ((1, [0, 0, 20]), (3, [0, -20, 20]), (5, [0, -20, 0])):
        k = int(np.searchsorted(tape.t, ends[leg] - 0.01))
        np.testing.assert_allclose(turned[k], wanted, atol=1.0)
