"""Everything about the mobility of a linkage in one answer: counted, by rank, finite, and why they differ.

How exact the parts of a linkage must be for a motion that its very numbers do not allow: Bennett's with four digits.

Where a constraint hardly counts, the linkage nearly moves: along the direction of that singular value the loops are
held as close as can be, at steps up to REACH, and the widest gap is the play that the joints need.

Names of the library's mechanisms in the language of the reader; names of others as they were given.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, not_negative
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.messages.catalogue import keys
from mafsil.mobility.actuation import Actuation, ActuationStatus, actuation
from mafsil.mobility.assembly_existence import close_drawing
from mafsil.mobility.finite import FiniteMobility, FiniteStatus, finite_mobility, mobility_around
from mafsil.mobility.four_bar import four_bar_of
from mafsil.mobility.gruebler import GrueblerCount, Structure, gruebler, structure
from mafsil.mobility.instantaneous import IdleFreedom, InstantaneousMobility, instantaneous_mobility
from mafsil.mobility.linkages.linkage import Linkage, on_linkage
from mafsil.mobility.linkages.loop_closure import configuration, largest_gap, loop_equations, loop_state, misfit, units
from mafsil.mobility.linkages.mechanism_linkage import LinkageLike, as_linkage
from mafsil.mobility.redundant_constraints import RedundantConstraints, blocks, redundant_constraints
from mafsil.mobility.tolerances import CLOSED, RANK, ROUNDED
from mafsil.solvers.decompositions import ranks
from mafsil.solvers.local_dimension import NEAR_STEPS
from mafsil.solvers.null_ways import solved_in_planes

NEARLY = 2e-3
"""Singular values up to this share of the largest are tried: a play of a thousandth of the size would free them."""
MOST = 6
"""Directions tried in each block of loops."""


class MobilityStatus(Status):
    """What a linkage can do; true if it moves."""

    MOVES = ("mobility.moves", True)
    MOVES_DEPENDENT = ("mobility.moves_dependent", True)
    BRANCH_POINT = ("mobility.at_branch_point", True)
    SHAKY = ("mobility.at_shaky", True)
    ONLY_INSTANTANEOUS = ("mobility.only_instantaneous", False)
    RIGID = ("mobility.is_rigid", False)
    NO_MOTION_FOUND = ("mobility.no_motion_found", False)
    IN_DOUBT = ("mobility.in_doubt", False)
    MOVES_WITH_PLAY = ("mobility.moves_with_play", True)


@dataclass(frozen=True, eq=False, repr=False)
class Mobility(
    Answer,
    data="mobility structure count instantaneous finite generic redundancy actuation nearly play "
    "name=linkage.name exactness dead_points",
):
    """The mobility of a linkage at a configuration; true if it moves.

    Attributes:
        linkage: drawn at that configuration.
        structure: chain, tree or loops.
        count: Gruebler's.
        instantaneous: by rank, with idle freedoms.
        finite: of real motions.
        around: mobility by rank at a configuration around; None if none was found.
        redundancy: dependent constraints and their causes.
        actuation: of the driven joints.
        play: how exact the parts are [m]: zero, as drawn.
        exactness: further motions, with the play that each needs.
    """

    linkage: Linkage
    structure: Structure
    count: GrueblerCount
    instantaneous: InstantaneousMobility
    finite: FiniteMobility
    around: InstantaneousMobility | None
    redundancy: RedundantConstraints
    actuation: Actuation
    play: float
    exactness: tuple[Exactness, ...]

    @property
    def mobility(self) -> int:
        """Dimension of the set of configurations through this one, as far as it was found; with what the play frees."""
        return self.finite.mobility + self._freed

    @property
    def _freed(self) -> int:
        doubtful = self.finite.at_most - self.finite.mobility if self.play >= self._doubt > 0.0 else 0
        return doubtful + sum(each.length <= self.play for each in self.exactness)

    @property
    def _doubt(self) -> float:
        """The gap that leaves motions in doubt [m]."""
        return self.finite.gap * self.linkage.size if self.finite.status is FiniteStatus.IN_DOUBT else 0.0

    def __bool__(self) -> bool:
        return self.mobility > 0

    @property
    def generic(self) -> int | None:
        """Mobility by rank at configurations around; None if none was found."""
        return None if self.around is None else self.around.mobility

    @property
    def nearly(self) -> int:
        """Number of constraints that count by less than what rounded digits leave: with them this is special."""
        return self.instantaneous.rank - int(ranks(loop_state(self.linkage).matrix, ROUNDED))

    @property
    def dead_points(self) -> tuple[IdleFreedom, ...]:
        """Motions that leave the output body at rest for an instant only: around, it moves with them."""
        if self.around is None:
            return ()
        stays = {(one.joints, one.count) for one in self.around.idle}
        return tuple(one for one in self.instantaneous.idle if (one.joints, one.count) not in stays)

    @property
    def status(self) -> MobilityStatus:
        """By finite mobility, and by the reason why the count differs."""
        if self._freed:
            return MobilityStatus.MOVES_WITH_PLAY
        match self.finite.status:
            case FiniteStatus.IN_DOUBT:
                return MobilityStatus.IN_DOUBT
            case FiniteStatus.RIGID:
                return MobilityStatus.RIGID
            case FiniteStatus.RIGID_SECOND_ORDER:
                return MobilityStatus.ONLY_INSTANTANEOUS
            case FiniteStatus.NOT_FOUND:
                return MobilityStatus.NO_MOTION_FOUND
            case FiniteStatus.BRANCH_POINT:
                return MobilityStatus.BRANCH_POINT
            case FiniteStatus.SHAKY:
                return MobilityStatus.SHAKY
            case _:
                right = self.count.mobility == self.finite.mobility
                return MobilityStatus.MOVES if right else MobilityStatus.MOVES_DEPENDENT

    def verdict(self, language: str | None = None) -> str:
        """What it can do, in one sentence."""
        return self.status.sentence(
            language, name=spoken_name(self.linkage.name, language), mobility=self.mobility,
            counted=self.count.mobility, instantaneous=self.instantaneous.mobility, at_most=self.finite.at_most,
            play=self.play, finite=self.finite.mobility,
        )  # fmt: skip

    def explain(self, language: str | None = None) -> str:
        """Verdict, count with terms and warnings, rank, finite mobility, causes, idle freedoms, actuators."""
        lines = [self.verdict(language), self.structure.explain(language)]
        if (bar := four_bar_of(self.linkage)) is not None:
            lines.append(say(f"mobility.{bar.grashof.value}", language=language))
        lines += self.count.explain(language).split("\n")[:1]
        lines += [
            say(f"mobility.{key}", language=language, m=self.count.group_dimension) for key in self.count.warnings
        ]
        lines += self.instantaneous.explain(language).split("\n")[:2]
        here = self.instantaneous.mobility
        if self.nearly:
            details = {"count": self.nearly, "share": self.instantaneous.kept}
            lines.append(say("mobility.nearly", language=language, **details, mobility=here + self.nearly))
        lines.append(self.finite.explain(language))
        if wanted := [each for each in self.exactness if each.length > self.play]:
            details = {"length": wanted[0].length, "mobility": self.mobility + 1, "joints": ", ".join(wanted[0].joints)}
            lines.append(say("mobility.exactness", language=language, **details))
        if self.generic is not None and self.generic != self.instantaneous.mobility:
            lines.append(
                say("mobility.generic", language=language, generic=self.generic, here=self.instantaneous.mobility)
            )
        if self.redundancy:
            lines += self.redundancy.explain(language).split("\n")
        dead = {one.joints for one in self.dead_points}
        for one in self.instantaneous.idle:
            kind = "dead_point" if one.joints in dead else "idle"
            details = {"count": one.count, "joints": ", ".join(one.joints), "output": self.linkage.output}
            lines.append(say(f"mobility.{kind}", language=language, **details))
        if self.actuation.status is not ActuationStatus.NONE:
            lines.append(self.actuation.explain(language))
        return "\n".join(lines)


def mobility(
    source: LinkageLike, q: ArrayLike | None = None, *, rule: str | None = None, play: float = 0.0, seed: int = 0
) -> Mobility:
    """Mobility of a mechanism by count, by rank at a configuration, and finite, with the reasons where they differ.

    Args:
        source: a Linkage, a Mechanism, a Robot, a library name, a file of a robot or of bodies and joints.
        q: coordinates [rad | m]: of a mechanism those of its tree (n,), of a linkage all (F,); as drawn if None.
        rule: of the count: planar, spherical or spatial; the one that fits if None.
        play: length to which parts are exact, or joints have clearance [m]: a motion of 0.4 rad that opens no loop
            wider counts.
        seed: of the directions in which motions are looked for.

    Raises:
        InputError: a negative play; loops that gape at these coordinates.
    """
    linkage = as_linkage(source, q)
    if linkage.apart:
        linkage = close_drawing(linkage)
    gap = float(largest_gap(linkage))
    if gap > CLOSED:
        raise InputError("mobility.gapes", name=linkage.name or "-", gap=gap)
    return Mobility(
        linkage, structure(linkage), gruebler(linkage, rule), instantaneous_mobility(linkage),
        finite_mobility(linkage, seed=seed), mobility_around(linkage, seed=seed), redundant_constraints(linkage),
        actuation(linkage), not_negative("play", play), exactness(linkage),
    )  # fmt: skip


@on_linkage
def unit_rates(linkage: Linkage, driven: str, theta: ArrayLike | None = None) -> dict[str, float]:
    """Rates of all joints of one freedom for unit rate of one of them, of a linkage of mobility 1.

    Args:
        linkage: as drawn.
        driven: name of the joint that moves with rate 1.
        theta: (F,) configuration [rad | m].

    Raises:
        InputError: the mobility is not 1, or that joint stands still in the motion.
    """
    found = instantaneous_mobility(linkage, theta)
    if found.mobility != 1:
        raise InputError("mobility.not_one", mobility=found.mobility)
    column = int(linkage.columns_of([driven])[0])
    values = found.rates[:, 0] * np.where(np.abs(linkage.screws[:3]).max(axis=0) > 0, 1.0, linkage.size)
    if abs(values[column]) < 1e-9 * np.abs(values).max():
        raise InputError("mobility.stands_still", joint=driven)
    return dict(zip(linkage.coordinate_names, (values / values[column]).tolist(), strict=True))


@on_linkage
def body_rates(linkage: Linkage, driven: str, bodies: Iterable[str], theta: ArrayLike | None = None) -> Floats:
    """(len(bodies),) angular velocities of bodies of a planar linkage for unit rate of one joint, at mobility 1.

    Args:
        linkage: of the plane, as drawn.
        driven: name of the joint that moves with rate 1.
        bodies: names.
        theta: (F,) configuration [rad | m].
    """
    rate = unit_rates(linkage, driven, theta)
    values = np.array([rate[name] for name in linkage.coordinate_names])
    spins = (np.abs(linkage.screws[:3]).max(axis=0) > 0) * np.sign(linkage.screws[2]) * values
    rows = [linkage.paths[linkage.bodies.index(body)][linkage.joint_of] for body in bodies]
    return np.array([float(row @ spins) for row in rows])


@dataclass(frozen=True)
class Exactness:
    """A further motion, and how exact parts must be to have it.

    Attributes:
        joints: names of those that move most in it, up to three.
        length: largest gap of a loop along it, at each of its joints alike [m].
    """

    joints: tuple[str, ...]
    length: float


@on_linkage
def exactness(linkage: Linkage, theta: ArrayLike | None = None) -> tuple[Exactness, ...]:
    """Motions that parts allow which are exact to a length only, the one that needs least play first.

    Args:
        linkage: as drawn.
        theta: (F,) closed configuration [rad | m].
    """
    value = configuration(linkage, theta)
    found = [one for each in blocks(linkage)[0] for one in _of_block(each.linkage, value[each.columns])]
    return tuple(sorted(found, key=lambda one: one.length))


def _of_block(linkage: Linkage, value: Floats) -> list[Exactness]:
    u, equations = value / units(linkage), loop_equations(linkage)
    _, s, Vt = np.linalg.svd(equations(u[None])[1][0])
    share = s / max(float(s.max(initial=0.0)), LEAST_DIVISOR)
    few = [k for k in range(len(s) - 1, -1, -1) if RANK < share[k] <= NEARLY][:MOST]
    lengths = _plays(linkage, u, Vt[few]) if few else []
    return [Exactness(_movers(linkage, Vt[k]), length) for k, length in zip(few, lengths, strict=True)]


def _plays(linkage: Linkage, u: Floats, directions: Floats) -> list[float]:
    """Widest gaps [m] on the ways along directions (k, F), both ways of each; at the first steps they are narrowest."""
    equations, widest = loop_equations(linkage), np.zeros(2 * len(directions))
    both = np.concatenate([directions, -directions])
    here, before = u + NEAR_STEPS[0] * both, float(NEAR_STEPS[0])
    for step in NEAR_STEPS.tolist():
        ahead = u + (here - u) * (step / before)
        here, _ = solved_in_planes(equations, ahead, both[:, None], step, np.inf)
        widest, before = np.maximum(widest, misfit(linkage, here * units(linkage))), step
    widest_of_each: list[float] = widest.reshape(2, -1).max(axis=0).tolist()
    return widest_of_each


def _movers(linkage: Linkage, direction: Floats) -> tuple[str, ...]:
    of_joint = np.array([np.abs(direction[linkage.joint_of == k]).max(initial=0.0) for k in range(len(linkage.joints))])
    most = np.argsort(-of_joint, kind="stable")[:3]
    return tuple(linkage.joints[int(k)].name for k in most)


def spoken_name(name: str, language: str | None = None) -> str:
    """The name of a linkage as sentences and pictures say it; a dash where it has none.

    Args:
        name: as the linkage has it, such as `four-bar` or `chain of 7`.
        language: `en` or `ar`; the current one if None.
    """
    numbers = re.findall(r"(?<![\w-])\d+(?![\w-])", name)
    key = re.sub(r"[^a-z0-9]+", "_", re.sub(r"(?<![\w-])\d+(?![\w-])", "n", name).lower())
    if len(numbers) > 1 or key not in keys("en", "mechanisms"):
        return name or "-"
    return say(f"mechanisms.{key}", language=language, n=numbers[0] if numbers else "")
