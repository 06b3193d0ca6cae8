"""Pinocchio with its own URDF reader: the whole way from the file to the numbers is independent of ours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin

from mafsil.arrays import Floats
from mafsil.model import JointKind, Mechanism
from tests.oracles.oracle import Answers, expansion, stacked
from tests.oracles.states import States

MOTION_ORDER = [3, 4, 5, 0, 1, 2]


class PinocchioFileOracle:
    """Link poses, tip pose and Jacobian, inverse dynamics, mass matrix and gravity, from the file itself."""

    name = "pinocchio from file"

    def __init__(self, path: Path, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.model = pin.buildModelFromUrdf(str(path))
        self.data = self.model.createData()
        self.expansion = expansion(mechanism)
        joints = [self.model.joints[self.model.getJointId(joint.name)] for joint in self.expansion.joints]
        self.q_at = [joint.idx_q for joint in joints]
        self.v_at = [joint.idx_v for joint in joints]
        self.circles = [joint.nq == 2 for joint in joints]
        self.lengths = np.array([joint.kind is JointKind.PRISMATIC for joint in self.expansion.joints])
        self.links = [self.model.getFrameId(name, pin.FrameType.BODY) for name in mechanism.link_names]
        self.tip = self.links[mechanism.link_names.index(mechanism.tip)]
        free = sum(joint.nq == 7 for joint in self.model.joints)  # held where the file draws them
        if len(joints) != self.model.njoints - 1 - free:
            raise AssertionError("Pinocchio read another number of joints")

    def evaluate(self, states: States) -> Answers:
        inputs = states.arguments(("q", "qd", "qdd"))
        return stacked([self._state(*row) for row in zip(*inputs, strict=True)])

    def _state(self, q: Floats, qd: Floats, qdd: Floats) -> Answers:
        model, data, B = self.model, self.data, self.expansion.B
        x, xd, xdd = self._configuration(B @ q + self.expansion.b), self._rates(B @ qd), self._rates(B @ qdd)
        pin.computeJointJacobians(model, data, x)
        pin.updateFramePlacements(model, data)
        base = np.linalg.inv(data.oMf[self.links[0]].homogeneous)
        upper = np.triu(np.reshape(pin.crba(model, data, x), (model.nv, model.nv)))
        M = (upper + np.triu(upper, 1).T)[np.ix_(self.v_at, self.v_at)]
        poses = np.array([base @ data.oMf[k].homogeneous for k in self.links])
        return {
            "link_poses": poses,
            "forward_kinematics": poses[self.links.index(self.tip)],
            "jacobian_body": self._tip_jacobian()[:, self.v_at] @ B,
            "mass_matrix": B.T @ M @ B,
            "inverse_dynamics": B.T @ pin.rnea(model, data, x, xd, xdd)[self.v_at],
            "gravity_torque": B.T @ pin.computeGeneralizedGravity(model, data, x)[self.v_at],
        }

    def _tip_jacobian(self) -> Floats:
        """(6, nv) with omega first; a single column comes as a vector."""
        J = pin.getFrameJacobian(self.model, self.data, self.tip, pin.LOCAL)
        return np.reshape(J, (6, self.model.nv))[MOTION_ORDER]

    def _configuration(self, values: Floats) -> Floats:
        """Continuous joints are (cos, sin) there."""
        x = pin.neutral(self.model)
        for at, circle, value in zip(self.q_at, self.circles, values, strict=True):
            if circle:
                x[at : at + 2] = np.cos(value), np.sin(value)
            else:
                x[at] = value
        return x

    def _rates(self, values: Floats) -> Floats:
        x = np.zeros(self.model.nv)
        x[self.v_at] = values
        return x
