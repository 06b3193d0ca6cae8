"""Pinocchio as an oracle: the mechanism rebuilt joint by joint in memory, no file, no shared algorithm in between."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from mafsil.arrays import Floats
from mafsil.model import Inertial, JointKind, Mechanism
from tests.oracles.oracle import Answers, Expansion, accelerations, expansion, stacked
from tests.oracles.states import States

MOTION_ORDER = [3, 4, 5, 0, 1, 2]
"""Pinocchio writes (v, omega) and (f, m)."""


class PinocchioOracle:
    """Every quantity of the catalogue."""

    name = "pinocchio"

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.expansion: Expansion = expansion(mechanism)
        self.model, self.frames = model_of(mechanism)
        self.data: Any = self.model.createData()
        self.rotorless = self.model.copy()
        self.rotorless.armature = np.zeros(self.model.nv)
        self.weightless = self.model.copy()
        self.weightless.gravity = pin.Motion.Zero()
        self.tip: int = self.frames[-1]
        # Pinocchio leaves what is fixed to the world out of the potential energy.
        self.fixed_energy: float = -mechanism.gravity @ _fixed_first_moment(mechanism)

    def evaluate(self, states: States) -> Answers:
        return stacked([self._state(*row) for row in zip(*states.arguments(_INPUTS), strict=True)])

    def _state(self, q: Floats, qd: Floats, qdd: Floats, tau: Floats, F_tip: Floats) -> Answers:
        model, data, B = self.model, self.data, self.expansion.B
        x, xd, xdd = B @ q + self.expansion.b, B @ qd, B @ qdd
        zero = np.zeros(model.nv)
        answers: Answers = {}
        pin.forwardKinematics(model, data, x, xd)
        pin.computeJointJacobiansTimeVariation(model, data, x, xd)
        pin.updateFramePlacements(model, data)
        answers["link_poses"] = np.array([data.oMf[k].homogeneous for k in self.frames[:-1]])
        answers["forward_kinematics"] = data.oMf[self.tip].homogeneous.copy()
        for name, frame in (("space", pin.WORLD), ("body", pin.LOCAL)):
            J = _rows_omega_v(pin.getFrameJacobian(model, data, self.tip, frame))
            dJ = _rows_omega_v(pin.getFrameJacobianTimeVariation(model, data, self.tip, frame))
            answers[f"jacobian_{name}"], answers[f"jacobian_{name}_rate"] = J @ B, dJ @ B
        J_b = answers["jacobian_body"]
        answers["kinetic_energy"] = np.float64(self._kinetic_energy(x, xd))
        answers["potential_energy"] = np.float64(pin.computePotentialEnergy(model, data, x) + self.fixed_energy)
        answers["coriolis_matrix"] = B.T @ pin.computeCoriolisMatrix(model, data, x, xd) @ B
        answers["inverse_dynamics"] = B.T @ pin.rnea(model, data, x, xd, xdd)
        answers["inverse_dynamics tip_wrench"] = B.T @ pin.rnea(model, data, x, xd, xdd, self._external(F_tip))
        answers["gravity_torque"] = B.T @ pin.computeGeneralizedGravity(model, data, x)
        answers["velocity_torque"] = B.T @ pin.rnea(self.weightless, data, x, xd, zero)
        upper = np.triu(pin.crba(model, data, x))
        M = answers["mass_matrix"] = B.T @ (upper + np.triu(upper, 1).T) @ B
        if self.expansion.follows:
            load = tau - B.T @ pin.nonLinearEffects(model, data, x, xd)
            answers["forward_dynamics"] = accelerations(M, load)
            answers["forward_dynamics tip_wrench"] = accelerations(M, load - J_b.T @ F_tip)
        else:
            answers["forward_dynamics"] = _in_coordinates(B, pin.aba(model, data, x, xd, B @ tau))
            loaded = pin.aba(model, data, x, xd, B @ tau, self._external(F_tip))
            answers["forward_dynamics tip_wrench"] = _in_coordinates(B, loaded)
        return answers

    def _kinetic_energy(self, x: Floats, xd: Floats) -> float:
        """Links and rotors apart: Pinocchio 4.1 counts the armature of some kinds of joint only."""
        links = pin.computeKineticEnergy(self.rotorless, self.data, x, xd)
        return float(links + self.model.armature @ xd**2 / 2)

    def _external(self, F_tip: Floats) -> Any:
        """Wrenches that the world exerts on the bodies, each in its joint frame."""
        forces = pin.StdVec_Force()
        for _ in range(self.model.njoints):
            forces.append(pin.Force.Zero())
        frame = self.model.frames[self.tip]
        forces[frame.parentJoint] = frame.placement.act(pin.Force(-F_tip[3:], -F_tip[:3]))
        return forces


_INPUTS = ("q", "qd", "qdd", "tau", "tip_wrench")


def _rows_omega_v(J: Floats) -> Floats:
    """(6, n) with rows (omega, v); Pinocchio returns a vector for one joint."""
    return J.reshape(6, -1)[MOTION_ORDER]


def _in_coordinates(B: Floats, x: Floats) -> Floats:
    """Joints and coordinates are the same, perhaps in another order."""
    return B.T @ x


def model_of(mechanism: Mechanism) -> tuple[Any, list[int]]:
    """The Pinocchio model, and its frame ids of all links and, last, of the tip frame."""
    model = pin.Model()
    model.name = mechanism.name
    model.gravity = pin.Motion(np.array(mechanism.gravity), np.zeros(3))
    base = mechanism.links[0]
    seats: dict[str, tuple[int, Any]] = {base.name: (0, pin.SE3(np.array(mechanism.T_sb)))}
    armature: list[float] = []
    if base.inertial is not None:
        model.appendBodyToJoint(0, _inertia(base.inertial), seats[base.name][1])
    for joint, link in zip(mechanism.joints, mechanism.links[1:], strict=True):
        carrier, seat = seats[joint.parent]
        placement = seat * pin.SE3(np.array(joint.T_pj))
        if joint.moves:
            index = model.addJoint(
                carrier, _joint(joint.kind, np.array(joint.axis), joint.pitch), placement, joint.name
            )
            armature.append(0.0 if joint.actuator is None else joint.actuator.reflected_inertia)
            seats[link.name] = (index, pin.SE3.Identity())
        else:
            seats[link.name] = (carrier, placement)
        if link.inertial is not None:
            model.appendBodyToJoint(seats[link.name][0], _inertia(link.inertial), seats[link.name][1])
    order = [model.idx_vs[model.getJointId(joint.name)] for joint in mechanism.joints if joint.moves]
    if order != sorted(order):
        raise AssertionError("Pinocchio sorted the joints differently")
    model.armature = np.array(armature)
    frames = [_frame(model, f"link {name}", *seats[name]) for name in mechanism.link_names]
    carrier, seat = seats[mechanism.tip]
    frames.append(_frame(model, "the tip", carrier, seat * pin.SE3(np.array(mechanism.T_lt))))
    return model, frames


def _joint(kind: JointKind, axis: Floats, pitch: float) -> Any:
    """Joints along a coordinate axis get their own, quicker class, as in Pinocchio's URDF reader."""
    along = "XYZ"[int(axis.argmax())] if sorted(axis) == [0.0, 0.0, 1.0] else ""
    match kind:
        case JointKind.REVOLUTE:
            return getattr(pin, f"JointModelR{along}")() if along else pin.JointModelRevoluteUnaligned(axis)
        case JointKind.PRISMATIC:
            return getattr(pin, f"JointModelP{along}")() if along else pin.JointModelPrismaticUnaligned(axis)
        case _:
            return pin.JointModelHelicalUnaligned(axis, pitch)


def _inertia(inertial: Inertial) -> Any:
    return pin.Inertia(inertial.mass, np.array(inertial.com), np.array(inertial.inertia))


def _frame(model: Any, name: str, joint: int, placement: Any) -> int:
    return model.addFrame(pin.Frame(name, joint, placement, pin.FrameType.OP_FRAME))


def _fixed_first_moment(mechanism: Mechanism) -> Floats:
    """Sum of m p_com in {s} over the links that no joint moves."""
    poses = {mechanism.links[0].name: np.array(mechanism.T_sb)}
    moment = np.zeros(3)
    for joint in mechanism.joints:
        if joint.parent in poses and not joint.moves:
            poses[joint.child] = poses[joint.parent] @ joint.T_pj
    for link in mechanism.links:
        if link.name in poses and link.inertial is not None:
            T = poses[link.name]
            moment += link.inertial.mass * (T[:3, :3] @ link.inertial.com + T[:3, 3])
    return moment
