"""Jobs whose tip meets a surface that does not give way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import JobError
from mafsil.job import parse_job, solve
from mafsil.job.judging.law_conditions import conditions

JOB = """
robot = "puma560"
angles = "degrees"

[start]
pose = { position = [0.5, 0.1, 0.02], rpy = [180, 0, 0] }

[controller]
kind = "impedance"

[tolerance]
position = 0.03

[[surface]]
point = [0, 0, 0]
normal = [0, 0, 1]
rigid = true
restitution = 0.4

[[move]]
path = "line"
pose = { position = [0.5, 0.1, -0.01], rpy = [180, 0, 0] }
"""


@pytest.mark.capability("10-68", "10-69")
def test_a_tip_that_is_moved_into_a_rigid_floor_bounces_and_rests_on_it():
    run = solve(parse_job(JOB), JOB, Path())
    found = run.recording.metadata["rigid_contact"]
    assert found["impacts"] > 1
    assert found["closures"] >= 1
    robot = mf.load("puma560")
    height = robot.forward_kinematics(run.recording.q)[:, 2, 3]
    assert height.min() > -1e-11
    assert height[-1] == pytest.approx(0.0, abs=1e-11)
    held = height < 1e-11
    assert (run.recording.contact_wrench[held, 3:] @ np.array([0.0, 0.0, -1.0]) >= 0.0).all()
    said = [remark.sentence("en") for remark in run.remarks]
    assert any("Zeno" in one for one in said)
    assert any(f"Impacts on rigid surfaces: {found['impacts']}" in one for one in said)
    assert not any("too stiff for the step" in one for one in said)


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("rigid = true\nrestitution = 0.4", "", "stiffness"),
        ("rigid = true", "stiffness = 1e4", "restitution"),
        ("rigid = true", "rigid = true\nstiffness = 1e4", "stiffness"),
        ("rigid = true", "rigid = true\ndamping = 20.0", "damping"),
        ("rigid = true", "rigid = true\nfriction = -0.2", "friction"),
        ("restitution = 0.4", "restitution = 1.4", "restitution"),
        ("[tolerance]", '[simulation]\nplant = "mujoco"\n[tolerance]', "plant"),
        ("[tolerance]", '[simulation]\nmethod = "euler"\n[tolerance]', "method"),
        ("[tolerance]", "[variation]\nfriction = [0.8, 1.2]\n[tolerance]", "not varied"),
        ("[[move]]", "[[surface]]\npoint = [0, 0, -1]\nnormal = [0, 0, 1]\n[[move]]", "stiffness"),
    ],
)
def test_what_does_not_go_with_a_rigid_surface_is_refused_where_it_stands(old, new, key):
    with pytest.raises(JobError, match=key):
        parse_job(JOB.replace(old, new, 1))


ROUGH = """
robot = "planar2r_point_masses"

[start]
joints = [0.4, 0.9]

[controller]
kind = "computed_torque"
frequency = 40

[tolerance]
position = 0.2

[[surface]]
point = [0, 1.34, 0]
normal = [0, 1, 0]
rigid = true
friction = 0.4

[[move]]
joints = [0.3, 0.9]
duration = 0.4
"""


@pytest.mark.capability("10-94")
def test_friction_of_a_rigid_surface_is_a_key_of_the_job_and_said_in_the_report():
    run = solve(parse_job(ROUGH), ROUGH, Path())
    arm, found = mf.load("planar2r_point_masses"), run.recording.metadata["rigid_contact"]
    T = arm.forward_kinematics(run.recording.q)
    force = np.einsum("kij,kj->ki", T[:, :3, :3], run.recording.contact_wrench[:, 3:])
    stop = next(event["time"] for event in found["events"] if event["kind"] == "stick")
    start = next(event["time"] for event in found["events"] if event["kind"] == "rest")
    sliding = (run.recording.t > start) & (run.recording.t < stop)
    assert sliding.sum() > 50
    np.testing.assert_allclose(force[sliding, 0], -0.4 * force[sliding, 1], rtol=1e-9)
    assert (np.abs(force[run.recording.t > stop, 0]) <= 0.4 * force[run.recording.t > stop, 1] * (1 + 2e-9)).all()
    (first, *_) = conditions(run)
    assert first.name == "sampled"
    assert 0.0 < first.value < 1.0
    for language, word in (("en", "Friction held the tip"), ("ar", "أمسك الاحتكاك الطرف")):
        assert any(word in remark.sentence(language) for remark in run.remarks)


def test_several_rigid_surfaces_of_a_job_hold_the_tip_in_their_corner():
    wall = "[[surface]]\npoint = [1.2, 0, 0]\nnormal = [-1, 0, 0]\nrigid = true\nfriction = 0.1\n\n[[move]]"
    text = ROUGH.replace("[[move]]", wall)
    run = solve(parse_job(text), text, Path())
    found = run.recording.metadata["rigid_contact"]
    places = mf.load("planar2r_point_masses").forward_kinematics(run.recording.q)[:, :3, 3]
    assert places[:, 1].min() > 1.34 - 1e-11
    assert places[:, 0].max() < 1.2 + 1e-11
    np.testing.assert_allclose(places[-1, :2], [1.2, 1.34], atol=1e-11)
    assert {event["surface"] for event in found["events"]} == {0, 1}
    assert any(f"Impacts on rigid surfaces: {found['impacts']}" in one.sentence("en") for one in run.remarks)


FELT = (
    ROUGH.replace("friction = 0.4", "friction = 0.1\nrestitution = 0.2")
    .split("[[move]]")[0]
    .replace('kind = "computed_torque"\nfrequency = 40', "{law}")
    + """[[move]]
joints = [0.39, 0.89]
duration = 0.3

[[move]]
joints = [0.38, 0.92]
duration = 0.3

[[move]]
joints = [0.45, 0.9]
duration = 0.4
"""
)


@pytest.mark.capability("10-69", "10-74", "10-82")
@pytest.mark.parametrize("kind", ["hybrid", "admittance"])
def test_a_law_that_feels_forces_meets_a_rigid_surface_presses_and_leaves_it(kind):
    law = 'kind = "hybrid"\nnormal_force = 15.0\nforce_integral = 20.0' if kind == "hybrid" else 'kind = "admittance"'
    text = FELT.replace("{law}", law)
    run = solve(parse_job(text), text, Path())
    tape, found = run.recording, run.recording.metadata["rigid_contact"]
    assert tape
    T = mf.load("planar2r_point_masses").forward_kinematics(tape.q)
    force = np.einsum("kij,kj->ki", T[:, :3, :3], tape.contact_wrench[:, 3:])
    assert T[:, 1, 3].min() > 1.34 - 1e-11
    # It came, stayed, and went when the plan did.
    assert found["impacts"] > 0
    assert found["releases"] == 1
    assert T[-1, 1, 3] > 1.35
    start = max(event["time"] for event in found["events"] if event["kind"] in {"rest", "closure"})
    held = (tape.t > start + 0.1) & (tape.t < 0.6)
    assert held.sum() > 100
    assert (force[held, 1] > 0.0).all()
    if kind == "hybrid":
        assert np.abs(force[held, 1] - 15.0).max() < 1.0
    names = {condition.name: condition for condition in conditions(run)}
    assert names["force_loop" if kind == "hybrid" else "rigid_step"].holds
