"""How good a configuration of a platform on rods is: dexterity, transmission, stiffness, accuracy; and its workspace.

All about the platform's own point p, V = (omega, p'): A V = B q' + l', rods that give way by l'. Hence

    J = A^-1 B,    compliance A^-1 (B K_q^-1 B' + K_l^-1) A^-T,    errors |J| dq + |A^-1| dl at worst.

Transmission of a leg: input, the angle between its rod and the normal of what its motor does; output, the same for what
the platform does at the rod's end while this motor alone moves. 90 degrees are best, 0 is singular.

References: Merlet, Parallel Robots, 2nd ed., ch. 6, 9, 10; Wang, Wu and Liu, Performance evaluation of parallel
manipulators: motion/force transmissibility, Mechanism and Machine Theory 45 (2010).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch, calculable, positive, real_array, single, spread, whole
from mafsil.errors import InputError
from mafsil.fields import between, check_fields
from mafsil.geometry import rotation
from mafsil.parallel.legs.leg_lines import unit_vectors
from mafsil.parallel.legs.rod_robot import LegDrive, RodRobot
from mafsil.parallel.platforms.platform_workspace import BLOCK, PlatformWorkspace
from mafsil.parallel.tolerances import RANK
from mafsil.solvers.decompositions import pinv, singular_values

REASONS = ("reach", "motor", "transmission", "condition")
"""Why a pose is refused, in the order in which reasons are counted."""


class RodIndicesStatus(Status):
    """Whether all rows are regular."""

    REGULAR = ("parallel.indices_regular", True)
    SINGULAR = ("parallel.indices_singular", False)


@dataclass(frozen=True, eq=False, repr=False)
class RodIndices(Answer, data="condition transmission stiffness worst_error deviation"):
    """Indices of configurations; true if none is singular. Of singular ones they are infinite, zero or NaN.

    Attributes:
        jacobian: (*batch, m, m) of (omega, p') = J q'.
        condition: (*batch,) of J, rotations times the length; 1 is isotropic.
        transmission: (*batch, m, 2) input and output angle of each leg [rad].
        stiffness: (*batch, m, m) of the platform at p, rows as (moment, force) [N m/rad, N/m]; NaN without stiffnesses.
        worst_error: (*batch, m) of the platform, from largest errors of motors and rods [rad, m].
        deviation: (*batch, m) the same as standard deviations of independent ones.
        length: by which rotations were made comparable with translations [m].
    """

    jacobian: Floats
    condition: Floats
    transmission: Floats
    stiffness: Floats
    worst_error: Floats
    deviation: Floats
    length: float

    @property
    def dexterity(self) -> Floats:
        """(*batch,) 1 over the condition number: 0 at a singular pose."""
        return 1.0 / self.condition

    @property
    def status(self) -> RodIndicesStatus:
        """Of all rows together."""
        regular = bool((self.condition < 1.0 / RANK).all())
        return RodIndicesStatus.REGULAR if regular else RodIndicesStatus.SINGULAR

    def explain(self, language: str | None = None) -> str:
        """Largest condition number and least transmission angles over all rows."""
        least = np.degrees(self.transmission.reshape(-1, 2).min(axis=0, initial=np.pi / 2))
        return self.status.sentence(
            language, condition=float(self.condition.max(initial=0.0)), into=float(least[0]), out=float(least[1]),
            rows=self.condition.size, length=self.length,
        )  # fmt: skip


def rod_indices(
    robot: RodRobot,
    x: ArrayLike,
    q: ArrayLike | None = None,
    *,
    length: float | None = None,
    motor_stiffness: ArrayLike | None = None,
    rod_stiffness: ArrayLike | None = None,
    motor_error: ArrayLike = 0.0,
    rod_error: ArrayLike = 0.0,
) -> RodIndices:
    """Dexterity, transmission, stiffness and accuracy of a platform on rods.

    Args:
        robot: as `rod_library` makes them, or `as_rod_robot`.
        x: (*batch, ...) poses or short coordinates.
        q: (*batch, m) of the motors; the first of both of each if None.
        length: makes rotations comparable [m]; the mean distance of the ends from the platform's point if None.
        motor_stiffness: of the motors, one or m [N m/rad | N/m]; rigid if None.
        rod_stiffness: along the rods, one or m [N/m]; rigid if None.
        motor_error: largest errors of the motors, one or m [rad | m].
        rod_error: of the rods: errors of length, clearances of their joints [m].

    Raises:
        InputError: x and q do not belong together, or the robot does not reach x.
    """
    value = robot.branch(x) if q is None else as_batch("q", q, (robot.m,), finite=True)
    A, B = _about_platform(robot, x, value)
    arm = np.linalg.norm(robot.rotating + robot.fixed, axis=1).mean()
    unit = positive("length", length) if length is not None else float(arm if arm > 0 else robot.size)
    weights = np.concatenate([np.full(robot.motion.angles, unit), np.ones(robot.m - robot.motion.angles)])
    singular = np.asarray(singular_values(A / weights)[..., -1] < RANK, dtype=np.bool_)

    def unless_singular(values: Floats, instead: float) -> Floats:
        return np.where(singular.reshape(singular.shape + (1,) * (values.ndim - singular.ndim)), instead, values)

    regular = np.where(singular[..., None, None], np.eye(robot.m), A)
    back = np.linalg.inv(regular)
    J = back @ B
    s = singular_values(J * weights[:, None])
    condition = np.divide(
        s[..., 0], s[..., -1], out=np.full(singular.shape, np.inf), where=s[..., -1] > RANK * s[..., 0]
    )
    errors = (("motor_error", motor_error), ("rod_error", rod_error))
    dq, dl = (calculable(name, spread(name, each, (robot.m,))) for name, each in errors)
    K = _stiffness(regular, B, robot.m, motor_stiffness, rod_stiffness)
    into, out = _transmission(robot, x, value, back)
    return RodIndices(
        unless_singular(J, np.nan), unless_singular(condition, np.inf),
        np.stack([into, unless_singular(out, 0.0)], axis=-1), unless_singular(K, np.nan),
        unless_singular(np.abs(J) @ np.abs(dq) + np.abs(back) @ np.abs(dl), np.inf),
        unless_singular(np.sqrt(J**2 @ dq**2 + back**2 @ dl**2), np.inf), unit,
    )  # fmt: skip


def _about_platform(robot: RodRobot, x: ArrayLike, q: Floats) -> tuple[Floats, Floats]:
    """A and B (*batch, m, m) for V = (omega, p') instead of the twist at the origin."""
    A, B = robot.motor_matrices(x, q)
    p = robot.poses(x)[..., :3, 3]
    full = np.zeros((*A.shape[:-1], 6))
    full[..., robot.motion.columns] = A
    full[..., :3] -= np.cross(p[..., None, :], full[..., 3:])
    return full[..., robot.motion.columns], np.asarray(B)


def _stiffness(A: Floats, B: Floats, m: int, motors: ArrayLike | None, rods: ArrayLike | None) -> Floats:
    """(*batch, m, m) A' (B K_q^-1 B' + K_l^-1)^-1 A; NaN where nothing gives way."""
    if motors is None and rods is None:
        return np.full(A.shape, np.nan)
    gives = np.zeros(A.shape)
    for name, value, M in (("motor_stiffness", motors, B), ("rod_stiffness", rods, np.eye(m))):
        if value is not None:
            k = calculable(name, spread(name, value, (m,)))
            if not (k > 0).all():
                raise InputError("input.positive", name=name, value=k.tolist())
            gives = gives + M @ (np.swapaxes(M, -1, -2) / k[:, None])
    return np.swapaxes(A, -1, -2) @ pinv(gives, RANK) @ A


def _transmission(robot: RodRobot, x: ArrayLike, q: Floats, back: Floats) -> tuple[Floats, Floats]:
    """(*batch, m) input and output angles: a right angle less that between force and motion at both ends of a rod."""
    T = robot.poses(x)
    u = unit_vectors(robot.ends(T) - robot.carriers(q))[1]
    into = np.ones(u.shape[:-1])
    if robot.drive is not LegDrive.EXTEND:
        swing = robot.swings(q)
        into = np.abs((u * swing).sum(axis=-1)) / np.linalg.norm(swing, axis=-1)
    V = np.zeros((*back.shape[:-2], robot.m, 6))
    V[..., robot.motion.columns] = np.swapaxes(back, -1, -2)
    arm = robot.rotating @ np.swapaxes(T[..., :3, :3], -1, -2)
    moved = np.linalg.norm(V[..., 3:] + np.cross(V[..., :3], arm), axis=-1)
    return np.arcsin(np.clip(into, 0.0, 1.0)), np.arcsin(1.0 / np.maximum(moved, 1.0))


@dataclass(frozen=True, eq=False)
class RodLimits:
    """What a platform on rods is allowed.

    Attributes:
        lower, upper: of the motors, one or m [rad | m].
        least_transmission: of both angles of every leg [rad].
        largest_condition: of J; what is as good as singular is refused in any case.
    """

    lower: ArrayLike = -np.inf
    upper: ArrayLike = np.inf
    least_transmission: float = 0.0
    largest_condition: float = 1.0 / RANK
    __post_init__ = check_fields(
        lower=real_array, upper=real_array, least_transmission=between(0.0, np.pi / 2), largest_condition=positive
    )


def rod_workspace(
    robot: RodRobot, lower: ArrayLike, upper: ArrayLike, *, limits: RodLimits | None = None, cells: int = 21,
    orientations: ArrayLike | None = None,
) -> PlatformWorkspace:  # fmt: skip
    """Where a platform on rods can be, at the middles of the cells of a box, with the first branch of every motor.

    Args:
        robot: its geometry.
        lower, upper: (3,) or, in a plane, (2,) corners of the box [m].
        limits: of motors, transmission and condition; only what rods reach if None.
        cells: along each side.
        orientations: (k, 3, 3) of the platform; the identity alone if None.
    """
    k, n = 2 if robot.is_flat else 3, whole("cells", cells, 1, 500)
    low, high = single("lower", lower, (k,)), single("upper", upper, (k,))
    if not (low < high).all():
        raise InputError("parallel.box", low=low.tolist(), high=high.tolist())
    R = rotation.check(np.eye(3)[None] if orientations is None else as_batch("orientations", orientations, (3, 3)))
    R = R.reshape(-1, 3, 3)
    steps, zero = (np.arange(n) + 0.5) / n, np.zeros(1)
    axes = [low[i] + (high[i] - low[i]) * steps if i < k else zero for i in range(3)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    asked, why = RodLimits() if limits is None else limits, np.zeros((len(R), len(places)), dtype=np.int8)
    for i, turn in enumerate(R):
        for first in range(0, len(places), BLOCK):
            T = np.tile(np.eye(4), (len(places[first : first + BLOCK]), 1, 1))
            T[:, :3, :3], T[:, :3, 3] = turn, places[first : first + BLOCK]
            why[i, first : first + BLOCK] = _refusals(robot, T, asked)
    shape = (len(R), *(len(axis) for axis in axes))
    reasons = {name: int((why == code).sum()) for code, name in enumerate(REASONS, start=1)}
    return PlatformWorkspace((axes[0], axes[1], axes[2]), np.asarray(why == 0).reshape(shape), reasons)


def _refusals(robot: RodRobot, T: Floats, limits: RodLimits) -> np.ndarray[tuple[int], np.dtype[np.int8]]:
    """(k,) number of the first reason against each pose (k, 4, 4), 0 if there is none."""
    found = robot.inverse_kinematics(T)
    q, reached = found.q[..., 0], found.reached
    low, high = (np.broadcast_to(np.asarray(v, dtype=np.float64), (robot.m,)) for v in (limits.lower, limits.upper))
    inside = ((q >= low) & (q <= high)).all(axis=-1)
    why = np.where(~reached, 1, np.where(~inside, 2, 0)).astype(np.int8)
    least, most = limits.least_transmission, limits.largest_condition
    on = np.flatnonzero(why == 0)
    if len(on):
        indices = rod_indices(robot, T[on], q[on])
        bad = np.where(indices.transmission.min(axis=(-1, -2)) < least, 3, np.where(indices.condition > most, 4, 0))
        why[on] = bad
    return why
