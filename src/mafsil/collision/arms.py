"""Checkers of more coordinates: several arms in one scene, and an arm whose base may stand anywhere."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, Truth, as_batch, not_negative
from mafsil.collision.checker import Checker
from mafsil.collision.joints import joints_of
from mafsil.collision.pairs import Body, SkipReason
from mafsil.collision.scene import Obstacle, Scene, as_pose
from mafsil.errors import InputError
from mafsil.fields import check_fields, or_none
from mafsil.lazy_module import lazily
from mafsil.model.loading import RobotLike
from mafsil.model.mounting import PLACES, mounted_together, on_movable_base
from mafsil.robot import Robot, as_open_tree

if TYPE_CHECKING:
    import mafsil.collision.layout as layout
    from mafsil.collision.arm_loops import Arm
else:
    layout = lazily("mafsil.collision.layout")


@dataclass(frozen=True, eq=False, slots=True)
class ArmMount:
    """An arm and its base pose.

    Attributes:
        name: how answers call it; its bodies are "name/link".
        robot: a Robot, a Mechanism, a library name or a path.
        T_sb: (4, 4) pose of its base in {s}, or a position (3,); None for that of the robot itself.
        attached, srdf, skip, radius, self_collision: as for `Checker`.
    """

    name: str
    robot: RobotLike
    T_sb: ArrayLike | None = None
    attached: Iterable[Obstacle] = ()
    srdf: str | Path | None = None
    skip: Iterable[tuple[str, str]] = ()
    radius: float | None = None
    self_collision: bool = True
    __post_init__ = check_fields(T_sb=or_none(as_pose), radius=or_none(not_negative))


class MultiArmCell(Checker):
    """Several arms in a scene: a `Checker` of the coordinates of all arms, one after the other.

    Every body of one arm is checked against every body of the others: no such pair is ever left out.

    Args:
        arms: each with its base pose.
        scene: a Scene, or its obstacles, around all of them.
        clearance: clearance below which anything counts as colliding [m].
        self_clearance: the same between bodies of one arm, as for `Checker` [m].
        samples, seed: as for `Checker`, for the pairs within each arm.

    Attributes:
        names: of the arms.
        robots: of each arm alone, at its base pose.
        columns: for each name the slice of its coordinates.

    Raises:
        InputError: no arm, a name used twice, or what `Checker` refuses.
    """

    def __init__(
        self,
        arms: Iterable[ArmMount],
        scene: Scene | Iterable[Obstacle] = (),
        *,
        clearance: float = 0.0,
        self_clearance: float | None = None,
        samples: int = 1000,
        seed: int = 0,
    ) -> None:
        given = tuple(arms)
        self.names: tuple[str, ...] = tuple(each.name for each in given)
        if not given or len(set(self.names)) < len(given):
            raise InputError("collision.arm_names", names=", ".join(self.names) or "-")
        scene = scene if isinstance(scene, Scene) else Scene(scene)
        self._alone = {each.name: _alone(each, scene, (clearance, self_clearance), samples, seed) for each in given}
        self.robots: dict[str, Robot] = {name: checker.robot for name, checker in self._alone.items()}
        mechanisms = [(name, robot.mechanism, robot.mechanism.T_sb) for name, robot in self.robots.items()]
        self.robot = as_open_tree(mounted_together(mechanisms))
        self.scene, self.samples, self.seed = scene, samples, seed
        one = self._alone[self.names[0]]
        self.clearance, self._self_clearance = one.clearance, one._self_clearance
        self.columns: dict[str, slice] = {}
        bodies, still, links, n = list[Body](), list[tuple[bool, ...]](), 1, 0
        self._skipped: dict[tuple[int, int], SkipReason] = {}
        for name, checker in self._alone.items():
            first = len(bodies)
            bodies += [replace(body, name=f"{name}/{body.name}", link=body.link + links) for body in checker.bodies]
            still += checker._still
            self._skipped |= {(first + a, first + b): why for (a, b), why in checker._unchecked().items()}
            self.columns[name] = slice(n, n + checker.robot.n)
            links += len(checker.robot.mechanism.links)
            n += checker.robot.n
        self.bodies, self._still = tuple(bodies), tuple(still)
        self._moving, self._passive = self.names, frozenset[str]()
        self._joints, self._self_collision = joints_of(self.robot.mechanism), True
        self._workshops = {}

    def _near(self, distance: float) -> dict[tuple[int, int], float]:
        found, first = dict[tuple[int, int], float](), 0
        for checker in self._alone.values():
            found |= {(first + a, first + b): kept for (a, b), kept in checker._near(distance).items()}
            first += len(checker.bodies)
        return found

    @property
    def tips(self) -> tuple[str, ...]:
        """Names of the links that carry the tips of the arms."""
        return tuple(f"{name}/{self.robots[name].mechanism.tip}" for name in self._moving)

    @property
    def ends_of_loops(self) -> tuple[str, ...]:
        """Names of the links that loops of the arms that are planned join."""
        return tuple(link for link in super().ends_of_loops if self.arm_of(link) in self._moving)

    def alone(self, name: str) -> Checker:
        """One of the arms in the scene, without the others.

        Raises:
            InputError: there is none of that name.
        """
        self._require(name)
        return self._alone[name].with_scene(self.scene).with_clearance(self.clearance, own=self._self_clearance)

    def among(self, names: Iterable[str], moving: Iterable[str] | None = None) -> Self:
        """The same coordinates with some of the arms only: what the others meet does not count.

        Args:
            names: of the arms that count.
            moving: of those whose tips matter to a planner, so that all their joints may move; all that count if None.

        Raises:
            InputError: an unknown name.
        """
        kept = tuple(names)
        planned = kept if moving is None else tuple(moving)
        for name in (*kept, *planned):
            self._require(name)
        owner, checked = self._owners(), set(kept) - self._passive
        still = [row if name in checked else (True,) * len(row) for name, row in zip(owner, self._still, strict=True)]
        other = self._with_arm(layout.arm_of(self.bodies, self._pairs_of(kept), still))
        other._moving = planned
        return other

    def met_by_each_other(self, names: Iterable[str]) -> Self:
        """The same coordinates with some of the arms only, of which each meets the others, but not itself or the scene.

        Raises:
            InputError: an unknown name.
        """
        kept = tuple(names)
        for name in kept:
            self._require(name)
        owner, still = self._owners(), [(True,) * len(row) for row in self._still]
        pairs = [(a, b) for a, b in self._pairs_of(kept) if owner[a] != owner[b]]
        return self._with_arm(layout.arm_of(self.bodies, pairs, still))

    def _owners(self) -> list[str]:
        """The arm of each body."""
        return [self.arm_of(body.name) for body in self.bodies]

    def _pairs_of(self, names: Iterable[str]) -> list[tuple[int, int]]:
        """Pairs of bodies of some arms, but for those of arms that are only met by the others."""
        owner, kept = self._owners(), set(names)
        owners = [(a, b, {owner[a], owner[b]}) for a, b in self._pairs()]
        return [(a, b) for a, b, both in owners if both <= kept and not both <= self._passive]

    def with_passive(self, names: Iterable[str]) -> Self:
        """The same arms, of which some are only met by the others: not checked against the scene and among themselves.

        Raises:
            InputError: an unknown name.
        """
        passive = frozenset(names)
        for name in passive:
            self._require(name)
        other = self.with_scene(self.scene)
        other._passive = passive
        return other.among(self.names)

    def join(self, q: Mapping[str, ArrayLike]) -> JointVector:
        """(*batch, n) coordinates of all arms, from those of each.

        Args:
            q: for each name (*batch, n of that arm); the batches broadcast.

        Raises:
            InputError: an arm without coordinates, an unknown name, a wrong shape.
        """
        for name in (*q, *self.names):
            self._require(name)
            if name not in q:
                raise InputError("collision.no_coordinates_of", name=name)
        parts = [as_batch(name, q[name], (self.robots[name].n,), finite=True) for name in self.names]
        batch = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
        return np.concatenate([np.broadcast_to(part, (*batch, part.shape[-1])) for part in parts], axis=-1)

    def split(self, q: ArrayLike) -> dict[str, JointVector]:
        """Coordinates of each arm (*batch, n of that arm), from those of all (*batch, n)."""
        rows = as_batch("q", q, (self.robot.n,))
        return {name: np.asarray(rows[..., columns]) for name, columns in self.columns.items()}

    def arm_of(self, body: str) -> str:
        """The arm that a body of an answer belongs to; empty for an obstacle."""
        return next((name for name in self.names if body.startswith(f"{name}/")), "")

    def clearances(self) -> Floats:
        """Bodies of different arms keep what they keep from everything else."""
        clearances, owner = super().clearances(), self._owners()
        pairs: list[list[int]] = self.arm.pairs.tolist()
        different = [owner[a] != owner[b] for a, b in pairs]
        clearances[1:][different] = self.clearance
        return clearances

    @cached_property
    def between(self) -> Arm:
        """The bodies with pairs of different arms only, as the compiled loops read them."""
        owner = [self.arm_of(body.name) for body in self.bodies]
        return layout.arm_of(self.bodies, [(a, b) for a, b in self._pairs() if owner[a] != owner[b]], self._still)

    def _require(self, name: str) -> None:
        if name not in self.robots:
            raise InputError("collision.no_arm", name=name, known=", ".join(self.names))


def _alone(arm: ArmMount, scene: Scene, clearances: tuple[float, float | None], samples: int, seed: int) -> Checker:
    """The checker of one arm at its base pose."""
    mechanism = as_open_tree(arm.robot).mechanism
    if arm.T_sb is not None:
        mechanism = replace(mechanism, T_sb=np.asarray(arm.T_sb))
    return Checker(
        mechanism, scene, attached=arm.attached, clearance=clearances[0], self_clearance=clearances[1], srdf=arm.srdf,
        skip=arm.skip, self_collision=arm.self_collision, radius=arm.radius, samples=samples, seed=seed,
    )  # fmt: skip


class MovableArm(Checker):
    """The checker of an arm with coordinates (x, y, z, yaw, q): answers are those of the arm with its base there.

    What no joint of the arm moves, such as its base, is not checked against the scene here, as with any arm;
    `base_is_free` does that.

    Args:
        arm: the checker of the arm, with all its settings.
        scene: what stands around, in {s}.
    """

    def __init__(self, arm: Checker, scene: Scene) -> None:
        self.scene, self.clearance, self.samples, self.seed = scene, arm.clearance, arm.samples, arm.seed
        self._self_clearance = arm._self_clearance
        self.robot = as_open_tree(on_movable_base(arm.robot.mechanism))
        self.bodies = tuple(replace(body, link=body.link + len(PLACES)) for body in arm.bodies)
        self._still, self._skipped, self._self_collision = arm._still, arm._unchecked(), True
        self._joints = joints_of(self.robot.mechanism)
        self._workshops, self._arm = {}, arm

    def _near(self, distance: float) -> dict[tuple[int, int], float]:
        return self._arm._near(distance)

    @cached_property
    def _base(self) -> Checker:
        still = [tuple(not each for each in row) for row in self._still]
        return self._with_arm(layout.arm_of(self.bodies, [], still))

    def base_is_free(self, bases: ArrayLike, stands_on: Iterable[str] = ()) -> Truth:
        """Whether what no joint moves keeps more than the clearance.

        Args:
            bases: (*batch, 4) x, y, z [m], yaw [rad] of the base.
            stands_on: names of obstacles that it may touch.

        Raises:
            InputError: a wrong shape, or no such obstacle.
        """
        rows = as_batch("bases", bases, (len(PLACES),), finite=True)
        allowed = tuple(stands_on)
        for name in allowed:
            self.scene.index(name)
        around = Scene(each for each in self.scene if each.name not in allowed)
        return self._base.with_scene(around).free(self.join(rows, np.zeros(self.robot.n - len(PLACES))))

    def join(self, bases: ArrayLike, q: ArrayLike) -> JointVector:
        """(*batch, 4 + n) coordinates of bases (*batch, 4) and of the arm (*batch, n); the batches broadcast."""
        a, b = np.asarray(bases, dtype=np.float64), np.asarray(q, dtype=np.float64)
        batch = np.broadcast_shapes(a.shape[:-1], b.shape[:-1])
        parts = [np.broadcast_to(part, (*batch, part.shape[-1])) for part in (a, b)]
        return np.concatenate(parts, axis=-1)
