"""Grasps of a given body: fingertips are tried all over its surface, what closes is rated, the best are returned.

Two soft fingers are sought along lines through the body (they close iff the line lies inside both cones); three and
more by random sets, closed or not in one batch, and rated by their epsilon quality about the centre of mass.

Two soft fingers resist a torsion of gamma about their line wherever they are, so for small gamma epsilon is
the same for nearly all of them. Among equals the one counts that carries weight best: epsilon with moments divided by
gamma instead of the body's size. It shrinks as the line leaves the centre of mass and as it nears the edge of a cone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import whole
from mafsil.errors import InputError
from mafsil.grasp.body import GraspedBody
from mafsil.grasp.contact import Contact
from mafsil.grasp.contact_batch import wrench_closures
from mafsil.grasp.grasp import Grasp
from mafsil.grasp.quality import quality_of_wrenches

Progress = Callable[[float], None]
"""Called with the share of the closing sets that are rated, up to 1."""
EDGES = 6
"""Of the cones while sets are sorted out; the best are rated with round cones."""
EQUAL = 0.05
"""Qualities within this share of the largest count as equal."""
INSIDE = 0.98
"""Lines are tilted up to this share of the friction angle."""


@dataclass(frozen=True, eq=False)
class PlannedGrasp:
    """One proposal.

    Attributes:
        grasp: the contacts.
        epsilon: quality about the body's centre, moments divided by its size; proven.
        opening: distance of the two fingers [m]; None for more.
        weight: two fingers: the weight, in any direction, that a total push of 1 holds together with its moment at a
            lever of gamma about the body's centre; None for more.
    """

    grasp: Grasp
    epsilon: float
    opening: float | None
    weight: float | None = None


class PlanStatus(Status):
    """Whether grasps were found."""

    FOUND = ("grasp.plan_found", True)
    FOUND_ON_OPEN_MESH = ("grasp.plan_open_mesh", True)
    NOT_FOUND = ("grasp.plan_none", False)


@dataclass(frozen=True, eq=False, repr=False)
class GraspPlan(
    Answer,
    entries="grasps",
    data="tried closing length=body.size centre=body.centre open_edges=body.open_edges",
):
    """The grasps that a search found, best first; true if there are any.

    Attributes:
        grasps: the best, best first; empty if none closes.
        tried: sets of contacts that were looked at.
        closing: how many of them close.
        body: that is to be grasped.
        status: found, on a closed or an open mesh, or not found.
    """

    grasps: tuple[PlannedGrasp, ...]
    tried: int
    closing: int
    body: GraspedBody
    status: PlanStatus

    def explain(self, language: str | None = None) -> str:
        """The finding in words."""
        best = self.grasps[0].epsilon if self.grasps else 0.0
        return self.status.sentence(
            language, tried=self.tried, closing=self.closing, epsilon=best,
            length=self.body.size, edges=self.body.open_edges,
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        grasps = [
            {"epsilon": p.epsilon, "weight": p.weight, "opening": p.opening, **p.grasp.to_dict()} for p in self.grasps
        ]
        return Answer.to_dict(self) | {"grasps": grasps}


def plan_grasps(
    body: Any, *, fingers: int = 2, mu: float = 0.5, gamma: float | None = None, opening: float = np.inf,
    tries: int = 2000, best: int = 10, seed: int = 0, progress: Progress | None = None,
) -> GraspPlan:  # fmt: skip
    """The most robust grasps of a body that a random search finds.

    1. Random lines through the body (two fingers) or random sets of surface points are tried; those that close stay.
    2. Each is rated by its epsilon quality with few cone edges.
    3. The best are rated again with round cones, and ordered.

    Args:
        body: mesh file, or anything with `vertices` and `faces` [m].
        fingers: 2 or more.
        mu: friction coefficient.
        gamma: torsional coefficient [m]; if None a hundredth of the body's size for two fingers and 0 for more.
        opening: two fingers: greatest distance between them [m].
        tries: sets of contacts looked at.
        best: how many are returned.
        seed: of the search; the same seed gives the same grasps.
        progress: called with the share of the closing sets that are rated.

    Raises:
        FileError: the mesh cannot be read.
        InputError: fewer than 2 fingers, numbers out of range, two fingers without torsional friction.
    """
    solid = GraspedBody.of(body)
    soft = (0.01 * solid.size if fingers == 2 else 0.0) if gamma is None else gamma
    _require(fingers, mu, soft, opening, tries, best)
    rng = np.random.default_rng(seed)
    sets = _pairs(solid, mu, soft, opening, tries, rng) if fingers == 2 else _sets(solid, fingers, mu, soft, tries, rng)
    if not sets:  # 1
        return GraspPlan((), tries, 0, solid, PlanStatus.NOT_FOUND)
    rated: list[tuple[float, float]] = []
    for k, contacts in enumerate(sets):  # 2
        weight = _rough_quality(contacts, solid, soft) if fingers == 2 else 0.0
        rated.append((_rough_quality(contacts, solid, solid.size), weight))
        if progress is not None:
            progress((k + 1) / len(sets))
    top = [_plan(sets[k], solid) for k in _order(rated)[:best]]  # 3
    order = _order([(p.epsilon, p.weight or 0.0) for p in top])
    status = PlanStatus.FOUND_ON_OPEN_MESH if solid.open_edges else PlanStatus.FOUND
    return GraspPlan(tuple(top[k] for k in order), tries, len(sets), solid, status)


def _order(rated: list[tuple[float, float]]) -> list[int]:
    """Indices, best first: qualities nearly as large as the largest count as equal to it, then the weight decides."""
    equal = (1.0 - EQUAL) * max(epsilon for epsilon, _ in rated)
    return sorted(range(len(rated)), key=lambda k: (min(rated[k][0], equal), rated[k][1], rated[k][0]), reverse=True)


def _require(fingers: int, mu: float, gamma: float, opening: float, tries: int, best: int) -> None:
    for name, value in (("tries", tries), ("best", best), ("opening", opening)):
        if not value > 0:
            raise InputError("input.positive", name=name, value=value)
    whole("tries", tries, 1, 10_000_000)
    whole("best", best, 1)
    if fingers < 2:
        raise InputError("grasp.few_fingers", got=fingers)
    if fingers == 2 and not (gamma > 0 and mu > 0):
        raise InputError("grasp.two_hard_fingers")
    if not (np.isfinite(mu) and mu >= 0):
        raise InputError("grasp.negative_coefficient", name="mu", value=mu)


def _pairs(
    body: GraspedBody, mu: float, gamma: float, opening: float, tries: int, rng: np.random.Generator
) -> list[list[Contact]]:
    """Ends of lines through the body that lie inside both friction cones."""
    points, face = body.sample(tries, rng)
    tangents = rng.normal(size=(tries, 3))
    normals = body.normals[face]
    tangents -= np.einsum("ri,ri->r", tangents, normals)[:, None] * normals
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    tilt = np.arctan(mu) * INSIDE * np.sqrt(rng.uniform(size=tries))[:, None]
    lines = np.cos(tilt) * normals + np.sin(tilt) * tangents
    distance, exit_face = body.opposite(points, lines)
    facing = -np.einsum("ri,ri->r", lines, body.normals[exit_face])
    good = (exit_face >= 0) & (distance <= opening) & (facing > np.cos(INSIDE * np.arctan(mu)))
    return [
        [
            body.contact(points[k], int(face[k]), mu, gamma),
            body.contact(points[k] + distance[k] * lines[k], int(exit_face[k]), mu, gamma),
        ]
        for k in np.flatnonzero(good)
    ]


def _sets(
    body: GraspedBody, fingers: int, mu: float, gamma: float, tries: int, rng: np.random.Generator
) -> list[list[Contact]]:
    """Random sets of contacts that close."""
    candidates = max(4 * fingers, int(np.sqrt(tries) * fingers))
    points, face = body.sample(candidates, rng)
    contacts = [body.contact(p, int(k), mu, gamma) for p, k in zip(points, face, strict=True)]
    wrenches = np.array([c.wrenches(EDGES) for c in contacts])
    chosen = rng.permuted(np.broadcast_to(np.arange(candidates), (tries, candidates)), axis=1)[:, :fingers]
    W = wrenches[chosen].swapaxes(1, 2).reshape(tries, wrenches.shape[1], -1)
    return [[contacts[i] for i in chosen[k]] for k in np.flatnonzero(wrench_closures(W).force_closure)]


def _rough_quality(contacts: list[Contact], body: GraspedBody, length: float) -> float:
    grasp = Grasp(contacts)
    return quality_of_wrenches(grasp.measure(length, body.centre) @ grasp.matrix(EDGES)).epsilon


def _plan(contacts: list[Contact], body: GraspedBody) -> PlannedGrasp:
    grasp = Grasp(contacts)
    epsilon = grasp.quality(body.size, about=body.centre).epsilon
    if len(contacts) > 2:
        return PlannedGrasp(grasp, epsilon, None)
    opening = float(np.linalg.norm(contacts[0].point - contacts[1].point))
    return PlannedGrasp(grasp, epsilon, opening, grasp.quality(contacts[0].gamma, about=body.centre).epsilon)
