"""The free body of one link: every wrench on it while the arm moves, and that together they change its momentum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector6, as_batch
from mafsil.geometry import wrench
from mafsil.mechanics.rigid_body import RigidBody
from mafsil.messages import say
from mafsil.model.link import Inertial
from mafsil.model.loading import RobotLike
from mafsil.robot import as_robot


@dataclass(frozen=True, eq=False)
class FreeBodyDiagram:
    """What acts on a link, all as wrenches (m, f) about the origin of the link's frame, in its axes [N m, N].

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
