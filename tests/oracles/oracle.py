"""What an independent source of the same numbers looks like, and how mimic joints are taken out of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mafsil.arrays import Floats
from mafsil.model import Joint, Mechanism
from tests.oracles.states import States

Answers = dict[str, Floats]
"""Quantity name -> (N, *core)."""


class Oracle(Protocol):
    """Evaluates the quantities it knows, one state after the other, by code that shares nothing with ours."""

    name: str

    def evaluate(self, states: States) -> Answers: ...


class Unsupported(Exception):
    """The oracle has no such joint."""


@dataclass(frozen=True, eq=False)
class Expansion:
    """All moving joints from the coordinates, q_all = B q + b: oracles know no mimic joints.

    By duality tau = B' tau_all, M = B' M_all B, C = B' C_all B, J = J_all B.
    """

    joints: tuple[Joint, ...]
    B: Floats
    b: Floats

    @property
    def follows(self) -> bool:
        return self.B.shape[0] != self.B.shape[1]


def expansion(mechanism: Mechanism) -> Expansion:
    """Rows in the order of the mechanism's moving joints."""
    column = {joint.name: k for k, joint in enumerate(mechanism.coordinates)}
    moving = tuple(joint for joint in mechanism.joints if joint.moves)
    B, b = np.zeros((len(moving), mechanism.n)), np.zeros(len(moving))
    for row, joint in enumerate(moving):
        if joint.mimic is None:
            B[row, column[joint.name]] = 1.0
        else:
            B[row, column[joint.mimic.leader]], b[row] = joint.mimic.multiplier, joint.mimic.offset
    return Expansion(moving, B, b)


def stacked(rows: list[Answers]) -> Answers:
    """One array per quantity."""
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def accelerations(M: Floats, load: Floats) -> Floats:
    """M^-1 load; NaN for a singular M: a robot with joints that move no inertia."""
    try:
        return np.linalg.solve(M, load)
    except np.linalg.LinAlgError:
        return np.full_like(load, np.nan)
