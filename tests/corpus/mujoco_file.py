"""MuJoCo with its own compiler as the judge of an MJCF file: poses, mass matrix and bias forces at random states.

Trees that float freely are compared with their base held where the file draws it; MuJoCo's rows of couplings between
joints are eliminated as ours are, q_all = B q + b.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from mafsil.arrays import Floats
from mafsil.model import Joint, JointKind, Mechanism
from tests.oracles import ours
from tests.oracles.natural_scale import natural_scale
from tests.oracles.oracle import expansion
from tests.oracles.states import States, sample

_KINDS = {
    mujoco.mjtJoint.mjJNT_HINGE: JointKind.REVOLUTE,
    mujoco.mjtJoint.mjJNT_SLIDE: JointKind.PRISMATIC,
    mujoco.mjtJoint.mjJNT_BALL: JointKind.REVOLUTE,
}


class NotComparable(Exception):
    """The two do not hold the same joints, with the reason."""


def _ball_rates(q: Floats, qd: Floats) -> tuple[Floats, Floats]:
    """Of turns about x, y, z in a row: E with the body's angular velocity E qd, and (dE/dt) qd."""
    last = Rotation.from_rotvec([0, 0, -q[2]])
    z, y = np.array([0.0, 0.0, 1.0]), last.apply([0.0, 1.0, 0.0])
    x = (last * Rotation.from_rotvec([0, -q[1], 0])).apply([1.0, 0.0, 0.0])
    growth = -qd[0] * np.cross(qd[1] * y + qd[2] * z, x) - qd[1] * np.cross(qd[2] * z, y)
    return np.stack([x, y, z], axis=1), growth


class MuJoCoFile:
    """One compiled MJCF file.

    Args:
        source: path of the file, or its text.
    """

    def __init__(self, source: Path | str) -> None:
        text = isinstance(source, str)
        self.model: Any = (
            mujoco.MjModel.from_xml_string(source) if text else mujoco.MjModel.from_xml_path(str(source))
        )  # fmt: skip
        self.data: Any = mujoco.MjData(self.model)

    def longest_chain(self) -> int:
        """Most hinges and slides from the world to a body."""
        depth = [0] * self.model.nbody
        for body in range(1, self.model.nbody):
            first, count = self.model.body_jntadr[body], self.model.body_jntnum[body]
            own = sum(int(kind) in (2, 3) for kind in self.model.jnt_type[first : first + count]) if count else 0
            depth[body] = depth[self.model.body_parentid[body]] + own
        return max(depth)

    def difference(self, mechanism: Mechanism, count: int) -> tuple[float, str]:
        """The largest difference at `count` random states in natural scale, and where it is."""
        pairs = self._pairs(mechanism)
        states = sample(mechanism, count, np.random.default_rng(0))
        names = ("link_poses", "mass_matrix", "inverse_dynamics")
        still = States(states.q, states.qd, 0 * states.qdd, states.tau, states.tip_wrench)
        mine = ours.traced(mechanism, still, names)
        scale, spread = natural_scale(mechanism), expansion(mechanism)
        moving = [pairs[joint.name] for joint in spread.joints]
        worst, where = 0.0, ""
        for k in range(count):
            E, steady = self._set(mechanism, pairs, moving, spread.B @ states.q[k] + spread.b, spread.B @ states.qd[k])
            M, E = np.zeros((self.model.nv, self.model.nv)), E @ spread.B
            mujoco.mj_fullM(self.model, self.data, M)
            theirs = {
                "mass_matrix": E.T @ M @ E,
                "inverse_dynamics": E.T @ (self.data.qfrc_bias + M @ steady),
            }
            errors = {n: float(scale.error(n, mine[n][k : k + 1], theirs[n][None]).max()) for n in theirs}
            errors["link_poses"] = self._pose_error(mechanism, mine["link_poses"][k], scale.size.length)
            for name, error in errors.items():
                if not error <= worst:
                    worst, where = error, f"{name} differs by {error:.2g}"
        return worst, where

    def _pairs(self, mechanism: Mechanism) -> dict[str, int]:
        """For each of our joints that MuJoCo has too, its number there; both lists run depth first."""
        known = {joint.name for joint in mechanism.joints}
        theirs = [k for k in range(self.model.njnt) if self._kept(k, mechanism, known)]
        named = {name: k for k in theirs if self.model.joint(k).name for name in self._names(k)}
        rest = iter(k for k in theirs if not self.model.joint(k).name for _ in self._names(k))
        pairs: dict[str, int] = {}
        for joint in mechanism.joints:
            k = named.get(joint.name)
            if k is None and joint.moves:
                k = next(rest, None)
            if k is not None:
                self._require_same(joint, k)
                pairs[joint.name] = k
        if len(set(pairs.values())) != len(theirs):
            missing = [self.model.joint(k).name or str(k) for k in theirs if k not in pairs.values()]
            raise NotComparable(f"MuJoCo has further joints: {', '.join(missing)[:100]}")
        return pairs

    def _names(self, k: int) -> list[str]:
        """Of our joints: a ball is three hinges."""
        name = self.model.joint(k).name
        return [f"{name}_{axis}" for axis in "xyz"] if self.model.jnt_type[k] == mujoco.mjtJoint.mjJNT_BALL else [name]

    def _require_same(self, joint: Joint, k: int) -> None:
        kind = _KINDS.get(mujoco.mjtJoint(int(self.model.jnt_type[k])))
        if joint.moves and joint.kind is not kind:
            raise NotComparable(f"joint {joint.name} is {kind} there")

    def _kept(self, k: int, mechanism: Mechanism, known: set[str]) -> bool:
        """Whether a joint is neither the free one of a base nor part of an object that we left out."""
        if self.model.jnt_type[k] == mujoco.mjtJoint.mjJNT_FREE:
            return False
        name = self.model.joint(k).name
        root = self.model.body_rootid[self.model.jnt_bodyid[k]]
        floats = self.model.body_jntnum[root] and self.model.jnt_type[self.model.body_jntadr[root]] == 0
        if not floats or name in known:
            return True
        base = self.model.body(int(root)).name
        return base in mechanism.link_names if base else not name

    def _set(
        self, mechanism: Mechanism, pairs: dict[str, int], moving: list[int], q: Floats, qd: Floats
    ) -> tuple[Floats, Floats]:
        """Set a state; E and e with MuJoCo's velocities E qd and accelerations E qdd + e."""
        model, data = self.model, self.data
        mujoco.mj_resetData(model, data)
        held = {pairs[joint.name] for joint in mechanism.joints if not joint.moves and joint.name in pairs}
        for k in range(model.neq):
            if model.eq_type[k] == mujoco.mjtEq.mjEQ_JOINT and model.eq_obj2id[k] < 0 and model.eq_obj1id[k] in held:
                at = model.jnt_qposadr[model.eq_obj1id[k]]
                data.qpos[at] = model.qpos0[at] + model.eq_data[k][0]
        E, steady = np.zeros((model.nv, len(moving))), np.zeros(model.nv)
        for k in dict.fromkeys(moving):
            own = [column for column, joint in enumerate(moving) if joint == k]
            first, dof = model.jnt_qposadr[k], model.jnt_dofadr[k]
            if len(own) == 1:
                data.qpos[first], E[dof, own] = q[own[0]], 1.0
            else:
                turn = Rotation.from_euler("XYZ", q[own])
                data.qpos[first : first + 4] = turn.as_quat(scalar_first=True)
                E[dof : dof + 3, own], steady[dof : dof + 3] = _ball_rates(q[own], qd[own])
        data.qvel[:] = E @ qd
        mujoco.mj_forward(model, data)
        return E, steady

    def _pose_error(self, mechanism: Mechanism, poses: Floats, reach: float) -> float:
        """Links that carry the name of a body."""
        worst = 0.0
        at = {name: k for k, name in enumerate(mechanism.link_names)}
        for body in range(1, self.model.nbody):
            k = at.get(self.model.body(body).name or "\0")
            if k is not None and not self._is_mocap(body):
                turn = np.abs(poses[k][:3, :3] - self.data.xmat[body].reshape(3, 3)).max()
                away = np.abs(poses[k][:3, 3] - self.data.xpos[body]).max() / max(reach, 1.0)
                worst = max(worst, float(turn), float(away))
        return worst

    def _is_mocap(self, body: int) -> bool:
        return self.model.body_mocapid[body] >= 0
