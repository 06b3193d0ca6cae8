"""Random members of the groups and the batch shapes that every law is tried at."""

from __future__ import annotations

from math import pi

import numpy as np
from hypothesis import strategies as st

from mafsil.geometry import pose, rotation

seeds = st.integers(0, 2**32 - 1)
batches = st.sampled_from([(), (1,), (3, 1, 2)])


def poses(seed: int, shape: tuple[int, ...], count: int = 1) -> list[np.ndarray]:
    """(*shape, 4, 4) uniform rotations, origins within one metre along each axis."""
    rng = np.random.default_rng(seed)
    return [
        pose.from_rotation_translation(rotation.random(rng, shape), rng.uniform(-1, 1, (*shape, 3)))
        for _ in range(count)
    ]


def coordinates_to_both_ends(rng: np.random.Generator, count: int) -> np.ndarray:
    """(count, 6) exponential coordinates: angles over (0, pi), a quarter down to 1e-12, a quarter up to pi - 1e-7."""
    axes = rng.standard_normal((count, 3))
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    theta = rng.uniform(0, pi, count)
    theta[::4] = 10.0 ** rng.uniform(-12, 0, len(theta[::4]))
    theta[1::4] = pi - 10.0 ** rng.uniform(-7, 0, len(theta[1::4]))
    return np.concatenate([axes * theta[:, None], rng.uniform(-1, 1, (count, 3))], axis=-1)
