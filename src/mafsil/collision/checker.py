"""Collision checks of an arm in a scene: yes or no in batches, distances with gradients, explanations.

Whether a motion along straight lines of the joints is free, as an answer.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from math import prod
from threading import get_ident
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil import threads
from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, Truth, as_batch, single
from mafsil.collision import segment_loops
from mafsil.collision.arm_in_scene import ArmInScene, not_negative
from mafsil.collision.status import CheckStatus, Clearance, CollisionCheck, ContactPair, unchecked_as_data
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.messages import clauses, say

if TYPE_CHECKING:
    import mafsil.collision.distance_loops as distance_loops
    import mafsil.collision.layout as layout
    import mafsil.collision.sampled_pairs as sampled_pairs
else:
    distance_loops = lazily("mafsil.collision.distance_loops")
    layout = lazily("mafsil.collision.layout")
    sampled_pairs = lazily("mafsil.collision.sampled_pairs")


MOST_CONTACTS = 200
FLOAT64 = np.dtype(np.float64)
VERDICTS: tuple[Any, Any] = (np.False_, np.True_)
ROWS_OF_THREAD = 1024
"""States that a thread checks before it takes others: a fraction of a millisecond."""


class Checker(ArmInScene):
    """The collision checker of an arm in a scene, prepared for many queries.

    Args:
        robot: a Robot, a Mechanism, a library name or a path.
        scene: a Scene, or its obstacles; empty by default.
        attached: what is fixed to the tip: obstacles whose poses are in the tip frame {t}.
        clearance: distance below which the arm counts as colliding [m].
        self_clearance: the same between bodies of the arm, which may be nearer to each other than to anything else [m].
            If None `clearance`, but less where two bodies are always near; `always_near` names them.
        srdf: path of a semantic description whose `disable_collisions` pairs are not checked.
        skip: further pairs of names (bodies, links) that are not checked.
        self_collision: whether bodies of the arm are checked against each other.
        radius: of capsules along links without a shape, and in place of those that robots of the library have [m]; None
            leaves them out.
        samples: random configurations by which pairs that always meet are found, and those that meet in many and at the
            zero configuration, where no `srdf` says which matter; 0 for none.
        skip_never_colliding: also leave out pairs that met in none of the samples: faster, without a proof that they
            cannot meet.
        seed: of the samples.
        rest: a configuration at which the robot is known to be free of itself, or several: bodies that meet there
            have shapes thicker than the robot, and are not checked against each other (n,) or (k, n) [rad | m].

    Attributes:
        robot, scene, clearance, self_clearance: as given.
        bodies: what collides of the arm; `skipped` says which pairs of them are not checked, and why.

    Raises:
        InputError: no shapes, a mesh file that is missing, numbers out of range.
        FileError: an SRDF or mesh file that cannot be read.
    """

    def in_collision(self, q: ArrayLike) -> Truth:
        """Whether the arm is within the clearance of an obstacle or of itself.

        Args:
            q: (*batch, n) joint coordinates [rad | m].

        Returns:
            (*batch).

        Raises:
            InputError: a wrong shape, NaN or infinities.
        """
        code = self._collides_at(q)
        if code >= 0:
            return VERDICTS[code]
        rows, batch = self._rows(q)
        found = np.empty(len(rows), np.bool_)
        self.workshop()  # What all threads share is laid out by one.

        def part(k: int) -> None:
            here = slice(k * ROWS_OF_THREAD, (k + 1) * ROWS_OF_THREAD)
            segment_loops.collide(self.workshop(), rows[here], found[here])

        threads.run(part, -(-len(rows) // ROWS_OF_THREAD), threads.available() if len(rows) > ROWS_OF_THREAD else 1)
        return found.reshape(batch)

    def free(self, q: ArrayLike) -> Truth:
        """Whether the arm keeps more than the clearance; arguments as `in_collision`."""
        code = self._collides_at(q)
        return VERDICTS[1 - code] if code >= 0 else ~self.in_collision(q)

    def _collides_at(self, q: ArrayLike) -> int:
        """Whether one configuration in an array of its own collides, 0 or 1; -1 for all else, which is looked at."""
        if type(q) is np.ndarray and q.dtype is FLOAT64 and q.shape == (self.robot.mechanism.n,):
            return segment_loops.collides_at(self._workshops.get(get_ident()) or self.workshop(), q)
        return -1

    def distance(self, q: ArrayLike, *, within: float = np.inf) -> Clearance:
        """Smallest distance, its points, bodies and gradient by q.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
            within: distances beyond it do not matter and count as infinite: quicker [m].

        Raises:
            InputError: a wrong shape, NaN or infinities; `within` is no length.
        """
        if not (type(within) is float and within >= 0.0):
            within = not_negative("within", within, most=np.inf)
        rows, batch = self._rows(q)
        out, who = np.zeros((len(rows), 10)), np.zeros((len(rows), 2), np.int64)
        gradient, motion = np.zeros(rows.shape), self.laid.motion
        self.workshop()  # What all threads share is laid out by one.

        def part(k: int) -> None:
            here = slice(k * layout.CHUNK, (k + 1) * layout.CHUNK)
            poses = self.robot.link_poses(rows[here])
            distance_loops.distances(self.workshop(), rows[here], poses, within, out[here], who[here])
            distance_loops.gradients(motion, poses, out[here], who[here], gradient[here])

        threads.run(part, -(-len(rows) // layout.CHUNK), threads.available() if len(rows) > layout.CHUNK else 1)
        first, second = self._names(out, who)
        point_first, point_second, normal = (out[:, k : k + 3].reshape(*batch, 3) for k in (1, 4, 7))
        return Clearance(
            rows.reshape(*batch, self.robot.n), self.clearance, out[:, 0].reshape(batch), point_first, point_second,
            normal, gradient.reshape(*batch, self.robot.n), first.reshape(batch), second.reshape(batch),
            None if self.keeps_one_clearance else self.free(rows).reshape(batch),
        )  # fmt: skip

    def check(self, q: ArrayLike) -> CollisionCheck:
        """What the arm meets at one configuration: every pair, by how much and where; else the nearest pair.

        Args:
            q: (n,) joint coordinates [rad | m].

        Raises:
            InputError: a wrong shape, NaN or infinities.
        """
        rows, batch = self._rows(q)
        if batch:
            raise InputError("input.shape", name="q", expected=(self.robot.n,), got=(*batch, self.robot.n), hint="")
        poses = next(layout.poses_in_parts(self.robot, rows))[1]
        out, who = np.zeros((MOST_CONTACTS, 10)), np.zeros((MOST_CONTACTS, 2), np.int64)
        around = self.scene.surroundings
        count = distance_loops.contacts(self.arm, poses[0], around, self.clearances(), len(self.scene), out, who)
        if count:
            order = np.argsort(out[:count, 0])
            contacts = tuple(self._contact(out[k], who[k]) for k in order)
            return CollisionCheck(CheckStatus.COLLIDING, rows[0], self.clearance, contacts)
        nearest = self.distance(rows[0])
        if np.isinf(nearest.distance):
            return CollisionCheck(CheckStatus.ALONE, rows[0], self.clearance, (), self.unchecked)
        return CollisionCheck(CheckStatus.FREE, rows[0], self.clearance, tuple(nearest), self.unchecked)

    def free_segment(self, a: ArrayLike, b: ArrayLike, *, extra: float = 0.0) -> Any:
        """Whether the straight motion of the joints from a to b is proved to keep more than the clearance.

        What comes within a micrometre of the clearance counts as not free.

        Args:
            a, b: (*batch, n) joint coordinates [rad | m].
            extra: clearance on top of the clearance [m].

        Returns:
            (*batch) truth values; a bool for a single motion.

        Raises:
            InputError: a wrong shape, NaN or infinities.
        """
        codes, _, _, batch = self._prove(a, b, not_negative("extra", extra))
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
            return PathCheck(PathStatus.FREE, points, len(points) - 1.0, points[-1], (), states, self.unchecked)
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

    def hits(self, q: ArrayLike) -> Truth:
        """(*batch, obstacles + 1) which obstacles of the scene the arm is within the clearance of, and, last, itself.

        Args:
            q: (*batch, n) joint coordinates [rad | m].

        Raises:
            InputError: a wrong shape, NaN or infinities.
        """
        around = self.checking(range(len(self.bodies)), ())
        checkers = [*(around.with_scene([each]) for each in self.scene), self.with_scene(())]
        return np.stack([each.in_collision(q) for each in checkers], axis=-1)

    def never_apart(self, first: str, second: str) -> bool:
        """Whether two bodies of the arm are within clearance at nearly all random configurations, by their names."""
        names = [body.name for body in self.bodies]
        if first not in names or second not in names or not self.robot.n:
            return False
        still = [(True,) * len(row) for row in self._still]
        pair = (min(map(names.index, (first, second))), max(map(names.index, (first, second))))
        alone = self._with_arm(layout.arm_of(self.bodies, [pair], still))
        return sampled_pairs.met_always(alone.in_collision(self.random_configurations(max(self.samples, 100))))

    def account(self, language: str | None = None) -> str:
        """What is checked, what is not and why, and whether that leaves free configurations without any scene."""
        pairs = self._pairs() if self._self_collision else []
        lines = [say("collision.checked", language=language, bodies=len(self.bodies), pairs=len(pairs))]
        lines += [*sampled_pairs.explain_skipped(self.skipped, language), *self._less_kept(language)]
        lines += [say(key, language=language) for key in self.unchecked]
        if pairs and self.samples and self.robot.n:
            lines += self._free_of_itself(language)
        return "\n".join(lines)

    def _less_kept(self, language: str | None) -> list[str]:
        """Which bodies keep less than the clearance of each other."""
        near = [f"{a} - {b} ({1e3 * kept:.3g} mm)" for (a, b), kept in self.always_near.items()]
        if not near:
            return []
        details = {"millimetres": 1e3 * self.clearance, "names": ", ".join(near)}
        return [say("collision.always_near", language=language, **details)]

    def _free_of_itself(self, language: str | None) -> list[str]:
        """How many random configurations are free of self-collision; which bodies meet at zero, and where none is."""
        alone = self.with_scene(())
        rows = alone.random_configurations(self.samples)
        free = int(alone.free(rows).sum())
        lines = [say("collision.free_of_itself", language=language, free=free, samples=self.samples)]
        if not alone.free(self.zero):
            met = alone.check(self.zero).contacts[: sampled_pairs.MOST_NAMED]
            meets = clauses((contact.sentence(language) for contact in met), language)
            lines.append(say("collision.zero_meets", language=language, contacts=meets))
        if not free:
            near = alone.distance(rows)
            most = Counter(zip(near.first.tolist(), near.second.tolist(), strict=True)).most_common(3)
            names = ", ".join(f"{first} - {second}" for (first, second), _ in most)
            lines.append(say("collision.never_free", language=language, names=names))
        return lines

    def _names(self, out: Floats, who: NDArray[np.int64]) -> tuple[NDArray[np.object_], NDArray[np.object_]]:
        bodies = np.array([body.name for body in self.bodies], object)
        second = np.array([*self.scene.names, *bodies[::-1]], object)
        found = np.isfinite(out[:, 0])
        names = np.where(found, bodies[who[:, 0]], ""), np.where(found, second[who[:, 1]], "")
        return names

    def _contact(self, row: Floats, who: NDArray[np.int64]) -> ContactPair:
        first, second = self._names(row[None], who[None])
        return ContactPair(str(first[0]), str(second[0]), float(row[0]), row[1:4], row[4:7], row[7:10])


class PathStatus(Status):
    """What is known of a motion."""

    FREE = ("collision.path_free", True)
    COLLIDING = ("collision.path_colliding", False)
    TOUCHING = ("collision.path_touching", False)


@dataclass(frozen=True, eq=False, repr=False)
class PathCheck(Answer, data="at q states contacts"):
    """The continuous collision check of a motion; true if the whole motion is proved collision-free.

    Attributes:
        status: free; colliding; touching: something comes within a micrometre of the clearance, which is not called
        free. points: (k, n) of the path.
        at: where along the path it stopped: the number of the segment plus the share of it; k - 1 if free.
        q: (n,) the configuration there.
        contacts: what it meets there, deepest first.
        states: configurations that were looked at.
        unchecked: keys of sentences about what was not looked at.
    """

    status: PathStatus
    points: Floats
    at: float
    q: Floats
    contacts: tuple[ContactPair, ...]
    states: int
    unchecked: tuple[str, ...] = ()

    def explain(self, language: str | None = None) -> str:
        """The verdict, where it shows, and a sentence for each contact."""
        head = self.status.sentence(language, at=self.at, segments=len(self.points) - 1, states=self.states)
        lines = [head, *(each.sentence(language) for each in self.contacts)]
        return "\n".join([*lines, *(say(key, language=language) for key in self.unchecked if self)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return Answer.to_dict(self) | {"unchecked": unchecked_as_data(self.unchecked)}


def path_points(n: int, q_a: ArrayLike, q_b: ArrayLike | None) -> Floats:
    """(k, n) points of a path, from a start and an end or from all of them.

    Raises:
        InputError: a wrong shape, fewer than two points, NaN or infinities.
    """
    if q_b is None:
        points = as_batch("q_a", q_a, (n,), finite=True)
        if points.ndim != 2 or len(points) < 2:
            raise InputError("collision.path_points", got=points.shape, n=n)
        return points
    ends = [as_batch(name, x, (n,), finite=True) for name, x in (("q_a", q_a), ("q_b", q_b))]
    for name, end in zip(("q_a", "q_b"), ends, strict=True):
        if end.ndim != 1:
            raise InputError("input.shape", name=name, expected=(n,), got=end.shape, hint="")
    return np.stack(ends)


def each_distance(checker: Checker, q: ArrayLike, within: float) -> tuple[Floats, Floats]:
    """What the arm keeps, body by body and pair by pair, and how that changes with the coordinates.

    Args:
        checker: the arm in its scene.
        q: (*batch, n) joint coordinates [rad | m].
        within: distances beyond it count as infinite [m].

    Returns:
        (*batch, bodies + pairs) distances [m], less than zero where something meets; (*batch, bodies + pairs, n) their
        gradients, zero beyond `within`.
    """
    n, arm, around = checker.robot.n, checker.arm, checker.scene.surroundings
    array = as_batch("q", q, (n,), finite=True)
    rows, batch = np.ascontiguousarray(array).reshape(-1, n), array.shape[:-1]
    items = len(arm.bodies) + len(arm.pairs)
    out, who = np.empty((len(rows), items, 10)), np.empty((len(rows), items, 2), np.int64)
    gradient = np.zeros((len(rows), items, n))
    for begin, poses in layout.poses_in_parts(checker.robot, rows):
        part = slice(begin, begin + len(poses))
        distance_loops.each_distance(arm, poses, around, float(within), out[part], who[part])
        of_items = np.repeat(poses, items, axis=0)
        found, rates = (x[part].reshape(-1, x.shape[2]) for x in (out, gradient))
        distance_loops.gradients(checker.laid.motion, of_items, found, who[part].reshape(-1, 2), rates)
    return out[:, :, 0].reshape(*batch, items), gradient.reshape(*batch, items, n)
