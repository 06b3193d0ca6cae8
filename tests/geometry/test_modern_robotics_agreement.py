"""Agreement with the code of Modern Robotics on random inputs, near 0 and near pi too; any number by command.

`python -m tests.geometry.test_modern_robotics_agreement 1000000`. Where the two differ, 50 digits decide: its
logarithm takes the angle from an arc cosine and keeps half of the digits near 0 and pi; below 1e-6 its exponential is
the identity.
"""

from __future__ import annotations

import sys

import numpy as np
import pytest

from mafsil.geometry import pose, rotation, screw, twist
from tests.geometry import arbiter
from tests.geometry.arbiter import EPS, Verdict, settle
from tests.geometry.samples import coordinates_to_both_ends

mr = pytest.importorskip("modern_robotics")


def verdicts(count: int, seed: int = 0) -> dict[str, Verdict]:
    """Comparison by function."""
    rng = np.random.default_rng(seed)
    V = coordinates_to_both_ends(rng, count)
    r, T = V[:, :3], pose.exp(V)
    R, length = T[:, :3, :3], np.linalg.norm(T[:, :3, 3], axis=-1)
    near = R + 0.1 * rotation.random(rng, (count,))
    exp3 = _each(lambda x: mr.MatrixExp3(mr.VecToso3(x)), r)
    log3 = _each(lambda M: mr.so3ToVec(mr.MatrixLog3(M)), R)
    exp6 = _each(lambda x: mr.MatrixExp6(mr.VecTose3(x)), V)
    log6 = _each(lambda M: mr.se3ToVec(mr.MatrixLog6(M)), T)
    return {
        "exp3": settle(rotation.exp(r), exp3, lambda k: arbiter.exact_exp3(r[k])),
        "log3": settle(rotation.log(R), log3, lambda k: arbiter.exact_log3(R[k])),
        "exp6": settle(T, exp6, lambda k: arbiter.exact_exp6(V[k]), length),
        "log6": settle(pose.log(T), log6, lambda k: arbiter.exact_log6(T[k]), length),
        "project": settle(
            rotation.project(near), _each(mr.ProjectToSO3, near), lambda k: arbiter.exact_project(near[k])
        ),
    }


def deviations(count: int, seed: int = 1) -> dict[str, float]:
    """Largest difference of the functions in which nothing cancels."""
    rng = np.random.default_rng(seed)
    V, W = coordinates_to_both_ends(rng, count), rng.uniform(-1, 1, (count, 6))
    T = pose.exp(V)
    pitch, point = rng.uniform(-2, 2, count), W[:, 3:]
    direction = W[:, :3] / np.linalg.norm(W[:, :3], axis=-1, keepdims=True)
    axis = [mr.ScrewToAxis(*row) for row in zip(point, direction, pitch, strict=True)]
    unit = _each(lambda x: mr.AxisAng6(x)[0], W)
    pairs = {
        "inverse": (pose.inverse(T), _each(mr.TransInv, T)),
        "adjoint": (pose.adjoint(T), _each(mr.Adjoint, T)),
        "ad": (twist.ad(V), _each(mr.ad, V)),
        "hat": (pose.hat(V), _each(mr.VecTose3, V)),
        "from_axis": (screw.from_axis(direction, point, pitch), np.array(axis)),
        "normalised": (screw.normalise(W), unit),
        "transform": (twist.transform(T, W), np.einsum("kij,kj->ki", _each(mr.Adjoint, T), W)),
    }
    return {name: float((np.abs(a - b) / np.maximum(np.abs(b), 1.0)).max()) for name, (a, b) in pairs.items()}


def _each(function: object, rows: np.ndarray) -> np.ndarray:
    return np.stack([np.asarray(function(row)) for row in rows])  # type: ignore[operator]


@pytest.mark.capability("04-63", "04-65", "04-95", "04-97")
def test_ten_thousand_random_motions() -> None:
    found = verdicts(10_000)
    assert {name: verdict for name, verdict in found.items() if verdict.lost} == {}


@pytest.mark.capability("04-96", "04-102")
def test_ten_thousand_changes_of_frame() -> None:
    assert {name: value for name, value in deviations(10_000).items() if value > 24 * EPS} == {}


def test_its_logarithm_near_a_half_turn_is_wrong_and_ours_is_not() -> None:
    r = np.array([[1.0, 2.0, -2.0]]) / 3 * (np.pi - 1e-7)
    R = rotation.exp(r)
    theirs = mr.so3ToVec(mr.MatrixLog3(R[0]))[None]
    verdict = settle(rotation.log(R), np.asarray(theirs), lambda k: arbiter.exact_log3(R[k]))
    assert verdict.theirs > 1e-4
    assert verdict.ours < 8 * EPS


if __name__ == "__main__":
    size = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    for name, verdict in verdicts(size).items():
        print(f"{name:12} {verdict}")
    for name, value in deviations(size).items():
        print(f"{name:12} {value:.2e}")
