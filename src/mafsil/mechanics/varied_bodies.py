"""The numbers of a plant that varies from run to run: its inertial parameters by body, friction of its joints.

The parameters are regrouped as `regrouping` does it with numbers: what a joint cannot feel moves to its parent, and
seven numbers of a body on a revolute joint are left. Which ones is known beforehand, so expressions get short.
"""

from __future__ import annotations

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.body_tree import BodyTree, lump_bodies
from mafsil.mechanics.composite_inertia import CompositeInertia
from mafsil.mechanics.frame_choice import in_chosen_frames
from mafsil.mechanics.friction import friction_law
from mafsil.mechanics.inertial_parameters import moved_parameters
from mafsil.mechanics.placement import Expression
from mafsil.model import JointKind, Mechanism

M, HX, HY, HZ, XX, YY, ZZ, XY, XZ, YZ = range(10)
FELT = {
    JointKind.REVOLUTE: (HX, HY, XX, ZZ, XY, XZ, YZ),
    JointKind.PRISMATIC: (M, HX, HY, HZ),
}
"""Parameters that a joint feels after regrouping; of other kinds all ten."""


def body_parameters(mechanism: Mechanism, parameters: Floats, payload: Floats | None = None) -> Floats:
    """(*batch, bodies, 10) regrouped parameters of the moving bodies, from those of the links that they carry.

    Args:
        mechanism: whose links they are.
        parameters: (*batch, L, 10) of the links, each in its own frame, as `inertial_parameters` orders them.
        payload: (*batch, 10) of a body fixed to the tip, in the tip frame; None for none.
    """
    tree = in_chosen_frames(lump_bodies(mechanism))
    batch = parameters.shape[:-2] if payload is None else np.broadcast_shapes(parameters.shape[:-2], payload.shape[:-1])
    bodies = np.zeros((*batch, len(tree.bodies), 10))
    for k, frame in enumerate(tree.frames.values()):
        bodies[..., frame.body, :] += moved_parameters(parameters[..., k, :], frame.R, frame.p)
    if payload is not None:
        bodies[..., tree.tip.body, :] += moved_parameters(payload, tree.tip.R, tree.tip.p)
    for i, body in reversed(tree.moving):
        passed = _pass(body.kind, bodies[..., i, :])
        bodies[..., i, :] -= passed
        bodies[..., body.parent, :] += moved_parameters(passed, body.R, body.p)
    return bodies[..., 1:, :]


def body_inertias(tree: BodyTree, parameters: Expression) -> list[CompositeInertia]:
    """Inertias of all bodies, base first, from regrouped parameters (10 (bodies - 1),) as expressions."""
    inertias = [CompositeInertia.of_parameters([ex.Expression(0.0)] * 10)]
    for i, body in tree.moving:
        felt = FELT.get(body.kind, range(10))
        at = 10 * (i - 1)
        inertias.append(
            CompositeInertia.of_parameters([parameters[at + k] if k in felt else ex.Expression(0.0) for k in range(10)])
        )
    return inertias


def friction_rows(mechanism: Mechanism) -> Floats:
    """(k, 4) viscous, Coulomb in either sense and offset of all joints that have friction."""
    law = friction_law(mechanism)
    return np.stack([law.viscous, law.positive, law.negative, law.offset], axis=1)


def _pass(kind: JointKind, parameters: Floats) -> Floats:
    """What of a body its joint does not feel."""
    passed = np.zeros_like(parameters)
    if kind is JointKind.REVOLUTE:
        passed[..., [M, HZ]] = parameters[..., [M, HZ]]
        passed[..., [XX, YY]] = parameters[..., YY, None]
    elif kind is JointKind.PRISMATIC:
        passed[..., XX:] = parameters[..., XX:]
    return passed
