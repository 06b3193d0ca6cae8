"""Error of the tool: closed forms of one and two links, first order against sampled arms, cheapest tolerances."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from scipy.optimize import minimize

import mafsil as mf
from mafsil.design import ParametricArm, Tolerances, accuracy, allocate

ARC_MINUTE = pi / 10800


def one_link(length: float = 0.5) -> mf.Robot:
    return mf.Robot.from_dh([{}], "modified", tool=_along(length))


def _along(x: float) -> np.ndarray:
    T = np.eye(4)
    T[0, 3] = x
    return T


def random_arm(seed: int) -> mf.Robot:
    """Five to seven joints at random places, one of them prismatic now and then."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(5, 8))
    rows = [
        {
            "a": rng.uniform(0, 0.5), "alpha": rng.choice([-pi / 2, 0, pi / 2, rng.uniform(-pi, pi)]),
            "d": rng.uniform(-0.3, 0.3), "kind": "P" if rng.random() < 0.15 else "R",
        }
        for _ in range(n)
    ]  # fmt: skip
    return mf.Robot.from_dh(rows, "modified", tool=_along(0.1))


def test_encoder_backlash_and_zero_of_one_link() -> None:
    found = accuracy(one_link(), [0.7], Tolerances(encoder=1e-4, backlash=ARC_MINUTE, zero=3e-4))
    parts = {"encoder": 1e-4 / sqrt(12), "backlash": ARC_MINUTE / sqrt(12), "zero": 1e-4}
    assert found.rms == pytest.approx(0.5 * sqrt(sum(v**2 for v in parts.values())))
    assert found.repeatability == pytest.approx(0.5 * sqrt(parts["encoder"] ** 2 + parts["backlash"] ** 2))
    total = sum(v**2 for v in parts.values())
    assert found.shares == pytest.approx({k: v**2 / total for k, v in parts.items()})
    # The error lies across the link.
    across = np.array([-np.sin(0.7), np.cos(0.7), 0])
    assert abs(found.directions[:, 0] @ across) == pytest.approx(1.0)
    assert found.pays_most == "zero joint1"
    assert found
    assert "0.0" in found.explain()


def test_length_tolerances_add_at_the_tool() -> None:
    two = mf.Robot.from_dh([{}, {"a": 0.4}], "modified", tool=_along(0.3))
    found = accuracy(two, [0.2, 0.9], Tolerances(length=3e-4))
    np.testing.assert_allclose(found.covariance[3:, 3:], 3 * 1e-8 * np.eye(3), atol=1e-20)


def test_heat_lengthens_links() -> None:
    two = mf.Robot.from_dh([{}, {"a": 0.4}], "modified", tool=_along(0.3))
    found = accuracy(two, [0.0, 0.0], Tolerances(temperature=30.0, expansion=12e-6))
    assert found.rms == pytest.approx(10.0 * 12e-6 * 0.7)
    bent = accuracy(two, [0.3, pi / 2], Tolerances(temperature=30.0, expansion=12e-6), samples=4000)
    assert bent.rms == pytest.approx(10.0 * 12e-6 * 0.5)
    assert bent
    tube = {"outer": 0.1, "wall": 0.01, "material": "steel"}
    design = ParametricArm.of(
        {"convention": "modified", "joint": [{"tube": tube}], "tool": {"xyz": [0.7, 0.0, 0.0]}}
    ).at()
    assert accuracy(design, [0.0], Tolerances(temperature=30.0)).rms == pytest.approx(10.0 * 12e-6 * 0.7)


@pytest.mark.parametrize("seed", range(20))
def test_ellipsoids_against_sampled_arms(seed: int) -> None:
    arm, rng = random_arm(seed), np.random.default_rng(100 + seed)
    tolerances = Tolerances(
        encoder=2 * pi / 2**16, backlash=ARC_MINUTE, zero=2e-4, length=1e-4, angle=1e-4, temperature=10.0,
        expansion=23e-6,
    )  # fmt: skip
    found = accuracy(arm, rng.uniform(-1.5, 1.5, arm.n), tolerances, samples=20_000, seed=seed)
    assert found
    C, S = found.covariance, found.sampled_covariance
    unit = np.sqrt(np.diag(C))
    # Standard error of 20,000 samples: 0.7 % of a variance.
    np.testing.assert_allclose(S / np.outer(unit, unit), C / np.outer(unit, unit), atol=0.04)
    assert found.sampled_rms == pytest.approx(found.rms, rel=0.02)
    assert 0.94 < found.inside < 0.96


def test_large_errors_contradict_the_first_order() -> None:
    found = accuracy(one_link(), [0.0], Tolerances(zero=6.0), samples=2000)
    assert not found
    assert "Monte Carlo" in found.explain()
    assert accuracy(one_link(), [0.0], Tolerances(zero=6.0)).to_dict()["status"] == "unchecked"


def test_deflection_is_a_bias_and_its_uncertainty_a_cause() -> None:
    table = {
        "convention": "frames", "tool": {"xyz": [0.8, 0.0, 0.0]},
        "joint": [{"axis": [0.0, 1.0, 0.0], "drive": {"stiffness": 2e4}}],
    }  # fmt: skip
    design = ParametricArm.of(table).at()
    found = accuracy(design, [0.0], Tolerances(stiffness=0.3), payload=5.0, samples=5000)
    sag = 5 * 9.81 * 0.8**2 / 2e4
    assert found.bias[5] == pytest.approx(-sag)
    assert found.rms == pytest.approx(0.1 * sag)
    assert found.pays_most == "stiffness"
    assert found


def test_cheapest_tolerances_at_one_pose_are_the_closed_form() -> None:
    two = mf.Robot.from_dh([{}, {"a": 0.4}], "modified", tool=_along(0.3))
    found = allocate(two, [0.0, 0.0], 1e-4, {"zero": 2.0})
    a, c = np.array([0.7, 0.3]) ** 2 / 9, np.array([2.0, 2.0])
    t = np.cbrt(c / a)
    t *= 1e-4 / sqrt(a @ t**2)
    assert list(found.tolerances.values()) == pytest.approx(t.tolist(), rel=1e-6)
    assert found.cost == pytest.approx((c / t).sum(), rel=1e-6)
    assert found
    assert accuracy(two, [0.0, 0.0], Tolerances(zero=list(found.tolerances.values()))).rms == pytest.approx(1e-4)


def test_cheapest_tolerances_at_several_poses_against_another_solver() -> None:
    arm = random_arm(3)
    poses = np.random.default_rng(0).uniform(-1.5, 1.5, (4, arm.n))
    found = allocate(arm, poses, 2e-4, {"length": 1.0, "zero": 3.0}, fixed=Tolerances(encoder=1e-5))
    assert found
    assert found.rms.max() == pytest.approx(2e-4)
    names = list(found.tolerances)

    def variances(t: np.ndarray) -> np.ndarray:
        given = {kind: np.zeros(arm.n + (kind == "length")) for kind in ("length", "zero")}
        for name, value in zip(names, t, strict=True):
            kind, joint = name.split()
            given[kind][(*arm.joint_names, "tool").index(joint)] = value
        return np.array([accuracy(arm, q, Tolerances(encoder=1e-5, **given)).rms ** 2 for q in poses])

    c = np.array([1.0 if name.startswith("length") else 3.0 for name in names])
    scale = np.array(list(found.tolerances.values()))
    other = minimize(
        lambda x: (c / scale / x).sum() / found.cost, np.full(len(names), 0.5), method="SLSQP",
        constraints={"type": "ineq", "fun": lambda x: 1 - variances(x * scale) / 4e-8},
        bounds=[(1e-3, 10)] * len(names), options={"maxiter": 200, "ftol": 1e-10},
    )  # fmt: skip
    assert other.fun == pytest.approx(1.0, abs=1e-4)


def test_no_room_and_wrong_arguments() -> None:
    found = allocate(one_link(), [0.0], 1e-5, {"zero": 1.0}, fixed=Tolerances(length=1e-3))
    assert not found
    assert "mm" in found.explain()
    with pytest.raises(mf.InputError, match="weight"):
        allocate(one_link(), [0.0], 1e-3, {"weight": 1.0})
    with pytest.raises(mf.InputError, match="wanted"):
        allocate(one_link(), [0.0], -1.0, {"zero": 1.0})
    with pytest.raises(mf.InputError, match="zero"):
        accuracy("puma560", np.zeros(6), Tolerances(zero=[1e-3] * 5))
    with pytest.raises(mf.InputError, match="encoder"):
        Tolerances(encoder=-1e-3)
    with pytest.raises(mf.InputError, match="chain"):
        accuracy(_branched(), [0.0, 0.0], Tolerances())


def _branched() -> mf.Robot:
    links = [mf.model.Link(name) for name in "blr"]
    joints = [mf.model.Joint(name=f"to_{c}", kind=mf.model.JointKind.REVOLUTE, parent="b", child=c) for c in "lr"]
    return mf.Robot(mf.Mechanism.assemble("y", links, joints))
