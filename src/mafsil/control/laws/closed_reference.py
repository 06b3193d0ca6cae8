"""A motion of the driven joints of a closed chain, as the motion of all its joints that keeps the loops closed."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, as_batch, require_kind
from mafsil.errors import InputError
from mafsil.parallel import ClosedChain
from mafsil.solvers import decompositions
from mafsil.trajectory import Motion, Trajectory

LONGEST_STEP = 0.05
"""Of the driven joints between two places from which configurations are found [rad | m]."""
FEWEST, MOST = 16, 20_000
SAMPLES = 400
"""Times at which the length of the motion is measured."""
FARTHEST = 10.0
"""Times the driven step, or its own usual step, that a passive joint may go in one: more is another way to close."""
DIFFERENCE = 1e-5
"""Time between accelerations for their derivative, over the duration."""
RANK = 1e-9
"""Singular value of the passive columns over the largest below which driven joints do not decide the others."""


@dataclass(frozen=True, eq=False)
class DrivenTrajectory:
    """All joints of a closed chain while its driven joints follow a trajectory.

    Attributes:
        chain: whose loops stay closed.
        driven: (a,) trajectory of the driven joints.
        places: (k,) times [s] of known configurations.
        known: (k, n) configurations that close the loops; those between are found from them.
    """

    chain: ClosedChain
    driven: Trajectory
    places: Floats = field(repr=False)
    known: JointVector = field(repr=False)

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return self.driven.duration

    @property
    def n(self) -> int:
        """Number of coordinates of the tree."""
        return self.chain.n

    def breaks(self) -> Floats:
        """Times between which the motion is smooth [s]."""
        return self.driven.breaks()

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration of all joints at the times `t` (*times) [s]."""
        motion, chain = self.driven.at(t), self.chain
        moment = np.clip(np.asarray(t, dtype=np.float64), 0.0, self.duration)
        columns: list[Floats] = [np.interp(moment, self.places, column) for column in self.known.T]
        guess: Floats = np.stack(columns, axis=-1)
        return Motion(*chain.following(guess, np.stack([motion.u, motion.v, motion.a], axis=-2)))

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, n) third derivative, by differences of accelerations on the side that moves [rad/s^3 | m/s^3]."""
        moment = np.asarray(t, dtype=np.float64)
        h = DIFFERENCE * max(self.duration, DIFFERENCE)
        low, high = (np.clip(moment + s, 0.0, self.duration) for s in (-h, h))
        return (self.at(high).a - self.at(low).a) / np.maximum(high - low, h)[..., None]


def driven_trajectory(chain: ClosedChain, driven: Trajectory, q_0: ArrayLike) -> DrivenTrajectory:
    """The motion of all joints that keeps the loops closed while the driven ones follow a trajectory.

    1. The start is closed with the driven joints where the trajectory begins.
    2. Configurations are followed from place to place, driven joints held, by Newton's method.
    3. Where the loops cannot be closed, or the driven joints do not decide the others, there is no such motion.

    Args:
        chain: a mechanism with loops.
        driven: trajectory of its a driven joints.
        q_0: (n,) all joints near the start: they say which way the loops are closed.

    Raises:
        InputError: a trajectory of another width; the loops cannot be closed at some time (named, with the gap), or the
            motion passes a singular configuration of the driven joints.
    """
    require_kind("chain", chain, "ClosedChain", "actuated", "close_loops")
    require_kind("driven", driven, "Trajectory", "n", "duration", "at")
    a = chain.actuated
    if driven.n != len(a):
        details = {"expected": f"n = {len(a)}", "got": f"n = {driven.n}", "hint": ""}
        raise InputError("input.shape", name="driven", **details)
    here = np.array(as_batch("q_0", q_0, (chain.n,), finite=True))
    if here.ndim != 1:
        raise InputError("input.shape", name="q_0", expected=(chain.n,), got=here.shape, hint="")
    t = _places(driven)
    u = driven.at(t).u
    known = np.empty((len(t), chain.n))
    for k, place in enumerate(u):
        guess = here + (known[k - 1] - known[k - 2] if k > 1 else 0.0)
        guess[a] = place
        found = chain.close_loops(guess, hold=a, tries=1)
        if not found:
            gap = float(found.error) if np.isfinite(found.error) else np.inf
            raise InputError("control.loops_not_closed", time=float(t[k]), gap=gap)
        if k and np.abs(found.q - here).max() > FARTHEST * max(np.abs(place - u[k - 1]).max(), LONGEST_STEP):
            raise InputError("control.loops_jump", time=float(t[k]), gap=float(np.abs(found.q - here).max()))
        known[k] = here = found.q
    _require_decided(chain, t, known)
    return DrivenTrajectory(chain, driven, t, known)


def _places(driven: Trajectory) -> Floats:
    """Times so close that no driven joint goes farther than a step between two of them."""
    t = np.linspace(0.0, driven.duration, SAMPLES)
    length = float(np.abs(np.diff(driven.at(t).u, axis=0)).sum(axis=0).max(initial=0.0))
    count = int(np.clip(np.ceil(length / LONGEST_STEP), FEWEST, MOST))
    return np.linspace(0.0, driven.duration, count + 1)


def _require_decided(chain: ClosedChain, t: Floats, known: JointVector) -> None:
    """Refuse places where the rates of the driven joints do not decide those of the others."""
    passive = np.setdiff1d(np.arange(chain.n), chain.actuated)
    s = decompositions.singular_values(np.ascontiguousarray(chain.terms(known).J[..., passive]))
    least = s[:, len(passive) - 1] if s.shape[1] >= len(passive) else np.zeros(len(t))
    free = least <= RANK * np.maximum(s[:, 0], 1.0)
    if len(passive) and free.any():
        raise InputError("control.loops_undecided", time=float(t[int(free.argmax())]))
