"""Parametric parallel robots on rods: Deltas, hexapods, Stewart platforms, five-bars, 3-RRR; tasks as those of arms.

    kind = "rotary_delta"                       # a name of KINDS

    [parameters]
    arm = { value = 0.3, low = 0.2, high = 0.5 }

    [geometry]                                  # what the maker of that kind takes, with formulas
    base = 0.2
    platform = 0.05
    arms = "arm"
    forearms = "2.4 * arm"

    [masses]                                    # of `RodMasses`, with formulas
    platform = 0.5
    arms = "2 * arm"

    [motors]
    effort = 30.0

Platforms move straight from pose to pose: every leg of a cycle is a fifth-degree motion of the platform from rest to
rest. With c = 1 / k_motor + 1 / (k_rod b^2), b = B of A V = B q', a load of efforts tau bends the platform by J c tau.

Reference: Merlet, Parallel Robots, 2nd ed., ch. 5, 9, 10.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, fields, replace
from inspect import signature
from os import PathLike
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Booleans, Floats, JointVector, PoseMatrix, real_array, spread
from mafsil.design.arm import ArmDesign, Family, ParametricArm, numbers_in, read_family, require_keys
from mafsil.design.tasks import IN_CYCLE, MEASURES, SAMPLES, Evaluation, TaskSet, evaluate_arm, measure_arms
from mafsil.errors import FileError, InputError
from mafsil.fields import check_fields, vector
from mafsil.floating_point import EPS
from mafsil.geometry import rotation
from mafsil.model.loading import RobotLike
from mafsil.parallel import RodRobot, StewartPlatform
from mafsil.parallel.legs.rod_dynamics import RodDynamics, RodMasses
from mafsil.parallel.legs.rod_indices import rod_indices
from mafsil.parallel.legs.rod_library import (
    as_rod_robot,
    five_bar_on_rods,
    h4,
    hexapod_on_rods,
    linear_delta,
    planar_on_rods,
    rotary_delta,
)


def stewart(base: float, platform: float, base_angles: ArrayLike, platform_angles: ArrayLike) -> RodRobot:
    """A Stewart platform with joints on two circles, as `StewartPlatform.on_circles`; its motors are its lengths."""
    return as_rod_robot(StewartPlatform.on_circles(base, platform, base_angles, platform_angles))


KINDS: dict[str, Callable[..., RodRobot]] = {
    "rotary_delta": rotary_delta, "linear_delta": linear_delta, "hexapod": hexapod_on_rods, "stewart": stewart,
    "five_bar": five_bar_on_rods, "planar": planar_on_rods, "h4": h4,
}  # fmt: skip
OUTSIDE: dict[str, Any] = {"rotary_delta": True, "h4": True, "five_bar": (False, True)}
"""Whether the second branch of the inverse kinematics is the elbow outside, as such robots are built."""
TABLES = ("geometry", "masses", "motors")


@dataclass(frozen=True, eq=False, slots=True)
class Motors:
    """What the motors and rods of a platform allow, one number for all or one for each.

    Attributes:
        lower, upper: of their coordinates [rad | m].
        effort: largest [N m | N].
        stiffness: of motor and gear, seen at the motor's coordinate; infinite for rigid ones [N m/rad | N/m].
        rod_stiffness: along the rods; infinite for rigid ones [N/m].
        second: whether the second branch of the inverse kinematics holds: the other elbow; as built if left out.
    """

    lower: ArrayLike = -np.inf
    upper: ArrayLike = np.inf
    effort: ArrayLike = np.inf
    stiffness: ArrayLike = np.inf
    rod_stiffness: ArrayLike = np.inf
    second: Any = False

    def __post_init__(self) -> None:
        for name in ("effort", "stiffness", "rod_stiffness"):
            value = real_array(name, getattr(self, name))
            if not (value > 0.0).all():
                raise InputError("input.positive", name=name, value=value.tolist())
        low, high = (real_array(name, getattr(self, name)) for name in ("lower", "upper"))
        if not (low <= high).all():
            raise InputError("input.range", name="lower", value=low.tolist(), low=-np.inf, high=high.tolist())


@dataclass(frozen=True, eq=False, slots=True)
class PlatformDesign:
    """One platform of a family.

    Attributes:
        robot: its geometry.
        values: of the parameters.
        masses: of its parts.
        motors: what they allow.
        gravity: (3,) in {s} [m/s^2].
    """

    robot: RodRobot
    values: Mapping[str, float] = field(default_factory=dict[str, float])
    masses: RodMasses = field(default_factory=lambda: RodMasses(0.0))
    motors: Motors = field(default_factory=Motors)
    gravity: ArrayLike = (0.0, 0.0, -9.81)
    __post_init__ = check_fields(gravity=vector(3))

    @property
    def effort(self) -> Floats:
        """(m,) largest efforts of the motors [N m | N]."""
        return spread("effort", self.motors.effort, (self.robot.m,), finite=False)

    @property
    def mass(self) -> float:
        """Of platform, rods and cranks [kg]."""
        m, parts = self.robot.m, self.masses
        return float(parts.platform + sum(spread(n, getattr(parts, n), (m,)).sum() for n in ("rods", "arms")))

    def loaded(self, payload: float, centre: ArrayLike) -> RodDynamics:
        """Its dynamics with a mass [kg] held at a place (3,) of the platform's frame [m]."""
        own = self.masses
        mass = own.platform + payload
        if not payload:
            return RodDynamics(self.robot, own, np.asarray(self.gravity, dtype=np.float64))
        d = np.asarray(centre, dtype=np.float64) - own.com
        # Of point masses an eigenvalue is zero, which rounding may not make negative.
        about = (1.0 + EPS) * (d @ d) * np.eye(3) - np.outer(d, d)
        masses = replace(
            own, platform=mass, com=own.com + payload / mass * d,
            inertia=own.inertia + own.platform * payload / mass * about,
        )  # fmt: skip
        return RodDynamics(self.robot, masses, np.asarray(self.gravity, dtype=np.float64))


@dataclass(frozen=True, eq=False)
class ParametricPlatform(Family):
    """A family of parallel robots on rods."""

    @classmethod
    def of(cls, source: Mapping[str, Any] | str | PathLike[str]) -> ParametricPlatform:
        """The platform of a TOML file (there under `platform`), or of the same keys in a dictionary.

        Raises:
            FileError: no such file, an unknown kind or key, a formula that is none.
            InputError: the numbers make no platform.
        """
        family = cls(*read_family(source, "platform"))
        require_keys(family.name, "platform", family.table, ("kind", "gravity", *TABLES), ("kind", "geometry"))
        if family.table["kind"] not in KINDS:
            raise FileError("design.no_kind", path=family.name, value=family.table["kind"], known=", ".join(KINDS))
        family.at()
        return family

    def at(self, **values: float) -> PlatformDesign:
        """The design with these values; the others have their usual ones.

        Raises:
            InputError: an unknown parameter, a value out of its bounds, numbers that make no platform.
        """
        chosen = self.choose(values)
        table = deepcopy(dict(self.table))
        geometry, masses, motors = (
            cast("dict[str, Any]", numbers_in(table.get(name, {}), chosen, self.name, name)) for name in TABLES
        )
        for name, given, kind in (("masses", masses, RodMasses), ("motors", motors, Motors)):
            require_keys(self.name, name, given, tuple(one.name for one in fields(kind)), ())
        kind, own = table["kind"], RodMasses(**cast("dict[str, Any]", {"platform": 0.0} | masses))
        known = signature(KINDS[kind]).parameters
        require_keys(
            self.name, "geometry", geometry, tuple(known),
            [name for name, one in known.items() if one.default is one.empty],
        )  # fmt: skip
        motors, gravity = {"second": OUTSIDE.get(kind, False)} | motors, table.get("gravity", (0.0, 0.0, -9.81))
        return PlatformDesign(KINDS[kind](**geometry), chosen, own, Motors(**motors), gravity)


def evaluate_platform(design: PlatformDesign, tasks: TaskSet) -> Evaluation:
    """How a platform does its tasks: closed forms of its inverse kinematics, its dynamics, rigid joints.

    Args:
        design: of a `ParametricPlatform`.
        tasks: what it shall do; without a scene, obstacles are not looked at.

    Raises:
        InputError: tasks with obstacles: links of platforms have no shapes.
    """
    if tasks.scene is not None:
        raise InputError("design.platform_scene")
    T, m = np.asarray(tasks.poses, dtype=np.float64), design.robot.m
    q, reached = _coordinates(design, T)
    P, at = len(T), np.flatnonzero(reached)
    gains, torque, held, bent, lowest = (
        np.full(shape, np.nan) for shape in ((P, 2), (P, m), (P,), (P,), (P,))
    )  # fmt: skip
    if len(at):
        indices = rod_indices(design.robot, T[at], q[at], length=tasks.characteristic_length)
        J, turns = indices.jacobian, design.robot.motion.angles
        weights = np.ones(m)
        weights[:turns] = tasks.characteristic_length or 1.0
        rows = J * weights[:, None]
        values = np.linalg.svd(rows if tasks.characteristic_length or not turns else rows[:, turns:], compute_uv=False)
        gains[at] = values[:, [-1, 0]]
        regular = at[np.isfinite(indices.condition)]
        J, x, u = J[np.isfinite(indices.condition)], T[regular], q[regular]
        loaded, rest = design.loaded(tasks.payload, tasks.centre), np.zeros((len(u), m))
        torque[regular] = loaded.inverse_dynamics(x, u, rest, rest)
        held[regular] = _capacity(design, tasks, x, u)
        gives = _compliance(design, x, u)
        bent[regular] = np.linalg.norm((J @ (gives * torque[regular])[..., None])[:, turns:, 0], axis=1)
        lowest[regular] = _lowest_frequency(loaded, x, u, gives)
        torque[at[~np.isin(at, regular)]] = np.inf
    peak, rms, speed, energy = _cycle(design, tasks, bool(reached.all()))
    return Evaluation(
        design, q, reached, np.zeros(P, dtype=np.bool_), gains, torque, held, bent, lowest, peak, rms, speed, energy,
        float("nan"), float("nan"),
    )  # fmt: skip


def _coordinates(design: PlatformDesign, T: PoseMatrix) -> tuple[JointVector, Booleans]:
    """(P, m) coordinates of the motors at poses, NaN where rods or motors do not allow them; and (P,) whether."""
    found, motors, m = design.robot.inverse_kinematics(T), design.motors, design.robot.m
    second = np.broadcast_to(np.asarray(motors.second, dtype=np.bool_), (m,))
    q = np.where(second, found.q[..., 1], found.q[..., 0])
    lower, upper = (
        np.broadcast_to(np.asarray(bound, dtype=np.float64), (m,)) for bound in (motors.lower, motors.upper)
    )
    reached: Booleans = np.asarray(found.reached & ((q >= lower) & (q <= upper)).all(axis=-1))
    return np.where(reached[:, None], q, np.nan), reached


def _capacity(design: PlatformDesign, tasks: TaskSet, T: PoseMatrix, q: JointVector) -> Floats:
    """(P,) the largest mass that the efforts hold still; zero where the own weight exceeds them [kg]."""
    rest = np.zeros(q.shape)
    own, more = (design.loaded(mass, tasks.centre).inverse_dynamics(T, q, rest, rest) for mass in (0.0, 1.0))
    room = design.effort - np.sign(more - own) * own
    each = np.divide(room, np.abs(more - own), out=np.full(own.shape, np.inf), where=more != own)
    return np.where((np.abs(own) > design.effort).any(axis=1), 0.0, np.maximum(each.min(axis=1), 0.0))


def _compliance(design: PlatformDesign, T: PoseMatrix, q: JointVector) -> Floats:
    """(P, m) motion of each motor's coordinate per effort, of its own gear and of its rod [rad/N m | m/N]."""
    b = np.einsum("...ii->...i", design.robot.motor_matrices(T, q)[1])
    motor, rod = (real_array(name, getattr(design.motors, name)) for name in ("stiffness", "rod_stiffness"))
    return 1.0 / motor + 1.0 / (rod * b**2)


def _lowest_frequency(loaded: RodDynamics, T: PoseMatrix, q: JointVector, gives: Floats) -> Floats:
    """(P,) lowest natural frequency with motors held; infinite of rigid robots and of those without masses [Hz]."""
    J = loaded.robot.jacobian(T, q)
    M = np.swapaxes(J, -1, -2) @ loaded.mass_matrix(T, q) @ J
    root = np.sqrt(gives)
    # C^(1/2) M C^(1/2) has the eigenvalues 1 / omega^2 of M q'' + C^-1 q = 0.
    slow = np.linalg.eigvalsh(root[..., :, None] * M * root[..., None, :])[..., -1]
    return np.divide(1.0, 2 * np.pi * np.sqrt(np.maximum(slow, 0.0)), out=np.full(slow.shape, np.inf), where=slow > 0.0)


def _cycle(design: PlatformDesign, tasks: TaskSet, reached: bool) -> tuple[Floats, Floats, Floats, float]:
    """Peak and rms efforts and largest rates (m,) of the motors, and work of the cycle; NaN if the way is not free."""
    nothing = np.full(design.robot.m, np.nan)
    if tasks.period is None or not reached:
        return nothing, nothing, nothing, float("nan")
    T, twist, change = platform_motion(np.asarray(tasks.poses, dtype=np.float64), tasks.period)
    q, inside = _coordinates(design, T)
    columns, loaded = design.robot.motion.columns, design.loaded(tasks.payload, tasks.centre)
    if not inside.all() or not rod_indices(design.robot, T, q):
        return nothing, nothing, nothing, float("nan")
    V, Vd = twist[:, columns], change[:, columns]
    tau = loaded.inverse_dynamics(T, q, V, Vd)
    rate, _ = loaded.motor_accelerations(T, q, V, Vd)
    work = float(np.maximum(tau * rate, 0.0).mean(axis=0).sum() * tasks.period)
    return np.abs(tau).max(axis=0), np.sqrt((tau**2).mean(axis=0)), np.abs(rate).max(axis=0), work


def platform_motion(poses: PoseMatrix, period: float) -> tuple[PoseMatrix, Floats, Floats]:
    """Poses, space twists (omega, v) and their derivatives of a cycle: straight from pose to pose, about one axis each.

    Args:
        poses: (P, 4, 4) in order.
        period: of the whole cycle, the way back to the first included [s].
    """
    u = ((np.arange(SAMPLES) + 0.5) / SAMPLES)[:, None]
    leg, after = period / len(poses), np.roll(poses, -1, axis=0)
    s, rate = 10 * u**3 - 15 * u**4 + 6 * u**5, (30 * u**2 - 60 * u**3 + 30 * u**4) / leg
    change = (60 * u - 180 * u**2 + 120 * u**3) / leg**2
    turn = rotation.log(np.swapaxes(poses[:, :3, :3], -1, -2) @ after[:, :3, :3])[:, None]
    axis, way = turn @ np.swapaxes(poses[:, :3, :3], -1, -2), (after - poses)[:, None, :3, 3]
    T = np.tile(np.eye(4), (len(poses), SAMPLES, 1, 1))
    T[..., :3, :3] = poses[:, None, :3, :3] @ rotation.exp(s * turn)
    T[..., :3, 3] = poses[:, None, :3, 3] + s * way
    omega, alpha, v, a, p = rate * axis, change * axis, rate * way, change * way, T[..., :3, 3]
    twist = np.concatenate([omega, v + np.cross(p, omega)], axis=-1)
    twist_rate = np.concatenate([alpha, a + np.cross(v, omega) + np.cross(p, alpha)], axis=-1)
    return T.reshape(-1, 4, 4), twist.reshape(-1, 6), twist_rate.reshape(-1, 6)


def evaluate(
    design: ArmDesign | PlatformDesign | RobotLike, tasks: TaskSet, *, q0: ArrayLike | None = None, seed: int = 0
) -> Evaluation:
    """How a design does its tasks, by the whole model.

    Args:
        design: of a `ParametricArm` or `ParametricPlatform`; or any robot, whose links and gears are rigid then.
        tasks: what it shall do.
        q0: (P, n) configurations to start the inverse kinematics of an arm from; NaN where there is none.
        seed: of its other starts; platforms need none.

    Raises:
        InputError: no serial chain, numbers out of range, obstacles for a platform.
    """
    if isinstance(design, PlatformDesign):
        return evaluate_platform(design, tasks)
    return evaluate_arm(design, tasks, q0=q0, seed=seed)


def measure_designs(
    designs: Sequence[ArmDesign] | Sequence[PlatformDesign],
    tasks: TaskSet,
    names: Sequence[str],
    *,
    seed: int = 0,
    starts: int = 1,
) -> tuple[dict[str, Floats], JointVector]:
    """Measures of many designs of one family: arms by the kernels of the family, platforms one by one.

    Args:
        designs: S of them.
        tasks: what they shall do; obstacles are left to `evaluate`.
        names: of `MEASURES`, but `payload`, which is that of single arms.
        seed: of the starts; equal seeds give equal results.
        starts: of the inverse kinematics of an arm for every pose; the best conditioned configuration is kept.

    Returns:
        (S,) each, NaN where poses are missed and the measure means nothing then; and (S, P, n) configurations, NaN
        where none was found.

    Raises:
        InputError: an unknown measure.
    """
    platforms = [one for one in designs if isinstance(one, PlatformDesign)]
    require_measures(names, ParametricPlatform if platforms else ParametricArm, "measure")
    if not platforms:
        arms = [one for one in designs if isinstance(one, ArmDesign)]
        return measure_arms(arms, tasks, names, seed=seed, starts=starts)
    still = tasks if set(IN_CYCLE) & set(names) else replace(tasks, period=None)
    judged = [evaluate_platform(one, still) for one in platforms]
    hollow = np.array([1.0 if one.reached.all() else np.nan for one in judged])
    whole_family = ("reached", "mass")
    found = {
        name: np.array([one.measures[name] for one in judged]) * (1.0 if name in whole_family else hollow)
        for name in names
    }
    return found, np.array([one.q for one in judged])


def require_measures(names: Iterable[str], family: type[Family], argument: str) -> None:
    """Refuse what a search cannot measure: the payload of arms, extents of platforms.

    Args:
        names: of measures.
        family: what is searched.
        argument: which has them, for the error.

    Raises:
        InputError: such a name, or an unknown one.
    """
    without = ("reach", "void") if issubclass(family, ParametricPlatform) else ("payload",)
    known = [name for name in MEASURES if name not in without]
    for name in names:
        if name not in known:
            raise InputError("input.choice", name=argument, value=name, known=", ".join(known))
