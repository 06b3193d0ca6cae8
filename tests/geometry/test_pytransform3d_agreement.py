"""Agreement with pytransform3d on random inputs, near 0 and near pi too; any number by command.

`python -m tests.geometry.test_pytransform3d_agreement 1000000`. Where the two differ, 50 digits decide:
near a half turn its quaternions lose four digits, and near the identity its exponential loses eight.
"""

from __future__ import annotations

import sys
from math import pi

import numpy as np
import pytest

from mafsil.geometry import euler, pose, quaternion, rotation, screw
from tests.geometry import arbiter
from tests.geometry.arbiter import EPS, LIMIT, Verdict, settle
from tests.geometry.samples import coordinates_to_both_ends

batch = pytest.importorskip("pytransform3d.batch_rotations")
rotations = pytest.importorskip("pytransform3d.rotations")
trajectories = pytest.importorskip("pytransform3d.trajectories")
transformations = pytest.importorskip("pytransform3d.transformations")


def verdicts(count: int, seed: int = 0) -> dict[str, Verdict]:
    """Comparison by function, whole batches on both sides."""
    rng = np.random.default_rng(seed)
    V, x = coordinates_to_both_ends(rng, count), rng.uniform(-1, 1, (count, 3))
    r, T = V[:, :3], pose.exp(V)
    R, length = T[:, :3, :3], np.linalg.norm(T[:, :3, 3], axis=-1)
    turn = batch.axis_angles_from_matrices(R)
    moved = trajectories.batch_dq_prod_vector(trajectories.dual_quaternions_from_transforms(T), x)
    q = quaternion.canonical(batch.quaternions_from_matrices(R))
    exp6 = trajectories.transforms_from_exponential_coordinates(V)
    log6 = trajectories.exponential_coordinates_from_transforms(T)
    return {
        "exp3": settle(rotation.exp(r), batch.matrices_from_compact_axis_angles(r), lambda k: arbiter.exact_exp3(r[k])),
        "log3": settle(rotation.log(R), turn[:, :3] * turn[:, 3:], lambda k: arbiter.exact_log3(R[k])),
        "exp6": settle(T, exp6, lambda k: arbiter.exact_exp6(V[k]), length),
        "log6": settle(pose.log(T), log6, lambda k: arbiter.exact_log6(T[k]), length),
        "to_quaternion": settle(quaternion.to_quaternion(R), q, lambda k: arbiter.exact_quaternion(R[k])),
        "act": settle(pose.act(T, x), moved, lambda k: arbiter.exact_act(T[k], x[k]), length),
    }


def deviations(count: int, seed: int = 1) -> dict[str, float]:
    """Largest difference of quaternions, products and inverses, whole batches on both sides."""
    rng = np.random.default_rng(seed)
    T, U = (pose.exp(coordinates_to_both_ends(rng, count)) for _ in range(2))
    q, p = quaternion.to_quaternion(T[:, :3, :3]), quaternion.to_quaternion(U[:, :3, :3])
    pairs = {
        "from_quaternion": (rotation.from_quaternion(q), batch.matrices_from_quaternions(q)),
        "multiply": (quaternion.multiply(q, p), batch.batch_concatenate_quaternions(q, p)),
        "inverse": (pose.inverse(T), trajectories.invert_transforms(T)),
        "compose": (pose.compose(T, U), trajectories.concat_many_to_many(U, T)),
    }
    return {name: float(np.abs(a - b).max()) for name, (a, b) in pairs.items()}


def sequence_deviations(count: int, seed: int = 2) -> dict[str, float]:
    """Largest difference of the rotations of all 24 sequences, whole batches on both sides."""
    angles = np.random.default_rng(seed).uniform(-pi, pi, (count, 3))
    found: dict[str, float] = {}
    for name in euler.SEQUENCES:
        places = ["xyz".index(letter) for letter in name.lower()]
        fixed = name.islower()
        theirs = batch.active_matrices_from_extrinsic_euler_angles if fixed else (
            batch.active_matrices_from_intrinsic_euler_angles
        )  # fmt: skip
        found[name] = float(np.abs(euler.from_euler(angles, name) - theirs(*places, angles)).max())
    return found


def single_deviations(count: int, seed: int = 3) -> dict[str, float]:
    """Largest difference of what it computes one at a time: Jacobians, adjoints, screws, angles."""
    rng = np.random.default_rng(seed)
    V = np.concatenate([_balls(rng, count), rng.uniform(-1, 1, (count, 3))], axis=-1)
    T, R = pose.exp(V), rotation.exp(V[:, :3])
    direction, point, pitch = (
        rotation.random(rng, (count,))[:, 0],
        rng.uniform(-1, 1, (count, 3)),
        rng.uniform(-2, 2, count),
    )
    axes = zip(point, direction, pitch, strict=True)
    q = quaternion.to_quaternion(R)
    pairs = {
        "left_jacobian3": (rotation.left_jacobian(V[:, :3]), _each(rotations.left_jacobian_SO3, V[:, :3])),
        "left_jacobian_inverse3": (
            rotation.left_jacobian_inverse(V[:, :3]), _each(rotations.left_jacobian_SO3_inv, V[:, :3])
        ),
        "left_jacobian6": (pose.left_jacobian(V), _each(transformations.left_jacobian_SE3, V)),
        "left_jacobian_inverse6": (pose.left_jacobian_inverse(V), _each(transformations.left_jacobian_SE3_inv, V)),
        "adjoint": (pose.adjoint(T), _each(transformations.adjoint_from_transform, T)),
        "from_axis": (
            screw.from_axis(direction, point, pitch),
            np.array([transformations.screw_axis_from_screw_parameters(*axis) for axis in axes]),
        ),
        "modified_rodrigues": (quaternion.to_modified_rodrigues(q), _each(rotations.mrp_from_quaternion, q)),
    }  # fmt: skip
    return {name: float((np.abs(a - b) / np.maximum(np.abs(a), 1.0)).max()) for name, (a, b) in pairs.items()}


def _balls(rng: np.random.Generator, count: int) -> np.ndarray:
    """Rotation vectors with angles over (0.1, 3.1): what cancels in their closed forms is judged by `verdicts`."""
    axes = rng.standard_normal((count, 3))
    return axes / np.linalg.norm(axes, axis=-1, keepdims=True) * rng.uniform(0.1, 3.1, (count, 1))


def _each(function: object, rows: np.ndarray) -> np.ndarray:
    return np.stack([np.asarray(function(row)) for row in rows])  # type: ignore[operator]


@pytest.mark.capability("04-63", "04-65", "04-95", "04-97")
def test_ten_thousand_random_motions() -> None:
    found = verdicts(10_000)
    assert {name: verdict for name, verdict in found.items() if verdict.lost} == {}


@pytest.mark.capability("04-74", "04-76", "04-81")
def test_ten_thousand_products_and_inverses() -> None:
    assert {name: value for name, value in deviations(10_000).items() if value > LIMIT} == {}


@pytest.mark.capability("04-44", "04-47")
def test_all_sequences() -> None:
    assert {name: value for name, value in sequence_deviations(10_000).items() if value > 8 * EPS} == {}


@pytest.mark.capability("04-35")
def test_angles_rebuild_the_rotation() -> None:
    R = rotation.random(np.random.default_rng(4), (1_000,))
    theirs = _each(lambda M: rotations.euler_from_matrix(M, 2, 1, 0, extrinsic=False), R)
    ours = euler.to_euler(R, "ZYX")
    found = settle(rotation.from_euler(ours, "ZYX"), rotation.from_euler(theirs, "ZYX"), lambda k: R[k].astype(object))
    assert found.lost == 0


@pytest.mark.capability("04-94", "04-102")
def test_jacobians_adjoints_and_screws() -> None:
    assert {name: value for name, value in single_deviations(1_000).items() if value > LIMIT} == {}


if __name__ == "__main__":
    size = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    for name, verdict in verdicts(size).items():
        print(f"{name:22} {verdict}")
    for comparison in (deviations, sequence_deviations, lambda count: single_deviations(min(count, 10_000))):
        for name, value in comparison(size).items():
            print(f"{name:22} {value:.2e}")
