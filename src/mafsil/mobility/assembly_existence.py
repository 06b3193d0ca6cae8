"""Whether the links of a linkage can meet in all its joints: found, proven impossible by lengths, or not found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mafsil.answer import SingleAnswer, Status
from mafsil.arrays import Floats
from mafsil.errors import ModelError
from mafsil.mobility.assembly import assembly_modes
from mafsil.mobility.closing import least_gap
from mafsil.mobility.linkages.drawing import drawn_at
from mafsil.mobility.linkages.joint_kind import Kind
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.loop_closure import closed_near
from mafsil.mobility.on_linkage import on_linkage
from mafsil.mobility.tolerances import TYPED

SHARED_POINT = (Kind.REVOLUTE, Kind.UNIVERSAL, Kind.SPHERICAL)
"""Kinds whose place is a point of both bodies for all coordinates."""


class ExistenceStatus(Status):
    """Whether the linkage can be put together."""

    EXISTS = ("mobility.exists", True)
    IMPOSSIBLE = ("mobility.exists_not", False)
    NOT_FOUND = ("mobility.exists_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class Existence(SingleAnswer):
    """Whether all loops can be closed at once; true if coordinates that do were found.

    Attributes:
        status: exists; impossible, proven by the lengths of a loop; not found, which proves nothing.
        theta: (F,) coordinates that close all loops [rad | m], or None.
        gap: smallest gap that was met (angle, length over the size).
        loop: joints of the loop that cannot close.
        excess: by how much its longest side is longer than the others together [m]: the distance to feasibility.
        joint: that gapes most where all together gape least, if no way was found, by `distance` [m] and `angle` [rad].
    """

    status: ExistenceStatus
    theta: Floats | None
    gap: float
    loop: tuple[str, ...] = ()
    excess: float = 0.0
    joint: str = ""
    distance: float = 0.0
    angle: float = 0.0

    def explain(self, language: str | None = None) -> str:
        """The finding in one sentence with its number."""
        return self.status.sentence(
            language, gap=self.gap, loop=", ".join(self.loop), excess=self.excess, joint=self.joint,
            distance=self.distance, angle=self.angle,
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "status": self.status.name.lower(), "theta": self.theta, "gap": self.gap, "loop": list(self.loop),
            "excess": self.excess, "joint": self.joint, "distance": self.distance, "angle": self.angle,
        }  # fmt: skip


@on_linkage
def can_assemble(linkage: Linkage, *, starts: int = 256, seed: int = 0) -> Existence:
    """Whether the links of a linkage can meet in all its joints.

    1. Newton's method from the drawing.
    2. A loop of hinges, universal and spherical joints is a polygon of fixed sides: if one is longer than the others
       together, it cannot close: proven.
    3. Newton's method from many random starts.

    Args:
        linkage: drawn apart (`child_at`) or together.
        starts: of the search.
        seed: of the starts.
    """
    near = closed_near(linkage)  # 1
    if near:
        return Existence(ExistenceStatus.EXISTS, near.theta, float(near.gap))
    for loop in range(linkage.loops):  # 2
        sides, names = loop_sides(linkage, loop)
        excess = 2 * max(sides, default=0.0) - sum(sides)
        if excess > TYPED * linkage.size:
            return Existence(ExistenceStatus.IMPOSSIBLE, None, float(near.gap), names, excess)
    found = assembly_modes(linkage, starts=starts, seed=seed)  # 3
    gap = min(found.least_gap, float(near.gap))
    if found:
        best = closed_near(linkage, found.theta[0])
        return Existence(ExistenceStatus.EXISTS, best.theta, float(best.gap))
    joint, distance, angle = least_gap(linkage)
    return Existence(
        ExistenceStatus.NOT_FOUND, None, gap, joint=joint, distance=distance, angle=angle
    )  # fmt: skip


def loop_sides(linkage: Linkage, loop: int) -> tuple[tuple[float, ...], tuple[str, ...]]:
    """Sides [m] of the polygon of an independent loop, and its joints; no sides if a joint has no point of both bodies.

    Args:
        linkage: as drawn.
        loop: its index.
    """
    inside = np.flatnonzero(linkage.cycles[loop])
    names = tuple(linkage.joints[k].name for k in inside)
    if any(linkage.joints[k].kind not in SHARED_POINT for k in inside):
        return (), names
    on_body: dict[str, list[Floats]] = {}
    for k in inside:
        each = linkage.joints[k]
        on_body.setdefault(each.parent, []).append(each.point)
        on_body.setdefault(each.child, []).append(each.point if each.child_point is None else each.child_point)
    return tuple(float(np.linalg.norm(ends[0] - ends[1])) for ends in on_body.values()), names


@on_linkage
def assembled(linkage: Linkage) -> Linkage:
    """A linkage that is drawn apart, drawn where its loops close.

    Raises:
        ModelError: it cannot be put together, or no way was found; the sentence says which, and how far it is from it.
    """
    found = can_assemble(linkage)
    if found.theta is None:
        raise ModelError("mobility.not_assembled", name=linkage.name or "-", reason=_Reason(found))
    return drawn_at(linkage, found.theta)


@dataclass(frozen=True)
class _Reason:
    """The sentence of an answer, in the language in which it is wanted."""

    found: Existence

    def spoken(self, language: str | None = None) -> str:
        return self.found.explain(language)
