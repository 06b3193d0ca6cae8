"""A mass on a spring and a damper meets a wall: the first contact in closed form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.one_joint.rows import RowAnswer, above_zero, finite, together
from mafsil.one_joint.second_order import SecondOrder
from mafsil.one_joint.tolerances import SETTLED

HALVINGS = 60
"""In the search for the instant of a crossing."""

SAMPLES = 4097
"""Of a motion in which a crossing is looked for, denser at the start, where it is fast."""


class WallStatus(Status):
    """What happens at the first contact."""

    LOST = ("one_joint.wall_lost", True)
    KEPT = ("one_joint.wall_kept", True)
    NOT_REACHED = ("one_joint.wall_not_reached", False)


@dataclass(frozen=True, eq=False, repr=False)
class WallContact(RowAnswer):
    """First contact of a mass with a wall; true if there is one.

    Attributes:
        verdict: (*batch) which of `statuses`.
        contact_time, contact_speed: (*batch) [s], [m/s]; NaN if not reached.
        peak_force, time_of_peak: (*batch) largest force and when after contact [N], [s].
        release: (*batch) how long after contact it is lost [s]; NaN if it is kept.
        rest_position, rest_force: (*batch) in the end [m], [N].
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(WallStatus)
    verdict: NDArray[np.int8]
    contact_time: Floats
    contact_speed: Floats
    peak_force: Floats
    time_of_peak: Floats
    release: Floats
    rest_position: Floats
    rest_force: Floats


def simulate_wall_contact(
    mass: ArrayLike,
    damping: ArrayLike,
    stiffness: ArrayLike,
    *,
    reference: ArrayLike,
    wall_stiffness: ArrayLike,
    start: ArrayLike,
    speed: ArrayLike = 0.0,
) -> WallContact:
    """A mass drawn to a reference behind a wall at x = 0, such as the tip of an arm under impedance control.

    D x'' + B x' + K (x - x_ref) = F, F = -k x for x > 0, none else.

    Args:
        mass, damping, stiffness: D, B, K (*batch), above zero [kg, N s/m, N/m].
        reference: x_ref (*batch) [m].
        wall_stiffness: k (*batch) [N/m].
        start: x < 0 at t = 0 (*batch) [m].
        speed: x' there (*batch) [m/s].

    Raises:
        InputError: a start that is not before the wall, a number out of its range.
    """
    D, B, K, ref, k, x, v = together(
        mass=above_zero("mass", mass), damping=above_zero("damping", damping),
        stiffness=above_zero("stiffness", stiffness), reference=finite("reference", reference),
        wall_stiffness=above_zero("wall_stiffness", wall_stiffness), start=finite("start", start),
        speed=finite("speed", speed),
    )  # fmt: skip
    if (x >= 0.0).any():
        raise InputError("input.range", name="start", value=float(x.max()), low=-np.inf, high=0.0)
    # 1. Free motion about x_ref, until x = 0: the error x - x_ref rises through -x_ref.
    free = SecondOrder.of_joint(D, B, K)
    when = _first_crossing(free, x - ref, v, -ref, 1.0)
    reached = np.isfinite(when)
    v_contact = free.state_at(np.where(reached, when, 0.0), x - ref, v)[1]
    # 2. Contact about the rest position K x_ref / (K + k).
    pressed = SecondOrder.of_joint(D, B, K + k)
    rest = K * ref / (K + k)
    turn = pressed.first_extremum(-rest, v_contact)
    peak_time = np.where(np.isfinite(turn), turn, 0.0)
    peak = pressed.state_at(peak_time, -rest, v_contact)[0] + rest
    release = _first_crossing(pressed, -rest, v_contact, -rest, -1.0)
    lost = np.isfinite(release)
    verdict = np.where(~reached, 2, np.where(lost, 0, 1)).astype(np.int8)
    nothing = np.nan
    end = np.where(ref > 0.0, rest, ref)
    return WallContact(
        verdict,
        np.where(reached, when, nothing),
        np.where(reached, v_contact, nothing),
        np.where(reached, k * np.where(np.isfinite(turn), peak, rest), nothing),
        np.where(reached, turn, nothing),
        np.where(reached & lost, release, nothing),
        end,
        k * np.maximum(end, 0.0),
    )


def _first_crossing(loop: SecondOrder, e0: Floats, v0: Floats, level: Floats, sense: float) -> Floats:
    """First time at which the error passes a level upwards (sense 1) or downwards (-1); infinite if never."""
    horizon = loop.settling_time(np.where(e0 == 0.0, 1.0, e0), v0, SETTLED)
    t = horizon[..., None] * np.linspace(0.0, 1.0, SAMPLES) ** 2
    rows = SecondOrder(loop.natural_frequency[..., None], loop.damping_ratio[..., None])
    value = sense * (rows.state_at(t, e0[..., None], v0[..., None])[0] - level[..., None])
    rising = (value[..., :-1] < 0.0) & (value[..., 1:] >= 0.0)
    # The start itself stands on the level where contact has just been made: only what comes after counts.
    at = np.argmax(rising, axis=-1)[..., None]
    low, high = (np.take_along_axis(t, at + k, axis=-1)[..., 0] for k in (0, 1))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        before = sense * (loop.state_at(middle, e0, v0)[0] - level) < 0.0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return np.where(rising.any(axis=-1), high, np.inf)
