"""Iterative learning: errors fall from pass to pass, as fast as the sensitivity says."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import Gains, combine, computed_torque
from mafsil.errors import InputError
from mafsil.simulation import Plant, Scenario, iterative_learning, learning_factor
from mafsil.simulation.iterative_learning import LearningStatus, low_passed
from mafsil.trajectory import quintic


def scenario(friction=True, payload=2.0, **options):
    robot = mf.load("puma560")
    arm = mf.Robot(robot.mechanism.with_payload(payload))
    path = quintic(np.zeros(6), [0.8, -0.5, 0.6, 0.4, -0.4, 0.5], 1.0)
    law = computed_torque(robot, natural_frequency=30.0, friction=False)
    plant = Plant(arm, friction=friction)
    return Scenario(robot=robot, plant=plant, trajectory=path, law=law, saturate=False, **options)


@pytest.mark.capability("10-88")
def test_a_payload_and_friction_that_the_model_does_not_know_are_learned():
    given = scenario()
    found = iterative_learning(given, 6)
    assert found.status is LearningStatus.IMPROVED
    assert len(found) == 6
    total = np.linalg.norm(found.error, axis=1)
    assert (np.diff(total) < 0).all()
    assert total[-1] < 0.02 * total[0]
    # What was learned does the same in a run of its own.
    alone = mf.simulate(Scenario(**{name: getattr(given, name) for name in (
        "robot", "plant", "trajectory", "saturate")}, law=combine(given.law, found.law)))  # fmt: skip
    rms = np.sqrt(np.mean((alone.q_ref - alone.q) ** 2, axis=0))
    assert np.linalg.norm(rms) < 1.2 * total[-1]
    assert f"{total[0]:.3g}" in found.explain("en")


@pytest.mark.capability("10-88")
def test_the_passes_converge_as_the_sensitivity_says():
    """A known load on a linear joint: the feedback of each pass is the last one's times Q S."""
    given = scenario(friction=False, payload=0.5)
    found = iterative_learning(given, 4, gain=0.5, cutoff=200.0)
    total = np.linalg.norm(found.error, axis=1)
    factor = learning_factor(given.law.gains, gain=0.5, cutoff=200.0).max()
    assert factor < 1
    assert (total[1:] / total[:-1] < factor).all()
    # Slow errors: Q S goes to 1 - gain.
    assert total[1] / total[0] == pytest.approx(0.5, abs=0.06)


@pytest.mark.capability("10-88")
def test_the_factor_is_that_of_the_transfer_function():
    gains = Gains.from_natural_frequency(2, [20.0, 20.0], [1.0, 0.2])
    found = learning_factor(gains, cutoff=1e6)
    w = np.linspace(0.1, 500, 200_000)
    for k, zeta in enumerate((1.0, 0.2)):
        s = 1j * w
        S = s**2 / (s**2 + 2 * zeta * 20 * s + 400)
        assert found[k] == pytest.approx(max(np.abs(S).max(), 1.0), rel=1e-3)
    assert learning_factor(gains, cutoff=1.0)[1] < 1 < found[1]


def test_the_low_pass_has_no_delay_and_lets_half_through_at_its_cutoff():
    t = np.arange(4000) * 1e-3
    wave = np.sin(2 * np.pi * 10.0 * t)[:, None]
    passed = low_passed(wave, 10.0 * 1e-3)
    middle = slice(1000, 3000)
    np.testing.assert_allclose(passed[middle], wave[middle] / np.sqrt(2), atol=1e-3)
    np.testing.assert_allclose(low_passed(np.ones((50, 2)), 0.01), 1.0)


def test_what_cannot_be_learned_from_is_said():
    with pytest.raises(InputError, match="batch"):
        iterative_learning(scenario(q=np.zeros((2, 6))), 2)
    with pytest.raises(InputError, match="gain"):
        iterative_learning(scenario(), 2, gain=1.5)
    with pytest.raises(InputError, match="cutoff"):
        iterative_learning(scenario(), 2, cutoff=0.0)
    nothing = iterative_learning(scenario(friction=False, payload=1e-9), 2)
    assert np.linalg.norm(nothing.error[0]) < 1e-3
