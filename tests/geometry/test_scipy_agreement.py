"""Agreement with SciPy's Rotation on many random inputs, near the ends too; a million by command.

`python tests/geometry/test_scipy_agreement.py 1000000`
"""

from __future__ import annotations

import sys
from math import pi

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Oracle

from mafsil.geometry import euler, quaternion, rotation
from tests import sizes

EPS = 2.0**-52


def deviations(count: int, seed: int = 0) -> dict[str, float]:
    """Largest deviation by function; angles and lengths in units of one."""
    rng = np.random.default_rng(seed)
    axes = rng.standard_normal((count, 3))
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    theta = rng.uniform(0, pi, count)
    theta[::4] = 10.0 ** rng.uniform(-12, 0, len(theta[::4]))
    theta[1::4] = pi - 10.0 ** rng.uniform(-7, 0, len(theta[1::4]))
    r = axes * theta[:, None]
    theirs = Oracle.from_rotvec(r)
    R = rotation.exp(r)
    q = theirs.as_quat(canonical=True, scalar_first=True)
    other = Oracle.random(count, random_state=seed)
    t = rng.uniform(0, 1, count)
    angles = rng.uniform(-pi, pi, (count, 3))
    found = {
        "exp": np.abs(R - theirs.as_matrix()).max(),
        "log": np.abs(rotation.log(theirs.as_matrix()) - theirs.as_rotvec()).max(),
        "to_quaternion": np.abs(quaternion.to_quaternion(theirs.as_matrix()) - q).max(),
        "from_quaternion": np.abs(rotation.from_quaternion(q) - theirs.as_matrix()).max(),
        "angle": np.abs(rotation.angle(R) - theirs.magnitude()).max(),
        "multiply": np.abs(R @ other.as_matrix() - (theirs * other).as_matrix()).max(),
        "apply": np.abs(rotation.apply(R, axes[::-1]) - theirs.apply(axes[::-1])).max(),
        "angle_between": np.abs(
            rotation.angle_between(R, other.as_matrix()) - (theirs.inv() * other).magnitude()
        ).max(),
    }
    relative = (theirs.inv() * other).as_rotvec()
    slerped = (theirs * Oracle.from_rotvec(t[:, None] * relative)).as_matrix()
    steady = np.linalg.norm(relative, axis=-1) < pi - 1e-3
    found["slerp"] = np.abs(rotation.slerp(R, other.as_matrix(), t) - slerped)[steady].max()
    for name in euler.SEQUENCES:
        matrices = Oracle.from_euler(name, angles).as_matrix()
        found[f"from_euler {name}"] = np.abs(rotation.from_euler(angles, name) - matrices).max()
        again = rotation.from_euler(rotation.to_euler(matrices, name), name)
        found[f"to_euler {name}"] = np.abs(again - matrices).max()
    return {name: float(value) for name, value in found.items()}


@pytest.mark.capability("04-18", "04-44", "04-77")
def test_random_rotations():
    found = deviations(sizes.size(20_000, 100_000))
    assert {name: value for name, value in found.items() if value > 24 * EPS} == {}


if __name__ == "__main__":
    size = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    for name, value in deviations(size).items():
        print(f"{name:18} {value:.2e}")
