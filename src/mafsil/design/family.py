"""Kernels of arms whose geometry and masses are inputs: many arms of one kind of joints are one batch.

A kernel of a robot has its numbers folded in, and compiling takes longer than a thousand arms of a study. Here the
poses of the joints and the inertial parameters of the bodies enter beside q; the code depends on the kinds of joints
alone, is compiled once and kept in the cache.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

import mafsil.kernels as kernels
from mafsil.arrays import Booleans, Floats, JointVector, PoseMatrix, frozen
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import pose
from mafsil.kernels import Kernel, Port, Signature
from mafsil.lazy_module import lazily
from mafsil.mechanics.body_tree import Attachment, Body, BodyTree, RigidInertia, lump_bodies
from mafsil.model import JointKind
from mafsil.robot import Robot

if TYPE_CHECKING:
    import mafsil.expression as ex
    import mafsil.mechanics.quantities.inverse_dynamics as inverse_dynamics
    import mafsil.mechanics.quantities.kinematics as kinematics
else:
    kinematics = lazily("mafsil.mechanics.quantities.kinematics")
    ex = lazily("mafsil.expression")
    inverse_dynamics = lazily("mafsil.mechanics.quantities.inverse_dynamics")

RANK = 1e-9
"""Singular values below this share of the largest entry are none."""
ITERATIONS, RESTARTS = 40, 3
"""Steps of an attempt, and further starts of poses still open, of the search for many designs."""
REACHED = 1e-9
"""Error of the tool that counts as none [m | rad]."""
STRETCH = 0.5
"""Largest joint motion of a step of that search [rad | m]."""
SWEEPS, SETTLED, EXTENT_STARTS = 400, 1e-13, 12
"""Rounds over all joints of the search for extreme distances, the share of a distance whose change ends it, starts."""
Kinds = tuple[tuple[str, float], ...]
"""Kind and pitch of each joint."""


@dataclass(frozen=True, eq=False, slots=True)
class ArmNumbers:
    """What distinguishes arms with the same kinds of joints; `...` are the axes of a batch of arms.

    Attributes:
        kinds: of the joints.
        places: (..., n + 1, 4, 4) pose of each joint, z along its axis, in the body before it; the tip's pose at last.
        bodies: (..., n, 10) inertial parameters of the body behind each joint, in its frame.
        armature: (..., n) inertia of rotors, seen at the joints [kg m^2 | kg].
        gravity: (..., 3) in {s} [m/s^2].
    """

    kinds: Kinds
    places: PoseMatrix
    bodies: Floats
    armature: Floats
    gravity: Floats

    @classmethod
    def of(cls, robot: Robot) -> ArmNumbers:
        """Those of one robot.

        Raises:
            InputError: it is no chain of joints of which each has a coordinate of its own.
        """
        mechanism = robot.mechanism
        tree = lump_bodies(mechanism)
        chain = [body.parent for _, body in tree.moving] == list(range(tree.n))
        if mechanism.loops or tree.follows or not chain or tree.tip.body != tree.n or not tree.n:
            raise InputError("design.no_chain", robot=robot.name)
        places = np.tile(np.eye(4), (tree.n + 1, 1, 1))
        for k, part in enumerate((*tree.bodies[1:], tree.tip)):
            places[k, :3, :3], places[k, :3, 3] = part.R, part.p
        places[0] = mechanism.T_sb @ places[0]
        bodies = np.array([_parameters(body.inertia) for _, body in tree.moving])
        kinds = tuple((body.kind.value, body.pitch) for _, body in tree.moving)
        armature = np.array([body.armature for _, body in tree.moving])
        return cls(kinds, frozen(places), frozen(bodies), frozen(armature), np.asarray(mechanism.gravity))

    @classmethod
    def stack(cls, arms: Sequence[ArmNumbers]) -> ArmNumbers:
        """Several arms of one kind of joints as a batch with one more axis in front.

        Raises:
            InputError: their joints differ in kind or pitch.
        """
        if any(each.kinds != arms[0].kinds for each in arms):
            raise InputError("design.kinds_differ")
        columns = zip(*((each.places, each.bodies, each.armature, each.gravity) for each in arms), strict=True)
        return cls(arms[0].kinds, *(np.stack(column) for column in columns))

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.kinds)

    def spread(self) -> ArmNumbers:
        """A batch of arms with an axis for the poses of each."""
        parts = (self.places, self.bodies, self.armature, self.gravity)
        return ArmNumbers(self.kinds, *(part[:, None] for part in parts))

    def rank(self, with_turns: bool) -> int:
        """Of the tool's Jacobian in general: the largest seen at random configurations of the first arm."""
        q = np.random.default_rng(0).uniform(-1.5, 1.5, (16, self.n))
        first = ArmNumbers(self.kinds, self.places.reshape(-1, self.n + 1, 4, 4)[0], *(np.zeros(0),) * 3)
        J = first.pose_and_jacobian(q)[1][:, 0 if with_turns else 3 :]
        return int(np.linalg.matrix_rank(J, tol=RANK * np.abs(J).max()).max())

    @property
    def shoulder(self) -> Floats:
        """(..., 3) where the common perpendicular of the first two axes stands on the first one, in {s} [m].

        Of parallel axes it is where the second joint's origin is seen from the first axis.
        """
        first, second = self.places[..., 0, :, :], self.places[..., 1, :, :]
        p, z = second[..., :3, 3], second[..., :3, 2]
        lean = z[..., 2]
        across = 1.0 - lean**2
        height = np.where(
            across > RANK, (p[..., 2] - lean * (p * z).sum(axis=-1)) / np.maximum(across, RANK), p[..., 2]
        )
        return np.asarray(first[..., :3, 3] + height[..., None] * first[..., :3, 2])

    def pose_and_jacobian(self, q: JointVector) -> tuple[PoseMatrix, Floats]:
        """T_st (..., 4, 4) and body Jacobian (..., 6, n) at q (..., n)."""
        return pose_kernel(self.kinds)(q, _rows(self.places))

    def torque(self, q: JointVector, qd: JointVector, qdd: JointVector, tip_wrench: Floats) -> Floats:
        """(..., n) joint efforts of a motion under gravity; `tip_wrench` (..., 6) is what the tip exerts, in {t}."""
        kernel = torque_kernel(self.kinds)
        rigid = kernel(q, qd, qdd, tip_wrench, _rows(self.places), self.bodies, self.gravity)
        return np.asarray(rigid) + self.armature * qdd


def configurations(
    arms: ArmNumbers,
    poses: PoseMatrix,
    task: str,
    lower: Floats,
    upper: Floats,
    seed: int,
    starts: int,
    quality: Callable[[PoseMatrix, Floats], Floats],
) -> JointVector:
    """(S, P, n) configurations of S arms for P poses, NaN where none was found: damped steps from seeded starts.

    dq = J' (J J' + |e|^2 E)^-1 e, with e the error in the tool's frame, clipped to the limits.

    Args:
        arms: (S, 1) of them.
        poses: (P, 4, 4) of the tool.
        task: `pose` or `position`.
        lower, upper: (S, n) bounds of the joints.
        seed: of the starts.
        starts: from which every pose is tried; the best of the configurations found is kept.
        quality: of configurations, from poses (k, 4, 4) and body Jacobians (k, 6, n) of the tool.

    Reference: Sugihara, Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method, 2011.
    """
    places: PoseMatrix = arms.places[:, 0]
    S, P, n = len(lower), len(poses), arms.n
    rng, rows = np.random.default_rng(seed), slice(0 if task == "pose" else 3, 6)
    q, best = np.full((S, P, n), np.nan), np.full((S, P), -np.inf)
    possible = may_reach(arms, poses, task)
    for attempt in range(1 + RESTARTS):
        missed = np.argwhere(np.isinf(best) & possible)
        if not len(missed):
            break
        tries = 1 if attempt else starts
        s, p = np.tile(missed, (tries, 1)).T
        points = rng.uniform(0.0, 1.0, (tries, P, n))
        if not attempt:
            points[0] = 0.35 + 0.3 * points[0]
        low, high = lower[s], upper[s]
        here = low + points[np.repeat(np.arange(tries), len(missed)), p] * (high - low)
        active = np.arange(len(s))
        done = np.zeros(len(s), dtype=np.bool_)
        for _ in range(ITERATIONS):
            part = replace(arms, places=places[s[active]])
            T, J = part.pose_and_jacobian(here[active])
            e, J = _error(T, poses[p[active]], task), J[:, rows]
            solved = np.abs(e).max(axis=1) < REACHED
            done[active[solved]] = True
            active, e, J = active[~solved], e[~solved], J[~solved]
            if not len(active):
                break
            A = J @ J.transpose(0, 2, 1) + ((e**2).sum(axis=1) + 1e-12)[:, None, None] * np.eye(e.shape[1])
            towards: Floats = np.asarray(np.linalg.solve(A, e[..., None]), dtype=np.float64)
            step = (J.transpose(0, 2, 1) @ towards)[..., 0]
            step = step * np.minimum(1.0, STRETCH / np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-12))
            here[active] = np.clip(here[active] + step, low[active], high[active])
        s, p, here = s[done], p[done], here[done]
        value = quality(*replace(arms, places=places[s]).pose_and_jacobian(here)) if tries > 1 else np.zeros(len(s))
        # Of several configurations for one pose the last that is written is the best.
        order = np.argsort(value, kind="stable")
        q[s[order], p[order]], best[s[order], p[order]] = here[order], value[order]
    return q


def may_reach(arms: ArmNumbers, poses: PoseMatrix, task: str) -> Booleans:
    """(S, P) whether poses (P, 4, 4) lie within the sum of all lengths of S arms (S, 1): if not, it is proved.

    Of a whole pose the place of the last joint is known too, and the lengths up to there count.
    """
    if arms.n < 2 or any(kind != "revolute" for kind, _ in arms.kinds):
        return np.ones((len(arms.places), len(poses)), dtype=np.bool_)
    places: PoseMatrix = arms.places[:, 0]
    shoulder: Floats = arms.shoulder[:, 0]
    second = (places[:, 0] @ places[:, 1])[:, :3, 3]
    lengths = np.linalg.norm(places[:, 2:, :3, 3], axis=-1)
    reached: Floats = np.linalg.norm(second - shoulder, axis=-1) + lengths[:, :-1].sum(axis=-1)
    if task == "pose":
        targets = (poses[None] @ np.linalg.inv(places[:, -1])[:, None])[..., :3, 3]
    else:
        targets, reached = poses[None, :, :3, 3], reached + lengths[:, -1]
    away = np.linalg.norm(targets - shoulder[:, None], axis=-1)
    return np.asarray(away <= (reached * (1.0 + REACHED) + REACHED)[:, None], dtype=np.bool_)


def reach_and_void(arms: ArmNumbers, lower: Floats, upper: Floats) -> tuple[Floats, Floats]:
    """(S,) largest and least distance of the tool from the shoulder of S arms that was found [m].

    Args:
        arms: (S,) of them.
        lower, upper: (S, n) bounds of the joints.
    """
    search = partial(extreme_distances, arms, arms.shoulder, lower, upper, starts=EXTENT_STARTS)
    return search(farthest=True)[0], search(farthest=False)[0]


def extreme_distances(
    arms: ArmNumbers, points: Floats, lower: Floats, upper: Floats, *, farthest: bool, starts: int, seed: int = 0,
    enough: float = 0.0, settled: float = SETTLED,
) -> tuple[Floats, JointVector]:  # fmt: skip
    """How near to points the tool of arms comes, or how far away: (S,) distances [m] and (S, n) configurations.

    With all other joints still, the square of the distance is a + b cos q + c sin q of a revolute joint and a parabola
    of a prismatic one: each joint in turn goes to its exact extremum between its limits, from seeded starts.

    Args:
        arms: (S,) of them, or one for all points.
        points: (S, 3) in {s}.
        lower, upper: (S, n) or (n,) bounds of the joints.
        farthest: seek the largest distance, not the least.
        starts: of each search.
        seed: of the starts.
        enough: distance that ends a search for the least [m].
        settled: share of the squared distance whose change in a round ends a search.

    Raises:
        InputError: a joint that is neither revolute nor prismatic.
    """
    for kind, _ in arms.kinds:
        if kind not in ("revolute", "prismatic"):
            raise InputError("input.choice", name="joint", value=kind, known="revolute, prismatic")
    S, n = len(points), arms.n
    rows = np.repeat(np.arange(S), starts)
    low, high = (np.broadcast_to(bound, (S, n))[rows] for bound in (lower, upper))
    q = low + np.random.default_rng(seed).uniform(size=(starts, n))[np.tile(np.arange(starts), S)] * (high - low)
    sign, best = -1.0 if farthest else 1.0, np.full(S, np.inf)
    value, going = np.full(len(q), np.inf), np.arange(len(q))
    for _ in range(SWEEPS):
        part = arms if arms.places.ndim == 3 else replace(arms, places=arms.places[rows[going]])
        before, here = value[going], q[going]
        for k in range(n):
            value[going] = _go_to_extremum(part, here, k, points[rows[going]], low[going, k], high[going, k], sign)
        q[going] = here
        np.minimum.at(best, rows[going], value[going])
        moves = ~(before - value[going] <= settled * (np.abs(value[going]) + LEAST_DIVISOR))
        going = going[moves & ((best[rows[going]] > enough**2) | farthest)]
        if not len(going):
            break
    q = q[np.lexsort((value, rows)).reshape(S, starts)[:, 0]]
    return np.linalg.norm(arms.pose_and_jacobian(q)[0][:, :3, 3] - points, axis=-1), q


def _go_to_extremum(
    arms: ArmNumbers, q: JointVector, k: int, points: Floats, low: Floats, high: Floats, sign: float
) -> Floats:
    """Put joint k of q (R, n) where sign times the squared distance from points (R, 3) is least; (R,) that value."""
    turns = arms.kinds[k][0] == "revolute"
    probes = np.array([0.0, 2 * np.pi / 3, -2 * np.pi / 3]) if turns else np.array([0.0, 1.0, -1.0])
    rows = np.repeat(q[:, None], 3, axis=1)
    rows[..., k] += probes
    spread = arms if arms.places.ndim == 3 else replace(arms, places=arms.places[:, None])
    f = sign * ((spread.pose_and_jacobian(rows)[0][..., :3, 3] - points[:, None]) ** 2).sum(axis=-1)
    ends = np.stack([low - q[:, k], high - q[:, k]], axis=1)
    if turns:
        cos, sin = (f @ each(probes) * 2 / 3 for each in (np.cos, np.sin))
        step = np.arctan2(-sin, -cos)
        # The same place whole turns on may lie within the limits where this one does not.
        step += 2 * np.pi * np.ceil((ends[:, 0] - step) / (2 * np.pi) - RANK)
        steps = np.column_stack([step, ends])
        values = f.mean(axis=1)[:, None] + cos[:, None] * np.cos(steps) + sin[:, None] * np.sin(steps)
    else:
        slope = (f[:, 1] - f[:, 2]) / 2
        steps = np.column_stack([-sign * slope / 2, ends])
        values = f[:, :1] + slope[:, None] * steps + sign * steps**2
    inside = (steps >= ends[:, :1] - RANK) & (steps <= ends[:, 1:] + RANK)
    row, chosen = np.arange(len(q)), np.where(inside, values, np.inf).argmin(axis=1)
    q[:, k] = np.clip(q[:, k] + steps[row, chosen], low, high)
    return values[row, chosen]


def _error(T: PoseMatrix, wanted: PoseMatrix, task: str) -> Floats:
    """(k, 3 | 6) way to the wanted pose in the tool's frame."""
    if task == "pose":
        return np.asarray(pose.error(T, wanted))
    return np.einsum("kji,kj->ki", T[:, :3, :3], wanted[:, :3, 3] - T[:, :3, 3])


def _rows(places: PoseMatrix) -> Floats:
    """(..., n + 1, 12) without the last line of each pose."""
    return np.ascontiguousarray(places[..., :3, :]).reshape(*places.shape[:-2], 12)


def pose_kernel(kinds: Kinds) -> Kernel:
    """Of q (n,), places (n + 1, 12) to the tip's pose (4, 4) and body Jacobian (6, n)."""
    n = len(kinds)
    outputs = {"pose": (4, 4), "jacobian": (6, n)}
    return _kernel("design_pose", kinds, {"q": (n,), "places": (n + 1, 12)}, outputs, partial(_pose, kinds))


def torque_kernel(kinds: Kinds) -> Kernel:
    """Of q, qd, qdd (n,), tip wrench (6,), places (n + 1, 12), bodies (n, 10), gravity (3,) to efforts (n,)."""
    n = len(kinds)
    inputs = {"q": (n,), "qd": (n,), "qdd": (n,), "tip_wrench": (6,)}
    inputs |= {"places": (n + 1, 12), "bodies": (n, 10), "gravity": (3,)}
    return _kernel("design_torque", kinds, inputs, {"tau": (n,)}, partial(_torque, kinds))


def _kernel(
    name: str, kinds: Kinds, inputs: dict[str, tuple[int, ...]], outputs: dict[str, tuple[int, ...]], build: Any
) -> Kernel:
    given, results = (tuple(Port(port, shape) for port, shape in side.items()) for side in (inputs, outputs))
    return kernels.compile(
        Signature(name, given, results),
        build,
        key=f"{name} {kinds}",
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics", "mafsil.design.family"),),
    )


def _pose(kinds: Kinds) -> Any:
    n = len(kinds)
    q, places = ex.symbol("q", n), ex.symbol("places", 12 * (n + 1))
    tree = _tree(kinds, places)
    T, J = (build(tree, q, tree.tip) for build in (kinematics.forward_kinematics_inward, kinematics.jacobian_body))
    return ex.Function("design_pose", [q, places], [ex.vec(T.T), ex.vec(J.T)], cse=True)


def _torque(kinds: Kinds) -> Any:
    n = len(kinds)
    q, qd, qdd, F = ex.symbol("q", n), ex.symbol("qd", n), ex.symbol("qdd", n), ex.symbol("F", 6)
    places, bodies, gravity = ex.symbol("places", 12 * (n + 1)), ex.symbol("bodies", 10 * n), ex.symbol("gravity", 3)
    tau = inverse_dynamics.inverse_dynamics(_tree(kinds, places, bodies, gravity), q, qd, qdd, F)
    return ex.Function("design_torque", [q, qd, qdd, F, places, bodies, gravity], [tau], cse=True)


def _tree(kinds: Kinds, places: Any, bodies: Any = None, gravity: Any = None) -> BodyTree:
    """The chain of bodies with symbols where a robot has numbers."""
    n = len(kinds)
    poses: list[Any] = [
        (ex.reshape(_take(places, 12 * k, (0, 4, 8, 1, 5, 9, 2, 6, 10)), 3, 3), _take(places, 12 * k, (3, 7, 11)))
        for k in range(n + 1)
    ]
    inertias: list[Any] = [RigidInertia.zero() if bodies is None else _inertia(bodies, 10 * k) for k in range(n)]
    moving = [
        Body(f"joint{k}", k, poses[k][0], poses[k][1], JointKind(kind), pitch, k, 1.0, 0.0, inertias[k], 0.0)
        for k, (kind, pitch) in enumerate(kinds)
    ]
    base = Body("", -1, np.eye(3), np.zeros(3), JointKind.FIXED, 0.0, -1, 0.0, 0.0, RigidInertia.zero(), 0.0)
    fall: Any = np.zeros(3) if gravity is None else gravity
    return BodyTree(n, np.eye(3), np.zeros(3), (base, *moving), {}, Attachment(n, *poses[n]), fall)


def _take(column: Any, start: int, places: Sequence[int]) -> Any:
    return ex.vertcat(*(column[start + k] for k in places))


def _inertia(bodies: Any, start: int) -> Any:
    """As `mafsil.mechanics.inertial_parameters` orders them."""
    I: Any = ex.reshape(_take(bodies, start, (4, 7, 8, 7, 5, 9, 8, 9, 6)), 3, 3)
    return RigidInertia(bodies[start], _take(bodies, start, (1, 2, 3)), I)


def _parameters(inertia: RigidInertia) -> Floats:
    I = inertia.I
    return np.array([inertia.mass, *inertia.h, I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]])
