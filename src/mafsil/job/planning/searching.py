"""Moves that a signal or a force of contact ends early: the arm brakes on its path.

Signals are known to the plan. A force is known to the simulation alone: who solves the job simulates the moves up to a
search, the tick at which the force comes stops it, and the moves after it are planned from there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.job.language.description import Job, Move
from mafsil.job.planning.cell_signals import conditions
from mafsil.job.planning.plan import Leg, Plan
from mafsil.job.planning.walk import Walk
from mafsil.job.remark import Refused, Remark
from mafsil.job.tolerances import WITHIN_LIMITS
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible
from mafsil.trajectory import Motion, Trajectory, check
from mafsil.trajectory.motion import moving_at, times

QUICKEST_BRAKE, SLOWER, LONGEST_BRAKE = 0.005, 1.3, 1.0
"""Times of braking that are tried: the first, the factor to the next, and the last [s]."""


@dataclass(frozen=True, eq=False, slots=True)
class StoppedMotion:
    """A motion up to a time, then braked on its path: its own time x has x' = 1, then 1 - (t - stop) / brake.

    Attributes:
        whole: the motion.
        stop: when braking begins [s].
        brake: how long it takes [s].
    """

    whole: Trajectory
    stop: float
    brake: float

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return self.stop + self.brake

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.whole.n

    def breaks(self) -> Floats:
        """Times between which it is smooth [s]."""
        x = self.whole.breaks()
        later = np.clip(x[(x > self.stop) & (x < self.stop + self.brake / 2.0)] - self.stop, 0.0, self.brake / 2.0)
        braking = self.stop + self.brake * (1.0 - np.sqrt(1.0 - 2.0 * later / self.brake))
        return np.unique(np.concatenate([x[x < self.stop], [self.stop], braking, [self.duration]]))

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration."""
        moment = times(t)
        x, rate, growth = self._clock(moment)
        u, v, a = self.whole.at(x)
        moving = moving_at(moment, self.duration, 1)
        return Motion(u, v * rate * moving, (a * rate**2 + v * growth) * moving)

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, n) third derivative at the times `t` [rad/s^3 | m/s^3]; zero outside 0 .. duration."""
        moment = times(t)
        x, rate, growth = self._clock(moment)
        whole = self.whole.jerk(x) * rate**3 + 3.0 * self.whole.at(x).a * rate * growth
        return whole * moving_at(moment, self.duration, 1)

    def _clock(self, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Time of the motion (*times), its rate and that of the rate (*times, 1)."""
        past = np.clip(t - self.stop, 0.0, self.brake)
        x = np.minimum(t, self.stop) + past - past**2 / (2.0 * self.brake)
        growth = np.where(t > self.stop, -1.0 / self.brake, 0.0)
        return x, (1.0 - past / self.brake)[..., None], growth[..., None]


def stop_by_signal(walk: Walk, index: int, move: Move) -> None:
    """The move just planned ends at the tick at which its signals come; refused where they do not."""
    leg, where = walk.legs[-1], walk.where(index)
    if walk.others_that_set(move.until) is not None:
        raise Refused("job.search_others", move=where, wanted=conditions(move.until))
    begin = walk.past - leg.trajectory.duration
    end = walk.signals.end_of_wait(begin, move.until, leg.trajectory.duration)
    if end is None:
        state = walk.signals.states(tuple(move.until), walk.past)
        raise Refused("job.search_end", move=where, wanted=conditions(move.until), state=state)
    _stop(walk, index, end - begin)
    details = {"move": where, "wanted": conditions(move.until), "time": quantity(end - begin, "s")}
    walk.remarks.append(Remark("good", "job.search_signal", details))


def stop_by_force(walk: Walk, index: int) -> None:
    """The move just planned ends where the force comes, as far as that is known."""
    walk.searches += 1
    if walk.searches <= len(walk.stops):
        time = walk.stops[walk.searches - 1]
        _stop(walk, index, time)
        walk.legs[-1] = replace(walk.legs[-1], stopped=time)


def _stop(walk: Walk, index: int, time: float) -> None:
    """Brake the last leg from a time on, within the limits [s]."""
    leg = walk.legs[-1]
    scale = walk.job.limits.acceleration_scale
    scaled = walk.scaled_limits(walk.job.move[index])
    limits = replace(scaled, acceleration=scaled.acceleration / scale, jerk=np.full(leg.trajectory.n, np.inf))
    brake, motion = QUICKEST_BRAKE, leg.trajectory
    while time + brake / 2.0 < leg.trajectory.duration:
        motion = StoppedMotion(leg.trajectory, time, brake)
        if check(motion, limits, tolerance=WITHIN_LIMITS):
            break
        brake, motion = SLOWER * brake, leg.trajectory
        if brake > LONGEST_BRAKE:
            raise Refused("job.search_brake", move=walk.where(index))
    walk.past += motion.duration - leg.trajectory.duration
    walk.q = motion.at(motion.duration).u
    place = np.asarray(walk.robot.forward_kinematics(walk.q))
    walk.legs[-1] = replace(leg, trajectory=motion, target=None, timing=None, targets=(place,))


def is_search(job: Job, leg: Leg) -> bool:
    """Whether a leg is a search by force."""
    return leg.index >= 0 and job.move[leg.index].until_force is not None


def search_remarks(job: Job, plan: Plan, *, simulated: bool = False) -> list[Remark]:
    """Where each search by force ended, or that it did not."""
    found: list[Remark] = []
    for leg in plan.legs:
        if not is_search(job, leg):
            continue
        force = quantity(job.move[leg.index].until_force or 0.0, "N")
        details = {"move": visible(leg.name) or str(leg.index + 1), "force": force}
        if leg.stopped is None:
            key, level = ("job.search_nothing", "failure") if simulated else ("job.search_open", "warning")
            found.append(Remark(level, key, details))
        elif simulated:
            found.append(Remark("good", "job.search_force", details | {"time": quantity(leg.stopped, "s")}))
    return found
