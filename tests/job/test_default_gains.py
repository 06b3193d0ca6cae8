"""The default gains of the PD law, on every arm of the library: stable at the sampling rate, and nearly all arrive."""

from pathlib import Path

import numpy as np
import pytest

from mafsil.control import gravity_compensation, inertia_gains
from mafsil.errors import JobError
from mafsil.job import Run, parse_job, solve
from mafsil.job.judging.judgement import summary
from mafsil.job.planning.resting import resting_place
from mafsil.model import library
from mafsil.robot import load
from mafsil.simulation import Scenario, simulate
from mafsil.trajectory.profiles import rest
from tests.sizes import few

TOO_FREE = ("arm6r", "rrprrr", "rrrp")
"""Arms with nearly massless directions: what 1 kHz allows is soft, and they are told to be late."""


def job(robot: str, more: str = "", settle: float = 0.3) -> str:
    """A move of 0.3 rad of every joint from the default start."""
    limits = load(robot).limits
    start = resting_place(limits)
    goal = np.clip(np.where(start + 0.3 <= limits.upper, start + 0.3, start - 0.3), limits.lower, limits.upper).tolist()
    return (
        f'robot = "{robot}"\n[start]\njoints = {start.tolist()}\n[controller]\nkind = "pd_gravity"\n{more}\n'
        f"[simulation]\nsettle = {settle}\n[[move]]\njoints = {goal}\n"
    )


def driven(text: str) -> Run:
    run = solve(parse_job(text), text, Path())
    assert isinstance(run, Run)
    return run


@pytest.mark.parametrize("name", [*few(library.robots(), 5), *few(sorted(TOO_FREE), 2)])
def test_default_gains_move_every_library_arm(name: str) -> None:
    run = driven(job(name))
    numbers = summary(run)
    assert run.stopped is None
    failures = [remark.sentence("en") for remark in run.remarks if remark.level == "failure"]
    late = run.recording.q[-1] - run.recording.q_ref[-1]
    if name in TOO_FREE:
        assert numbers.not_reached
        assert any("lags behind" in sentence for sentence in failures)
        assert np.abs(late).max() < 0.4
    else:
        assert not failures
        assert np.abs(late).max() < 0.003
    tail = np.abs(run.recording.qd[-100:])
    assert tail[-50:].max() <= tail[:50].max() + 1e-6, "still, or calming down"


@pytest.mark.parametrize("name", ["panda", "ur5e", "planar3r", "scara_rrrp"])
@pytest.mark.parametrize("period", [1e-3, 4e-3, 2e-2])
def test_default_gains_stay_below_the_limit_of_the_sampled_loop(name: str, period: float) -> None:
    robot = load(name)
    q = np.linspace(resting_place(robot.limits), resting_place(robot.limits) + 0.3, 8)
    gains = inertia_gains(robot, q, period)
    decay = np.linalg.eigvals(np.linalg.solve(robot.mass_matrix(q), np.diag(gains.kd))).real.max()
    assert decay * period <= 1.5 + 1e-9
    law = gravity_compensation(robot, gains.kp, gains.kd)
    hold = Scenario(robot=robot, trajectory=rest(q[0], 0.4), law=law, q=q[0] + 1e-3, qd=0.0 * q[0], period=period)
    tape = simulate(hold, fused=False)
    assert tape.status.succeeded
    assert np.abs(tape.qd[-5:]).max() < 0.05


def test_a_stiffness_alone_keeps_the_damping_ratio() -> None:
    ours = driven(job("puma560")).driven[0].scenario.law.gains
    harder = driven(job("puma560", "kp = 9000")).driven[0].scenario.law.gains
    np.testing.assert_allclose(harder.kp, 9000.0)
    np.testing.assert_allclose(harder.kd / np.sqrt(harder.kp), ours.kd / np.sqrt(ours.kp), rtol=1e-12)
    given = driven(job("puma560", "kd = 70")).driven[0].scenario.law.gains
    np.testing.assert_allclose(given.kp, ours.kp)
    np.testing.assert_allclose(given.kd, 70.0)


@pytest.mark.parametrize(
    ("old", "name"),
    [
        ("frequency = 30", "frequency"),
        ("damping = 0.5", "damping"),
        ('kind = "computed_torque"\nkp = 10', "kp"),
        ('kind = "computed_torque"\nkd = [1.0, 2.0]', "kd"),
    ],
)
def test_gains_of_another_law_are_refused(old: str, name: str) -> None:
    text = job("planar2r", old)
    if "computed_torque" in old:
        text = text.replace('kind = "pd_gravity"\n', "")
    with pytest.raises(JobError) as caught:
        parse_job(text)
    assert caught.value.key == "job.no_gain"
    assert name in caught.value.message("en")
    assert caught.value.details["line"]


@pytest.mark.parametrize(("former", "name"), [("stiffness = 10", "kp"), ("rate_gain = 10", "kd")])
def test_former_names_of_gains_lead_to_the_present_ones(former: str, name: str) -> None:
    with pytest.raises(JobError, match=f"did you mean: {name}"):
        parse_job(job("planar2r", former), "x.toml")
