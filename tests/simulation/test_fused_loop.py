"""The loop compiled as a whole agrees with the general one to rounding, and ends as it does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import combine, computed_torque, feedforward, gravity_compensation, pid
from mafsil.errors import InputError
from mafsil.kernels.march import march
from mafsil.model import Friction
from mafsil.simulation import Plant, SensorNoise, WrenchPulse
from mafsil.simulation.fused import can_fuse
from mafsil.simulation.recording import SimulationStatus
from mafsil.trajectory import quintic

Q = np.array([0.2, -0.4, 0.6, 0.3, -0.5, 0.1])


@pytest.fixture(scope="module")
def arm():
    return mf.load("puma560")


def scenario(arm, **options):
    settings = {
        "robot": arm,
        "trajectory": quintic(Q, Q + 0.3, 0.15),
        "law": computed_torque(arm),
        "q": Q + 0.02 * np.random.default_rng(0).normal(size=(3, 2, 6)),
        "integrator": "semi_implicit_euler",
    }
    return mf.Scenario(**(settings | options))


def agree(a, b, tolerance=1e-11):
    assert a.status is b.status
    assert len(a.t) == len(b.t)
    others = b.arrays()
    for name, array in a.arrays().items():
        size = max(1.0, np.abs(array).max(initial=0.0))
        np.testing.assert_allclose(array, others[name], rtol=0, atol=tolerance * size, err_msg=name)
    same = {key: value for key, value in a.metadata.items() if key not in ("fused", "seconds")}
    assert same == {key: value for key, value in b.metadata.items() if key not in ("fused", "seconds")}


def test_friction_decides_which_step_is_compiled(arm):
    """Robots that differ in friction alone, one after another: code of the first, on the disk, is not the second's."""
    for viscous in (0.4, 4.0):
        joints = (replace(j, friction=Friction(viscous, 0.3)) if j.moves else j for j in arm.mechanism.joints)
        rubbing = mf.Robot(replace(arm.mechanism, joints=tuple(joints)))
        case = scenario(rubbing, law=computed_torque(arm), integrator="implicit_friction")
        agree(mf.simulate(case, fused=True), mf.simulate(case, fused=False), 1e-9)


CASES = {
    "computed torque": lambda arm: {},
    "with an integral and noise": lambda arm: {
        "law": computed_torque(arm, integral=50.0),
        "noise": SensorNoise(1e-4, 1e-3, 7),
    },
    "gravity compensation, pushes": lambda arm: {
        "law": gravity_compensation(arm, [800, 800, 400, 80, 80, 80], [60, 60, 30, 3, 3, 3]),
        "disturbances": (WrenchPulse(0.03, 0.05, [0, 0, 1.0, 20.0, 0, 0]),),
    },
    "feedforward and PID": lambda arm: {
        "law": combine(feedforward(arm), pid(6, [800, 800, 400, 80, 80, 80], [60, 60, 30, 3, 3, 3], 10.0))
    },
    "integrals that wait": lambda arm: {
        "law": combine(
            gravity_compensation(arm, 60.0, 4.0, 900.0, effort_limit=[20, 50, 30, 1, np.inf, 2]),
            pid(6, 20.0, 2.0, 400.0, effort_limit=[1, 2, 3, 4, 5, 0.5]),
            computed_torque(arm, integral=9.0),
        ),
        "noise": SensorNoise(1e-4, 1e-3, 7),
    },
    "another plant, rk4, no limits": lambda arm: {
        "plant": Plant(arm, friction=False).with_payload(1.0, [0.0, 0.0, 0.1]),
        "integrator": "rk4",
        "saturate": False,
    },
    "implicit friction": lambda arm: {"integrator": "implicit_friction", "plant": Plant(arm)},
    "substeps": lambda arm: {"step": 5e-4, "period": 2e-3},
}


@pytest.mark.capability("10-14", "09-65")
@pytest.mark.parametrize("case", CASES)
def test_both_loops_agree_to_rounding(arm, case):
    tried = scenario(arm, **CASES[case](arm))
    a, b = mf.simulate(tried, fused=True), mf.simulate(tried, fused=False)
    assert a.metadata["fused"]
    assert not b.metadata["fused"]
    assert a.status is SimulationStatus.COMPLETED
    agree(a, b)


def test_single_runs_and_batches_have_equal_bits(arm):
    tried = scenario(arm)
    whole = mf.simulate(tried, fused=True)
    for index in ((0, 0), (2, 1)):
        alone = mf.simulate(replace(tried, q=tried.q[index]), fused=True)
        for name in ("q", "qd", "qdd", "tau"):
            np.testing.assert_array_equal(getattr(alone, name), getattr(whole, name)[(slice(None), *index)])


def test_blow_ups_end_at_the_same_tick(arm):
    wild = gravity_compensation(arm, 1e7, 1e6)
    for options in ({"law": wild, "saturate": False}, {"law": wild, "saturate": False, "q": Q}):
        tried = scenario(arm, **options)
        with np.errstate(all="ignore"):
            a, b = mf.simulate(tried, fused=True), mf.simulate(tried, fused=False)
        assert a.status is b.status is SimulationStatus.BLOWN_UP
        assert len(a.t) == len(b.t) > 1
        assert np.isfinite(a.qd).all()


def test_progress_is_told_and_can_stop(arm):
    tried = scenario(arm, q=Q, duration=1.0)
    told: list[float] = []
    mf.simulate(tried, told.append, fused=True)
    assert told[-1] == 1.0
    assert told == sorted(told)
    stopped = mf.simulate(tried, lambda done: done < 0.3, fused=True)
    assert stopped.status is SimulationStatus.CANCELLED
    assert 0.2 < stopped.duration < 0.6
    for progress in (3, "often"):
        with pytest.raises(InputError, match="progress"):
            mf.simulate(tried, progress)  # type: ignore[arg-type]


def test_what_cannot_be_compiled_runs_step_by_step(arm):
    class Passive:
        def __call__(self, t, q, qd, reference):
            return np.zeros_like(q)

        def session(self, period):
            return self

    python = scenario(arm, law=Passive())
    long = scenario(arm, step=1e-4, period=1e-3)
    for tried in (python, long, scenario(arm, law=combine(pid(6, 1.0), Passive()))):
        assert not can_fuse(tried)
        with pytest.raises(InputError, match="step by step"):
            mf.simulate(tried, fused=True)
        assert not mf.simulate(replace(tried, duration=0.01)).metadata["fused"]


def test_long_runs_are_compiled_unasked_and_short_ones_not(arm):
    assert not mf.simulate(scenario(arm, q=Q)).metadata["fused"]
    assert mf.simulate(scenario(arm, q=np.broadcast_to(Q, (60, 6)))).metadata["fused"]


def test_marching_refuses_arrays_that_do_not_fit(arm):
    from mafsil.robot.compiling import compile_quantity

    kernel = compile_quantity(arm.mechanism, "gravity_torque")
    q, out = np.zeros((4, 3, 6)), np.empty((4, 3, 6))
    march(kernel, [q, out], 4)
    np.testing.assert_array_equal(out, np.broadcast_to(arm.gravity_torque(np.zeros(6)), (4, 3, 6)))
    march(kernel, [q[:0], out[:0]], 0)
    for wrong in ([q, out[:3]], [q[:, :2], out], [q[..., ::-1], out], [q.astype(np.float32), out], [q, out[:, :1]]):
        with pytest.raises(InputError):
            march(kernel, wrong, 4)
