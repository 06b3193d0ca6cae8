"""Synthesis of six-bars that meet five positions of a path or of a function exactly.

A chain of three links follows any task; two links between its bodies leave it one freedom. Seen from one body, the
other takes five poses, and a link between them is a dyad of five poses: all are found, and all pairs of them.

- Path: crank (with timing), middle and last link with the point; a link from ground to the middle link, then one from
  ground (Stephenson) or from the crank (Watt) to the last one.
- Function: a four-bar is driven by the crank, and a link joins its rocker (Watt) or its coupler (Stephenson) to the
  output link, which turns about a third pivot.

Reference: G. S. Soh, J. M. McCarthy, The synthesis of six-bar linkages as constrained planar 3R chains, Mech. Mach.
Theory 43 (2008).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, number, positive, radians, single, whole
from mafsil.errors import InputError
from mafsil.mobility.four_bar import FourBar
from mafsil.mobility.synthesis.assessment import NO_LIMITS, LinkageLimits
from mafsil.mobility.synthesis.crank_chain import ChainSynthesis, Placed, rank_chains
from mafsil.mobility.synthesis.dyads import Complexes, as_complex, spread, unit_numbers
from mafsil.mobility.synthesis.function_task import angle_pairs
from mafsil.mobility.synthesis.path import checked_points, require_apart
from mafsil.mobility.synthesis.six_bar import (
    COUPLER,
    CRANK,
    GROUND,
    LAST,
    ROCKER,
    BodyPositions,
    Form,
    measure_six_bar,
)
from mafsil.mobility.tolerances import SAME_GROUND

MOST_TRIALS = 20
"""Random linkages tried for each sample: one in three or four closes at all positions."""
FIVE = 5
"""Positions that a dyad meets exactly in finitely many ways."""


@dataclass(frozen=True)
class ThreeLinkChain:
    """The chain that carries a path: crank, middle link and last link with the point, hinged in a row.

    Attributes:
        pivot: (2,) of the crank [m].
        lengths: of crank, middle and last link [m].
        phase: angle of the crank in the world, less its timing [rad].
        elbow: 1 for the hinge between middle and last link to the left of the line to the point, -1 for the right.
    """

    pivot: tuple[float, float]
    lengths: tuple[float, float, float]
    phase: float = 0.0
    elbow: int = 1

    def __post_init__(self) -> None:
        single("pivot", self.pivot, (2,))
        for value in single("lengths", self.lengths, (3,)).tolist():
            positive("lengths", value)
        number("phase", self.phase)
        if self.elbow not in (1, -1):
            raise InputError("input.whole", name="elbow", value=self.elbow, low=-1, high=1)

    def hinges(self, points: Complexes, timing: Floats) -> tuple[complex, Complexes, Complexes] | None:
        """Pivot, ends (N,) of the crank and of the middle link; None where it does not reach."""
        A, (a, b, c) = complex(*self.pivot), self.lengths
        B = A + a * unit_numbers(timing + self.phase)
        way = points - B
        s = np.abs(way)
        if (s > b + c).any() or (s < abs(b - c)).any() or s.min() == 0.0:
            return None
        turn = (b * b + s * s - c * c) / (2 * b * s)
        return A, B, B + b * way / s * (turn + 1j * self.elbow * np.sqrt(1.0 - turn**2))


def synthesise_six_bar_path(
    points: ArrayLike,
    timing: ArrayLike,
    *,
    form: Form = "stephenson",
    chains: Iterable[ThreeLinkChain] | None = None,
    samples: int = 40,
    seed: int = 0,
    limits: LinkageLimits = NO_LIMITS,
) -> ChainSynthesis:
    """Six-bars a point of which passes five points at given angles of the crank.

    Of one chain all links that complete it are found: at most twelve of Stephenson's form, nine of Watt's. Chains are
    free to choose: those given, or a sample, so that without chains the answer is a sample too.

    Args:
        points: (5, 2) [m].
        timing: (5,) angles of the crank, from any line [rad].
        form: `stephenson` (III) or `watt`.
        chains: crank, middle and last link to complete.
        samples: chains to try if none are given.
        seed: of the sample.
        limits: region of fixed pivots, least transmission angle, longest link.

    Raises:
        InputError: not five points, timing of another length, two equal points or angles, an unknown form.
    """
    z, angles = checked_points(points, FIVE, FIVE), radians("timing", single("timing", timing, (FIVE,)))
    require_apart(angles)
    base = {"stephenson": GROUND, "watt": CRANK}.get(_form(form), GROUND)
    task, T = np.column_stack([z, angles]), as_complex(z)
    given = chains is not None
    trials = list(chains) if chains is not None else _chains(T, angles, whole("samples", samples, 1, 4000), seed)
    placed: list[list[Placed]] = []
    reached = 0
    for chain in trials:
        hinges = chain.hinges(T, angles)
        if hinges is None:
            continue
        reached += 1
        placed += [[one] for one in _complete_chain(form, base, *hinges, T)]
    details = {"chains": reached}
    return rank_chains(placed, limits, "path", task, "six_bar_path", complete=given and reached > 0, details=details)


def _form(form: str) -> Form:
    """The form by name.

    Raises:
        InputError: an unknown one.
    """
    if form not in ("watt", "stephenson"):
        raise InputError("synthesis.six_bar_form", form=form)
    return form


def _chains(T: Complexes, timing: Floats, count: int, seed: int) -> Iterable[ThreeLinkChain]:
    """Chains at random about points (N,) that they reach, with links of about their size."""
    rng, size, middle = np.random.default_rng(seed), float(spread(T)), complex(T.mean())
    for _ in range(MOST_TRIALS * count):
        x, y = (rng.uniform(-2.5, 2.5, 2) * size + np.array([middle.real, middle.imag])).tolist()
        a, b, c = (rng.uniform((0.3, 0.8, 0.8), (1.5, 3.0, 3.0)) * size).tolist()
        chain = ThreeLinkChain((x, y), (a, b, c), float(rng.uniform(-np.pi, np.pi)), int(rng.choice([-1, 1])))
        if count and chain.hinges(T, timing) is not None:
            count -= 1
            yield chain


def _complete_chain(form: Form, base: int, A: complex, B: Complexes, P: Complexes, T: Complexes) -> list[Placed]:
    """Six-bars of one chain in N positions.

    Args:
        form: Watt's or Stephenson's.
        base: body from which the last link is held: the ground or the crank.
        A: pivot of the crank.
        B, P, T: (N,) ends of crank, middle and last link.
    """
    bodies = BodyPositions.of((np.zeros_like(B), np.ones_like(B)), (np.full_like(B, A), B), (B, P), (P, T))
    middle, last = 2, 3
    found: list[Placed] = []
    for C, D in bodies.links(middle, GROUND):
        if np.abs(D - A).max() <= SAME_GROUND * np.abs(B - A).max():
            continue  # the crank itself
        for Q, E in bodies.links(last, base):
            if base == CRANK and np.abs(E - B).max() <= SAME_GROUND * np.abs(P - B).max():
                continue  # the middle link itself
            one = measure_six_bar(form, A, B, C, D, (COUPLER, P, Q, base, E), T)
            found += [] if one is None else [one]
    return found


def synthesise_six_bar_function(
    inputs: ArrayLike,
    outputs: ArrayLike,
    *,
    form: Form = "watt",
    drivers: Iterable[tuple[FourBar, int, ArrayLike]] | None = None,
    samples: int = 100,
    seed: int = 0,
    limits: LinkageLimits = NO_LIMITS,
) -> ChainSynthesis:
    """Six-bars that coordinate five pairs of angles of the crank and of an output link.

    A four-bar with A at the origin and D on the x axis is driven; of it, and of the pivot E of the output link, all
    links that join both are found: at most three from the rocker (Watt), four from the coupler (Stephenson).

    Args:
        inputs: (5,) angles of the crank from the x axis [rad].
        outputs: (5,) angles of the output link, from any line [rad].
        form: `watt` or `stephenson` (III).
        drivers: four-bars, each with its assembly mode (0 or 1) and the pivot (2,) of the output link [m].
        samples: drivers to try if none are given, of ground 1 m.
        seed: of the sample.
        limits: region of fixed pivots, least transmission angle, longest link.

    Raises:
        InputError: not five pairs, two equal angles of the crank, an unknown form.
    """
    theta, phi = angle_pairs(inputs, outputs)
    if len(theta) != FIVE:
        raise InputError("synthesis.angle_count", got=theta.shape, least=FIVE, most=FIVE)
    body, given = ROCKER if _form(form) == "watt" else COUPLER, drivers is not None
    trials = drivers if drivers is not None else _drivers(theta, whole("samples", samples, 1, 4000), seed)
    placed: list[list[Placed]] = []
    reached = 0
    for bar, mode, pivot in trials:
        closed = bar.positions(theta)
        if not closed.reachable.all():
            continue
        reached += 1
        C = as_complex(closed.C[:, whole("mode", mode, 0, 1)])
        B = bar.crank * unit_numbers(theta)
        D, E = np.full_like(C, bar.ground), np.full_like(C, complex(*single("drivers", pivot, (2,))))
        zero, one = np.zeros_like(C), np.ones_like(C)
        bodies = BodyPositions.of((zero, one), (zero, B), (B, C), (D, C), (E, E + unit_numbers(phi)))
        for P, Q in bodies.links(body, LAST):
            if body == ROCKER and np.abs(P - D).max() <= SAME_GROUND * bar.ground:
                continue  # the ground itself
            found = measure_six_bar(form, 0j, B, C, D, (body, P, Q, GROUND, E), None)
            placed += [] if found is None else [[found]]
    task, details = np.column_stack([theta, phi]), {"chains": reached}
    return rank_chains(
        placed, limits, "function", task, "six_bar_function", complete=given and reached > 0, details=details
    )  # fmt: skip


def _drivers(theta: Floats, count: int, seed: int) -> Iterable[tuple[FourBar, int, ArrayLike]]:
    """Four-bars of ground 1 m at random that close at crank angles (N,), with a mode and a pivot of the output link."""
    rng = np.random.default_rng(seed)
    for _ in range(MOST_TRIALS * count):
        crank, coupler, rocker = rng.uniform((0.15, 0.4, 0.4), (0.9, 1.8, 1.8)).tolist()
        bar, mode, pivot = (
            FourBar(crank, coupler, rocker, 1.0),
            int(rng.integers(2)),
            rng.uniform((-1, -1.5), (2.5, 1.5)),
        )
        if count and bar.positions(theta).reachable.all():
            count -= 1
            yield bar, mode, pivot
