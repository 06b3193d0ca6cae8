"""R12: verdicts on force closure by three methods, on random plane and spatial grasps and on planted boundaries.

`python -m tests.reliability.grasps --grasps 10000000 --resume DIR`

Plane grasps have whole numbers, and every candidate certificate (the cross product of two columns) is tried in exact
integer arithmetic. Spatial ones: linear program, growing polytope, and the certificate or combination read back.
"""

from __future__ import annotations

import sys
from itertools import combinations

import numpy as np

from mafsil.arrays import Floats
from mafsil.grasp import Contact, Grasp
from mafsil.grasp.contact_batch import wrench_closures
from mafsil.grasp.quality import point_discs, quality_of_discs
from mafsil.solvers.rational import Location, locate_origin
from tests.reliability import figures

CHUNK = 20_000
SPATIAL_EVERY = 10
"""One grasp in so many is spatial."""
MARGINAL_EVERY = 1000


def work(seed: int, grasps: int) -> dict[str, int]:
    """Counts of grasps, verdicts and disagreements."""
    rng = np.random.default_rng([12, seed])
    count: dict[str, int] = {"grasps": grasps}
    spatial = grasps // SPATIAL_EVERY
    for size, judged in ((grasps - spatial, _plane), (spatial, _spatial)):
        for start in range(0, size, CHUNK):
            for name, value in judged(rng, min(CHUNK, size - start)).items():
                count[name] = count.get(name, 0) + value
    planted = max(1, grasps // MARGINAL_EVERY)
    return count | {"planted": planted, "bad_marginal": sum(not _marginal(rng) for _ in range(planted))}


def plane_grasps(rng: np.random.Generator, count: int) -> Floats:
    """(count, 3, n) wrenches of contacts at whole places with whole normals and mu = 1/2, 1 or 2, or none."""
    contacts = int(rng.integers(2, 5))
    points, normals = rng.integers(-4, 5, (count, contacts, 2)), rng.integers(-3, 4, (count, contacts, 2))
    normals[~normals.any(axis=-1)] = (1, 0)
    if rng.random() < 0.3:
        return _wrenches(points, 2 * normals)
    numerator, denominator = ((1, 2), (1, 1), (2, 1))[int(rng.integers(3))]
    tangent = np.stack([-normals[..., 1], normals[..., 0]], axis=-1)
    edges = [denominator * normals + sign * numerator * tangent for sign in (-1, 1)]
    return np.concatenate([_wrenches(points, edge) for edge in edges], axis=-1)


def _wrenches(points: Floats, forces: Floats) -> Floats:
    moment = points[..., 0] * forces[..., 1] - points[..., 1] * forces[..., 0]
    return np.stack([moment, forces[..., 0], forces[..., 1]], axis=1).astype(float)


def exactly_closed(W: Floats) -> np.ndarray:
    """Closure of (count, 3, n) whole wrenches: rank 3, and no cross product of two columns supports all of them."""
    A = np.swapaxes(W, 1, 2).astype(np.int64)
    opened, full = np.zeros(len(A), bool), np.zeros(len(A), bool)
    for i, j in combinations(range(A.shape[1]), 2):
        y = np.cross(A[:, i], A[:, j])
        heights = np.einsum("bnm,bm->bn", A, y)
        full |= heights.any(axis=1)
        opened |= y.any(axis=1) & ((heights >= 0).all(axis=1) | (heights <= 0).all(axis=1))
    return full & ~opened


def _proofs(W: Floats, found) -> int:
    """Combinations that do not combine to zero with positive weights, certificates that do not support."""
    size = np.abs(W).max(axis=(1, 2))
    yes, no = found.force_closure, ~found.force_closure
    x, y = found.combination[yes], found.certificate[no]
    residual = np.abs(np.einsum("bmn,bn->bm", W[yes], x)).max(axis=1, initial=0.0) > 1e-10 * size[yes]
    support = np.einsum("bmn,bm->bn", W[no], y).min(axis=1, initial=0.0) < -1e-10 * size[no]
    return int((residual | (x <= 0).any(axis=1)).sum() + (support | ~y.any(axis=1)).sum())


def _plane(rng: np.random.Generator, count: int) -> dict[str, int]:
    W = plane_grasps(rng, count)
    found = wrench_closures(W)
    differ = found.force_closure != exactly_closed(W)
    return {"closed": int(found.force_closure.sum()), "bad_plane": int(differ.sum()), "bad_proofs": _proofs(W, found)}


def _spatial(rng: np.random.Generator, count: int) -> dict[str, int]:
    n = int(rng.integers(7, 25))
    points, normals = rng.normal(size=(2, count, n, 3))
    if rng.random() < 0.5:
        points, normals = np.round(points), np.round(2 * normals)
        normals[~normals.any(axis=-1)] = (1, 0, 0)
    W = np.ascontiguousarray(np.concatenate([np.cross(points, normals), normals], axis=-1).swapaxes(1, 2))
    found = wrench_closures(W)
    differ = 0
    for k in range(len(W)):
        ball = quality_of_discs(point_discs(W[k]), tolerance=0.0)
        size = np.abs(W[k]).max()
        sure = ball is not None and (ball.epsilon > 1e-6 * size or ball.upper == 0.0)
        closed = (
            ball.epsilon > 0 if ball is not None and sure else locate_origin(W[k].T.tolist()).place is Location.INSIDE
        )
        differ += int(closed != found.force_closure[k])
    return {"closed": int(found.force_closure.sum()), "bad_spatial": differ, "bad_proofs": _proofs(W, found)}


def _marginal(rng: np.random.Generator) -> bool:
    """Two fingers with the joining line exactly on the edge of one cone: marginal, whatever the place and the size."""
    p, q = rng.integers(-9, 10, (2, 2))
    while not (q - p).any():
        q = rng.integers(-9, 10, 2)
    mu = float(rng.choice([0.25, 0.5, 1.0]))
    d = (q - p).astype(float)
    normal = d + rng.choice([-1, 1]) * mu * np.array([-d[1], d[0]])
    return Grasp([Contact(p, normal, mu), Contact(q, -d, mu)]).closure(margins=False).verdict == "marginal"


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "grasps", 100_000, 100_000)
    sys.exit(not figures.run("R12", options, work)["passed"])
