"""MuJoCo's numbers for a mechanism, written as MJCF with exact decimals; imported only when it is asked for."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.geometry import rotation
from mafsil.mechanics.quantity import States
from mafsil.mechanics.textbook import Textbook
from mafsil.model import Inertial, Joint, JointKind, Mechanism
from mafsil.verification.pinocchio_peer import solve_coupled

LEFT_OUT = ("coriolis_matrix", "inverse_dynamics_derivatives", "link_wrenches", "regressor")
GENERAL = '<inertial pos="0.1 0.2 0.3" quat="1 2 3 4" mass="1" diaginertia="1 1.1 1.2"/>'
"""Stands in the text, so that massless links compile too; the true numbers are written into the compiled model."""


def answers(mechanism: Mechanism, s: States) -> tuple[dict[str, Floats], list[tuple[str, str]]]:
    """Arrays by routine at all states, and what was not compared; nothing for robots with helical joints.

    Args:
        mechanism: any open chain or tree.
        s: states.
    """
    if any(joint.kind is JointKind.HELICAL for joint in mechanism.joints):
        return {}, [("mujoco", "verification.helical")]
    if any(joint.mimic is not None and joint.mimic.higher for joint in mechanism.joints):
        return {}, [("mujoco", "verification.curved")]
    peer = MuJoCoArm(mechanism)
    rows = [peer.state(s.q[k], s.qd[k], s.qdd[k], s.tau[k]) for k in range(len(s.q))]
    found = {name: np.stack([row[name] for row in rows]) for name in rows[0]}
    return found, [(f"{name}, mujoco", "verification.not_compared") for name in LEFT_OUT]


class MuJoCoArm:
    """A mechanism in MuJoCo: the compiled model, and the matrix from our coordinates to its joints.

    Args:
        mechanism: any open chain or tree without helical joints.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mujoco: Any = import_module("mujoco")
        book = Textbook(mechanism)
        moving = [k for k, joint in enumerate(mechanism.joints) if joint.moves]
        self.B, self.b = book.share[moving], book.offset[moving]
        self.model = self.mujoco.MjModel.from_xml_string(_text(mechanism))
        for k, link in enumerate(mechanism.links):
            self._write(k + 1, link.inertial)
        self.data = self.mujoco.MjData(self.model)
        self.mujoco.mj_setConst(self.model, self.data)
        self.tip, self.T_lt = 1 + mechanism.link_names.index(mechanism.tip), np.asarray(mechanism.T_lt)
        self.follows = any(joint.mimic is not None for joint in mechanism.joints)

    def _write(self, body: int, inertial: Inertial | None) -> None:
        model = self.model
        if inertial is None:
            model.body_mass[body], model.body_inertia[body] = 0.0, 0.0
            return
        moments, axes = np.linalg.eigh(inertial.inertia)
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        model.body_mass[body], model.body_inertia[body] = inertial.mass, moments
        model.body_ipos[body], model.body_iquat[body] = inertial.com, rotation.to_quaternion(axes)

    def state(self, q: Floats, qd: Floats, qdd: Floats, tau: Floats) -> dict[str, Floats]:
        """All quantities at one state."""
        mujoco, model, data, B = self.mujoco, self.model, self.data, self.B
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = B @ q + self.b, B @ qd
        mujoco.mj_forward(model, data)
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = data.xmat[self.tip].reshape(3, 3), data.xpos[self.tip]
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        potential, kinetic = data.energy.copy()
        found: dict[str, Floats] = {
            "forward_kinematics": T @ self.T_lt,
            "mass_matrix": B.T @ M @ B,
            "potential_energy": np.asarray(potential),
            "kinetic_energy": np.asarray(kinetic),
        }
        if self.follows:
            found["forward_dynamics"] = solve_coupled(found["mass_matrix"], tau - B.T @ data.qfrc_bias)
        else:
            data.qfrc_applied[:] = B @ tau
            mujoco.mj_forward(model, data)
            found["forward_dynamics"] = B.T @ data.qacc
        data.qacc[:] = B @ qdd
        mujoco.mj_inverse(model, data)
        found["inverse_dynamics"] = B.T @ data.qfrc_inverse
        data.qvel[:] = 0
        mujoco.mj_forward(model, data)
        found["gravity_torque"] = B.T @ data.qfrc_bias
        return found


def _text(mechanism: Mechanism) -> str:
    """One body per link, in the order of the links."""
    children: dict[str, list[Joint]] = {}
    for joint in mechanism.joints:
        children.setdefault(joint.parent, []).append(joint)

    def body(link: str, T: Floats, joint: Joint | None) -> str:
        inside = "".join(body(child.child, child.T_pj, child) for child in children.get(link, ()))
        place = f'pos="{_row(T[:3, 3])}" quat="{_row(rotation.to_quaternion(T[:3, :3]))}"'
        return f"<body {place}>{GENERAL}{_moving(joint)}{inside}</body>"

    return (
        '<mujoco><compiler angle="radian" inertiafromgeom="false"/>'
        f'<option gravity="{_row(mechanism.gravity)}">'
        '<flag contact="disable" constraint="disable" energy="enable"/></option>'
        f"<worldbody>{body(mechanism.links[0].name, mechanism.T_sb, None)}</worldbody></mujoco>"
    )


def _moving(joint: Joint | None) -> str:
    if joint is None or not joint.moves:
        return ""
    kind = "slide" if joint.kind is JointKind.PRISMATIC else "hinge"
    armature = 0.0 if joint.actuator is None else joint.actuator.reflected_inertia
    return f'<joint type="{kind}" axis="{_row(joint.axis)}" armature="{armature!r}"/>'


def _row(numbers: Floats) -> str:
    return " ".join(repr(float(x)) for x in numbers)
