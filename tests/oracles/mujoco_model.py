"""MuJoCo as an oracle: the mechanism written as MJCF text with exact numbers, its own compiler and C code behind it."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from mafsil.arrays import Floats
from mafsil.model import Inertial, Joint, JointKind, Mechanism
from tests.oracles.oracle import Answers, Unsupported, accelerations, expansion, stacked
from tests.oracles.states import States

PLACEHOLDER = '<inertial pos="0.1 0.2 0.3" quat="1 2 3 4" mass="1" diaginertia="1 1.1 1.2"/>'
"""Bodies of general position, so that MuJoCo keeps all terms; the true inertias are written into the compiled model,
which lets massless links and point masses through that the MJCF compiler refuses."""


class MuJoCoOracle:
    """All but the Coriolis matrix and external wrenches in inverse dynamics, which MuJoCo does not have."""

    name = "mujoco"

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.expansion = expansion(mechanism)
        self.model = model_of(mechanism)
        self.data = mujoco.MjData(self.model)
        self.bodies = np.arange(1, 1 + len(mechanism.links))
        self.tip_body = 1 + mechanism.link_names.index(mechanism.tip)

    def evaluate(self, states: States) -> Answers:
        inputs = states.arguments(("q", "qd", "qdd", "tau", "tip_wrench"))
        return stacked([self._state(*row) for row in zip(*inputs, strict=True)])

    def _state(self, q: Floats, qd: Floats, qdd: Floats, tau: Floats, F_tip: Floats) -> Answers:
        model, data, B = self.model, self.data, self.expansion.B
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = B @ q + self.expansion.b, B @ qd
        mujoco.mj_forward(model, data)
        answers = self._kinematics()
        M_all = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M_all)
        M = answers["mass_matrix"] = B.T @ M_all @ B
        answers["potential_energy"], answers["kinetic_energy"] = data.energy.copy()
        bias = B.T @ data.qfrc_bias
        load = self._tip_load(F_tip)
        answers |= self._forward_dynamics(M, bias, tau, load)
        data.qacc[:] = B @ qdd
        mujoco.mj_inverse(model, data)
        answers["inverse_dynamics"] = B.T @ data.qfrc_inverse
        answers["inverse_dynamics tip_wrench"] = answers["inverse_dynamics"] - B.T @ load
        answers["velocity_torque"] = self._velocity_torque()
        data.qvel[:] = 0
        mujoco.mj_forward(model, data)
        answers["gravity_torque"] = B.T @ data.qfrc_bias
        return answers

    def _kinematics(self) -> Answers:
        model, data, B = self.model, self.data, self.expansion.B
        poses = np.tile(np.eye(4), (len(self.bodies), 1, 1))
        poses[:, :3, :3], poses[:, :3, 3] = data.xmat[self.bodies].reshape(-1, 3, 3), data.xpos[self.bodies]
        T = poses[self.tip_body - 1] @ self.mechanism.T_lt
        R, p = T[:3, :3], T[:3, 3]
        jacp, jacr, dp, dr = (np.zeros((3, model.nv)) for _ in range(4))
        mujoco.mj_jac(model, data, jacp, jacr, p, self.tip_body)
        mujoco.mj_jacDot(model, data, dp, dr, p, self.tip_body)
        omega, velocity = jacr @ data.qvel, jacp @ data.qvel
        point, rotation = _skew(p), _skew(omega)
        return {
            "link_poses": poses,
            "forward_kinematics": T,
            "jacobian_space": np.vstack([jacr, jacp + point @ jacr]) @ B,
            "jacobian_body": np.vstack([R.T @ jacr, R.T @ jacp]) @ B,
            "jacobian_space_rate": np.vstack([dr, dp + _skew(velocity) @ jacr + point @ dr]) @ B,
            "jacobian_body_rate": np.vstack([R.T @ (dr - rotation @ jacr), R.T @ (dp - rotation @ jacp)]) @ B,
        }

    def _tip_load(self, F_tip: Floats) -> Floats:
        """Joint efforts of the wrench that the world exerts on the tip."""
        model, data = self.model, self.data
        T = data.xmat[self.tip_body].reshape(3, 3), data.xpos[self.tip_body]
        R, p = T[0] @ self.mechanism.T_lt[:3, :3], T[1] + T[0] @ self.mechanism.T_lt[:3, 3]
        load = np.zeros(model.nv)
        mujoco.mj_applyFT(model, data, -R @ F_tip[3:], -R @ F_tip[:3], p, self.tip_body, load)
        return load

    def _forward_dynamics(self, M: Floats, bias: Floats, tau: Floats, load: Floats) -> Answers:
        model, data, B = self.model, self.data, self.expansion.B
        answers: Answers = {}
        for name, extra in (("forward_dynamics", 0 * load), ("forward_dynamics tip_wrench", load)):
            if self.expansion.follows:
                answers[name] = accelerations(M, tau - bias + B.T @ extra)
                continue
            data.qfrc_applied[:] = B @ tau + extra
            mujoco.mj_forward(model, data)
            answers[name] = B.T @ data.qacc
        return answers

    def _velocity_torque(self) -> Floats:
        gravity = self.model.opt.gravity.copy()
        self.model.opt.gravity[:] = 0
        mujoco.mj_forward(self.model, self.data)
        self.model.opt.gravity[:] = gravity
        return self.expansion.B.T @ self.data.qfrc_bias


def model_of(mechanism: Mechanism) -> Any:
    """The compiled MuJoCo model: body 1 + k is link k.

    Raises:
        Unsupported: a helical joint.
    """
    model = mujoco.MjModel.from_xml_string(mjcf_text(mechanism))
    for k, link in enumerate(mechanism.links):
        _write_inertia(model, 1 + k, link.inertial)
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def mjcf_text(mechanism: Mechanism) -> str:
    """One body per link in the order of the links, placed by exact decimals."""
    children: dict[str, list[Joint]] = {}
    for joint in mechanism.joints:
        children.setdefault(joint.parent, []).append(joint)

    def body(link: str, T: Floats, joint: Joint | None) -> str:
        inside = "".join(body(child.child, child.T_pj, child) for child in children.get(link, ()))
        where = f'pos="{_text(T[:3, 3])}" quat="{_text(_quaternion(T[:3, :3]))}"'
        return f"<body {where}>{PLACEHOLDER}{_joint_text(joint)}{inside}</body>"

    gravity = _text(mechanism.gravity)
    return (
        f'<mujoco><compiler angle="radian" inertiafromgeom="false"/><option gravity="{gravity}">'
        '<flag contact="disable" constraint="disable" energy="enable"/></option>'
        f"<worldbody>{body(mechanism.links[0].name, mechanism.T_sb, None)}</worldbody></mujoco>"
    )


def _joint_text(joint: Joint | None) -> str:
    if joint is None or not joint.moves:
        return ""
    if joint.kind is JointKind.HELICAL:
        raise Unsupported("MuJoCo has no helical joint")
    kind = "slide" if joint.kind is JointKind.PRISMATIC else "hinge"
    armature = 0.0 if joint.actuator is None else joint.actuator.reflected_inertia
    return f'<joint type="{kind}" axis="{_text(joint.axis)}" armature="{armature!r}"/>'


def _text(numbers: Floats) -> str:
    return " ".join(repr(float(x)) for x in numbers)


def _quaternion(R: Floats) -> Floats:
    """(w, x, y, z) of a rotation, from its largest component, which keeps all digits."""
    xx, yy, zz = np.diag(R)
    squares = np.array([1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz])
    turn = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sums = np.array([R[1, 0] + R[0, 1], R[0, 2] + R[2, 0], R[2, 1] + R[1, 2]])
    rows = np.array(
        [
            [squares[0], *turn],
            [turn[0], squares[1], sums[0], sums[1]],
            [turn[1], sums[0], squares[2], sums[2]],
            [turn[2], sums[1], sums[2], squares[3]],
        ]
    )
    row = rows[np.argmax(squares)]
    return row / np.linalg.norm(row)


def _write_inertia(model: Any, body: int, inertial: Inertial | None) -> None:
    if inertial is None:
        model.body_mass[body], model.body_inertia[body] = 0.0, 0.0
        return
    moments, axes = np.linalg.eigh(inertial.inertia)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    model.body_mass[body], model.body_inertia[body] = inertial.mass, moments
    model.body_ipos[body], model.body_iquat[body] = inertial.com, _quaternion(axes)


def _skew(x: Floats) -> Floats:
    return np.array([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]])
