"""Directions found by force against those that made the forces; feedforward through a known contact."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil.control import SpringDamper, feedforward
from mafsil.control.contact import contact_feedforward, estimate_contact_constraint
from mafsil.control.contact.tip_sensor import EstimatedConstraintStatus
from mafsil.errors import InputError
from mafsil.simulation import Plant, Scenario
from mafsil.trajectory import quintic


@pytest.mark.capability("10-75")
@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.integers(0, 5))
def test_blocked_directions_are_found(seed, blocked):
    rng = np.random.default_rng(seed)
    A = np.linalg.qr(rng.normal(size=(6, 6)))[0][:blocked]
    noise = np.array([0.01, 0.01, 0.01, 0.1, 0.1, 0.1])
    forces = 5.0 * rng.normal(size=(400, blocked)) @ A + noise * rng.normal(size=(400, 6))
    found = estimate_contact_constraint(forces, noise)
    assert len(found.A) == blocked
    assert found.status is (EstimatedConstraintStatus.BLOCKED if blocked else EstimatedConstraintStatus.NOTHING)
    # What moves along the surface is not blocked by what was found.
    free = np.linalg.svd(A)[2][blocked:] if blocked else np.eye(6)
    assert np.abs(found.A @ free.T).max(initial=0.0) < 0.05
    assert found.explain("ar") != found.explain("en")
    assert "400" in found.explain("en")


def test_forces_that_say_nothing_are_refused():
    for forces, noise in ((np.zeros(6), 1.0), (np.zeros((0, 6)), 1.0), (np.ones((3, 6)), 0.0), ([[np.nan]], 1.0)):
        with pytest.raises(InputError):
            estimate_contact_constraint(forces, noise)
    assert not estimate_contact_constraint(np.zeros((2, 6)), 1.0)


@pytest.mark.capability("10-92")
def test_a_known_contact_is_fed_forward_exactly():
    arm = mf.load("planar2r")
    path = quintic(np.array([0.4, 1.1]), np.array([0.7, 0.8]), 0.6)
    spring = SpringDamper(arm.forward_kinematics(path.at(0.0).u)[:3, 3], stiffness=200.0, damping=20.0)
    plant = Plant(arm, friction=False, environment=spring)

    def worst(law, step=1e-4):
        run = mf.simulate(
            Scenario(
                robot=arm, plant=plant, trajectory=path, law=law, step=step, integrator="rk4", saturate=False
            )
        )  # fmt: skip
        return np.abs(run.q - run.q_ref).max()

    blind, knows = worst(feedforward(arm)), worst(contact_feedforward(arm, spring))
    assert knows < 1e-3 * blind
    # What is left is the effort held within each period: it halves with the period.
    assert worst(contact_feedforward(arm, spring), 2e-4) / knows == pytest.approx(2.0, rel=0.1)
    with pytest.raises(InputError, match="environment"):
        contact_feedforward(arm, 3.0)
