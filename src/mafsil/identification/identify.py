"""From a log of a robot to a better model of it.

The prior: the parameters of the description, made physically consistent, and their spread.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from mafsil.arrays import Floats, positive
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.identification.examination import examine_log
from mafsil.identification.log import MotionLog, Remark, held_out_fraction
from mafsil.identification.regression import (
    BodyParameterisation,
    Fit,
    Parameterisation,
    RegressorStack,
    ball,
    fit_base_parameters,
    most_likely,
    nearest_consistent,
    physically_consistent,
)
from mafsil.identification.result import Identification, Parameter, Validation, unidentifiable
from mafsil.identification.smoothing import Log, SmoothMotion, opened, prepare_log
from mafsil.identification.tolerances import DEPENDENT, LEAST_MASS, NO_EFFORT
from mafsil.identification.torque_model import TorqueModel, with_parameters
from mafsil.mechanics.friction import SMOOTHING
from mafsil.mechanics.inertial_parameters import BaseParameters, inertial_parameters
from mafsil.model import Mechanism
from mafsil.robot import Robot, of_robot

PART_OF_EFFORT = 0.3
"""Friction takes about this share of a joint's efforts."""
PART_OF_INERTIA = 0.5
"""A rotor has about this share of the inertia that its joint moves."""
LEAST_INERTIA = 0.01
"""Of the largest inertia of all joints: what a rotor may have where the joint moves next to nothing."""
SLOWEST = 0.1
"""Rates below this [rad/s | m/s] do not count as motion."""
LEAST_RANGE = 0.02
"""A joint that covers less than this [rad | m] has hardly moved."""
SPREAD = 0.5
"""How far masses of a description may be off: a factor exp(2 SPREAD) either way is likely."""


@dataclass(frozen=True, eq=False, slots=True)
class _Problem:
    """Rows to learn from and rows held out, in the base parameters that are looked for."""

    stack: RegressorStack
    held_out: RegressorStack | None
    base: BaseParameters


@of_robot
def identify(
    robot: Robot,
    log: Log | Sequence[Log],
    *,
    validation: Log | None = None,
    held_out: float = 0.2,
    rotor_inertia: bool | None = None,
    bandwidth: float | None = None,
    prior_spread: float = SPREAD,
    smoothing: float = SMOOTHING,
    degrees: bool = False,
) -> Identification:
    """Masses, inertias, friction and, on request, rotor inertias from recorded motion and efforts.

    tau = Y(q, qd, qdd) pi + viscous qd + Coulomb sign(qd) + offset + rotor qdd, by weighted least squares.

    Before that the log is held against the description: reversed signs, degrees, milliseconds, a motor's efforts and
    swapped columns are named in `faults`, with their numbers, and then the answer is false.

    Args:
        robot: the kinematics, and its masses as prior.
        log: one or several logs; see `read_log` for files.
        validation: another log, on which the new model is tried; by default the end of each log is held out for it.
        held_out: the fraction of each log that is held out, 0 to 0.9.
        rotor_inertia: whether inertias of rotors are looked for; if None, where the description has some.
        bandwidth: highest frequency of the motion [Hz]; found in the log if None.
        prior_spread: how far masses of the description may be off, as a logarithm; small values hold on to them.
        smoothing: rate [rad/s | m/s] within which Coulomb friction changes its sign.
        degrees: whether revolute joints of a log file are in degrees.

    Raises:
        InputError: a log of another robot, too short, or not clean; the row is named.
        FileError: a log file that cannot be read; the line is named.

    Reference: Gautier & Khalil; Swevers et al., IEEE CSM 27(5), 2007; Wensing, Kim & Slotine, IEEE RA-L 3, 2018.
    """
    logs = [opened(one, robot, degrees) for one in _list(log)]
    model = TorqueModel(robot, positive("smoothing", smoothing))
    back = held_out_fraction("held_out", held_out) if validation is None else 0.0
    parts = [one.split(back) if back else (one, None) for one in logs]
    others = [opened(validation, robot, degrees)] if validation is not None else [end for _, end in parts if end]
    training = [prepare_log(start, bandwidth) for start, _ in parts]
    tests = [prepare_log(other, max(band for _, band, _ in training)) for other in others]
    rotors = bool(model.prior[-robot.n :].any()) if rotor_inertia is None else rotor_inertia
    full = _stack(model, _motions(training))
    if not full.rows:
        raise InputError("identification.too_short", seconds=max(one.duration for one in logs))
    tried = _stack(model, _motions(tests))
    problem = _problem(model, full, tried if tried.rows else None, rotors)
    remarks = [remark for one in logs for remark in one.remarks()]
    remarks += [remark for _, _, found in training for remark in found]
    remarks += _hardly_moving(robot, logs)
    band = max(band for _, band, _ in training)
    found = _identify(model, problem, full, positive("prior_spread", prior_spread), band, rotors, remarks)
    return replace(found, faults=tuple(examine_log(robot, _motions(training))))


def _motions(prepared: Sequence[tuple[list[SmoothMotion], float, list[Remark]]]) -> list[SmoothMotion]:
    """The motions of all logs, one after the other."""
    return [motion for motions, _, _ in prepared for motion in motions]


def _stack(model: TorqueModel, motions: list[SmoothMotion]) -> RegressorStack:
    blocks = (block for motion in motions for block in model.equations(motion))
    return RegressorStack.of(blocks, model.robot.n, model.base.count)


def _problem(model: TorqueModel, full: RegressorStack, tried: RegressorStack | None, rotors: bool) -> _Problem:
    """The rows as they are, or without the rotors' columns, the description's rotors taken as known."""
    base = model.base
    if rotors:
        return _Problem(full, tried, base)
    first = len(model.labels) - model.rotor_count
    columns = np.flatnonzero(np.array(base.columns) < first)
    known = base.combination[:, first:] @ model.prior[first:]
    combination = base.combination[columns].copy()
    combination[:, first:] = 0.0
    smaller = BaseParameters(
        tuple(base.labels[k] for k in columns),
        tuple(base.columns[k] for k in columns),
        combination,
        tuple(label for label in base.silent if not label.endswith(".rotor")),
    )
    return _Problem(full.reduce_columns(columns, known), tried and tried.reduce_columns(columns, known), smaller)


def _identify(
    model: TorqueModel,
    problem: _Problem,
    full: RegressorStack,
    spread: float,
    band: float,
    rotors: bool,
    remarks: list[Remark],
) -> Identification:
    start = prior_of(model, problem.stack, spread, rotors=rotors)
    parameterisation, K = start.parameterisation, problem.base.combination
    b0 = K @ parameterisation.prior
    fit = fit_base_parameters(problem.stack, b0, K @ parameterisation.at(np.zeros(parameterisation.size))[1])
    found = most_likely(parameterisation, fit.triangle, K, model.nonnegative)
    described, new = K @ model.prior, K @ found
    parameters = tuple(
        Parameter(label, float(b), float(error), float(before), float(after))
        for label, b, error, before, after in zip(
            problem.base.labels, fit.b, fit.standard_errors, described, new, strict=True
        )
    )
    remarks = [*remarks, *start.remarks]
    if not rotors:
        remarks += _rotors_needed(full, problem.stack, fit)
    return Identification(
        robot=Robot(with_parameters(model, found, rotors)),
        before=model.robot,
        parameters=parameters,
        covariance=fit.covariance,
        base=problem.base,
        identifiable_count=fit.identifiable_count,
        condition_number=fit.condition_number,
        noise=fit.noise,
        bandwidth=band,
        rows=problem.stack.rows,
        unidentifiable=unidentifiable(model, problem.base, fit, b0, parameterisation),
        validation=_validation(model.robot.joint_names, problem, described, new),
        remarks=tuple(remarks),
    )


def _validation(joints: tuple[str, ...], problem: _Problem, before: Floats, after: Floats) -> Validation:
    rows = problem.held_out or problem.stack
    effort = np.maximum(rows.effort(), LEAST_DIVISOR)
    training = problem.stack
    return Validation(
        joints=joints,
        held_out=problem.held_out is not None,
        effort=rows.effort(),
        before=100.0 * rows.residual(before) / effort,
        after=100.0 * rows.residual(after) / effort,
        training=100.0 * training.residual(after) / np.maximum(training.effort(), LEAST_DIVISOR),
    )


def _rotors_needed(full: RegressorStack, without: RegressorStack, fit: Fit) -> list[Remark]:
    """Whether rows fit so much better with rotors that it cannot be chance."""
    k = full.triangles.shape[-1] - 1
    R = full.weighted_triangle(fit.noise)
    b = np.asarray(np.linalg.lstsq(R[:, :-1], R[:, -1], rcond=DEPENDENT)[0], dtype=np.float64)
    with_rotors = full.residual(b)
    gain = (
        full.rows
        * ((without.residual(fit.b) ** 2 - with_rotors**2) / np.maximum(with_rotors, LEAST_DIVISOR) ** 2).sum()
    )
    better = float((with_rotors / without.residual(fit.b)).min())
    extra = max(k - (without.triangles.shape[-1] - 1), 1)
    if extra and gain > 30.0 * extra and better < 0.9:
        return [Remark("identification.rotors", {"percent": 100.0 * (1.0 - better)})]
    return []


def _hardly_moving(robot: Robot, logs: list[MotionLog]) -> list[Remark]:
    reach = np.max([np.ptp(one.signals()["q"], axis=0) for one in logs], axis=0)
    return [
        Remark("identification.hardly_moved", {"joint": name, "way": float(way)})
        for name, way in zip(robot.joint_names, reach, strict=True)
        if way < LEAST_RANGE
    ]


def _list(log: Log | Sequence[Log]) -> list[Log]:
    """One log or several, as a list; an empty one is refused."""
    logs = list(log) if isinstance(log, list | tuple) else [cast("Log", log)]
    if not logs:
        raise InputError("identification.no_log")
    return logs


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
            parameters[links[0]] = _invent(parameters[links].sum(axis=0), length)
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


def _invent(known: Floats, length: float) -> Floats:
    """A ball for a body of which at most a moment of inertia is known."""
    radius = 0.1 * length
    moment = float(known[4:7].max())
    return ball(2.5 * moment / radius**2 if moment > 0.0 else 1.0, radius, np.zeros(3))
