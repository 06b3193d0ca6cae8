"""Random arms of every family that has a closed form: axes anywhere, or along coordinate axes with round offsets."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import product

import numpy as np

from mafsil.geometry import pose
from mafsil.ik.chain import Chain

Maker = Callable[[np.random.Generator, bool], Chain]


def _directions(rng: np.random.Generator, n: int, rounded: bool) -> np.ndarray:
    if rounded:
        return np.eye(3)[rng.integers(0, 3, n)] * rng.choice([-1.0, 1.0], (n, 1))
    w = rng.normal(size=(n, 3))
    return w / np.linalg.norm(w, axis=1, keepdims=True)


def _points(rng: np.random.Generator, n: int, rounded: bool) -> np.ndarray:
    return rng.integers(-2, 3, (n, 3)) * 0.25 if rounded else 0.5 * rng.normal(size=(n, 3))


def _chain(w: np.ndarray, r: np.ndarray, slides: tuple[int, ...], rng: np.random.Generator, rounded: bool) -> Chain:
    sliding = np.isin(np.arange(len(w)), slides)
    r = np.where(sliding[:, None], 0.0, r - (r * w).sum(axis=1, keepdims=True) * w)
    home = pose.exp(np.concatenate([_directions(rng, 1, rounded)[0] * (np.pi / 2 if rounded else 1.1), np.zeros(3)]))
    home[:3, 3] = _points(rng, 1, rounded)[0]
    return Chain(w, r, tuple(bool(s) for s in sliding), tuple(range(len(w))), home)


def wrist(at: int, slides: tuple[int, ...], rng: np.random.Generator, rounded: bool) -> Chain:
    """Six joints, three of them through one point."""
    w, r = _directions(rng, 6, rounded), _points(rng, 6, rounded)
    r[at : at + 3] = r[at]
    return _chain(w, r, slides, rng, rounded)


def wrist_and(kind: str, rng: np.random.Generator, rounded: bool) -> Chain:
    """A spherical wrist, and axes 2 and 3 parallel or 1 and 2 meeting: PUMA and its relatives."""
    w, r = _directions(rng, 6, rounded), _points(rng, 6, rounded)
    r[3:] = r[3]
    if kind == "parallel":
        w[2] = w[1] * rng.choice([-1.0, 1.0])
    else:
        r[1] = r[0]
    return _chain(w, r, (), rng, rounded)


def parallel(at: int, slides: tuple[int, ...], meeting: bool, rng: np.random.Generator, rounded: bool) -> Chain:
    """Six joints, three neighbours parallel; the last two meeting if asked for (UR)."""
    w, r = _directions(rng, 6, rounded), _points(rng, 6, rounded)
    w[at : at + 3] = w[at] * rng.choice([-1.0, 1.0], (3, 1))
    if meeting:
        r[5] = r[4]
    return _chain(w, r, slides, rng, rounded)


def five(rng: np.random.Generator, rounded: bool) -> Chain:
    """Five joints: two, and a spherical wrist."""
    w, r = _directions(rng, 5, rounded), _points(rng, 5, rounded)
    r[2:] = r[2]
    return _chain(w, r, (), rng, rounded)


def planar(slides: tuple[int, ...], rng: np.random.Generator, rounded: bool) -> Chain:
    """Three parallel axes; four joints with a slide along them (SCARA)."""
    n = 4 if slides else 3
    w, r = np.repeat(_directions(rng, 1, rounded), n, axis=0), _points(rng, n, rounded)
    return _chain(w, r, slides, rng, rounded)


FAMILIES: dict[str, Maker] = {
    "puma": partial(wrist_and, "parallel"),
    "generalised_puma": partial(wrist_and, "meeting"),
    "ur": partial(parallel, 1, (), True),
    "five": five,
    "planar": partial(planar, ()),
    **{f"scara{k}": partial(planar, (k,)) for k in (0, 2, 3)},
    **{f"wrist_at_{at + 1}": partial(wrist, at, ()) for at in range(4)},
    **{f"parallel_at_{at + 1}": partial(parallel, at, (), False) for at in range(4)},
    **{
        "wrist_" + "".join("RP"[s] for s in kinds): partial(wrist, 3, tuple(i for i in range(3) if kinds[i]))
        for kinds in product((0, 1), repeat=3)
        if any(kinds)
    },
}
"""Makers by name: of a random generator and whether axes and offsets are round."""


def forward(chain: Chain, q: np.ndarray) -> np.ndarray:
    """(*batch, 4, 4) poses by the product of exponentials: nothing of the closed form is in it."""
    T = np.broadcast_to(np.eye(4), (*q.shape[:-1], 4, 4))
    for screw, x in zip(chain.screws, np.moveaxis(q, -1, 0), strict=True):
        T = T @ pose.exp(screw * x[..., None])
    return T @ chain.home


def jacobian(chain: Chain, q: np.ndarray) -> np.ndarray:
    """(*batch, 6, n) space Jacobians, lengths in units of the arm."""
    T = np.broadcast_to(np.eye(4), (*q.shape[:-1], 4, 4))
    columns = []
    for screw, x in zip(chain.screws, np.moveaxis(q, -1, 0), strict=True):
        columns.append((pose.adjoint(T) @ screw[:, None])[..., 0])
        T = T @ pose.exp(screw * x[..., None])
    # About the middle of the arm, so that far origins do not count.
    J = np.stack(columns, axis=-1)
    centre = chain.points[~np.array(chain.prismatic)].mean(axis=0) if not all(chain.prismatic) else np.zeros(3)
    shift = np.eye(4)
    shift[:3, 3] = -centre
    return pose.adjoint(shift) @ J / np.repeat([1.0, chain.size], 3)[:, None]
