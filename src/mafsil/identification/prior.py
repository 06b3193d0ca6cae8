"""The prior: the parameters of the description, made physically consistent, and their spread."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.identification.consistency import (
    BodyParameterisation,
    Parameterisation,
    ball,
    nearest_consistent,
    physically_consistent,
)
from mafsil.identification.regression import RegressorStack
from mafsil.identification.remark import Remark
from mafsil.identification.tolerances import LEAST_MASS, NO_EFFORT
from mafsil.identification.torque_model import TorqueModel
from mafsil.mechanics.inertial_parameters import inertial_parameters
from mafsil.model import Mechanism

PART_OF_EFFORT = 0.3
"""Friction takes about this share of a joint's efforts."""
PART_OF_INERTIA = 0.5
"""A rotor has about this share of the inertia that its joint moves."""
LEAST_INERTIA = 0.01
"""Of the largest inertia of all joints: what a rotor may have where the joint moves next to nothing."""
SLOWEST = 0.1
"""Rates below this [rad/s | m/s] do not count as motion."""


@dataclass(frozen=True, eq=False, slots=True)
class Prior:
    """All physically consistent parameters around the description.

    Attributes:
        parameterisation: its origin is the description, or what had to stand in for it.
        remarks: links whose masses had to be invented or changed.
    """

    parameterisation: Parameterisation
    remarks: tuple[Remark, ...]


def prior_of(model: TorqueModel, stack: RegressorStack, spread: float, *, rotors: bool) -> Prior:
    """The prior of a robot.

    Args:
        model: the parameters.
        stack: the rows, whose efforts bound the friction.
        spread: how far the masses of the description may be off, as a logarithm.
        rotors: whether rotor inertias are free.
    """
    inertial, bodies, remarks = _bodies(model.robot.mechanism)
    prior = model.prior.copy()
    prior[: model.inertial_count] = inertial.ravel()
    scale = np.zeros(len(prior))
    scale[model.inertial_count : -model.rotor_count] = _friction_scale(model, stack)
    if rotors:
        typical = np.array([model.robot.mass_matrix(np.zeros(model.robot.n))]).reshape(model.robot.n, -1).diagonal()
        floor = PART_OF_INERTIA * np.maximum(typical, LEAST_INERTIA * max(float(typical.max()), LEAST_MASS))
        scale[-model.rotor_count :] = np.maximum(prior[-model.rotor_count :], floor)
    return Prior(Parameterisation(bodies, scale, prior, spread), tuple(remarks))


def _friction_scale(model: TorqueModel, stack: RegressorStack) -> Floats:
    """(3 n,) what viscous, Coulomb and offset of each joint may be."""
    n = model.robot.n
    effort = np.maximum(PART_OF_EFFORT * stack.effort(), NO_EFFORT)
    places = {column: k for k, column in enumerate(model.base.columns)}
    size, rates = stack.size(), np.full(n, SLOWEST)
    for j in range(n):
        column = places.get(model.inertial_count + 3 * j)
        if column is not None:
            rates[j] = max(float(size[j, column]), SLOWEST)
    return np.stack([effort / rates, effort, effort], axis=1).ravel()


def _bodies(mechanism: Mechanism) -> tuple[Floats, dict[int, BodyParameterisation], list[Remark]]:
    """Parameters (L, 10) that bodies can have, parameterisations of those that move, and what was changed."""
    parameters = inertial_parameters(mechanism).copy()
    length = max(sum(float(np.linalg.norm(joint.T_pj[:3, 3])) for joint in mechanism.joints), 0.1)
    lumps = _lumps(mechanism)
    remarks: list[Remark] = []
    for links in lumps:
        if not (parameters[links, 0] > 0.0).any():
            parameters[links[0]] = _invented(parameters[links].sum(axis=0), length)
            name, mass = mechanism.links[links[0]].name, float(parameters[links[0], 0])
            remarks.append(Remark("identification.invented", {"link": name, "mass": mass}))
    parameterisations: dict[int, BodyParameterisation] = {}
    for k in (k for links in lumps for k in links if parameters[k, 0] > 0.0):
        near = nearest_consistent(parameters[k], length)
        if not physically_consistent(parameters[k]):
            remarks.append(Remark("identification.impossible", {"link": mechanism.links[k].name}))
        parameters[k] = near
        parameterisations[10 * k] = BodyParameterisation.around(near)
    return parameters, parameterisations, remarks


def _lumps(mechanism: Mechanism) -> list[list[int]]:
    """Links that move as one, by their places; what is fixed to the ground is left out."""
    place = {link.name: k for k, link in enumerate(mechanism.links)}
    body, lumps = {mechanism.links[0].name: -1}, list[list[int]]()
    for joint in mechanism.joints:
        if joint.moves:
            body[joint.child] = len(lumps)
            lumps.append([])
        else:
            body[joint.child] = body[joint.parent]
        if body[joint.child] >= 0:
            lumps[body[joint.child]].append(place[joint.child])
    return lumps


def _invented(known: Floats, length: float) -> Floats:
    """A ball for a body of which at most a moment of inertia is known."""
    radius = 0.1 * length
    moment = float(known[4:7].max())
    return ball(2.5 * moment / radius**2 if moment > 0.0 else 1.0, radius, np.zeros(3))
