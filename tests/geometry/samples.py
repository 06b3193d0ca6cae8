"""Random members of the groups and the batch shapes that every law is tried at."""

from __future__ import annotations

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
