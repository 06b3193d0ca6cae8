"""Row R9b: assembly modes of random platforms on six legs: the planted pose is found, lengths hold, forty in all.

python -m tests.reliability.platforms --platforms 10000 --resume DIR

Each platform has its own random ends and a random pose, of which only the lengths of the legs are told. The real poses
are checked by plain arithmetic: lengths to 1e-9 of the size, rotations proper. Of every fiftieth platform a proof is
asked that its poses exist, differ and are all.
"""

from __future__ import annotations

import sys
from collections import Counter

import numpy as np

from mafsil.arrays import Floats
from mafsil.geometry import pose
from mafsil.parallel import StewartPlatform, stewart_assembly_modes
from tests.reliability import figures

SAME = 1e-6
"""Entries of poses nearer than this are those of the planted one: near a double pose half of the digits are lost."""
LENGTH = 1e-9
PROVED_EACH = 50


def work(seed: int, count: int) -> dict[str, int]:
    """Modes of `count` random platforms."""
    rng, total = np.random.default_rng([8, seed]), Counter[str](platforms=count)
    base, platform = rng.normal(size=(count, 6, 3)), rng.normal(size=(count, 6, 3))
    planted = pose.exp(rng.normal(size=(count, 6)) * [1.5, 1.5, 1.5, 1, 1, 1])
    lengths = lengths_at(planted, base, platform)
    found = stewart_assembly_modes(base, platform, lengths)
    for k in range(count):
        T = found.T[k, : int(found.count[k])]
        apart = np.abs(T - planted[k]).max(axis=(1, 2)) if len(T) else np.array([np.inf])
        size = float(max(np.abs(base[k]).max(), np.abs(platform[k]).max()))
        left = np.abs(lengths_at(T, base[k], platform[k]) - lengths[k]).max(initial=0.0)
        turned = np.abs(T[:, :3, :3] @ T[:, :3, :3].swapaxes(1, 2) - np.eye(3)).max(initial=0.0)
        total["real"] += len(T)
        total["all_forty"] += int(found.paths[k]) == found.expected == 40
        total["bad_planted"] += bool(apart.min() > SAME)
        total["bad_lengths"] += bool(left > LENGTH * size)
        total["bad_rotations"] += bool(turned > LENGTH or (np.linalg.det(T[:, :3, :3]) < 0).any())
        total["bad_count"] += int(found.paths[k]) > 40
        if k % PROVED_EACH == 0:
            proof = StewartPlatform(base[k], platform[k]).certificate(lengths[k])
            total["asked_for_proof"] += 1
            total["proven_to_be_all"] += proof.status.name == "ALL"
            total["bad_proof"] += proof.status.name == "ALL" and proof.real != len(T)
    return dict(total)


def lengths_at(T: Floats, base: Floats, platform: Floats) -> Floats:
    """(*batch, 6) distances of the ends of the legs at poses (*batch, 4, 4), by plain arithmetic."""
    ends = np.einsum("...ij,...kj->...ki", T[..., :3, :3], platform) + T[..., None, :3, 3]
    return np.sqrt(((ends - base) ** 2).sum(axis=-1))


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "platforms", 10_000, 500)
    sys.exit(not figures.run("R9b", options, work)["passed"])
