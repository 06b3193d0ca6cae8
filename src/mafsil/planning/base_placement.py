"""Where an arm has to stand: base poses from which a set of target poses is reached, free, with something to spare."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil import collision, ik, performance
from mafsil.arrays import Floats, JointVector, PoseMatrix, as_batch, positive, single, whole
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.model.appearance import reach, with_skeleton
from mafsil.model.loading import RobotLike, require_no_loops
from mafsil.model.placement import checked_poses, inverse
from mafsil.planning.outcome import best_kept, tells_of_interruption
from mafsil.planning.placement_answer import MEASURES, BasePlacement, PlacementFailure, PlacementStatus
from mafsil.robot import as_robot

if TYPE_CHECKING:
    import mafsil.ik.answers.batch as batch
else:
    batch = lazily("mafsil.ik.answers.batch")

if TYPE_CHECKING:
    from mafsil.collision import Checker, Obstacle, Scene

CHUNK = 4000
"""Pairs of base pose and target that are solved at once."""
MOST_POSES = 200_000


@tells_of_interruption
def optimal_base_placement(
    robot: RobotLike | Checker,
    targets: ArrayLike,
    *,
    scene: Scene | Iterable[Obstacle] | None = None,
    region: Sequence[Sequence[float]] = ((-1.0, 1.0), (-1.0, 1.0)),
    heights: ArrayLike = (0.0,),
    yaws: int = 8,
    spacing: float = 0.1,
    enough_clearance: float = 0.1,
    stands_on: Iterable[str] = (),
    samples: int = 1,
    refinements: int = 3,
    seed: int = 0,
) -> BasePlacement:
    """The best base pose of a grid for reaching all targets, and what each other one misses, and why.

    1. Base poses: a grid over the region, the heights, and yaws all round; those whose base stands in something go.
    2. For each, all solutions of the inverse kinematics for all targets; those within the limits and free of collision
       reach. Between targets the motions are not planned.
    3. A solution is as good as the worst of three shares: how far from joint limits (1 in the middle), how far from
       singular (1 / condition of the Jacobian with lengths over the arm's characteristic length), how much of the
       wanted clearance it keeps. A target is as good as its best solution, a base as its worst target.
    4. Around the best base the grid is made finer, `refinements` times by half.

    Targets that no pose of the grid reaches may be reached from between; the answer says how many poses were tried.

    Args:
        robot: the arm, or a Checker of it with its clearance, tool and pairs. An arm without shapes gets tubes along
            its links and is not checked against itself.
        targets: (m, 4, 4) poses of the tip in {s}, or one (4, 4).
        scene: what stands around, in {s}; None for that of a Checker, or nothing.
        region: ((x from, to), (y from, to)) of the base [m].
        heights: (h,) of the base [m].
        yaws: how many, evenly all round.
        spacing: of the grid [m].
        enough_clearance: beyond which more does not count [m].
        stands_on: names of obstacles that the base may touch: the table that it is bolted to.
        samples: values of the free coordinates of an arm with more joints than the task needs.
        refinements: of step 4.
        seed: of the samples.

    Ctrl-C gives the best of the base poses that were looked at, `interrupted`, as soon as there is one.

    Memory: 64 solutions of CHUNK pairs at once, and 24 bytes for each base pose and target.

    Raises:
        InputError: no targets or no poses, an empty region, numbers out of range, an unknown obstacle.

    Reference:
        N. Vahrenkamp, T. Asfour, R. Dillmann, Robot placement based on reachability inversion, ICRA 2013.
    """
    arm = robot if isinstance(robot, collision.Checker) else _checker_of(robot)
    require_no_loops(arm.robot.mechanism)
    goals = _targets(targets)
    allowed = (stands_on,) if isinstance(stands_on, str) else tuple(stands_on)
    around = arm.scene if scene is None else scene if isinstance(scene, collision.Scene) else collision.Scene(scene)
    search = _Search(arm, around, goals, positive("enough_clearance", enough_clearance), allowed, samples, seed)
    # 1.
    step, count = positive("spacing", spacing), whole("yaws", yaws, least=1)
    corners = single("region", cast("ArrayLike", region), (2, 2))
    axes = [_axis(f"region[{k}]", corners[k].tolist(), step) for k in range(2)]
    levels = np.atleast_1d(np.asarray(as_batch("heights", heights, (), finite=True), dtype=np.float64))
    turns = 2.0 * np.pi * np.arange(count) / count
    if len(axes[0]) * len(axes[1]) * len(levels) * count > MOST_POSES:
        total = len(axes[0]) * len(axes[1]) * len(levels) * count
        raise InputError("planning.too_many_poses", count=total, most=MOST_POSES)
    grid = np.stack([each.ravel() for each in np.meshgrid(*axes, levels, turns, indexing="ij")], axis=1)
    # 2., 3.
    found = search.evaluate(grid)
    # 4.
    finer = whole("refinements", refinements) if len(found.bases) == len(grid) else 0
    low, high = (np.array([f(axis) for axis in (*axes, levels)]) for f in (np.min, np.max))
    turn = 2.0 * np.pi / count
    with best_kept(lambda: True):
        for _ in range(finer):
            step, turn = step / 2.0, turn / 2.0
            best = found.bases[found.best]
            near = np.stack(np.meshgrid(*(np.array([-1.0, 0.0, 1.0]) * d for d in (step, step, turn)), indexing="ij"))
            moves = np.delete(near.reshape(3, -1).T, 13, axis=0)
            rows = best + np.insert(moves, 2, 0.0, axis=1)
            rows = rows[((rows[:, :3] >= low) & (rows[:, :3] <= high)).all(axis=1)]
            if len(rows):
                found = found.with_more(search.evaluate(rows))
    return search.answer(found)


class _Search:
    """The arm, the targets, and how base poses are judged."""

    def __init__(
        self, arm: Checker, scene: Scene, targets: PoseMatrix, enough_clearance: float, stands_on: tuple[str, ...],
        samples: int, seed: int,
    ) -> None:  # fmt: skip
        self.robot, self.targets, self.stands_on = arm.robot, targets, stands_on
        self.enough_clearance = enough_clearance
        self.movable = collision.MovableArm(arm, scene)
        self.alone = bool(len(scene) == 0)
        self.farthest = reach(arm.robot.mechanism)
        redundant = arm.robot.n > 6 and whole("samples", samples, least=1) > 1
        limits, rng = arm.robot.limits, np.random.default_rng(whole("seed", seed))
        bounded = np.isfinite(limits.lower) & np.isfinite(limits.upper)
        low, high = (np.where(bounded, each, side) for each, side in ((limits.lower, -np.pi), (limits.upper, np.pi)))
        self.starts: list[JointVector | None] = [None]
        if redundant:
            self.starts += list(rng.uniform(low, high, (samples - 1, arm.robot.n)))

    def evaluate(self, bases: Floats) -> BasePlacement:
        """What each of (k, 4) base poses reaches, and how well; at Ctrl-C of those looked at till then."""
        shape = (len(bases), len(self.targets))
        misses, quality = np.full(shape, PlacementFailure.REACH, np.int8), np.full((*shape, len(MEASURES)), -1.0)
        q = np.full((*shape, self.robot.n), np.nan)
        open_bases = np.asarray(self.movable.base_is_free(bases, self.stands_on), dtype=np.bool_)
        misses[~open_bases] = PlacementFailure.BASE
        T_sb = base_poses(bases)
        near = np.linalg.norm(self.targets[None, :, :3, 3] - T_sb[:, None, :3, 3], axis=2) <= self.farthest
        rows, done = np.argwhere(open_bases[:, None] & near), 0
        with best_kept(lambda: done > 0):
            for begin in range(0, len(rows), CHUNK):
                done = int(rows[begin, 0])
                self._solve(bases, T_sb, rows[begin : begin + CHUNK], misses, quality, q)
            done = len(bases)
        return BasePlacement(
            PlacementStatus.NOT_FOUND, self.robot, self.targets, bases[:done], misses[:done], quality[:done], q[:done],
            done,
        )  # fmt: skip

    def _solve(
        self, bases: Floats, T_sb: PoseMatrix, rows: NDArray[np.intp], misses: NDArray[np.int8], quality: Floats,
        q: JointVector,
    ) -> None:  # fmt: skip
        """Solutions of some pairs (base, target), the best of each kept."""
        # The tip's pose for a base at the mechanism's own base pose, which the kinematics know.
        own = np.asarray(self.robot.mechanism.T_sb)
        wanted = own @ _inverses(T_sb[rows[:, 0]]) @ self.targets[rows[:, 1]]
        for start in self.starts:
            answer = ik.inverse_kinematics(self.robot, wanted, q0=start)
            assert isinstance(answer, batch.SolutionBatch)
            valid, within = np.asarray(answer.valid), np.asarray(answer.within)
            pair, branch = np.nonzero(valid & within)
            limited = valid.any(axis=1)
            self._note(rows[limited], PlacementFailure.LIMITS, misses)
            if not len(pair):
                continue
            configurations = np.ascontiguousarray(answer.q[pair, branch])
            full = self.movable.join(bases[rows[pair, 0]], configurations)
            free = np.asarray(self.movable.free(full), dtype=np.bool_)
            self._note(rows[pair[~free]], PlacementFailure.COLLISION, misses)
            self._note(rows[pair[free]], PlacementFailure.NONE, misses)
            measured = self._measured(configurations[free], full[free])
            worst = measured.min(axis=1)
            order = np.lexsort((worst, pair[free]))
            best = order[np.append(np.diff(pair[free][order]) > 0, True)[: len(order)]]
            i, j = rows[pair[free][best]].T
            better = worst[best] > quality[i, j].min(axis=1)
            best, i, j = best[better], i[better], j[better]
            quality[i, j], q[i, j] = measured[best], configurations[free][best]

    def _note(self, rows: NDArray[np.intp], miss: PlacementFailure, misses: NDArray[np.int8]) -> None:
        """Why pairs are missed: the reason that comes latest counts."""
        here = misses[rows[:, 0], rows[:, 1]]
        misses[rows[:, 0], rows[:, 1]] = np.maximum(here, np.int8(miss))

    def _measured(self, q: JointVector, full: JointVector) -> Floats:
        """(k, 3) shares in the order of MEASURES."""
        out = np.ones((len(q), len(MEASURES)))
        if not len(q):
            return out
        limits = self.robot.limits
        bounded = np.isfinite(limits.lower) & np.isfinite(limits.upper) & (limits.upper > limits.lower)
        if bounded.any():
            lower, upper = limits.lower[bounded], limits.upper[bounded]
            middle, half = (upper + lower) / 2.0, (upper - lower) / 2.0
            out[:, 0] = (1.0 - np.abs(q[:, bounded] - middle) / half).min(axis=1)
        singular = np.linalg.svd(performance.scaled_jacobian(self.robot, q).J, compute_uv=False)
        out[:, 1] = singular[:, -1] / singular[:, 0]
        if not self.alone:
            clearance = self.movable.clearance
            distance = self.movable.distance(full, within=clearance + self.enough_clearance).distance
            out[:, 2] = np.clip((distance - clearance) / self.enough_clearance, 0.0, 1.0)
        return np.maximum(out, 0.0)

    def answer(self, found: BasePlacement) -> BasePlacement:
        """With the status, and for targets that the best base misses by a collision what they meet."""
        contacts = dict[int, Any]()
        best = found.best
        for j in np.flatnonzero(found.misses[best] == PlacementFailure.COLLISION):
            contacts[int(j)] = self._contact(found.bases[best], self.targets[j])
        return found.with_verdict(contacts)

    def _contact(self, base: Floats, target: PoseMatrix) -> Any:
        """What the arm meets in the solution that meets least."""
        own, T_sb = np.asarray(self.robot.mechanism.T_sb), base_poses(base[None])[0]
        answer = ik.inverse_kinematics(self.robot, (own @ inverse(T_sb) @ target)[None])
        assert isinstance(answer, batch.SolutionBatch)
        rows = answer.q[0][np.asarray(answer.valid)[0] & np.asarray(answer.within)[0]]
        if not len(rows):
            return None
        found = self.movable.distance(self.movable.join(base, rows))
        return list(found)[int(found.distance.argmax())]


def _checker_of(robot: RobotLike) -> Checker:
    """The arm with its shapes, or with tubes along its links."""
    mechanism = as_robot(robot).mechanism
    own = any(link.collisions or link.visuals for link in mechanism.links)
    shown = mechanism if any(link.collisions for link in mechanism.links) else with_skeleton(mechanism)
    return collision.Checker(shown, self_collision=own)


def base_poses(bases: Floats) -> PoseMatrix:
    """(*batch, 4, 4) poses of bases (*batch, 4): x, y, z [m], yaw [rad]."""
    T = np.zeros((*bases.shape[:-1], 4, 4))
    c, s = np.cos(bases[..., 3]), np.sin(bases[..., 3])
    T[..., 0, 0], T[..., 0, 1], T[..., 1, 0], T[..., 1, 1] = c, -s, s, c
    T[..., 2, 2] = T[..., 3, 3] = 1.0
    T[..., :3, 3] = bases[..., :3]
    return T


def _inverses(T: PoseMatrix) -> PoseMatrix:
    out = np.zeros_like(T)
    out[..., :3, :3] = np.swapaxes(T[..., :3, :3], -1, -2)
    out[..., :3, 3] = -np.einsum("...ij,...j->...i", out[..., :3, :3], T[..., :3, 3])
    out[..., 3, 3] = 1.0
    return out


def _targets(targets: ArrayLike) -> PoseMatrix:
    rows = checked_poses("targets", targets)
    rows = rows[None] if rows.ndim == 2 else rows
    if rows.ndim != 3 or not len(rows):
        raise InputError("input.shape", name="targets", expected=("m", 4, 4), got=rows.shape, hint="")
    return np.asarray(rows)


def _axis(name: str, ends: Sequence[float], spacing: float) -> Floats:
    low, high = (float(x) for x in np.asarray(as_batch(name, ends, (2,), finite=True)))
    if low > high:
        raise InputError("input.range", name=name, value=high, low=low, high=np.inf)
    steps = whole(f"{name} / spacing", max(int(np.ceil((high - low) / spacing - 1e-9)), 0), most=MOST_POSES)
    return np.linspace(low, high, steps + 1)
