"""Trajectories one after the other, with rests between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, frozen, not_negative, require_kind, spread
from mafsil.errors import InputError
from mafsil.trajectory.motion import Motion, Printed, Trajectory, moving_at, times
from mafsil.trajectory.profiles.polynomial import rest


@dataclass(frozen=True, eq=False, repr=False)
class Sequence(Printed):
    """Parts one after the other.

    Attributes:
        parts: (k) trajectories of equal n, each starting where the one before ends.
        starts: (k + 1,) their starting times, and the end [s].
    """

    parts: tuple[Trajectory, ...]
    starts: Floats

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return float(self.starts[-1])

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.parts[0].n

    def breaks(self) -> Floats:
        """Times between which the motion is smooth [s]."""
        return np.unique(
            np.concatenate([start + part.breaks() for start, part in zip(self.starts[:-1], self.parts, strict=True)])
        )

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration."""
        moment = times(t)
        which = self._locate(moment)
        if moment.ndim == 0:
            return self._at_one(moment, int(which))
        present: list[int] = np.unique(which).tolist()
        if len(present) == 1:
            out = self.parts[present[0]].at(self._local(moment, present[0]))
        else:
            shape = moment.shape + self.parts[0].at(0.0).u.shape
            out = Motion(*(np.zeros(shape) for _ in range(3)))
            for k in present:
                here = which == k
                values = self.parts[k].at(self._local(moment[here], k))
                for whole, value in zip(out, values, strict=True):
                    whole[here] = value
        moving = moving_at(moment, self.duration, out.u.ndim - moment.ndim)
        return Motion(out.u, out.v * moving, out.a * moving)

    def _at_one(self, moment: Floats, k: int) -> Motion:
        """At one time, which lies in part k: laws of the tip ask so in each tick."""
        u, v, a = self.parts[k].at(self._local(moment, k))
        moving = moving_at(moment, self.duration, u.ndim)
        return Motion(u, v * moving, a * moving)

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, *batch, n) third derivative at the times `t` [rad/s^3 | m/s^3]; zero outside 0 .. duration."""
        moment = times(t)
        which = self._locate(moment)
        out = np.zeros(moment.shape + self.parts[0].at(0.0).u.shape)
        present: list[int] = np.unique(which).tolist()
        for k in present:
            here = which == k
            out[here] = self.parts[k].jerk(self._local(moment[here], k))
        return out * moving_at(moment, self.duration, out.ndim - moment.ndim)

    def _locate(self, t: Floats) -> NDArray[np.intp]:
        return np.clip(np.searchsorted(self.starts, t, side="right") - 1, 0, len(self.parts) - 1)

    def _local(self, t: Floats, k: int) -> Floats:
        """Time since the start of part k, never beyond its ends by rounding."""
        return np.clip(t - self.starts[k], 0.0, self.parts[k].duration)


def sequence(*parts: Trajectory, rests: float | tuple[float, ...] = 0.0, tolerance: float = 1e-6) -> Sequence:
    """Join trajectories, resting between them.

    Args:
        parts: at least one; each must start where the one before ends.
        rests: pause after each part but the last, one number or (k - 1,) numbers [s].
        tolerance: largest gap between an end and the next start [rad | m].

    Raises:
        InputError: no part, parts of different widths, a gap, or a negative rest.
    """
    tolerance = not_negative("tolerance", tolerance)
    if not parts:
        raise InputError("trajectory.no_parts")
    for k, part in enumerate(parts):
        require_kind(f"parts[{k}]", part, "Trajectory", "duration", "at")
    pauses = spread("rests", rests, (len(parts) - 1,))
    if not (pauses >= 0.0).all():
        raise InputError("input.range", name="rests", value=pauses.min(), low=0.0, high=np.inf)
    joined: list[Trajectory] = []
    for k, part in enumerate(parts):
        if k:
            _require_meeting(joined[-1], part, k, tolerance)
            if pauses[k - 1] > 0.0:
                joined.append(rest(part.at(0.0).u, pauses[k - 1]))
        joined.append(part)
    ends = np.cumsum([part.duration for part in joined])
    return Sequence(tuple(joined), frozen(np.concatenate([[0.0], ends])))


def _require_meeting(before: Trajectory, after: Trajectory, index: int, tolerance: float) -> None:
    end, start = before.at(before.duration).u, after.at(0.0).u
    if end.shape != start.shape:
        raise InputError("input.shape", name=f"parts[{index}]", expected=end.shape, got=start.shape, hint="")
    gap = np.abs(end - start)
    if gap.max(initial=0.0) > tolerance:
        raise InputError(
            "trajectory.gap", index=index, joint=int(gap.argmax()) % before.n, gap=gap.max(), limit=tolerance
        )
