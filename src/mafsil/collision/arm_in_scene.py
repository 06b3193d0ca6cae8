"""An arm in a scene, laid out for checks: its bodies, which pairs of them are checked, clearances to keep."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from math import prod
from pathlib import Path
from threading import get_ident
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, Truth, as_batch, positive, real_array, whole
from mafsil.collision.joints import Kinship, joints_of, kinship_of
from mafsil.collision.pairs import (
    Body,
    SkippedPair,
    SkipReason,
    bodies_of,
    mesh_files,
    named_pairs,
    skipped_by_structure,
    still_shapes,
)
from mafsil.collision.scene import Obstacle, Scene, as_obstacles
from mafsil.collision.shapes import MOST_LENGTH, Plane
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.model.loading import RobotLike
from mafsil.regular_file import FileStamps
from mafsil.robot import as_open_tree

if TYPE_CHECKING:
    import mafsil.collision.layout as layout
    import mafsil.collision.sampled_pairs as sampled_pairs
    import mafsil.collision.srdf as srdf_file
    from mafsil.collision.arm_loops import Arm
    from mafsil.collision.layout import LaidArm
    from mafsil.collision.workshop_loops import Workshop, World
    from mafsil.kernels.loops.entry import Held
else:
    layout = lazily("mafsil.collision.layout")
    sampled_pairs = lazily("mafsil.collision.sampled_pairs")
    srdf_file = lazily("mafsil.collision.srdf")


OF_ARM = (
    "bodies", "laid", "kinship", "has_carriers", "moves_tip", "_joints", "_still", "_skipped", "_clearances_of_pairs",
    "_files",
)  # fmt: skip
"""What the robot keeps of an arm: nothing of it depends on scene and clearances."""
MOST_KEPT = 8
"""Arms that a robot keeps: with different radii, tools, pairs that are not checked."""


class ArmInScene:
    """An arm in a scene: its bodies, which pairs of them are checked, clearances to keep. Arguments as `Checker`."""

    _self_clearance: float | None = None
    _key: tuple[Any, ...] = ()
    _files = FileStamps((), (), True)

    def __init__(
        self,
        robot: RobotLike,
        scene: Scene | Iterable[Obstacle] = (),
        *,
        attached: Iterable[Obstacle] = (),
        clearance: float = 0.0,
        self_clearance: float | None = None,
        srdf: str | Path | None = None,
        skip: Iterable[tuple[str, str]] = (),
        self_collision: bool = True,
        radius: float | None = None,
        samples: int = 1000,
        skip_never_colliding: bool = False,
        seed: int = 0,
        known_free: ArrayLike | None = None,
    ) -> None:
        self.robot = as_open_tree(robot)
        self.scene = scene if isinstance(scene, Scene) else Scene(scene)
        self.clearance = not_negative("clearance", clearance)
        self._self_clearance = None if self_clearance is None else not_negative("self_clearance", self_clearance)
        self.samples = whole("samples", samples)
        self.seed = whole("seed", seed)
        self._self_collision, self._workshops = self_collision, dict[int, "Held[Workshop]"]()
        fixed, skip = as_obstacles("attached", attached), tuple(skip)
        if any(isinstance(each.geometry, Plane) for each in fixed):
            raise InputError("collision.attached_plane")
        thick = None if radius is None else positive("radius", radius)
        listed = None if srdf is None else srdf_file.disabled_pairs(srdf)
        rest = None if known_free is None else self._rows(known_free, "known_free")[0]
        of_pairs = self_collision, self.samples, self.seed, skip_never_colliding
        known = None if listed is None else frozenset(listed), None if rest is None else rest.tobytes()
        self._key = (self.robot.mechanism, fixed, thick, repr(skip), *of_pairs, *known)
        if not self._recall():
            self._files = FileStamps.of(mesh_files(self.robot.mechanism, fixed))
            self._choose_pairs(fixed, thick, listed, skip, rest, skip_never_colliding)

    def _choose_pairs(
        self, fixed: tuple[Obstacle, ...], radius: float | None, listed: Mapping[frozenset[str], str] | None,
        skip: tuple[tuple[str, str], ...], rest: Floats | None, skip_never_colliding: bool,
    ) -> None:  # fmt: skip
        """The bodies, and which pairs of them are not checked."""
        mechanism = self.robot.mechanism
        self.bodies: tuple[Body, ...] = bodies_of(mechanism, fixed, radius)
        self._joints = joints_of(mechanism)
        self._still = still_shapes(mechanism, self.bodies)
        known = (*dict.fromkeys((*(body.name for body in self.bodies), *mechanism.link_names)),)
        self._skipped = skipped_by_structure(mechanism, self.bodies, {**(listed or {}), **named_pairs(skip, known)})
        if rest is not None:
            self._skipped |= self._resting_pairs(rest)
        if self._self_collision:
            self._sample_pairs(skip_never_colliding, listed is None)
        self._clearances_of_pairs: dict[float, dict[tuple[int, int], float]] = {}

    def _recall(self) -> bool:
        """Take over what the robot keeps of an arm with the same settings, if its mesh files are as they were."""
        kept = self.robot.derived.get(self._key)
        if kept is None or kept["_files"].has_changed():
            return False
        self.__dict__.update(kept)
        return True

    def _keep(self) -> None:
        """Keep the arm, without scene and clearances, with the robot, for the next one that has the same settings."""
        if self._key and self._files.settled:
            self.robot.derived[self._key] = {name: getattr(self, name) for name in OF_ARM}
            for key in list(self.robot.derived)[:-MOST_KEPT]:
                self.robot.derived.pop(key, None)

    def world(self) -> World:
        """All that compiled loops ask whether a motion is free, with arrays of this thread alone."""
        return self.workshop().value.world

    def workshop(self) -> Held[Workshop]:
        """The world and the arrays that this thread works in, for compiled loops that are asked again and again."""
        here = get_ident()
        shop = self._workshops.get(here)
        if shop is None:
            shop = self._workshops[here] = self.laid.workshop(self.scene, self.clearances())
        return shop

    def __getstate__(self) -> dict[str, Any]:
        """What another process can use: all but what lies at an address of this one."""
        return self.__dict__ | {"_workshops": {}, "_key": ()}

    @property
    def tips(self) -> tuple[str, ...]:
        """Names of the links that carry the tip frame."""
        return (self.robot.mechanism.tip,)

    @cached_property
    def moves_tip(self) -> Truth:
        """(n,) whether a coordinate moves a tip or what closes a loop; those of a gripper do not."""
        mechanism, joints = self.robot.mechanism, self._joints
        tips = [mechanism.link_names.index(name) for name in (*self.tips, *self.ends_of_loops)]
        moves = np.zeros(self.robot.n, np.bool_)
        moves[joints.column[joints.moves[:, tips].any(axis=1)]] = True
        return moves

    @cached_property
    def kinship(self) -> Kinship:
        """Which coordinates belong together; what moves one of several tips, or closes a loop, belongs to all."""
        found = kinship_of(self._joints, self.robot.n, self.moves_tip)
        if len(self.tips) > 1 or self.robot.mechanism.loops:
            found.limb[self.moves_tip] = True
        return found

    @cached_property
    def has_carriers(self) -> bool:
        """Whether some limb carries another one, as a torso carries arms."""
        limb, carries = self.kinship
        return bool((carries & ~limb).any())

    @property
    def ends_of_loops(self) -> tuple[str, ...]:
        """Names of the links that loops join, which have to move as the loops ask."""
        return tuple(name for loop in self.robot.mechanism.loops for name in (loop.parent, loop.child))

    @property
    def skipped(self) -> tuple[SkippedPair, ...]:
        """Pairs of bodies that are not checked against each other, each with its reason."""
        named = self._skipped.items()
        return tuple(SkippedPair(self.bodies[a].name, self.bodies[b].name, reason) for (a, b), reason in named)

    @property
    def unchecked(self) -> tuple[str, ...]:
        """Keys of sentences about what is not looked at: the robot against itself, anything around it."""
        found: list[str] = [] if self._self_collision else ["collision.unchecked_itself"]
        return (*found, "collision.unchecked_around") if not len(self.scene) else tuple(found)

    @property
    def resting(self) -> tuple[SkippedPair, ...]:
        """Those of `skipped` that meet where the robot is known to be free."""
        return tuple(each for each in self.skipped if each.reason is SkipReason.REST)

    @property
    def only_drawn(self) -> tuple[str, ...]:
        """Links that the description draws without a collision shape, where others have one: they meet nothing."""
        checked = {body.link for body in self.bodies}
        links = self.robot.mechanism.links
        return tuple(link.name for k, link in enumerate(links) if link.visuals and k not in checked)

    @cached_property
    def laid(self) -> LaidArm:
        """The arm as the compiled loops read it, shared by all scenes."""
        pairs = self._pairs() if self._self_collision else []
        laid = layout.LaidArm(self.robot, self._joints, layout.arm_of(self.bodies, pairs, self._still))
        self.__dict__["laid"] = laid
        self._keep()
        return laid

    @property
    def arm(self) -> Arm:
        """Bodies and pairs as the compiled loops read them."""
        return self.laid.arm

    def with_scene(self, scene: Scene | Iterable[Obstacle]) -> Self:
        """The same arm in another scene: nothing of the arm is computed again."""
        other = object.__new__(type(self))
        known = {"laid": self.laid, "kinship": self.kinship, "has_carriers": self.has_carriers}
        other.__dict__.update(self.__dict__ | known | {"_workshops": {}})
        other.scene = scene if isinstance(scene, Scene) else Scene(scene)
        return other

    def checking(self, bodies: Sequence[int], pairs: Sequence[int]) -> Self:
        """The same arm and scene, where only some bodies count among the surroundings, and only some pairs of them.

        Args:
            bodies: indices into `bodies`.
            pairs: indices of the pairs that are checked, rows of `arm.pairs`.
        """
        table, others = self.arm.bodies.copy(), np.setdiff1d(np.arange(len(self.bodies)), bodies)
        table[others, 3] = table[others, 1]
        return self._with_arm(self.arm._replace(bodies=table, pairs=self.arm.pairs[np.asarray(pairs, np.int64)]))

    def _with_arm(self, arm: Arm) -> Self:
        """The same in the same scene with other pairs, or other pieces that the surroundings matter to."""
        other = self.with_scene(self.scene)
        other.__dict__["laid"] = self.laid.with_arm(arm)  # A cached property is an entry of the dictionary.
        for name in ("moves_tip", "kinship", "has_carriers"):
            other.__dict__.pop(name, None)
        return other

    @property
    def self_clearance(self) -> float:
        """Clearance between bodies of the arm below which it counts as colliding [m]."""
        return self.clearance if self._self_clearance is None else self._self_clearance

    def with_clearance(self, clearance: float | None = None, *, own: float | None = None) -> Self:
        """The same arm and scene with another clearance to keep, and between bodies of the arm; None as it is [m]."""
        other = self.with_scene(self.scene)
        if clearance is not None:
            other.clearance = not_negative("clearance", clearance)
        if own is not None:
            other._self_clearance = not_negative("self_clearance", own)
        return other

    def clearances(self) -> Floats:
        """(1 + pairs,) clearances to keep from the surroundings, and between the bodies of each pair of `arm` [m].

        Bodies of the arm that are always near keep less than the clearance, unless an own one was asked for.
        """
        found = np.full(1 + len(self.arm.pairs), self.self_clearance)
        found[0] = self.clearance
        if less := self._kept_less():
            pairs: list[list[int]] = self.arm.pairs.tolist()
            found[1:] = [less.get((a, b), self.self_clearance) for a, b in pairs]
        return found

    @property
    def keeps_one_clearance(self) -> bool:
        """Whether every pair keeps the clearance, so that the nearest one decides."""
        return self.self_clearance == self.clearance and not self._kept_less()

    @property
    def always_near(self) -> dict[tuple[str, str], float]:
        """Pairs of bodies that keep less than the clearance, as they are always near; what each keeps [m]."""
        return self._named(self._kept_less())

    def nearer_than(self, distance: float) -> dict[tuple[str, str], float]:
        """Pairs of bodies of the arm that often come nearer than a distance; what they seldom come below [m]."""
        return self._named(self._near(distance))

    def _named(self, pairs: dict[tuple[int, int], float]) -> dict[tuple[str, str], float]:
        return {(self.bodies[a].name, self.bodies[b].name): kept for (a, b), kept in pairs.items()}

    def _kept_less(self) -> dict[tuple[int, int], float]:
        """Pairs that keep less than the clearance, by indices of bodies; none where an own one was asked for."""
        return {} if self._self_clearance is not None else self._near(self.clearance)

    def _near(self, distance: float) -> dict[tuple[int, int], float]:
        known = self._clearances_of_pairs
        if not (distance and self._self_collision and self.samples and self.robot.n):
            return {}
        if distance not in known:
            pairs, rows = self._pairs(), self.random_configurations(self.samples)
            kept = sampled_pairs.kept_by_pairs(self.robot, self.bodies, pairs, rows, distance).tolist()
            known[distance] = {pair: m for pair, m in zip(pairs, kept, strict=True) if m < distance}
        return known[distance]

    def _pairs(self) -> list[tuple[int, int]]:
        count = len(self.bodies)
        return [(a, b) for a in range(count) for b in range(a + 1, count) if (a, b) not in self._skipped]

    def _unchecked(self) -> dict[tuple[int, int], SkipReason]:
        """All pairs of bodies that are not checked; without self-collision those that could be count as listed."""
        return self._skipped | ({} if self._self_collision else dict.fromkeys(self._pairs(), SkipReason.LISTED))

    def _resting_pairs(self, rows: Floats) -> dict[tuple[int, int], SkipReason]:
        """Pairs that meet where the robot is known to be free: their shapes are thicker than it."""
        pairs = self._pairs()
        met = sampled_pairs.meetings(self.robot, self.bodies, pairs, rows)
        return {pair: SkipReason.REST for pair, count in zip(pairs, met.tolist(), strict=True) if count}

    def _sample_pairs(self, skip_never_colliding: bool, unlisted: bool) -> None:
        """Leave out pairs that meet too often in samples to be meant, and, if asked, those that meet in none."""
        if self.samples and self.robot.n:
            rows = np.concatenate([self.zero[None], self.random_configurations(self.samples)])
            self._skipped |= sampled_pairs.skipped_by_samples(
                self.robot,
                self.bodies,
                self._pairs(),
                rows,
                skip_never_colliding=skip_never_colliding,
                unlisted=unlisted,
            )

    @property
    def zero(self) -> JointVector:
        """(n,) the zero configuration, as near as the limits allow."""
        limits = self.robot.limits
        return np.minimum(np.maximum(np.zeros(self.robot.n), limits.lower), limits.upper)

    def random_configurations(self, count: int) -> Floats:
        """(count, n) configurations, uniform between the limits; half a turn or a metre where there are none."""
        limits, coordinates = self.robot.mechanism.limits, self.robot.mechanism.coordinates
        turns = np.array([np.pi if each.screw[:3].any() else 1.0 for each in coordinates])
        lower = np.where(np.isfinite(limits.lower), limits.lower, -turns)
        upper = np.where(np.isfinite(limits.upper), limits.upper, turns)
        return np.random.default_rng(self.seed).uniform(np.minimum(lower, upper), upper, (count, self.robot.n))

    def _rows(self, q: ArrayLike, name: str = "q") -> tuple[Floats, tuple[int, ...]]:
        array = as_batch(name, q, (self.robot.n,), finite=True)
        # Not -1 rows: an arm without coordinates has as many as the batch.
        return np.ascontiguousarray(array.reshape(prod(array.shape[:-1]), self.robot.n)), array.shape[:-1]


def not_negative(name: str, value: float, most: float = MOST_LENGTH) -> float:
    """The number itself, if it is a length from zero on.

    Raises:
        InputError: it is none.
    """
    if type(value) is float and 0.0 <= value <= most:
        return value
    number = real_array(name, value)
    if number.ndim or not 0.0 <= number <= most:
        raise InputError("collision.length", name=name, value=value, most=most)
    return float(number)
