"""Jobs choose any law: each does a motion, and the bench says what each bears."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import add_delay, combine, feedforward, inertia_gains, pid
from mafsil.control.joints import EncoderLoop
from mafsil.errors import InputError, JobError
from mafsil.job import Run, bench_laws, parse_job, solve
from mafsil.job.driving.laws import KINDS
from mafsil.job.judging.law_bench import CONDITIONS, LawStatus
from mafsil.job.judging.law_conditions import Condition, conditions
from mafsil.job.judging.law_stability import growth_along
from mafsil.job.judging.symptoms import error_growth
from mafsil.simulation import Plant, Scenario
from mafsil.simulation.findings import alternating_efforts
from mafsil.simulation.fused import can_fuse
from mafsil.trajectory import quintic
from mafsil.trajectory.profiles import rest
from tests.job.test_job_planning import planned

JOB = """
robot = "puma560"
[simulation]
friction = {friction}
[controller]
kind = "{kind}"
{gains}
[[move]]
joints = [0.4, -0.3, 0.5, 0.3, -0.4, 0.5]
[[move]]
pause = 0.2
"""


def run(kind, gains="", friction="true"):
    text = JOB.format(kind=kind, gains=gains, friction=friction)
    found = solve(parse_job(text), text, Path())
    assert isinstance(found, Run)
    return found


@pytest.mark.capability("10-2")
@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "hybrid"])
def test_every_law_brings_the_arm_to_its_target(kind):
    found = run(kind, friction="false")
    assert found.recording
    assert {remark.key for remark in found.remarks} >= {"job.all_reached"}
    error = found.recording.q_ref - found.recording.q
    assert np.sqrt(np.mean(error**2)) < 0.02


def test_gains_of_a_law_belong_to_it():
    soft, stiff = (run("pid", f"kp = {k}\nkd = {d}\nintegral = 0") for k, d in ((100, 20), (900, 60)))
    errors = [np.abs(each.recording.q_ref - each.recording.q).max() for each in (soft, stiff)]
    assert errors[1] < 0.5 * errors[0]
    narrow, wide = (run("sliding_mode", f"width = {w}") for w in (0.02, 0.5))
    errors = [np.abs(each.recording.q_ref - each.recording.q).max() for each in (narrow, wide)]
    assert errors[0] < errors[1]
    with pytest.raises(JobError, match="margin"):
        run("adaptive", "margin = 1")
    with pytest.raises(JobError, match="learning"):
        run("pid", "learning = 1")


def test_a_law_that_falls_at_its_start_is_told_apart_from_gains_that_are_too_hard():
    text = """
robot = "panda"
[controller]
kind = "{kind}"
[start]
joints = [0, -0.5, 0, -2.0, 0, 1.6, 0.8]
[[move]]
joints = [0.1, -0.4, 0.1, -1.9, 0.1, 1.7, 0.7]
"""
    fallen, known = (solve(parse_job(text.format(kind=kind)), text, Path()) for kind in ("pid", "pd_gravity"))
    (said,) = [remark for remark in fallen.remarks if remark.key == "job.empty_integral"]
    panda, q = mf.load("panda"), np.array([0, -0.5, 0, -2.0, 0, 1.6, 0.8])
    drop = np.linalg.solve(panda.mass_matrix(q), panda.gravity_torque(q))
    k = int(np.abs(drop / panda.limits.acceleration).argmax())
    (amount,) = re.findall(rf"accelerates joint{k + 1} by ([\d,]+)°/s²", said.sentence("en"))
    assert float(amount.replace(",", "")) == pytest.approx(np.degrees(abs(drop[k])), rel=5e-3)
    assert "pd_gravity" in said.sentence("ar")
    assert any(remark.key == "job.acceleration_crossed" for remark in fallen.remarks)
    assert not {"job.empty_integral", "job.acceleration_crossed"} & {remark.key for remark in known.remarks}


def test_a_payload_of_the_simulation_hangs_at_the_tip_and_the_law_does_not_know_it():
    loaded, bare = (run("pd_gravity", friction=f"false\npayload = {mass}").recording for mass in (2.0, 0.0))
    arm = mf.load("puma560")
    q, qd, qdd = loaded.q[-1], loaded.qd[-1], loaded.qdd[-1]
    true = arm.with_payload(2.0).inverse_dynamics(q, qd, qdd)
    np.testing.assert_allclose(loaded.tau[-1], true, atol=1e-9)
    assert np.abs(loaded.q_ref[-1] - q).max() > 10 * np.abs(bare.q_ref[-1] - bare.q[-1]).max()


def test_a_delay_keeps_efforts_back():
    robot = mf.load("planar2r")
    law = add_delay(pid(2, [30.0, 20.0], [5.0, 3.0]), 0.003)
    start = np.array([0.1, -0.2])
    late, now = (
        mf.simulate(Scenario(robot=robot, trajectory=rest(np.zeros(2), 0.2), law=each, q=start, qd=np.zeros(2)))
        for each in (law, law.law)
    )
    asked = -np.array([30.0, 20.0]) * late.q - np.array([5.0, 3.0]) * late.qd
    np.testing.assert_allclose(late.tau_commanded[3:-1], asked[:-4], atol=1e-9)
    np.testing.assert_allclose(late.tau_commanded[:3], asked[[0, 0, 0]], atol=1e-9)
    assert np.abs(late.q - now.q).max() > 1e-6
    with pytest.raises(InputError, match="whole number"):
        add_delay(law.law, 0.0015).session(0.001)
    with pytest.raises(InputError, match="delay"):
        add_delay(law.law, -1.0)
    in_job = run("pid", "delay = 0.004")
    assert in_job.recording


def test_the_bench_measures_what_each_law_bears():
    laid = JOB.replace("joints =", 'profile = "quintic"\njoints =')
    text = laid.format(kind="computed_torque", gains="", friction="false")
    robot, plan = planned(text)
    shares: list[float] = []
    found = bench_laws(parse_job(text), text, robot, plan, ("computed_torque", "pd_gravity", "pid"), shares.append)
    assert found
    assert len(shares) == 3 * len(CONDITIONS)
    assert shares[-1] == 1.0
    by_law = {each.kind: each for each in found}
    ideal = by_law["computed_torque"]
    assert found.results[0] is ideal, "without friction and with its own masses the model is exact"
    assert ideal.joint_error[0] < 1e-4
    assert ideal.joint_error[1] > 5 * ideal.joint_error[0], "masses that it does not know"
    assert ideal.joint_error[2] > 5 * ideal.joint_error[0], "a load that it does not know"
    assert all(each.status is LawStatus.DONE for each in found)
    alone = run("pd_gravity", friction="false")
    rms = np.sqrt(np.mean((alone.recording.q_ref - alone.recording.q) ** 2))
    assert by_law["pd_gravity"].joint_error[0] == pytest.approx(rms)
    assert 0 < by_law["pid"].growth < 1
    assert found.to_dict()["laws"][0]["kind"] == "computed_torque"
    assert found.explain("en") != found.explain("ar")
    lost = replace(found.results[0], joint_error=(1e-4, 2e-4, np.nan, 1e-4, np.nan)).explain("en")
    assert "2 of 5 conditions ended early" in lost, "nothing is worse than a run that ended"
    assert "pd_gravity" in repr(found)
    with pytest.raises(JobError, match="computed_torque"):
        bench_laws(parse_job(text), text, robot, plan, ("magic",))


def test_the_command_prints_a_row_for_each_law(tmp_path, capsys):
    from mafsil.cli.main import main

    path = tmp_path / "job.toml"
    path.write_text(JOB.format(kind="pid", gains="kp = 100\nkd = 20\nintegral = 0", friction="true"))
    assert main(["compare", "control", str(path), "--laws", "pid", "pd_gravity"]) == 0
    out = capsys.readouterr().out
    assert "pid" in out
    assert "cause: " in out
    assert " instead of " in out


@pytest.mark.capability("02-24")
def test_feedforward_needs_feedback_and_helps_it_where_the_model_is_wrong():
    """The usual scheme: each joint by itself; the model beside it makes it better, alone it drifts."""
    robot = mf.load("puma560")
    arm = mf.Robot(robot.mechanism.with_payload(1.0))
    path = quintic(np.zeros(6), [0.8, -0.5, 0.6, 0.4, -0.4, 0.5], 0.6)
    own = inertia_gains(robot, path.at(np.linspace(0, 0.6, 20)).u, 1e-3)
    joints, model = pid(6, own.kp, own.kd), feedforward(robot, friction=False)
    errors = []
    for law in (model, joints, combine(model, joints)):
        plant = Plant(arm, friction=False)
        run = mf.simulate(Scenario(robot=robot, plant=plant, trajectory=path, law=law, saturate=False))
        assert run
        np.testing.assert_allclose(run.q_ref[-1], path.at(0.6).u, atol=1e-12)
        errors.append(np.sqrt(np.mean((run.q_ref - run.q) ** 2)))
    alone, feedback, both = errors
    assert both < 0.5 * feedback
    assert feedback < 0.2 * alone


def test_stability_is_looked_at_along_the_run():
    """By differences of the loop as by the gains, below one where it is stable and above where it is not."""
    text = JOB.format(kind="pd_gravity", gains="", friction="true")
    for kind in ("computed_torque", "model_predictive"):
        found = run(kind)
        driven = found.driven[0]
        factor, time = growth_along(found.job, driven)
        assert 0.5 < factor < 1.0, kind
        if kind == "computed_torque":
            known = error_growth(driven, driven.stretch.trajectory.at(time).u)
            assert factor == pytest.approx(known, abs=2e-3), "the same step to second order in the period"
    hard = 'kind = "model_predictive"\nfrequency = 3000\nhorizon = 3\ninterval = 0.0005'
    wild = text.replace('kind = "pd_gravity"', hard)
    wild = wild.replace("[simulation]", "[simulation]\nstep = 0.005")
    found = solve(parse_job(wild), wild, Path())
    assert growth_along(found.job, found.driven[0]).factor > 1.0


@pytest.mark.capability("10-23", "10-84")
@pytest.mark.parametrize("kind", ["pd_gravity", "computed_torque", "sliding_mode", "min_max"])
@pytest.mark.parametrize("late", [0, 3])
def test_the_growth_of_errors_is_that_of_two_runs_that_begin_side_by_side(kind, late):
    """The second road: no slope is taken, the arm just begins a little aside, and the difference is watched."""
    q = np.array([0.4, -0.3, 0.5, 0.3, -0.4, 0.5])
    gains = {"pd_gravity": "kp = 1500\nkd = 60", "sliding_mode": "width = 0.1"}.get(kind, "")
    text = JOB.format(kind=kind, gains=f"{gains}\ndelay = {0.001 * late}", friction="false")
    text = text.replace("[[move]]\njoints = [0.4, -0.3, 0.5, 0.3, -0.4, 0.5]\n", f"[start]\njoints = {q.tolist()}\n")
    found = solve(parse_job(text), text, Path())
    factor, _ = growth_along(found.job, found.driven[0])
    scenario = replace(found.driven[0].scenario, saturate=False)
    aside = 1e-5 * np.random.default_rng(5).normal(size=(40, 6))
    tape = mf.simulate(replace(scenario, q=q + np.concatenate([aside, -aside])))
    x = np.concatenate([tape.q, tape.qd / 30.0], axis=-1)
    waiting = [tape.tau_commanded[k : len(x) - max(late - 1, 0) + k] / 1e3 for k in range(late)]
    z = np.concatenate([x[: len(x) - max(late - 1, 0)], *waiting], axis=-1)
    z = (z[:, :40] - z[:, 40:])[4:40]
    step = np.linalg.lstsq(z[:-1].reshape(-1, z.shape[-1]), z[1:].reshape(-1, z.shape[-1]), rcond=None)[0]
    watched = np.abs(np.linalg.eigvals(step)).max()
    assert watched == pytest.approx(factor, abs=5e-4)


@pytest.mark.parametrize("kind", ["linear_quadratic", "sliding_mode", "min_max", "impedance", "admittance"])
def test_defaults_are_stable_on_an_arm_with_light_joints_and_one_too_many(kind):
    """A Panda at 1 kHz: its last joints weigh a hundredth of its first ones."""
    text = f"""
robot = "panda"
[start]
joints = [0.8, 0.8, -0.8, -1.32, 0.8, 1.35, -0.8]
[limits]
speed_scale = 1.0
acceleration_scale = 1.0
[simulation]
friction = false
settle = 0.05
[tolerance]
orientation = 0.02
joints = 0.03
[controller]
kind = "{kind}"
[[move]]
joints = [0.6, 0.5, -0.6, -1.5, 0.6, 1.4, -0.5]
"""
    found = solve(parse_job(text), text, Path())
    assert isinstance(found, Run)
    held = conditions(found)
    assert held[0].name == "sampled"
    assert all(each.holds for each in held), held
    assert not {each.key for each in found.remarks} & {"job.law_unstable", "job.gives_way"}


def test_a_job_that_fails_names_the_condition_that_does_not_hold():
    found = run("pd_gravity", "kp = 500000\nkd = 5000", friction="false")
    named = [each for each in found.remarks if each.key == "job.law_unstable"]
    assert len(named) == 1
    assert "spectral radius" in named[0].sentence("en")
    assert named[0].sentence("ar") != named[0].sentence("en")
    assert not [each for each in run("pd_gravity").remarks if each.key == "job.law_unstable"]


def test_an_integral_goes_on_when_the_arm_takes_a_part():
    text = """
robot = "puma560"
[part.box]
mass = 1.0
size = [0.05, 0.05, 0.05]
[simulation]
friction = false
[controller]
kind = "pid"
[start]
joints = [0.0, 0.8, -0.4, 0.0, 0.5, 0.0]
[[move]]
joints = [0.1, 0.7, -0.5, 0.1, 0.4, 0.1]
[[move]]
pause = 0.8
[[move]]
pick = "box"
[[move]]
pause = 0.1
"""
    found = solve(parse_job(text), text, Path())
    assert isinstance(found, Run)
    tape, taken = found.recording, found.driven[1].stretch.start
    k = int(np.searchsorted(tape.t, taken - 1e-9))
    held = found.driven[0].scenario.true_plant.robot.gravity_torque(tape.q[k])
    np.testing.assert_allclose(tape.tau[k - 2 : k + 1], np.tile(held, (3, 1)), atol=0.05)
    assert np.abs(tape.q - tape.q_ref)[k:].max() < 3e-4


@pytest.mark.parametrize("width", [1e-6, 2.0])
def test_an_effort_that_switches_at_every_tick_is_named(width):
    text = f"""
robot = "planar2r"
[simulation]
friction = false
[controller]
kind = "sliding_mode"
margin = 50
width = {width}
[start]
joints = [0.3, 0.8]
[[move]]
joints = [0.4, 0.7]
"""
    found = solve(parse_job(text), text, Path())
    assert isinstance(found, Run)
    said = [remark for remark in found.remarks if remark.key == "simulation.alternates"]
    assert len(said) == (width < 1e-3)
    assert ("Effort chatter" in found.recording.explain("en")) == (width < 1e-3)
    if said:
        assert "joint2" in said[0].sentence("en")
        assert "يعلو عزم" in said[0].sentence("ar")


def test_noise_of_sensors_is_no_switching_effort():
    rng = np.random.default_rng(0)
    t, even = 1e-3 * np.arange(4000), (-1.0) ** np.arange(4000)
    assert alternating_efforts(t, rng.normal(size=(4000, 3))) is None
    late = np.where((t > 1.0) & (t < 1.5), 0.2, 0.0) * even
    joint, step, begin, lasted = alternating_efforts(t, np.stack([np.cos(t), late + 1.0], axis=1))
    assert (joint, step) == (1, pytest.approx(0.4, rel=2e-3))
    assert begin == pytest.approx(1.0, abs=3e-3)
    assert lasted == pytest.approx(0.5, abs=5e-3)
    assert alternating_efforts(t, np.stack([np.cos(t), 0.01 * late + 1.0], axis=1)) is None


def test_a_number_that_is_nearly_its_limit_shows_on_which_side_it_is():
    for value, shown in ((1.00000019, "1.00000019"), (0.99972, "0.99972"), (1.0, "1 "), (1.7, "1.7")):
        assert f" {shown.strip()} " in Condition("sampled", value, 1.0).explain(language="en")


@pytest.mark.capability("10-87")
@pytest.mark.parametrize("height", [-0.2, 0.2])
def test_an_adaptive_law_that_touches_something_fails_its_condition(height):
    """Its proof knows no force but those of inertia: what pushes at the tip is learned as a payload."""
    arm, start, goal = mf.load("planar2r"), [0.4, 0.9], [0.3, 0.9]
    low = arm.forward_kinematics(goal)[1, 3]
    text = f"""
robot = "planar2r"
[start]
joints = {start}
[controller]
kind = "adaptive"
[tolerance]
position = 0.5
[[surface]]
point = [0, {low + height * 0.05}, 0]
normal = [0, 1, 0]
stiffness = 2000
damping = 50
[[move]]
joints = {goal}
"""
    found = solve(parse_job(text), text, Path())
    assert isinstance(found, Run)
    named = {each.name: each for each in conditions(found)}
    assert ("learned" in named) == (height > 0.0)
    if height > 0.0:
        tape = found.recording
        efforts = np.einsum("kij,ki->kj", arm.jacobian_body(tape.q), tape.contact_wrench)
        assert not named["learned"].holds
        assert named["learned"].value == pytest.approx(np.abs(efforts).max())
        assert named["learned"].explain(language="en") != named["learned"].explain(language="ar")


def test_the_integral_of_a_job_waits_where_efforts_are_at_their_limits():
    (driven,) = run("pid").driven
    law = driven.scenario.law
    np.testing.assert_array_equal(law.effort_limit, driven.scenario.robot.limits.effort)
    assert can_fuse(driven.scenario)


@pytest.mark.capability("10-11", "10-103")
def test_a_job_has_encoders_before_its_law_and_errors_of_their_size():
    text = JOB.format(kind="computed_torque", gains="delay = 0.001", friction="false")
    text = text.replace("[[move]]\npause", 'profile = "quintic"\n[[move]]\npause')
    coarse = text.replace("friction = false", "friction = false\nnoise = { resolution = 1e-3, filter_time = 0.002 }")
    runs = [solve(parse_job(each), each, Path()) for each in (text, coarse)]
    law = runs[1].driven[0].scenario.law
    assert isinstance(law.law, EncoderLoop), "the delay is behind the law, the encoders before it"
    assert (float(law.law.resolution), law.law.filter_time) == (1e-3, 0.002)
    errors = [np.abs(each.recording.q_ref - each.recording.q).max() for each in runs]
    assert errors[0] < 2e-4 < errors[1] < 5e-3
    factors = [
        growth_along(parse_job(each), found.driven[0]).factor for each, found in zip((text, coarse), runs, strict=True)
    ]
    assert factors[0] == pytest.approx(factors[1]), "steps have no slope: small errors are those of the law itself"
