"""What is left when joints are locked, and whether chosen motors are too few, too many or the wrong ones."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations
from math import comb

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import whole
from mafsil.errors import InputError
from mafsil.mobility.instantaneous import instantaneous_mobility
from mafsil.mobility.linkages.linkage import Linkage, on_linkage
from mafsil.mobility.linkages.loop_closure import loop_matrix
from mafsil.mobility.tolerances import RANK
from mafsil.solvers.decompositions import ranks

MOST_SUBSETS = 20_000


class ActuationStatus(Status):
    """Whether the driven joints determine all motions; true if the output body obeys them."""

    NONE = ("mobility.actuation_none", False)
    FULL = ("mobility.actuation_full", True)
    IDLE_LEFT = ("mobility.actuation_idle", True)
    REDUNDANT = ("mobility.actuation_redundant", True)
    UNDERACTUATED = ("mobility.actuation_under", False)
    SINGULAR_CHOICE = ("mobility.actuation_singular", False)


@dataclass(frozen=True, eq=False, repr=False)
class Actuation(Answer, data="actuators mobility left output_left antagonistic"):
    """Driven joints against mobility at one configuration.

    Attributes:
        actuators: number of driven coordinates.
        mobility: number of possible motions.
        left: motions that are left when all of them are locked.
        output_left: motions of the output body among them.
    """

    actuators: int
    mobility: int
    left: int
    output_left: int

    @property
    def independent(self) -> int:
        """Number of motions that the actuators determine."""
        return self.mobility - self.left

    @property
    def antagonistic(self) -> int:
        """Actuators beyond that: they must move in step, and can be tensed against each other."""
        return self.actuators - self.independent

    @property
    def status(self) -> ActuationStatus:
        """By what is left and what is too much."""
        if not self.actuators:
            return ActuationStatus.NONE
        if self.output_left:
            enough = self.actuators >= self.mobility
            return ActuationStatus.SINGULAR_CHOICE if enough else ActuationStatus.UNDERACTUATED
        if self.antagonistic:
            return ActuationStatus.REDUNDANT
        return ActuationStatus.IDLE_LEFT if self.left else ActuationStatus.FULL

    def explain(self, language: str | None = None) -> str:
        """The finding in one sentence."""
        return self.status.sentence(
            language, actuators=self.actuators, mobility=self.mobility, left=self.left, output=self.output_left,
            antagonistic=self.antagonistic,
        )  # fmt: skip


@on_linkage
def actuation(linkage: Linkage, theta: ArrayLike | None = None, *, joints: Iterable[str] | None = None) -> Actuation:
    """Whether driven joints determine the motion at a configuration.

    Args:
        linkage: as drawn.
        theta: (F,) [rad | m].
        joints: names of the driven ones; those marked as actuated if None.
    """
    names = [each.name for each in linkage.joints if each.actuated] if joints is None else joints
    names = [linkage.joints[k].name for k in linkage.index_of(names)]
    free, rest = instantaneous_mobility(linkage, theta), instantaneous_mobility(linkage, theta, locked=names)
    return Actuation(len(linkage.columns_of(names)), free.mobility, rest.mobility, rest.output_mobility)


@on_linkage
def locked_mobility(linkage: Linkage, names: Iterable[str], theta: ArrayLike | None = None) -> int:
    """Mobility by rank that is left when joints are locked at a configuration (F,)."""
    return instantaneous_mobility(linkage, theta, locked=names).mobility


@on_linkage
def mobility_with_locked_joints(
    linkage: Linkage, size: int, theta: ArrayLike | None = None
) -> dict[tuple[str, ...], int]:
    """Mobility by rank that is left, for every choice of `size` locked joints.

    Args:
        linkage: as drawn.
        size: number of joints locked together.
        theta: (F,) configuration [rad | m].

    Raises:
        InputError: more than MOST_SUBSETS choices.
    """
    J = len(linkage.joints)
    if comb(J, whole("size", size, 0, J)) > MOST_SUBSETS:
        raise InputError("mobility.many_subsets", count=comb(J, size), limit=MOST_SUBSETS)
    A = loop_matrix(linkage, theta)
    choices = list(combinations(range(J), size))
    names = [tuple(linkage.joints[k].name for k in choice) for choice in choices]
    kept = np.array([~np.isin(linkage.joint_of, choice) for choice in choices]).reshape(len(choices), -1)
    if not len(A):
        left = kept.sum(axis=1)
    else:
        left = kept.sum(axis=1) - ranks(A * kept[:, None, :], RANK)
    return dict(zip(names, left.tolist(), strict=True))
