"""What a tip touches: springs, dampers, compliant walls; the wrench that they exert on it.

Virtual walls and fixtures: an arm that lets the hand feel what is not there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import (
    Floats,
    JointVector,
    PoseMatrix,
    Vector3,
    Vector6,
    as_batch,
    not_negative,
    positive,
    real_array,
    require_finite,
    require_kind,
    single,
)
from mafsil.control.laws.law import Law
from mafsil.errors import InputError
from mafsil.fields import check_fields
from mafsil.lazy_module import lazily
from mafsil.model.loading import RobotLike
from mafsil.robot import Robot, as_open_tree, of_robot
from mafsil.trajectory import Motion

if TYPE_CHECKING:
    import mafsil.robot.closed_states as closed_states
else:
    closed_states = lazily("mafsil.robot.closed_states")


@runtime_checkable
class Environment(Protocol):
    """Maps the state of a tip to the wrench on it."""

    def wrench(self, T: PoseMatrix, V: Vector6) -> Vector6:
        """(*batch, 6) wrench (m, f) that the world exerts on the tip, in the tip frame [N m, N].

        Args:
            T: (*batch, 4, 4) pose of the tip in {s}.
            V: (*batch, 6) body twist.
        """
        ...


@dataclass(frozen=True, eq=False, slots=True)
class Wall:
    """A plane that gives way as spring and damper and never pulls: f = max(0, k d - b d') along its normal, d > 0 deep.

    Tangential friction opposes sliding with mu times the normal force, rounded off below `slow`.

    Attributes:
        point, normal: (3,) on the plane, and out of it towards the arm; in {s} [m, 1].
        stiffness, damping: k [N/m] and b [N s/m].
        friction: mu.
        slow: speed of sliding below which friction falls off [m/s].
    """

    point: Vector3
    normal: Vector3
    stiffness: float
    damping: float = 0.0
    friction: float = 0.0
    slow: float = 1e-3
    _numbers = check_fields(stiffness=positive, damping=not_negative, friction=not_negative, slow=positive)

    def __post_init__(self) -> None:
        self._numbers()
        point, normal = single("point", self.point, (3,)), single("normal", self.normal, (3,))
        length = float(np.linalg.norm(normal))
        if not length:
            raise InputError("control.no_normal")
        object.__setattr__(self, "point", point)
        object.__setattr__(self, "normal", normal / length)

    def depth(self, T: PoseMatrix) -> Floats:
        """(*batch,) how deep the tip's origin is in the wall [m]; negative before it.

        Args:
            T: (*batch, 4, 4) pose of the tip in {s}.
        """
        return -((T[..., :3, 3] - self.point) @ self.normal)

    def wrench(self, T: PoseMatrix, V: Vector6) -> Vector6:
        """(*batch, 6) on the tip, in the tip frame [N m, N].

        Args:
            T: (*batch, 4, 4) pose of the tip in {s}.
            V: (*batch, 6) body twist.
        """
        R = T[..., :3, :3]
        velocity = (R @ V[..., 3:, None])[..., 0]
        constants = (self.stiffness, self.damping, self.friction, self.slow)
        return _at_tip(R, surface_force(self.depth(T), self.normal, velocity, *constants))


@dataclass(frozen=True, eq=False, slots=True)
class SpringDamper:
    """A spring and a damper between the tip's origin and a place: f = K (place - p) - B dp/dt in {s}.

    Attributes:
        place: (3,) [m].
        stiffness, damping: a number, (3,) along the axes of {s}, or (3, 3) [N/m, N s/m].
    """

    place: Vector3
    stiffness: ArrayLike = 0.0
    damping: ArrayLike = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "place", single("place", self.place, (3,)))
        for name in ("stiffness", "damping"):
            object.__setattr__(self, name, _square(name, getattr(self, name)))

    def wrench(self, T: PoseMatrix, V: Vector6) -> Vector6:
        """(*batch, 6) on the tip, in the tip frame [N m, N].

        Args:
            T: (*batch, 4, 4) pose of the tip in {s}.
            V: (*batch, 6) body twist.
        """
        R = T[..., :3, :3]
        velocity = (R @ V[..., 3:, None])[..., 0]
        K, B = np.asarray(self.stiffness), np.asarray(self.damping)
        return _at_tip(R, (self.place - T[..., :3, 3]) @ K.T - velocity @ B.T)


@dataclass(frozen=True, eq=False, slots=True)
class CombinedEnvironment:
    """Several environments at once; their wrenches add up.

    Attributes:
        parts: walls, springs, or any environments.
    """

    parts: tuple[Environment, ...]

    def wrench(self, T: PoseMatrix, V: Vector6) -> Vector6:
        """(*batch, 6) on the tip, in the tip frame [N m, N]."""
        still: Vector6 = np.zeros((*np.broadcast_shapes(T.shape[:-2], V.shape[:-1]), 6))
        return sum((part.wrench(T, V) for part in self.parts), still)


def tip_wrench_of(robot: RobotLike, environment: Environment, q: JointVector, qd: JointVector) -> Vector6:
    """(*batch, 6) wrench that an environment exerts on a robot's tip, in the tip frame: what an ideal sensor reads.

    Args:
        robot: whose tip it is.
        environment: what it touches.
        q, qd: (*batch, n) state; of a robot with loops one with closed loops.
    """
    require_kind("environment", environment, "Environment", "wrench")
    arm = as_open_tree(robot)
    if arm.mechanism.loops and arm is not robot:
        closed_states.require_closed(arm.mechanism, q, qd)
    V = (arm.jacobian_body(q) @ as_batch("qd", qd, (arm.n,))[..., None])[..., 0]
    return environment.wrench(arm.forward_kinematics(q), V)


def surface_force(
    depth: Floats, outward: Vector3, velocity: Vector3, stiffness: float, damping: float, friction: float, slow: float
) -> Vector3:
    """(*batch, 3) force in {s} of a surface that gives way and never pulls, with friction that opposes sliding.

    Args:
        depth: (*batch,) in the surface [m].
        outward: (3,) or (*batch, 3) normal.
        velocity: (*batch, 3) of the point [m/s].
        stiffness, damping, friction: as `Wall`.
        slow: speed of sliding below which friction falls off [m/s].
    """
    away = (velocity * outward).sum(axis=-1)
    push = np.where(depth > 0.0, np.maximum(stiffness * depth - damping * away, 0.0), 0.0)
    force = push[..., None] * outward
    if friction:
        sliding = velocity - away[..., None] * outward
        speed = np.linalg.norm(sliding, axis=-1)
        force = force - (friction * push / np.maximum(speed, slow))[..., None] * sliding
    return force


def _at_tip(R: Floats, force: Floats) -> Vector6:
    """A force in {s} through the tip's origin, as a wrench in the tip frame."""
    turned = (np.swapaxes(R, -1, -2) @ force[..., None])[..., 0]
    return np.concatenate([np.zeros_like(turned), turned], axis=-1)


def _square(name: str, value: ArrayLike) -> Floats:
    """(3, 3) from a number, a diagonal or a matrix."""
    array = require_finite(name, real_array(name, value))
    if array.shape == (3, 3):
        return array
    if array.shape not in ((), (3,)):
        raise InputError("input.shape", name=name, expected=(3, 3), got=array.shape, hint="")
    return np.diag(np.broadcast_to(array, (3,)))


@dataclass(frozen=True, eq=False, slots=True)
class VirtualEnvironment:
    """tau = g(q) + J' F: the arm weighs nothing, and its tip feels the wrench F of an environment that is not there.

    Attributes:
        robot: the model.
        environment: what is felt.
    """

    robot: Robot
    environment: Environment

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        wrench = tip_wrench_of(self.robot, self.environment, q, qd)
        J = self.robot.jacobian_body(q)
        return self.robot.gravity_torque(q) + (wrench[..., None, :] @ J)[..., 0, :]

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


@of_robot
def virtual_environment(robot: Robot, environment: Environment) -> VirtualEnvironment:
    """The law of a haptic arm: a wall that must not be entered, a guide that leads the hand, anything with a wrench.

    A sampled arm renders walls up to k = 2 b / T only, b being what damps the hand: `stiffest_wall` and
    `sampled_wall_radius` say what is stable.

    Args:
        robot: the model.
        environment: what is felt.

    Raises:
        InputError: an environment without a wrench.
    """
    require_kind("environment", environment, "Environment", "wrench")
    return VirtualEnvironment(robot, environment)
