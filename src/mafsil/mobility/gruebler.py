"""Mobility by counting: Gruebler's rule in the plane, on the sphere and in space, with every term and its warnings.

What kind of chain a linkage is: serial, tree, one loop, several loops, with branches.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import whole
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.mobility.linkages.linkage import Linkage, on_linkage
from mafsil.mobility.linkages.loop_closure import reduced_screws
from mafsil.mobility.spaces.motion_group import Group, MotionGroup, motion_group

RULES = {"planar": 3, "spherical": 3, "spatial": 6}
"""Freedoms m of a body that nothing holds back."""


class CountStatus(Status):
    """What the count alone says; it takes all constraints as independent."""

    MOVES = ("mobility.count_moves", True)
    NONE_LEFT = ("mobility.count_none", False)
    TOO_MANY = ("mobility.count_negative", False)


@dataclass(frozen=True, eq=False, repr=False)
class GrueblerCount(Answer, data="rule m links joints freedoms constraints loops couplings mobility"):
    """Gruebler's count dof = m (N - 1 - J) + sum f; true if it is positive.

    Attributes:
        rule: planar, spherical or spatial.
        links: N, the ground among them.
        freedoms: f of each of the J joints.
        warnings: sentences: why the count may be wrong here.
        group: what the joints generate together, if their places are known.
        couplings: fixed ratios between joints, each of which takes one freedom.
    """

    rule: str
    links: int
    freedoms: tuple[int, ...]
    warnings: tuple[str, ...] = ()
    group: MotionGroup | None = None
    couplings: int = 0

    @property
    def m(self) -> int:
        """Freedoms of a body on its own."""
        return RULES[self.rule]

    @property
    def joints(self) -> int:
        """J."""
        return len(self.freedoms)

    @property
    def constraints(self) -> tuple[int, ...]:
        """m - f of each joint."""
        return tuple(self.m - f for f in self.freedoms)

    @property
    def loops(self) -> int:
        """L = J - N + 1, of a linkage in one piece."""
        return self.joints - self.links + 1

    @property
    def mobility(self) -> int:
        """The count, negative too."""
        return self.m * (self.links - 1 - self.joints) + sum(self.freedoms) - self.couplings

    @property
    def status(self) -> CountStatus:
        """By the sign of the count."""
        if self.mobility > 0:
            return CountStatus.MOVES
        return CountStatus.NONE_LEFT if self.mobility == 0 else CountStatus.TOO_MANY

    def explain(self, language: str | None = None) -> str:
        """The count with its terms, the same by loops, what it says, and the warnings."""
        details = {
            "m": self.m, "links": self.links, "joints": self.joints, "sum": sum(self.freedoms), "loops": self.loops,
            "mobility": self.mobility, "rule": say(f"mobility.rule_{self.rule}", language=language),
        }  # fmt: skip
        key = "mobility.count_coupled" if self.couplings else "mobility.count"
        lines = [say(key, language=language, couplings=self.couplings, **details), self.status.sentence(language)]
        return "\n".join(
            [*lines, *(say(f"mobility.{key}", language=language, m=self.group_dimension) for key in self.warnings)]
        )

    @property
    def group_dimension(self) -> int:
        """Dimension of the group that the joints generate; m if their places are not known."""
        return self.m if self.group is None else self.group.dimension

    def to_dict(self) -> dict[str, Any]:
        """Plain data with every term."""
        return Answer.to_dict(self) | {
            "warnings": [say(f"mobility.{key}", m=self.group_dimension) for key in self.warnings],
        }


def gruebler_count(links: int, freedoms: Sequence[int], rule: str = "spatial") -> GrueblerCount:
    """Gruebler's count from numbers alone.

    dof = m (N - 1) - sum (m - f) = m (N - 1 - J) + sum f

    Args:
        links: N, the ground among them.
        freedoms: f of each joint; a pin through k links is k - 1 joints.
        rule: planar or spherical (m = 3), spatial (m = 6).

    Raises:
        InputError: an unknown rule, no links, freedoms beyond m.

    Reference: Lynch & Park, Modern Robotics, eq. 2.4.
    """
    m = RULES.get(rule)
    if m is None:
        raise InputError("mobility.unknown_rule", rule=rule, known=", ".join(RULES))
    number = whole("links", links, 1)
    each = tuple(whole(f"freedoms[{k}]", f, 0, m) for k, f in enumerate(freedoms))
    return GrueblerCount(rule, number, each)


@on_linkage
def gruebler(linkage: Linkage, rule: str | None = None) -> GrueblerCount:
    """Gruebler's count of a linkage, with the rule that its joints allow, or with another and a warning.

    Args:
        linkage: as drawn.
        rule: planar, spherical or spatial; what the joints allow if None. All axes parallel to one normal and all
            translations across it: planar. All axes through one point and no translations: spherical.
    """
    linkage.require_all_joints()
    group = motion_group(reduced_screws(linkage))
    right = "planar" if linkage.planar else natural_rule(group)
    chosen = right if rule is None else rule
    if not isinstance(cast("object", chosen), str) or chosen not in RULES:
        raise InputError("mobility.unknown_rule", rule=chosen, known=", ".join(RULES))
    freedoms = tuple(joint.freedoms for joint in linkage.joints)
    if max(freedoms) > RULES[chosen]:
        raise InputError("mobility.too_free", rule=chosen, m=RULES[chosen], most=max(freedoms))
    warnings: list[str] = []
    if chosen != right:
        warnings.append("warn_planar_as_spatial" if RULES[chosen] > RULES[right] else "warn_spatial_as_planar")
    if chosen == "spatial" and right == "spatial" and group.dimension < 6:
        warnings.append("warn_smaller_group")
    return GrueblerCount(
        chosen, len(linkage.bodies), freedoms, tuple(warnings), group, len(linkage.couplings)
    )  # fmt: skip


def natural_rule(group: MotionGroup) -> str:
    """The rule that fits a group of motions: planar and spherical ones are counted with m = 3."""
    if group.kind in (Group.PLANAR, Group.PLANE_TRANSLATION):
        return "planar"
    return "spherical" if group.kind is Group.SPHERICAL else "spatial"


class StructureStatus(Status):
    """Kinds of chains; true for all of them."""

    SERIAL = ("mobility.serial", True)
    TREE = ("mobility.tree", True)
    SINGLE_LOOP = ("mobility.single_loop", True)
    MANY_LOOPS = ("mobility.many_loops", True)
    HYBRID = ("mobility.hybrid", True)


@dataclass(frozen=True, eq=False, repr=False)
class Structure(Answer, data="links joints loops degrees"):
    """Links, joints and loops of a linkage.

    Attributes:
        links: N, with the ground.
        joints: J.
        loops: L = J - N + 1, independent ones.
        degrees: number of joints at each body, in order.
        status: serial; tree (branched, no loop); one loop; several; loops with open branches.
    """

    links: int
    joints: int
    loops: int
    degrees: tuple[int, ...]
    status: StructureStatus


@on_linkage
def structure(linkage: Linkage) -> Structure:
    """The kind of chain: a tree has no loop, a serial chain no body with more than two joints besides."""
    linkage.require_all_joints()
    degrees = np.bincount(linkage.ends.ravel(), minlength=len(linkage.bodies))
    if not linkage.loops:
        serial = int(degrees.max()) <= 2 and degrees[0] == 1
        status = StructureStatus.SERIAL if serial else StructureStatus.TREE
    elif bool((np.abs(linkage.cycles).sum(axis=0) == 0).any()):
        status = StructureStatus.HYBRID
    else:
        status = StructureStatus.SINGLE_LOOP if linkage.loops == 1 else StructureStatus.MANY_LOOPS
    return Structure(len(linkage.bodies), len(linkage.joints), linkage.loops, tuple(int(d) for d in degrees), status)
