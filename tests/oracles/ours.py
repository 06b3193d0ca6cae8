"""Our own numbers by two methods: CasADi evaluating the expression, and the compiled kernels."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import ModelError
from mafsil.mechanics.catalogue import CATALOGUE
from mafsil.model import Mechanism
from mafsil.robot.trace import signature, trace
from tests.oracles.casadi_expression import as_casadi
from tests.oracles.oracle import Answers
from tests.oracles.states import States

ALL = (
    "forward_kinematics",
    "link_poses",
    "jacobian_space",
    "jacobian_body",
    "jacobian_space_rate",
    "jacobian_body_rate",
    "inverse_dynamics",
    "forward_dynamics",
    "mass_matrix",
    "coriolis_matrix",
    "velocity_torque",
    "gravity_torque",
    "kinetic_energy",
    "potential_energy",
    "inverse_dynamics tip_wrench",
    "forward_dynamics tip_wrench",
)
"""Names of the quantities that the oracles answer too, optional inputs named behind."""


def traced(mechanism: Mechanism, states: States, names: Iterable[str] = ALL) -> Answers:
    """By CasADi's virtual machine, without our code generator."""
    return _answered(names, lambda name: _evaluated(mechanism, states, name))


def compiled(robot: Any, states: States, names: Iterable[str] = ALL) -> Answers:
    """By the kernels of a Robot."""

    def evaluated(name: str) -> Floats:
        row, *optional = name.split()
        return robot.kernel(row, None, tuple(optional))(*_inputs(name, states))

    return _answered(names, evaluated)


def _answered(names: Iterable[str], evaluated: Callable[[str], Floats]) -> Answers:
    """All quantities but the accelerations of robots that have none: joints that move no inertia."""
    answers: Answers = {}
    for name in names:
        try:
            answers[name] = evaluated(name)
        except ModelError as error:
            if error.key not in ("mechanics.no_inertia", "mechanics.singular"):
                raise
    return answers


def function(mechanism: Mechanism, name: str) -> Any:
    """The function of a quantity, for CasADi to evaluate."""
    row, *optional = name.split()
    return as_casadi(trace(mechanism, CATALOGUE[row], None, tuple(optional)))


def _inputs(name: str, states: States) -> list[Floats]:
    row, *optional = name.split()
    return states.arguments((*CATALOGUE[row].inputs, *optional))


def _evaluated(mechanism: Mechanism, states: States, name: str) -> Floats:
    row, *optional = name.split()
    shape = signature(mechanism, CATALOGUE[row], tuple(optional)).outputs[0].shape
    columns = [np.ascontiguousarray(x.T) for x in _inputs(name, states)]
    result = np.asarray(function(mechanism, name)(*columns).full())
    return np.ascontiguousarray(result.T).reshape(len(states), *shape)
