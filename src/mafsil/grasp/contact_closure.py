"""Force closure straight from contacts with round cones, by one compiled call."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial

import numpy as np

from mafsil.arrays import Floats, frozen
from mafsil.grasp.closure import NOT_ASKED, Closure, Margin, Verdict, closure, conditioning, inside, outside
from mafsil.grasp.cone import RoundSet
from mafsil.grasp.contact import Contact
from mafsil.grasp.enclosure import UNSURE, positive_weights

START = 6
"""Points on the rim of a round cone with which the search for a proof begins."""


def round_closure(contacts: Sequence[Contact], *, margins: bool = True) -> Closure:
    """Force closure of contacts with round cones, by one compiled call; near the boundary with care.

    Args:
        contacts: in space, some with friction.
        margins: False: the margin is not wanted, and NaN.
    """
    from mafsil.solvers import contact_span_loops as loops

    k = len(contacts)
    weights, most = positive_weights(START * k), k * (START + loops.ROUNDS)
    columns, x, y = np.empty((most, 6)), np.empty(most), np.empty(6)
    state, count = loops.contact_span((0,) * 6, rows(contacts), circle(START), weights, UNSURE, columns, x, y)
    closed, columns = state == loops.SPANS, columns[:count].T
    measured = partial(_margin, tuple(contacts), closed) if margins else NOT_ASKED
    if closed:
        return Closure(Verdict.YES, "grasp.closed", 6, 6, measured, columns, x[:count])
    if state == loops.OPEN:
        return Closure(Verdict.NO, "grasp.open", 6, 6, measured, columns, certificate=y)
    whole = RoundSet.of(contacts, np.eye(6))
    return closure(whole.rim(START), whole=whole, transform=conditioning([c.point for c in contacts]), margins=margins)


def rows(contacts: Sequence[Contact]) -> Floats:
    """(k, 2 d + 2) point, normal, mu and gamma of each contact."""
    return np.array([contact.row for contact in contacts])


@cache
def circle(edges: int) -> Floats:
    """(edges, 2) cosines and sines all round; read-only."""
    angles = 2 * np.pi * np.arange(edges) / edges
    return frozen(np.stack([np.cos(angles), np.sin(angles)], axis=1))


def _margin(contacts: Sequence[Contact], closed: bool) -> Margin:
    whole = RoundSet.of(contacts, np.eye(6))
    return (inside if closed else outside)(whole.rim(START), whole)
