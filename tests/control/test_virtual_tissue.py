"""A haptic device: a hand pushes, and the tip is a tool of another mass on tissue that gives way."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import Impedance, TaskCoordinates, hold_pose, impedance_control
from mafsil.control.analysis import impedance_class
from mafsil.simulation import Plant, Scenario
from mafsil.trajectory.profiles import rest


class Hand:
    """A constant force in {s}, whatever the device does."""

    def __init__(self, force):
        self.force = np.array(force)

    def wrench(self, T, V):
        turned = (np.swapaxes(T[..., :3, :3], -1, -2) @ self.force[..., None])[..., 0]
        return np.concatenate([np.zeros_like(turned), turned], axis=-1)


@pytest.mark.capability("10-85", "10-81")
def test_the_hand_feels_the_tool_and_the_tissue_and_not_the_device():
    device, q = mf.load("planar2r"), np.array([0.5, 1.2])
    hand = Hand([2.0, -1.0, 0.0])
    tool = Impedance.of(2, inertia=0.8, damping=[6.0, 9.0], stiffness=[60.0, 90.0])
    law = impedance_control(
        device, tool, hold_pose(device.forward_kinematics(q)), coordinates=TaskCoordinates(rows=(3, 4)),
        sensor=lambda q, qd: np.broadcast_to(hand.force[:2], (*np.shape(q)[:-1], 2)),
    )  # fmt: skip
    plant = Plant(device, friction=False, environment=hand)

    def strayed(step):
        run = mf.simulate(
            Scenario(
                robot=device, plant=plant, trajectory=rest(q, 3.0), law=law, step=step, integrator="rk4", saturate=False
            )
        )  # fmt: skip
        assert run
        tip = device.forward_kinematics(run.q)[:, :2, 3]
        # m x'' + b x' + k x = F from rest, both axes underdamped.
        m, b, k, F = 0.8, np.array([6.0, 9.0]), np.array([60.0, 90.0]), hand.force[:2]
        decay = b / (2 * m)
        w = np.sqrt(k / m - decay**2)
        t = run.t[:, None]
        x = F / k * (1 - np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t)))
        np.testing.assert_allclose(tip[-1] - tip[0], F / k, rtol=2e-3)
        return np.abs(tip - tip[0] - x).max()

    worst = [strayed(step) for step in (1e-3, 5e-4)]
    assert worst[1] < 1e-4
    assert worst[0] / worst[1] == pytest.approx(2.0, rel=0.1)
    # Against a hand that holds on stiffly the tissue is soft.
    assert impedance_class(tool, Impedance.of(2, stiffness=2000.0)).status.name == "LOW"
