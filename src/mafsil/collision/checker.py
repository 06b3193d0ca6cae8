"""Collision checks of an arm in a scene: yes or no in batches, distances with gradients, explanations."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property
from math import prod
from pathlib import Path
from threading import get_ident
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, Truth, as_batch, positive, real_array, single, whole
from mafsil.collision.bodies import Body, bodies_of
from mafsil.collision.joints import Kinship, joints_of, kinship_of
from mafsil.collision.pairs import Reason, SkippedPair, named_pairs, skipped_by_structure, still_shapes
from mafsil.collision.path_check import PathCheck, PathStatus, path_points
from mafsil.collision.scene import Obstacle, Scene, as_obstacles
from mafsil.collision.shapes import MOST_LENGTH, Plane
from mafsil.collision.srdf import disabled_pairs
from mafsil.collision.status import Check, CheckStatus, Clearance, Contact
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.model.loading import RobotLike
from mafsil.robot import as_robot

if TYPE_CHECKING:
    import mafsil.collision.distance_loops as distance_loops
    import mafsil.collision.laid_arm as laid_arm
    import mafsil.collision.layout as layout
    import mafsil.collision.sampled_pairs as sampled_pairs
    import mafsil.collision.segment_loops as segment_loops
    from mafsil.collision.arm_loops import Arm
    from mafsil.collision.laid_arm import LaidArm
    from mafsil.collision.workshop_loops import Workshop, World
    from mafsil.solvers.held_loops import Held
else:
    distance_loops = lazily("mafsil.collision.distance_loops")
    laid_arm = lazily("mafsil.collision.laid_arm")
    layout = lazily("mafsil.collision.layout")
    sampled_pairs = lazily("mafsil.collision.sampled_pairs")
    segment_loops = lazily("mafsil.collision.segment_loops")

MOST_CONTACTS = 200


class Checker:
    """An arm in a scene, laid out for many questions.

    Args:
        robot: a Robot, a Mechanism, a library name or a path.
        scene: a Scene, or its obstacles; empty by default.
        attached: what is fixed to the tip: obstacles whose poses are in the tip frame {t}.
        margin: clearance below which the arm counts as colliding [m].
        own_margin: the same between bodies of the arm, which may be nearer to each other than they are meant to come to
            anything else; `margin` if None [m].
        srdf: path of a semantic description whose `disable_collisions` pairs are not checked.
        skip: further pairs of names (bodies, links) that are not checked.
        self_collision: whether bodies of the arm are checked against each other.
        radius: of capsules along links without a shape [m]; None leaves them out.
        samples: random configurations by which pairs that always meet are found, and those that meet in many and at the
            zero configuration, where no `srdf` says which matter; 0 for none.
        drop_unseen: also leave out pairs that met in none of the samples: quicker, but nothing proves that they
            cannot meet.
        seed: of the samples.

    Attributes:
        robot, scene, margin, own_margin: as given.
        bodies: what collides of the arm; `skipped` says which pairs of them are not checked, and why.

    Raises:
        InputError: no shapes, a mesh file that is missing, numbers out of range.
        FileError: an SRDF or mesh file that cannot be read.
    """

    _own_margin: float | None = None

    def __init__(
        self,
        robot: RobotLike,
        scene: Scene | Iterable[Obstacle] = (),
        *,
        attached: Iterable[Obstacle] = (),
        margin: float = 0.0,
        own_margin: float | None = None,
        srdf: str | Path | None = None,
        skip: Iterable[tuple[str, str]] = (),
        self_collision: bool = True,
        radius: float | None = None,
        samples: int = 1000,
        drop_unseen: bool = False,
        seed: int = 0,
    ) -> None:
        self.robot = as_robot(robot)
        self.scene = scene if isinstance(scene, Scene) else Scene(scene)
        self.margin = _not_negative("margin", margin)
        self._own_margin = None if own_margin is None else _not_negative("own_margin", own_margin)
        self.samples = whole("samples", samples)
        self.seed = whole("seed", seed)
        mechanism = self.robot.mechanism
        fixed = as_obstacles("attached", attached)
        if any(isinstance(each.geometry, Plane) for each in fixed):
            raise InputError("collision.attached_plane")
        self.bodies: tuple[Body, ...] = bodies_of(
            mechanism, fixed, None if radius is None else positive("radius", radius)
        )
        self._joints = joints_of(mechanism)
        self._still = still_shapes(mechanism, self.bodies)
        known = (*dict.fromkeys((*(body.name for body in self.bodies), *mechanism.link_names)),)
        listed = {**({} if srdf is None else disabled_pairs(srdf)), **named_pairs(skip, known)}
        self._skipped = skipped_by_structure(mechanism, self.bodies, listed)
        if self_collision:
            self._sample_pairs(drop_unseen, srdf is None)
        self._self_collision = self_collision
        # By thread, and whether proofs are compiled for it.
        self._workshops: dict[tuple[int, bool], Held[Workshop]] = {}

    def in_collision(self, q: ArrayLike) -> Truth:
        """Whether the arm is within the margin of an obstacle or of itself.

        Args:
            q: (*batch, n) joint coordinates [rad | m].

        Returns:
            (*batch).

        Raises:
            InputError: a wrong shape, NaN or infinities.
        """
        rows, batch = self._rows(q)
        found = np.empty(len(rows), np.bool_)
        segment_loops.collide(self._workshop(), rows, found)
        return found.reshape(batch)

    def free(self, q: ArrayLike) -> Truth:
        """Whether the arm keeps more than the margin; arguments as `in_collision`."""
        return ~self.in_collision(q)

    def distance(self, q: ArrayLike, *, within: float = np.inf) -> Clearance:
        """Smallest distance, its points, bodies and gradient by q.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            within: distances beyond it do not matter and count as infinite: quicker [m].

        Raises:
            InputError: a wrong shape, NaN or infinities; `within` is no length.
        """
        if not (type(within) is float and within >= 0.0):
            within = _not_negative("within", within, most=np.inf)
        rows, batch = self._rows(q)
        out, who = np.zeros((len(rows), 10)), np.zeros((len(rows), 2), np.int64)
        gradient, shop = np.zeros(rows.shape), self._workshop()
        for begin, poses in laid_arm.poses_in_parts(self.robot, rows):
            part = slice(begin, begin + len(poses))
            distance_loops.distances(shop, rows[part], poses, within, out[part], who[part])
            distance_loops.gradients(self.laid.motion, poses, out[part], who[part], gradient[part])
        first, second = self._names(out, who)
        point_first, point_second, normal = (out[:, k : k + 3].reshape(*batch, 3) for k in (1, 4, 7))
        return Clearance(
            rows.reshape(*batch, self.robot.n), self.margin, out[:, 0].reshape(batch), point_first, point_second,
            normal, gradient.reshape(*batch, self.robot.n), first.reshape(batch), second.reshape(batch),
            None if self.own_margin == self.margin else self.free(rows).reshape(batch),
        )  # fmt: skip

    def check(self, q: ArrayLike) -> Check:
        """What the arm meets at one configuration: every pair, by how much and where; else the nearest pair.

        Args:
            q: (n,) joint coordinates [rad | m].

        Raises:
            InputError: a wrong shape, NaN or infinities.
        """
        rows, batch = self._rows(q)
        if batch:
            raise InputError("input.shape", name="q", expected=(self.robot.n,), got=(*batch, self.robot.n), hint="")
        poses = next(laid_arm.poses_in_parts(self.robot, rows))[1]
        out, who = np.zeros((MOST_CONTACTS, 10)), np.zeros((MOST_CONTACTS, 2), np.int64)
        around = self.scene.surroundings
        count = distance_loops.contacts(self.arm, poses[0], around, self.margins(), len(self.scene), out, who)
        if count:
            order = np.argsort(out[:count, 0])
            contacts = tuple(self._contact(out[k], who[k]) for k in order)
            return Check(CheckStatus.COLLIDING, rows[0], self.margin, contacts)
        nearest = self.distance(rows[0])
        if np.isinf(nearest.distance):
            return Check(CheckStatus.ALONE, rows[0], self.margin, ())
        return Check(CheckStatus.FREE, rows[0], self.margin, tuple(nearest))

    def free_segment(self, a: ArrayLike, b: ArrayLike, *, extra: float = 0.0) -> Any:
        """Whether the straight motion of the joints from a to b is proved to keep more than the margin.

        What comes within a micrometre of the margin counts as not free.

        Args:
            a, b: (*batch, n) joint coordinates [rad | m].
            extra: clearance on top of the margin [m].

        Returns:
            (*batch) truth values; a bool for a single motion.

        Raises:
            InputError: a wrong shape, NaN or infinities.
        """
        codes, _, _, batch = self._prove(a, b, _not_negative("extra", extra))
        return bool(codes[0] == 0) if batch == () else (codes == 0).reshape(batch)

    def check_path(self, q_a: ArrayLike, q_b: ArrayLike | None = None) -> PathCheck:
        """Whether a motion along straight lines of the joints is free, proved; else what it meets, and where.

        Args:
            q_a: (n,) the start, or (k, n) all points of a path, k >= 2.
            q_b: (n,) the end, if `q_a` is the start.

        Raises:
            InputError: a wrong shape, NaN or infinities.
        """
        points = path_points(self.robot.n, q_a, q_b)
        codes, t, evaluations, _ = self._prove(points[:-1], points[1:])
        stopped = np.flatnonzero(codes)
        states = int(evaluations.sum())
        if not len(stopped):
            return PathCheck(PathStatus.FREE, points, len(points) - 1.0, points[-1], (), states)
        k = int(stopped[0])
        q = points[k] + t[k] * (points[k + 1] - points[k])
        status = PathStatus.COLLIDING if codes[k] == 1 else PathStatus.TOUCHING
        return PathCheck(status, points, k + float(t[k]), q, self.check(q).contacts, states)

    def _prove(
        self, a: ArrayLike, b: ArrayLike, extra: float = 0.0
    ) -> tuple[NDArray[np.int64], Floats, NDArray[np.int64], tuple[int, ...]]:
        """Codes of `segment_loops`, where they show, states looked at, and the shape of the batch."""
        n = self.robot.n
        A, B = (as_batch(name, x, (n,), finite=True) for name, x in (("a", a), ("b", b)))
        if A.shape != B.shape:
            A, B = np.broadcast_arrays(A, B)
        batch = A.shape[:-1]
        A, B = (np.ascontiguousarray(x).reshape(prod(batch), n) for x in (A, B))
        codes, evaluations = np.zeros((2, len(A)), np.int64)
        t = np.zeros(len(A))
        if not n:
            codes[:] = self.in_collision(A)
            return codes, t, evaluations + 1, batch
        segment_loops.prove_segments(self.workshop(), extra, A, B, codes, t, evaluations)
        return codes, t, evaluations, batch

    def largest_way(self, change: ArrayLike, largest: ArrayLike) -> float:
        """How far any point of the arm can move when the coordinates change [m]; arguments as `largest_ways`."""
        return float(self.largest_ways(change, largest).max(initial=0.0))

    def largest_ways(self, change: ArrayLike, largest: ArrayLike) -> Floats:
        """(b,) how far any point of each body can move when the coordinates change [m]; upper bounds.

        Args:
            change: (n,) largest change of each coordinate [rad | m].
            largest: (n,) largest magnitude of each, for sliding joints [rad | m].
        """
        n, motion = self.robot.n, self.laid.motion
        dq, most = (np.abs(single(name, x, (n,))) for name, x in (("change", change), ("largest", largest)))
        rates = np.abs(motion.joints[:, 2]) * dq[motion.joints[:, 1].astype(np.int64)]
        reach = motion.reach + motion.stretch @ most + motion.joints[:, 4:5]
        lever = np.where(motion.joints[:, 3:4] != 0.0, reach, 1.0)
        return (rates[:, None] * lever * motion.moves).sum(axis=0)

    def world(self) -> World:
        """All that compiled loops ask whether a motion is free, with arrays of this thread alone."""
        return self.workshop().value.world

    def workshop(self) -> Held[Workshop]:
        """The world and the arrays that this thread works in, for compiled loops that are asked again and again."""
        here = get_ident(), True
        shop = self._workshops.get(here)
        if shop is None:
            shop = self._workshops[here] = self._workshop()
            segment_loops.be_able_to_prove(shop)
        return shop

    def _workshop(self) -> Held[Workshop]:
        """As `workshop`; who proves nothing does not wait until proofs are compiled."""
        here = get_ident(), False
        if here not in self._workshops:
            self._workshops[here] = self.laid.workshop(self.scene, self.margins())
            segment_loops.be_able_to_tell(self._workshops[here])
        return self._workshops[here]

    def __getstate__(self) -> dict[str, Any]:
        """What another process can use: all but what lies at an address of this one."""
        return self.__dict__ | {"_workshops": {}}

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
    def only_drawn(self) -> tuple[str, ...]:
        """Links that the description draws without a collision shape, where others have one: they meet nothing."""
        checked = {body.link for body in self.bodies}
        links = self.robot.mechanism.links
        return tuple(link.name for k, link in enumerate(links) if link.visuals and k not in checked)

    @cached_property
    def laid(self) -> LaidArm:
        """The arm as the compiled loops read it, shared by all scenes."""
        pairs = self._pairs() if self._self_collision else []
        return laid_arm.LaidArm(self.robot, self._joints, layout.arm_of(self.bodies, pairs, self._still))

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

    def hits(self, q: ArrayLike) -> Truth:
        """(*batch, obstacles + 1) which obstacles of the scene the arm is within the margin of, and, last, itself.

        Args:
            q: (*batch, n) joint coordinates [rad | m].

        Raises:
            InputError: a wrong shape, NaN or infinities.
        """
        around = self.checking(range(len(self.bodies)), ())
        checkers = [*(around.with_scene([each]) for each in self.scene), self.with_scene(())]
        return np.stack([each.in_collision(q) for each in checkers], axis=-1)

    def _with_arm(self, arm: Arm) -> Self:
        """The same in the same scene with other pairs, or other pieces that the surroundings matter to."""
        other = self.with_scene(self.scene)
        other.__dict__["laid"] = self.laid.with_arm(arm)  # A cached property is an entry of the dictionary.
        for name in ("moves_tip", "kinship", "has_carriers"):
            other.__dict__.pop(name, None)
        return other

    @property
    def own_margin(self) -> float:
        """Clearance between bodies of the arm below which it counts as colliding [m]."""
        return self.margin if self._own_margin is None else self._own_margin

    def with_margin(self, margin: float | None = None, *, own: float | None = None) -> Self:
        """The same arm and scene with another clearance to keep, and between bodies of the arm; None as it is [m]."""
        other = self.with_scene(self.scene)
        if margin is not None:
            other.margin = _not_negative("margin", margin)
        if own is not None:
            other._own_margin = _not_negative("own_margin", own)
        return other

    def margins(self) -> Floats:
        """(1 + pairs,) clearances to keep from the surroundings, and between the bodies of each pair of `arm` [m]."""
        found = np.full(1 + len(self.arm.pairs), self.own_margin)
        found[0] = self.margin
        return found

    def _pairs(self) -> list[tuple[int, int]]:
        count = len(self.bodies)
        return [(a, b) for a in range(count) for b in range(a + 1, count) if (a, b) not in self._skipped]

    def _unchecked(self) -> dict[tuple[int, int], Reason]:
        """All pairs of bodies that are not checked; without self-collision those that could be count as listed."""
        return self._skipped | ({} if self._self_collision else dict.fromkeys(self._pairs(), Reason.LISTED))

    def _sample_pairs(self, drop_unseen: bool, unlisted: bool) -> None:
        """Leave out pairs that meet too often in samples to be meant, and, if asked, those that meet in none."""
        if self.samples and self.robot.n:
            rows = np.concatenate([self.zero[None], self.random_configurations(self.samples)])
            self._skipped |= sampled_pairs.skipped_by_samples(
                self.robot, self.bodies, self._pairs(), rows, drop_unseen=drop_unseen, unlisted=unlisted
            )

    def never_apart(self, first: str, second: str) -> bool:
        """Whether two bodies of the arm are within the margin at nearly all random configurations, by their names."""
        names = [body.name for body in self.bodies]
        if first not in names or second not in names or not self.robot.n:
            return False
        still = [(True,) * len(row) for row in self._still]
        pair = (min(map(names.index, (first, second))), max(map(names.index, (first, second))))
        alone = self._with_arm(layout.arm_of(self.bodies, [pair], still))
        return sampled_pairs.met_always(alone.in_collision(self.random_configurations(max(self.samples, 100))))

    def account(self, language: str | None = None) -> str:
        """What is checked, what is not and why, and whether that leaves free configurations without any scene."""
        return sampled_pairs.explained(self, self._pairs() if self._self_collision else [], language)

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

    def _rows(self, q: ArrayLike) -> tuple[Floats, tuple[int, ...]]:
        array = as_batch("q", q, (self.robot.n,), finite=True)
        # Not -1 rows: an arm without coordinates has as many as the batch.
        return np.ascontiguousarray(array.reshape(prod(array.shape[:-1]), self.robot.n)), array.shape[:-1]

    def _names(self, out: Floats, who: NDArray[np.int64]) -> tuple[NDArray[np.object_], NDArray[np.object_]]:
        bodies = np.array([body.name for body in self.bodies], object)
        second = np.array([*self.scene.names, *bodies[::-1]], object)
        found = np.isfinite(out[:, 0])
        names = np.where(found, bodies[who[:, 0]], ""), np.where(found, second[who[:, 1]], "")
        return names

    def _contact(self, row: Floats, who: NDArray[np.int64]) -> Contact:
        first, second = self._names(row[None], who[None])
        return Contact(str(first[0]), str(second[0]), float(row[0]), row[1:4], row[4:7], row[7:10])


def _not_negative(name: str, value: float, most: float = MOST_LENGTH) -> float:
    number = real_array(name, value)
    if number.ndim or not 0.0 <= number <= most:
        raise InputError("collision.length", name=name, value=value, most=most)
    return float(number)
