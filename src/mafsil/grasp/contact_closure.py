"""Force closure straight from contacts with round cones, by one compiled call."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial

import numpy as np

from mafsil.arrays import Floats, frozen
from mafsil.grasp import loops
from mafsil.grasp.closure import (
    NOT_REQUESTED,
    Closure,
    ClosureStatus,
    Margin,
    closure,
    conditioning,
    margin_inside,
    margin_outside,
)
from mafsil.grasp.contact import Contact
from mafsil.grasp.enclosure import ConeWrenches, positive_weights
from mafsil.grasp.tolerances import SOLVER

START = 6
"""Points on the rim of a round cone with which the search for a proof begins."""


def round_closure(contacts: Sequence[Contact], *, margins: bool = True) -> Closure:
    """Force closure of contacts with round cones, by one compiled call; near the boundary with care.

    Args:
        contacts: in space, some with friction.
        margins: False: the margin is not requested, and NaN.
    """
    program, k = loops.contact_span_loops, len(contacts)
    weights, most = positive_weights(START * k), k * (START + program.ROUNDS)
    columns, x, y = np.empty((most, 6)), np.empty(most), np.empty(6)
    state, count = program.contact_span((0,) * 6, rows(contacts), circle(START), weights, SOLVER, columns, x, y)
    closed, columns = state == program.SPANS, columns[:count].T
    measured = partial(_margin, tuple(contacts), closed) if margins else NOT_REQUESTED
    if closed:
        return Closure(ClosureStatus.CLOSED, 6, 6, measured, columns, x[:count])
    if state == program.OPEN:
        return Closure(ClosureStatus.OPEN, 6, 6, measured, columns, certificate=y)
    cones = ConeWrenches.of(contacts, np.eye(6))
    return closure(cones.rim(START), cones=cones, transform=conditioning([c.point for c in contacts]), margins=margins)


def rows(contacts: Sequence[Contact]) -> Floats:
    """(k, 2 d + 2) point, normal, mu and gamma of each contact."""
    return np.array([contact.row for contact in contacts])


@cache
def circle(edges: int) -> Floats:
    """(edges, 2) cosines and sines all round; read-only."""
    angles = 2 * np.pi * np.arange(edges) / edges
    return frozen(np.stack([np.cos(angles), np.sin(angles)], axis=1))


def _margin(contacts: Sequence[Contact], closed: bool) -> Margin:
    cones = ConeWrenches.of(contacts, np.eye(6))
    return (margin_inside if closed else margin_outside)(cones.rim(START), cones)
