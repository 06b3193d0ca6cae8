"""Motions and recordings as answers: true if they reached their end, iterable over a batch, tables when printed."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import computed_torque
from mafsil.mechanics.rigid_body import RigidBody
from mafsil.simulation import forward_dynamics_trajectory, free_body_motion, inverse_dynamics_trajectory
from mafsil.solvers import Event
from mafsil.trajectory import quintic

Q = np.array([0.3, -0.4])
WIDEST, LONGEST = 100, 25


@pytest.fixture(scope="module")
def arm() -> mf.Robot:
    return mf.load("planar2r")


def fits_a_screen(text: str) -> bool:
    lines = text.split("\n")
    return len(lines) <= LONGEST and max(map(len, lines)) <= WIDEST


def test_a_recording_is_true_and_prints_a_row_for_each_joint(arm: mf.Robot) -> None:
    run = mf.simulate(mf.Scenario(robot=arm, trajectory=quintic(Q, Q + 0.2, 0.05), law=computed_torque(arm)))
    assert run
    assert len(run) == 1
    assert [one.t is run.t for one in run] == [True]
    assert fits_a_screen(repr(run))
    assert all(name in str(run) for name in arm.joint_names)
    assert run._repr_html_().startswith("<pre")
    assert run.to_dict()["status"] == "completed"


def test_a_batch_is_iterated_run_by_run(arm: mf.Robot) -> None:
    starts = Q + np.linspace(-0.1, 0.1, 3)[:, None]
    batch = mf.simulate(
        mf.Scenario(robot=arm, trajectory=quintic(Q, Q + 0.2, 0.02), law=computed_torque(arm), q=starts)
    )
    assert len(batch) == 3
    for k, run in enumerate(batch):
        np.testing.assert_array_equal(run.q, batch.q[:, k])
        np.testing.assert_array_equal(run.tip_position_error, batch.tip_position_error[:, k])


def test_a_forward_motion_of_a_batch_keeps_the_events_of_each(arm: mf.Robot) -> None:
    starts = np.array([[0.5, 0.0], [-0.5, 0.2]])
    event = Event(lambda t, y: y[..., 0], name="passes zero")
    motion = forward_dynamics_trajectory(arm, starts, duration=0.6, events=[event])
    assert motion
    parts = list(motion)
    assert sum(len(part.events) for part in parts) == len(motion.events)
    for k, part in enumerate(parts):
        np.testing.assert_array_equal(part.at(0.31).u, motion.at(0.31).u[k])
        assert fits_a_screen(str(part))
    late = forward_dynamics_trajectory(arm, Q, duration=1.0, method="dop853", most_steps=2)
    assert not late
    assert late.to_dict()["status"] == late.status.name.lower()


def test_an_inverse_motion_says_whether_its_efforts_are_numbers(arm: mf.Robot) -> None:
    t = np.linspace(0.0, 0.5, 20)
    motion = inverse_dynamics_trajectory(arm, quintic(Q, Q + 0.2, 0.5), t)
    assert motion
    assert fits_a_screen(str(motion))
    assert "20" in motion.explain("en")
    assert motion.to_dict()["joints"] == list(arm.joint_names)


def test_a_free_body_prints_its_components() -> None:
    body = RigidBody(mf.model.Inertial(1.0, [0.0, 0.0, 0.0], np.diag([0.1, 0.2, 0.3])))
    motion = free_body_motion(body, np.eye(4), [0.0, 1.0, 0.1, 0.0, 0.0, 0.0], duration=0.2)
    assert motion
    assert fits_a_screen(str(motion))
    assert len(list(motion)) == 1
