"""The same laws on MuJoCo's arm: what moves freely moves alike, and a recording says who computed it."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import computed_torque
from mafsil.errors import InputError
from mafsil.job import Run, parse_job, solve
from mafsil.simulation import MuJoCoPlant, Plant, Scenario, WrenchPulse, simulate
from mafsil.simulation import mujoco_plant as module
from mafsil.trajectory import quintic
from mafsil.trajectory.profiles import rest

ALIKE = 1e-10
"""Difference of joint positions after a second of free motion [rad], of which the arms cover up to ten."""


class Limp:
    """No effort at all."""

    def __call__(self, t, q, qd, reference):
        return np.zeros_like(q)

    def session(self, period):
        return self


def _both(robot, law, trajectory, friction=False, **options):
    return [
        simulate(
            Scenario(robot=robot, trajectory=trajectory, law=law, plant=kind(robot, friction=friction), **options),
            fused=False,
        )
        for kind in (Plant, MuJoCoPlant)
    ]


@pytest.mark.capability("10-2", "09-7")
@pytest.mark.parametrize("name", ["planar2r", "puma560", "panda"])
@pytest.mark.parametrize("integrator", ["semi_implicit_euler", "rk4"])
def test_free_motion_is_the_same(name, integrator):
    robot = mf.load(name)
    q, qd = np.linspace(0.3, -0.8, robot.n), np.linspace(-0.5, 0.7, robot.n)
    ours, theirs = _both(robot, Limp(), rest(q, 1.0), q=q, qd=qd, integrator=integrator)
    assert ours
    assert theirs
    assert np.abs(ours.q[-1] - q).max() > 1.0
    assert np.abs(ours.q - theirs.q).max() < ALIKE
    assert np.abs(ours.qdd - theirs.qdd).max() < 1e4 * ALIKE
    assert theirs.metadata["plant"].startswith("MuJoCo ")
    assert ours.metadata["plant"].startswith("mafsil ")


@pytest.mark.capability("10-2")
def test_the_same_law_runs_unchanged_with_pushes_and_batches():
    robot = mf.load("puma560")
    path = quintic(np.zeros(6), [0.8, -0.5, 0.6, 0.4, -0.4, 0.5], 0.5)
    start = 0.05 * np.random.default_rng(0).normal(size=(3, 6))
    push = WrenchPulse(0.1, 0.2, np.array([0, 0, 1, 5, -8, 3.0]))
    ours, theirs = _both(robot, computed_torque(robot), path, q=start, disturbances=(push,), step=5e-4)
    assert theirs.q.shape == ours.q.shape == (1001, 3, 6)
    assert np.abs(ours.q - theirs.q).max() < ALIKE


def test_dry_friction_keeps_the_arm_at_rest_and_slows_it_alike():
    robot = mf.load("puma560")
    path = quintic(np.zeros(6), [0.8, -0.5, 0.6, 0.4, -0.4, 0.5], 1.0)
    ours, theirs = _both(robot, computed_torque(robot, friction=False), path, friction=True)
    tracked = np.abs(ours.q - ours.q_ref).max()
    assert tracked > 0.01
    assert np.abs(ours.q - theirs.q).max() < 0.02 * tracked


def test_what_mujoco_does_not_know_is_refused(monkeypatch):
    robot = mf.load("planar2r")
    scenario = Scenario(
        robot=robot, trajectory=rest([0, 0], 0.1), law=Limp(), plant=MuJoCoPlant(robot), integrator="midpoint"
    )
    with pytest.raises(InputError, match="semi_implicit_euler, implicit_friction, rk4"):
        simulate(scenario)
    monkeypatch.setattr(module, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"mafsil\[mujoco\]"):
        MuJoCoPlant(robot)


def test_a_job_is_driven_by_either():
    assert importlib.util.find_spec("mujoco")
    text = """
robot = "puma560"
[simulation]
friction = false
plant = "{plant}"
[[move]]
joints = [0.4, -0.3, 0.5, 0.3, -0.4, 0.5]
"""
    runs = [solve(parse_job(words := text.format(plant=plant)), words, Path()) for plant in ("mafsil", "mujoco")]
    ours, theirs = runs
    assert isinstance(ours, Run)
    assert isinstance(theirs, Run)
    assert np.abs(ours.recording.q - theirs.recording.q).max() < ALIKE
    assert "MuJoCo" in theirs.explain()
    assert "MuJoCo" in theirs.explain("ar")
    assert "MuJoCo" not in ours.explain()
