"""Equilibrium link by link: the wrench that every joint passes on in an arm at rest.

Forces and couples on any links of an arm: virtual work, holding efforts, equilibrium of arms and linkages.

The free body of one link: every wrench on it while the arm moves, and that together they change its momentum.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, PoseMatrix, Vector3, Vector6, as_batch, not_negative, single
from mafsil.errors import InputError
from mafsil.fields import check_fields, vector
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import wrench
from mafsil.mechanics.rigid_body import RigidBody
from mafsil.messages import say
from mafsil.model.joint import polynomial
from mafsil.model.link import Inertial
from mafsil.model.loading import RobotLike
from mafsil.performance.velocity.jacobians import tool_jacobian
from mafsil.performance.velocity.scaling import TOLERANCE, require_one
from mafsil.robot import Robot, as_robot, of_robot


@dataclass(frozen=True, eq=False)
class JointReactions:
    """What each joint of the tree, fixed ones included, passes from its parent link to its child link.

    Attributes:
        joints: names, in the order of `mechanism.joints`.
        about_origin: (*batch, k, 6) wrenches (m, f) on the child, moments about the origin of {s}, axes of {s}.
        at_joint: (*batch, k, 6) the same with moments about the joint frame's origin.
        torque: (*batch, n) their parts along the joint axes: the efforts that hold the arm.
    """

    joints: tuple[str, ...]
    about_origin: Floats
    at_joint: Floats
    torque: JointVector


@of_robot
def joint_reactions(
    robot: Robot, q: ArrayLike, tip_wrench: ArrayLike | None = None, *, loads: Sequence[LinkLoad] = ()
) -> JointReactions:
    """Joint reaction wrenches of a static arm under gravity, loads on its links and a wrench at the tip.

    For every link: reaction of its own joint = reactions it passes on - its weight - its loads (+ what the tip exerts).

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        tip_wrench: (*batch, 6) wrench the tip exerts on the world, in the tip frame [N m, N]; none if None.
        loads: acting on links.
    """
    mechanism = robot.mechanism
    poses = robot.link_poses(q)
    net = [-weight for weight in link_weights(robot, q)]
    for load in loads:
        k = _link_index(mechanism.link_names, load.link)
        net[k] = net[k] - load.about_origin(poses[..., k, :, :])
    if tip_wrench is not None:
        T_ts = np.linalg.inv(robot.forward_kinematics(q))
        tip = mechanism.link_names.index(mechanism.tip)
        net[tip] = net[tip] + wrench.transform(T_ts, tip_wrench)
    for k in reversed(range(len(mechanism.joints))):
        parent = mechanism.parents[k]
        net[parent] = net[parent] + net[k + 1]
    batch = np.broadcast_shapes(*(wrenches.shape for wrenches in net))
    about_origin = np.stack([np.broadcast_to(wrenches, batch) for wrenches in net[1:]], axis=-2)
    points = poses[..., 1:, :3, 3]
    at_joint = about_origin.copy()
    at_joint[..., :3] -= np.cross(points, about_origin[..., 3:])
    return JointReactions(
        tuple(joint.name for joint in mechanism.joints), about_origin, at_joint, _along(robot, q, poses, at_joint)
    )


def _link_index(names: Sequence[str], link: str) -> int:
    if link not in names:
        raise InputError("input.choice", name="link", value=link, known=", ".join(names))
    return list(names).index(link)


@of_robot
def link_weights(robot: Robot, q: ArrayLike) -> list[Floats]:
    """For each link the wrench (*batch, 6) of its weight, moments about the origin of {s}, axes of {s}."""
    mechanism = robot.mechanism
    poses = robot.link_poses(q)
    weights: list[Floats] = []
    for k, link in enumerate(mechanism.links):
        mass, com = (0.0, np.zeros(3)) if link.inertial is None else (link.inertial.mass, link.inertial.com)
        T = poses[..., k, :, :]
        at = T[..., :3, 3] + T[..., :3, :3] @ com
        force = np.broadcast_to(mass * mechanism.gravity, at.shape)
        weights.append(wrench.from_force(np.ascontiguousarray(at), np.ascontiguousarray(force)))
    return weights


@of_robot
def unbalanced_links(robot: Robot, q: ArrayLike, reactions: ArrayLike, tip_wrench: ArrayLike | None = None) -> Floats:
    """(*batch, L - 1, 6) net wrench on every moving link: zero everywhere if the reactions hold the arm.

    The free-body check of given reactions, one sum for each link, all moments about the origin of {s}.

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        reactions: (*batch, k, 6) as `JointReactions.about_origin`.
        tip_wrench: (*batch, 6) wrench the tip exerts on the world, in the tip frame; none if None.
    """
    mechanism = robot.mechanism
    passed = as_batch("reactions", reactions, (len(mechanism.joints), 6))
    net = [passed[..., k, :] + w for k, w in enumerate(link_weights(robot, q)[1:])]
    for k, parent in enumerate(mechanism.parents):
        if parent:
            net[parent - 1] = net[parent - 1] - passed[..., k, :]
    tip = mechanism.link_names.index(mechanism.tip)
    if tip_wrench is not None and tip:
        net[tip - 1] = net[tip - 1] - wrench.transform(np.linalg.inv(robot.forward_kinematics(q)), tip_wrench)
    return np.stack(net, axis=-2)


def _along(robot: Robot, q: ArrayLike, poses: Floats, at_joint: Floats) -> JointVector:
    """Power of each reaction on its joint's screw, summed for joints that follow a coordinate."""
    mechanism = robot.mechanism
    index = {name: i for i, name in enumerate(robot.joint_names)}
    torque = np.zeros((*at_joint.shape[:-2], robot.n))
    for k, joint in enumerate(mechanism.joints):
        if not joint.moves:
            continue
        R = poses[..., k + 1, :3, :3]
        screw = np.concatenate([R @ joint.screw[:3], R @ joint.screw[3:]], axis=-1)
        leader = index[joint.name if joint.mimic is None else joint.mimic.leader]
        factor = 1.0 if joint.mimic is None else polynomial(joint.mimic.curve(1), np.asarray(q)[..., leader])
        torque[..., leader] += factor * (screw * at_joint[..., k, :]).sum(axis=-1)
    return torque


@dataclass(frozen=True, eq=False)
class LinkLoad:
    """A force at a point of a link and a couple, acting ON the link.

    Attributes:
        link: its name.
        force: (3,) [N].
        moment: (3,) couple [N m].
        point: (3,) where the force acts, in the link's frame [m].
        axes: in whose axes force and moment are given: `space` or `link`.
    """

    link: str
    force: ArrayLike = (0.0, 0.0, 0.0)
    moment: ArrayLike = (0.0, 0.0, 0.0)
    point: ArrayLike = (0.0, 0.0, 0.0)
    axes: Literal["space", "link"] = field(default="space")
    __post_init__ = check_fields(force=vector(3), moment=vector(3), point=vector(3))

    def in_space(self, T_sl: Floats) -> tuple[Vector3, Vector3]:
        """(*batch, 3) moment and force in the axes of {s}, the link's frame being T_sl (*batch, 4, 4)."""
        m, f = single("moment", self.moment, (3,)), single("force", self.force, (3,))
        if self.axes == "link":
            return T_sl[..., :3, :3] @ m, T_sl[..., :3, :3] @ f
        if self.axes != "space":
            raise InputError("input.choice", name="axes", value=self.axes, known="space, link")
        return np.broadcast_to(m, T_sl[..., :3, 3].shape), np.broadcast_to(f, T_sl[..., :3, 3].shape)

    def about_origin(self, T_sl: Floats) -> Vector6:
        """(*batch, 6) wrench (m, f) about the origin of {s}, in its axes."""
        m, f = self.in_space(T_sl)
        at = T_sl[..., :3, 3] + T_sl[..., :3, :3] @ single("point", self.point, (3,))
        F = np.array(wrench.from_force(np.ascontiguousarray(at), np.ascontiguousarray(f)))
        F[..., :3] += m
        return F


def generalized_force(robot: RobotLike, q: ArrayLike, loads: Sequence[LinkLoad]) -> JointVector:
    """Q = sum of J_k' F_k: what loads on links do for each joint coordinate, by virtual work.

    Args:
        robot: the arm, its mechanism, name or path.
        q: (*batch, n) joint coordinates [rad | m].
        loads: on any links.

    Returns:
        (*batch, n) [N m | N]; the joints hold the loads with tau = -Q, gravity left aside.
    """
    robot = as_robot(robot)
    total = np.zeros_like(as_batch("q", q, (robot.n,)))
    for load in loads:
        J = tool_jacobian(robot, q, frame=load.link, point=single("point", load.point, (3,)))
        m, f = load.in_space(robot.forward_kinematics(q, frame=load.link))
        total = total + np.einsum("...ij,...i->...j", J, np.concatenate([m, f], axis=-1))
    return total


def holding_torque(robot: RobotLike, q: ArrayLike, loads: Sequence[LinkLoad], *, gravity: bool = False) -> JointVector:
    """(*batch, n) efforts that hold the arm against loads on its links: tau = -Q.

    Args:
        robot: the arm, its mechanism, name or path.
        q: (*batch, n) joint coordinates [rad | m].
        loads: on any links.
        gravity: whether the arm's own weight is carried too.
    """
    robot = as_robot(robot)
    gravity_efforts = robot.gravity_torque(q) if gravity else 0.0
    return gravity_efforts - generalized_force(robot, q, loads)


class EquilibriumStatus(Status):
    """Whether loads do no work in any motion that the constraints allow."""

    EQUILIBRIUM = ("performance.equilibrium", True)
    NO_EQUILIBRIUM = ("performance.no_equilibrium", False)


@dataclass(frozen=True, eq=False, repr=False)
class VirtualWork(Answer, data="rates work"):
    """Whether a system of bodies is in equilibrium: its loads do no work in any motion that its constraints allow.

    Attributes:
        rates: (k, n) independent joint rates that the constraints allow.
        work: (k,) power of loads and efforts in each of them [W].
        tolerance: largest power, over the sum of sizes, that counts as none.
        size: sum of the sizes that cancel.
    """

    rates: Floats
    work: Floats
    tolerance: float
    size: float

    @property
    def status(self) -> EquilibriumStatus:
        """Equilibrium, if the largest power is none beside the sizes that cancel."""
        balanced = np.abs(self.work).max(initial=0.0) <= self.tolerance * max(self.size, LEAST_DIVISOR)
        return EquilibriumStatus.EQUILIBRIUM if balanced else EquilibriumStatus.NO_EQUILIBRIUM

    def explain(self, language: str | None = None) -> str:
        """Whether it is in equilibrium, and the largest power."""
        power = float(np.abs(self.work).max(initial=0.0))
        return self.status.sentence(language, power=power, motions=len(self.rates))


def virtual_work(
    robot: RobotLike,
    q: ArrayLike,
    loads: Sequence[LinkLoad] = (),
    tau: ArrayLike | None = None,
    *,
    constraint: ArrayLike | None = None,
    gravity: bool = False,
    tolerance: float = 1e-9,
) -> VirtualWork:
    """The principle of virtual work: N' (Q + tau) = 0 for all rates N that the constraints allow.

    Args:
        robot: the arm, or the open chain of a linkage.
        q: (n,) joint coordinates at which the constraints hold [rad | m].
        loads: on any links.
        tau: (n,) joint efforts; none if None.
        constraint: (k, n) matrix A of loop constraints A qd = 0, such as the rows of `task_jacobian` that a pin holds;
            none if None.
        gravity: whether weights are loads too.
        tolerance: of the sum, relative to the sizes of its terms.
    """
    tolerance = not_negative("tolerance", tolerance)
    robot = as_robot(robot)
    configuration = require_one("q", q, robot.n)
    terms = [generalized_force(robot, configuration, [load]) for load in loads]
    terms.append(np.zeros(robot.n) if tau is None else single("tau", tau, (robot.n,)))
    if gravity:
        terms.append(-robot.gravity_torque(configuration))
    A = np.zeros((0, robot.n)) if constraint is None else np.atleast_2d(as_batch("constraint", constraint, (robot.n,)))
    if len(A):
        _, s, Vt = np.linalg.svd(A)
        rates = Vt[int((s > TOLERANCE * max(float(s[0]), LEAST_DIVISOR)).sum()) :]
    else:
        rates = np.eye(robot.n)
    size = float(sum(np.abs(term).sum() for term in terms))
    return VirtualWork(rates, rates @ np.sum(terms, axis=0), tolerance, size)


@dataclass(frozen=True, eq=False)
class FreeBodyDiagram:
    """The free-body diagram of a link: wrenches (m, f) about the origin of its frame, in its axes [N m, N].

    Attributes:
        link: name.
        names: (k) of what acts: the joint from its parent, joints to its children, its weight, the world at the tip.
        wrenches: (k, 6) on the link, in the order of the names.
        momentum_rate: (6,) G dV - [ad_V]' G V, what the wrenches add up to.
    """

    link: str
    names: tuple[str, ...]
    wrenches: Floats
    momentum_rate: Vector6

    @property
    def residual(self) -> float:
        """Largest part of the sum that the momentum does not account for [N m | N]: rounding."""
        return float(np.abs(self.wrenches.sum(axis=0) - self.momentum_rate).max())

    def explain(self, language: str | None = None) -> str:
        """A table: one line for each wrench, then their sum and the change of momentum."""
        rows = [*zip(self.names, self.wrenches, strict=True)]
        rows.append((say("performance.free_body_sum", language=language), self.wrenches.sum(axis=0)))
        rows.append((say("performance.free_body_momentum", language=language), self.momentum_rate))
        width = max(len(name) for name, _ in rows)
        title = say("performance.free_body_title", language=language, link=self.link)
        body = [f"{name:<{width}}" + "".join(f"{x:12.5f}" for x in values + 0.0) for name, values in rows]
        head = " " * width + "".join(f"{name:>12}" for name in ("m_x", "m_y", "m_z", "f_x", "f_y", "f_z"))
        return "\n".join([title, head, *body])


def free_body_diagram(
    robot: RobotLike,
    link: str,
    q: ArrayLike,
    qd: ArrayLike | None = None,
    qdd: ArrayLike | None = None,
    tip_wrench: ArrayLike | None = None,
) -> FreeBodyDiagram:
    """The free-body diagram of a link as a table.

    Args:
        robot: the arm.
        link: name of one of its links other than the base.
        q, qd, qdd: (n,) motion [rad | m] and time derivatives; at rest if None.
        tip_wrench: (6,) wrench (m, f) the tip exerts on the world, in the tip frame [N m, N]; none if None.

    Raises:
        ModelError: no such link.
        InputError: a wrong shape or a number that is not finite.

    Reference: Lynch & Park, Modern Robotics, sec. 8.3 and fig. 8.6.
    """
    arm = as_robot(robot)
    mechanism, zero = arm.mechanism, np.zeros(arm.n)
    body = mechanism.link(link).inertial or Inertial(0.0, np.zeros(3), np.zeros((3, 3)))
    index = mechanism.link_names.index(link)
    u = as_batch("q", q, (arm.n,), finite=True)
    v = zero if qd is None else as_batch("qd", qd, (arm.n,), finite=True)
    a = zero if qdd is None else as_batch("qdd", qdd, (arm.n,), finite=True)
    F_tip = np.zeros(6) if tip_wrench is None else as_batch("tip_wrench", tip_wrench, (6,), finite=True)
    passed, poses = arm.link_wrenches(u, v, a, F_tip), arm.link_poses(u)
    T_sl: PoseMatrix = poses[index]
    T_ls = np.linalg.inv(T_sl)
    acting: list[tuple[str, Vector6]] = []
    for k, joint in enumerate(mechanism.joints):
        if joint.child == link:
            acting.append((joint.name, passed[k + 1]))
        elif joint.parent == link:
            T_link_child: PoseMatrix = T_ls @ poses[k + 1]
            T_child_link = np.linalg.inv(T_link_child)
            acting.append((joint.name, -wrench.transform(T_child_link, passed[k + 1])))
    down = T_ls[:3, :3] @ mechanism.gravity
    acting.append((say("performance.free_body_weight"), wrench.from_force(body.com, body.mass * down)))
    if mechanism.tip == link and F_tip.any():
        T_tip_link = np.linalg.inv(mechanism.T_lt)
        acting.append((say("performance.free_body_world"), -wrench.transform(T_tip_link, F_tip)))
    V, dV = arm.link_twists(u, v)[index], arm.link_accelerations(u, v, a)[index]
    return FreeBodyDiagram(
        link, tuple(name for name, _ in acting), np.array([F for _, F in acting]), RigidBody(body).wrench(V, dV)
    )
