"""Random robots as people have them: trees and typed tables, with all, some or no masses and limits."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from mafsil.model import DHRow, Inertial, Limits, Link, Mechanism, mechanism_from_dh
from tests.oracles.random_tree import random_tree


def random_robot(seed: int) -> Mechanism:
    """A tree, with mimic and fixed joints and bare links inside, or an arm from a typed table."""
    rng = np.random.default_rng(seed)
    mechanism = _table(rng) if rng.random() < 0.4 else random_tree(rng, most_joints=9, helical=False)
    limited = rng.random() < 0.7
    joints = [replace(joint, limits=_limits(rng) if limited else Limits()) for joint in mechanism.joints]
    masses = rng.choice(["as drawn", "none", "some degenerate"], p=[0.5, 0.15, 0.35])
    links = [link if masses == "as drawn" else _changed(rng, link, masses == "none") for link in mechanism.links]
    return replace(mechanism, joints=tuple(joints), links=tuple(links))


def _table(rng: np.random.Generator) -> Mechanism:
    rows = [
        DHRow(
            a=float(rng.choice([0.0, rng.uniform(-0.5, 0.5)])),
            alpha=float(rng.choice([0.0, np.pi / 2, -np.pi / 2, rng.uniform(-3, 3)])),
            d=float(rng.choice([0.0, rng.uniform(-0.5, 0.5)])),
            theta=float(rng.choice([0.0, rng.uniform(-3, 3)])),
            kind="P" if rng.random() < 0.3 else "R",
        )
        for _ in range(int(rng.integers(1, 8)))
    ]
    bodies = [Inertial(1.0, rng.normal(size=3) / 10, np.diag([0.02, 0.03, 0.04])) for _ in rows]
    arm = mechanism_from_dh(rows, str(rng.choice(["classic", "modified"])))
    moving = [replace(link, inertial=body) for link, body in zip(arm.links[1:], bodies, strict=True)]
    return replace(arm, links=(arm.links[0], *moving))


def _limits(rng: np.random.Generator) -> Limits:
    """Each bound known or not; a range may be open at one end."""
    known = rng.random(6) < 0.6
    lower, upper = (float(sign * rng.uniform(0.1, 3)) if known[k] else sign * inf for k, sign in ((0, -1), (1, 1)))
    rest = [float(rng.uniform(0.1, 100)) if known[k] else inf for k in range(2, 6)]
    return Limits(lower, upper, *rest)


def _changed(rng: np.random.Generator, link: Link, bare: bool) -> Link:
    """No mass, a point, a thin rod, a thin plate, or as it was."""
    kind = "none" if bare else rng.choice(["none", "point", "rod", "plate", "as it was"])
    if link.inertial is None or kind == "as it was":
        return link
    moments = {"none": None, "point": (0.0, 0.0, 0.0), "rod": (0.0, 0.1, 0.1), "plate": (0.1, 0.2, 0.3)}[str(kind)]
    if moments is None:
        return replace(link, inertial=None)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    inertia = turn @ np.diag(moments) @ turn.T
    return replace(link, inertial=Inertial(link.inertial.mass, link.inertial.com, (inertia + inertia.T) / 2))
