"""Files of ours as Pinocchio and MuJoCo read them: tip pose, mass matrix, gravity and bias at random states."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType

import mujoco
import numpy as np
import pinocchio as pin

from mafsil.arrays import Floats
from mafsil.errors import ModelError
from mafsil.mechanics.inertial_parameters import reflected_inertias
from mafsil.mechanics.textbook import Textbook
from mafsil.model import Joint, Mechanism
from mafsil.model.losses import with_space_link, with_tip_link
from mafsil.model.mjcf.writer import sites_of

STATES = 3


@dataclass(frozen=True)
class Motion:
    """Numbers at one state: pose of the tip, mass matrix, gravity and bias in the joints' own order, spread."""

    T: Floats
    M: Floats
    g: Floats
    bias: Floats


Reader = Callable[[Mechanism, str], Callable[[Floats, Floats], Motion]]


def text_of(mechanism: Mechanism, tool: ModuleType) -> str:
    """The text; what changes the motion is left out where the format has no word for it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return tool.write(mechanism)
        except ModelError as refusal:
            return tool.write(mechanism, without=[refusal.details["what"]])


def differences(mechanism: Mechanism, text: str, reader: Reader, seed: int = 0) -> dict[str, float]:
    """Largest relative difference of each number between us and a reader of the text, over random states."""
    book, rng = Textbook(mechanism), np.random.default_rng(seed)
    theirs, zero = reader(mechanism, text), np.zeros((1, mechanism.n))
    worst = dict.fromkeys(("T", "M", "g", "bias"), 0.0)
    for _ in range(STATES):
        q, qd = rng.uniform(-2, 2, (2, 1, mechanism.n))
        found = theirs(q[0], qd[0])
        ours = {
            "T": book.pose(q)[0],
            "M": book.mass_matrix(q)[0],
            "g": book.newton_euler(q, zero, zero, None).tau[0],
            "bias": book.newton_euler(q, qd, zero, None).tau[0],
        }
        for name, value in ours.items():
            gap = np.abs(np.asarray(getattr(found, name)) - value).max(initial=0.0)
            worst[name] = max(worst[name], float(gap / max(1.0, np.abs(value).max(initial=0.0))))
    return worst


def by_pinocchio(mechanism: Mechanism, text: str) -> Callable[[Floats, Floats], Motion]:
    """urdfdom's reader and Pinocchio's algorithms; gravity and rotors, which URDF does not have, are set after."""
    model = pin.buildModelFromXML(text)
    model.gravity = pin.Motion(np.array(mechanism.gravity), np.zeros(3))
    data = model.createData()
    moving = [joint for joint in mechanism.joints if joint.moves]
    joints = [model.joints[model.getJointId(joint.name)] for joint in moving]
    assert len(joints) == model.njoints - 1
    at = [joint.idx_v for joint in joints]
    rotors = np.diag(reflected_inertias(mechanism))
    spread, shift = spread_of(mechanism, moving)
    tip = model.getFrameId(with_space_link(with_tip_link(mechanism)).tip, pin.FrameType.BODY)

    def motion(q: Floats, qd: Floats) -> Motion:
        x, xd = pin.neutral(model), np.zeros(model.nv)
        for joint, value in zip(joints, spread @ q + shift, strict=True):
            x[joint.idx_q : joint.idx_q + joint.nq] = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
        xd[at] = spread @ qd
        pin.framesForwardKinematics(model, data, x)
        upper = np.triu(np.reshape(pin.crba(model, data, x), (model.nv, model.nv)))
        M = (upper + np.triu(upper, 1).T)[np.ix_(at, at)]
        g = pin.computeGeneralizedGravity(model, data, x)[at]
        bias = pin.rnea(model, data, x, xd, 0 * xd)[at]
        T = data.oMf[tip].homogeneous.copy()
        return Motion(T, spread.T @ M @ spread + rotors, spread.T @ g, spread.T @ bias)

    return motion


def by_mujoco(mechanism: Mechanism, text: str) -> Callable[[Floats, Floats], Motion]:
    """MuJoCo's compiler and its algorithms; damping and dry friction are passive forces there, and no bias."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    moving = [joint for joint in mechanism.joints if joint.moves]
    at = [model.joint(joint.name).id for joint in moving]
    assert len(at) == model.njnt == model.nv
    spread, shift = spread_of(mechanism, moving)
    framed = with_tip_link(mechanism, sites_of)
    is_site = framed.tip in sites_of(framed)
    tip = (model.site if is_site else model.body)(framed.tip).id

    def motion(q: Floats, qd: Floats) -> Motion:
        data.qpos[at], data.qvel[at] = spread @ q + shift, 0.0
        mujoco.mj_forward(model, data)
        g = data.qfrc_bias[at].copy()
        data.qvel[at] = spread @ qd
        mujoco.mj_forward(model, data)
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        T = np.eye(4)
        axes, origins = (data.site_xmat, data.site_xpos) if is_site else (data.xmat, data.xpos)
        T[:3, :3], T[:3, 3] = axes[tip].reshape(3, 3), origins[tip]
        bias = data.qfrc_bias[at]
        return Motion(T, spread.T @ M[np.ix_(at, at)] @ spread, spread.T @ g, spread.T @ bias)

    return motion


def spread_of(mechanism: Mechanism, moving: list[Joint]) -> tuple[Floats, Floats]:
    """From our coordinates to the coordinates of all moving joints: followers move with their leaders."""
    book = Textbook(mechanism)
    rows = [mechanism.joints.index(joint) for joint in moving]
    return book.share[rows], book.offset[rows]
