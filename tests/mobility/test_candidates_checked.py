"""A candidate of a synthesis is counted only if its own positions keep the lengths of its links."""

from __future__ import annotations

import numpy as np

from mafsil.mobility.synthesis.answers import SynthesisStatus, outcome, rank_candidates
from mafsil.mobility.synthesis.fitting import Positions


def turned(count: int, error: float) -> Positions:
    """Four-bars of a planted linkage in three positions, of which one pivot is off by an error."""
    crank, coupler, rocker, ground = 1.0, 3.0, 2.5, 3.2
    B = crank * np.exp(1j * np.array([0.3, 0.8, 1.3]))
    span = ground - B
    d = np.abs(span)
    angle = np.arccos((coupler**2 + d**2 - rocker**2) / (2 * coupler * d))
    C = B + coupler * span / d * np.exp(1j * angle)
    moved = C.copy()
    moved[1] += error
    rows = np.ones(count)
    frame = np.tile([1.0, 0.0, 0.0], (count, 1))
    return Positions(0j * rows, np.tile(B, (count, 1)), np.tile(moved, (count, 1)), ground * rows + 0j, frame)


def test_links_that_change_their_lengths_are_no_candidate():
    for error, counted in ((0.0, 2), (1e-12, 2), (1e-6, 0), (1e-2, 0)):
        found = rank_candidates([turned(2, error)], 1.0, either_side=False)
        assert found.count == counted
        assert (outcome(found) is SynthesisStatus.NONE) == (counted == 0)
    both = rank_candidates([turned(1, 0.0), turned(3, 1e-3)], 1.0, either_side=True)
    assert both.count == 1
    assert both.candidates[0].residual < 1e-9
