"""Pinocchio's numbers for a mechanism, built joint by joint in its memory; imported only when it is asked for.

Accelerations of joints that follow others, from a peer's own mass matrix and bias, for it knows no coupling.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.mechanics.quantity import States
from mafsil.mechanics.textbook import Textbook
from mafsil.model import JointKind, Mechanism

OURS = [3, 4, 5, 0, 1, 2]
"""Rows (v, omega) of Pinocchio in our order."""
LEFT_OUT = ("link_twists", "link_wrenches", "regressor", "task_space")


def answers(mechanism: Mechanism, s: States) -> tuple[dict[str, Floats], list[tuple[str, str]]]:
    """Arrays by routine at all states, and what was not compared.

    Args:
        mechanism: any open chain or tree.
        s: states.
    """
    if any(joint.mimic is not None and joint.mimic.higher for joint in mechanism.joints):
        return {}, [("pinocchio", "verification.curved")]
    peer = _Pinocchio(mechanism)
    rows = [peer.state(s.q[k], s.qd[k], s.qdd[k], s.tau[k]) for k in range(len(s.q))]
    found = {name: np.stack([row[name] for row in rows]) for name in rows[0]}
    return found, [(f"{name}, pinocchio", "verification.not_compared") for name in LEFT_OUT]


class _Pinocchio:
    """The model, and the matrix from our coordinates to its joints."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.pin: Any = import_module("pinocchio")
        book = Textbook(mechanism)
        moving = [k for k, joint in enumerate(mechanism.joints) if joint.moves]
        self.B, self.b = book.share[moving], book.offset[moving]
        self.follows = any(joint.mimic is not None for joint in mechanism.joints)
        self.model = self.pin.Model()
        self.model.gravity = self.pin.Motion(np.array(mechanism.gravity), np.zeros(3))
        self.tip = self._build(mechanism)
        self.model.armature = book.armature[moving]
        order = [self.model.idx_vs[self.model.getJointId(mechanism.joints[k].name)] for k in moving]
        self.B, self.b = self.B[np.argsort(order)], self.b[np.argsort(order)]
        self.model.armature = book.armature[moving][np.argsort(order)]
        self.data: Any = self.model.createData()
        self.weightless = self.model.copy()
        self.weightless.gravity = self.pin.Motion.Zero()

    def _build(self, mechanism: Mechanism) -> int:
        pin = self.pin
        places: dict[str, tuple[int, Any]] = {mechanism.links[0].name: (0, pin.SE3(np.array(mechanism.T_sb)))}
        for joint, link in zip(mechanism.joints, mechanism.links[1:], strict=True):
            carrier, place = places[joint.parent]
            placement = place * pin.SE3(np.array(joint.T_pj))
            if joint.moves:
                index = self.model.addJoint(
                    carrier, self._joint(joint.kind, joint.axis, joint.pitch), placement, joint.name
                )
                places[link.name] = (index, pin.SE3.Identity())
            else:
                places[link.name] = (carrier, placement)
            if link.inertial is not None:
                body = link.inertial
                inertia = pin.Inertia(body.mass, np.array(body.com), np.array(body.inertia))
                self.model.appendBodyToJoint(places[link.name][0], inertia, places[link.name][1])
        carrier, place = places[mechanism.tip]
        tip = place * pin.SE3(np.array(mechanism.T_lt))
        return self.model.addFrame(pin.Frame("the tip", carrier, tip, pin.FrameType.OP_FRAME))

    def _joint(self, kind: JointKind, axis: Floats, pitch: float) -> Any:
        match kind:
            case JointKind.REVOLUTE:
                return self.pin.JointModelRevoluteUnaligned(np.array(axis))
            case JointKind.PRISMATIC:
                return self.pin.JointModelPrismaticUnaligned(np.array(axis))
            case _:
                return self.pin.JointModelHelicalUnaligned(np.array(axis), pitch)

    def state(self, q: Floats, qd: Floats, qdd: Floats, tau: Floats) -> dict[str, Floats]:
        """All quantities at one state."""
        pin, model, data, B = self.pin, self.model, self.data, self.B
        x, xd, xdd = B @ q + self.b, B @ qd, B @ qdd
        pin.forwardKinematics(model, data, x, xd)
        pin.computeJointJacobiansTimeVariation(model, data, x, xd)
        pin.updateFramePlacements(model, data)
        found: dict[str, Floats] = {"forward_kinematics": data.oMf[self.tip].homogeneous.copy()}
        for name, frame in (("space", pin.WORLD), ("body", pin.LOCAL)):
            J, dJ = pin.getFrameJacobian(model, data, self.tip, frame), pin.getFrameJacobianTimeVariation(
                model, data, self.tip, frame
            )  # fmt: skip
            found[f"jacobian_{name}"] = J.reshape(6, -1)[OURS] @ B
            found[f"jacobian_{name}_rate"] = dJ.reshape(6, -1)[OURS] @ B
        found["inverse_dynamics"] = B.T @ pin.rnea(model, data, x, xd, xdd)
        found["gravity_torque"] = B.T @ pin.computeGeneralizedGravity(model, data, x)
        found["velocity_torque"] = B.T @ pin.rnea(self.weightless, data, x, xd, 0 * xd)
        found["coriolis_matrix"] = B.T @ pin.computeCoriolisMatrix(model, data, x, xd) @ B
        upper = np.triu(pin.crba(model, data, x))
        found["mass_matrix"] = B.T @ (upper + np.triu(upper, 1).T) @ B
        if self.follows:
            found["forward_dynamics"] = solve_coupled(
                found["mass_matrix"], tau - B.T @ pin.nonLinearEffects(model, data, x, xd)
            )
        else:
            found["forward_dynamics"] = B.T @ pin.aba(model, data, x, xd, B @ tau)
        found["inverse_dynamics_derivatives"] = self._slopes(x, xd, xdd)
        return found

    def _slopes(self, x: Floats, xd: Floats, xdd: Floats) -> Floats:
        self.pin.computeRNEADerivatives(self.model, self.data, x, xd, xdd)
        M = np.triu(self.data.M) + np.triu(self.data.M, 1).T
        blocks = [self.B.T @ block @ self.B for block in (self.data.dtau_dq, self.data.dtau_dv, M)]
        return np.stack(blocks)


def solve_coupled(M: Floats, load: JointVector) -> JointVector:
    """(n,) qdd of M qdd = load; infinite where M cannot be inverted, so that nothing agrees with it."""
    try:
        return np.linalg.solve(M, load).astype(np.float64, copy=False)
    except np.linalg.LinAlgError:
        return np.full_like(load, np.inf)
