"""What went wrong in a run, each as a number that another run of the same job can be held against."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from mafsil.arrays import Floats
from mafsil.job.arrival import Arrival, arrival, arrivals
from mafsil.job.run import Run
from mafsil.messages.quantities import quantity
from mafsil.model import JointKind

GIVES_WAY = (np.pi / 2, 0.5)
"""How far beyond everything planned a revolute or a prismatic joint is when the arm has given way [rad, m]."""
MOST_FAILURES = 5
"""Misses that get a sentence each; the rest are counted."""
BROKEN = 1.02
"""Share of a limit of speed or acceleration beyond which it is broken; what lies between is a warning."""
RATES = {"speed": ("qd", "velocity", "/s"), "acceleration": ("qdd", "acceleration", "/s²")}
"""Of each rate: its array in a recording, its limit, its unit."""


class Symptom(Protocol):
    """Something that went wrong."""

    @property
    def leg(self) -> int:
        """Until the end of which it shows."""
        ...

    def amount(self, run: Run) -> float:
        """How much of it there is in a run of the same job: at most 1 is allowed; inf where the run has no end there.

        Args:
            run: with at least the moves up to `leg`.
        """
        ...

    def measure(self, run: Run) -> str:
        """The same in words, or a key of the catalogue.

        Args:
            run: likewise.
        """
        ...


@dataclass(frozen=True, slots=True)
class EndedEarly:
    """The simulation stopped."""

    leg: int

    def amount(self, run: Run) -> float:
        """Nothing or everything."""
        return 0.0 if run.recording.status.succeeded else float("inf")

    def measure(self, run: Run) -> str:
        """Whether it came to its end."""
        return "@job.run_ends" if run.recording.status.succeeded else "@job.run_stops"


@dataclass(frozen=True, slots=True)
class GivenWay:
    """A joint beyond everything planned, by more than a quarter turn or half a metre."""

    leg: int
    joint: int

    def amount(self, run: Run) -> float:
        """As share of what counts as giving way."""
        return float(beyond_plan(run)[self.joint] / _way(run)[self.joint])

    def measure(self, run: Run) -> str:
        """How far beyond."""
        return joint_quantity(run, self.joint, float(beyond_plan(run)[self.joint]))


@dataclass(frozen=True, slots=True)
class Missed:
    """A target that was not reached.

    Attributes:
        leg: whose end it is.
        by: what is told of it: `position`, `orientation`, or the index of a joint.
    """

    leg: int
    by: Literal["position", "orientation"] | int

    def amount(self, run: Run) -> float:
        """As share of its tolerance."""
        judged = self._judge(run)
        return float("inf") if judged is None else judged.share

    def measure(self, run: Run) -> str:
        """The error that was the largest share of its tolerance in the run that missed."""
        judged = self._judge(run)
        if judged is None:
            return "@job.run_stops"
        if isinstance(self.by, int):
            return joint_quantity(run, self.by, float(judged.joint_errors[self.by]))
        if self.by == "position":
            return quantity(judged.position_error, "m")
        return quantity(judged.orientation_error, "rad")

    def _judge(self, run: Run) -> Arrival | None:
        return arrival(run.job, run.plan, self.leg, run.recording)


@dataclass(frozen=True, slots=True)
class LimitBroken:
    """A joint beyond 102 % of its speed or acceleration limit.

    Attributes:
        leg: in which it is worst.
        joint: which one.
        rate: `speed` or `acceleration`.
    """

    leg: int
    joint: int
    rate: str

    def amount(self, run: Run) -> float:
        """The excess over the limit, as share of what makes it a failure."""
        return (self._share(run) - 1.0) / (BROKEN - 1.0)

    def measure(self, run: Run) -> str:
        """The excess in per cent of the limit."""
        return quantity(max(self._share(run) - 1.0, 0.0), "share")

    def _share(self, run: Run) -> float:
        array, limit, _ = RATES[self.rate]
        peak = float(np.abs(getattr(run.recording, array)[:, self.joint]).max())
        return peak / float(getattr(run.robot.limits, limit)[self.joint])


def symptoms(run: Run) -> tuple[Symptom, ...]:
    """What went wrong in a run: that it stopped, that the arm gave way, the first misses, the limits it broke worst.

    Args:
        run: of a whole job.
    """
    missed = [missed_by(one) for one in arrivals(run.job, run.plan, run.recording) if not one.reached]
    return (*_ends(run), *missed[:MOST_FAILURES], *_broken(run))


def missed_by(judged: Arrival) -> Missed:
    """A miss, with the error that is the largest share of its tolerance."""
    allowed = judged.tolerances
    if judged.goal == "joints":
        return Missed(judged.leg, int((judged.joint_errors / allowed.joints).argmax()))
    way, turn = judged.position_error / allowed.position, judged.orientation_error / allowed.orientation
    return Missed(judged.leg, "position" if way >= turn else "orientation")


def beyond_plan(run: Run) -> Floats:
    """(n,) how far each joint was beyond everything planned, at most [rad | m]."""
    tape = run.recording
    beyond = np.maximum(tape.q_ref.min(axis=0) - tape.q, tape.q - tape.q_ref.max(axis=0))
    return np.asarray(beyond.max(axis=0))


def gave_way(run: Run) -> tuple[int, float] | None:
    """The joint that is farthest beyond everything planned, and since when [s], if the arm has given way.

    An arm that is led by hand where nothing pulls it back has not.
    """
    tape = run.recording
    if run.job.controller.guides:
        return None
    beyond = np.maximum(tape.q_ref.min(axis=0) - tape.q, tape.q - tape.q_ref.max(axis=0))
    share = beyond / _way(run)
    if not share.max() > 1.0:
        return None
    joint = int(share.max(axis=0).argmax())
    return joint, float(tape.t[int((share[:, joint] > 1.0).argmax())])


def joint_quantity(run: Run, joint: int, value: float, per: str = "") -> str:
    """A coordinate, or with `per` its rate, for people."""
    prismatic = run.robot.mechanism.coordinates[joint].kind is JointKind.PRISMATIC
    return quantity(value, ("m" if prismatic else "rad") + per)


def _ends(run: Run) -> Iterator[Symptom]:
    last = len(run.plan.legs) - 1
    if not run.recording.status.succeeded:
        yield EndedEarly(last)
    fallen = gave_way(run)
    if fallen is not None:
        yield GivenWay(last, fallen[0])


def _broken(run: Run) -> Iterator[Symptom]:
    """For speed and for acceleration the joint that is worst."""
    for rate, (array, limit, _) in RATES.items():
        allowed: Floats = getattr(run.robot.limits, limit)
        values: Floats = np.abs(getattr(run.recording, array))
        shares: Floats = values / np.where(allowed > 0.0, allowed, np.inf)
        if shares.max(initial=0.0) > BROKEN:
            row, joint = divmod(int(shares.argmax()), shares.shape[1])
            time = float(run.recording.t[row])
            leg = int(np.searchsorted(run.plan.starts, time, side="right")) - 1
            yield LimitBroken(min(leg, len(run.plan.legs) - 1), joint, rate)


def _way(run: Run) -> Floats:
    """(n,) [rad | m]."""
    revolute = run.robot.mechanism.angular
    return np.where(revolute, *GIVES_WAY)
