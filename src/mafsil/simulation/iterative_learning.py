"""Iterative learning: the same motion again and again, each pass corrected by the errors of the last one.

What the law's feedback had to add in one pass becomes feedforward of the next, u_{j+1} = Q (u_j + gain feedback_j), Q a
low pass without phase. Of a linear loop with sensitivity S it multiplies the feedback by Q (1 - gain (1 - S)) each
time, so it converges where that is below one at all frequencies.

Reference: Bristow, Tharayil and Alleyne, A survey of iterative learning control, IEEE Control Systems 26(3), 2006.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, positive, real_array, require_kind, whole
from mafsil.control import Gains, combine
from mafsil.control.joints import LearnedEffort
from mafsil.errors import InputError
from mafsil.messages.tables import number, table
from mafsil.simulation.loop import simulate
from mafsil.simulation.recording import Recording, SimulationStatus
from mafsil.simulation.scenario import Scenario
from mafsil.trajectory import Motion

FREQUENCIES = 2000
"""At which the convergence of a joint is looked at."""
REACH = 4.0
"""Standard deviations of the low pass at which it is cut off."""


class LearningStatus(Status):
    """Whether passes got better."""

    IMPROVED = ("simulation.learning_improved", True)
    WORSE = ("simulation.learning_worse", False)
    FAILED = ("simulation.learning_failed", False)


@dataclass(frozen=True, eq=False, repr=False)
class LearningRun(Answer, data="error effort period", entries="passes"):
    """All passes; true if the last one follows better than the first, iterable over the recordings.

    Attributes:
        passes: recordings, the first without anything learned.
        error: (passes, n) root mean square error of each joint [rad | m].
        effort: (k, n) what was learned, for the next pass [N m | N].
        period: between rows of it [s].
    """

    passes: tuple[Recording, ...]
    error: Floats
    effort: Floats
    period: float

    @property
    def law(self) -> LearnedEffort:
        """What was learned as a law, to be combined with the feedback."""
        return LearnedEffort(self.period, self.effort)

    @property
    def status(self) -> LearningStatus:
        """FAILED where a pass did not come to its end."""
        if not self.passes[-1]:
            return LearningStatus.FAILED
        total = np.linalg.norm(self.error, axis=1)
        return LearningStatus.IMPROVED if total[-1] < total[0] else LearningStatus.WORSE

    def _table(self) -> list[str]:
        head = ("", *(f"{k + 1}" for k in range(self.error.shape[1])))
        rows = [(str(k + 1), *(number(each) for each in row)) for k, row in enumerate(self.error.tolist())]
        return table(head, rows)

    def explain(self, language: str | None = None) -> str:
        """The errors of the first and of the last pass."""
        total = np.linalg.norm(self.error, axis=1)
        return self.status.sentence(
            language, passes=len(self), first=float(total[0]), last=float(total[-1]), best=int(total.argmin()) + 1
        )


def iterative_learning(scenario: Scenario, passes: int = 8, *, gain: float = 1.0, cutoff: float = 20.0) -> LearningRun:
    """Iterative learning control: the feedback of each pass is added to the feedforward of the next.

    1. A pass with the law and what was learned.
    2. What the law commanded beyond that, and beyond what it commands where there is no error (its model), is feedback;
       it is added to what was learned, and low passed.

    Args:
        scenario: its law is feedback, or feedback and model; a batch is not learned from.
        passes: how many.
        gain: share of the feedback that is learned, above 0 and at most 1.
        cutoff: of the low pass, where it lets half of the power through [Hz]; what is faster stays feedback.

    Raises:
        InputError: a number out of its range, a batch.
    """
    require_kind("scenario", scenario, "Scenario", "trajectory", "law")
    count, share = whole("passes", passes, 1, 10_000), _share(gain)
    start, _ = scenario.start()
    if start.ndim != 1:
        raise InputError("simulation.learning_batch", shape=start.shape)
    period = scenario.control_period
    learned: Floats | None = None
    recordings: list[Recording] = []
    errors = list[Floats]()
    for _ in range(count):
        # 1
        law = scenario.law if learned is None else combine(scenario.law, LearnedEffort(period, learned))
        run = simulate(replace(scenario, law=law))
        if run.status is SimulationStatus.INTERRUPTED:
            raise KeyboardInterrupt
        recordings.append(run)
        errors.append(np.asarray(np.sqrt(np.mean((run.q_ref - run.q) ** 2, axis=0))))
        if not run:
            break
        # 2
        before = np.zeros_like(run.tau_commanded) if learned is None else learned
        feedback = run.tau_commanded - before - _on_reference(scenario, run)
        learned = low_passed(before + share * feedback, positive("cutoff", cutoff) * period)
    return LearningRun(
        tuple(recordings), np.stack(errors), np.zeros((0, len(start))) if learned is None else learned, period
    )


def _on_reference(scenario: Scenario, run: Recording) -> Floats:
    """(k, n) what the law commands where the motion is the reference [N m | N]."""
    u, v = run.q_ref, run.qd_ref
    wanted = [Motion(u[k], v[k], run.qdd_ref[k]) for k in range(len(u))]
    return np.stack([scenario.law(float(t), u[k], v[k], wanted[k]) for k, t in enumerate(run.t)])


def low_passed(values: ArrayLike, cutoff: float) -> Floats:
    """(k, n) values without what is fast and without delay: the mean under a bell curve, ends held on.

    Args:
        values: (k, n).
        cutoff: where half of the power passes, in cycles per row.
    """
    rows = real_array("values", values)
    width = np.sqrt(np.log(2.0)) / (2.0 * np.pi * positive("cutoff", cutoff))
    reach = min(int(np.ceil(REACH * width)), len(rows))
    bell = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
    bell /= bell.sum()
    padded = np.pad(rows, ((reach, reach), (0, 0)), mode="edge")
    found = np.empty_like(rows)
    for k in range(rows.shape[1]):
        found[:, k] = np.convolve(padded[:, k], bell, mode="valid")
    return found


def learning_factor(gains: Gains, *, gain: float = 1.0, cutoff: float = 20.0) -> Floats:
    """(n,) what the feedback is multiplied by from pass to pass at the worst frequency, joint by joint.

    For a loop whose error obeys e'' + kd e' + kp e + ki int e = ..., such as computed torque: below one the passes
    converge. Loops of damping 0.7 and more do with any cutoff.

    Args:
        gains: of the feedback, in units of acceleration.
        gain, cutoff: as for `iterative_learning`.
    """
    require_kind("gains", gains, "Gains", "kp", "kd", "ki")
    w = np.geomspace(1e-3, 1e5, FREQUENCIES)[:, None]
    s = 1j * w
    sensitivity = s**3 / (s**3 + gains.kd * s**2 + gains.kp * s + gains.ki)
    passed = 2.0 ** (-0.5 * (w / (2.0 * np.pi * positive("cutoff", cutoff))) ** 2)
    return np.asarray((passed * np.abs(1.0 - _share(gain) * (1.0 - sensitivity))).max(axis=0))


def _share(gain: float) -> float:
    value = positive("gain", gain)
    if value > 1.0:
        raise InputError("input.range", name="gain", value=value, low=0.0, high=1.0)
    return value
