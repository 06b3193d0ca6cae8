"""What a recording shows besides its end: efforts that were clipped or alternate, contact that chatters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.messages import say
from mafsil.messages.quantities import digits, quantity
from mafsil.messages.visible import visible

WINDOW, CHANGES = 40, 8
"""Ticks within which so many changes between contact and none count as chattering."""

ALTERNATIONS, SWING = 50, 0.05
"""Ticks in a row in which an effort goes up and down by turns, by this share of its largest: noise does not do that."""

BRIEF = 4
"""Steps below which a contact from its beginning to its end is too short for its forces to be computed."""


def near_singular_sentence(found: Mapping[str, float] | None, language: str | None) -> str | None:
    """How near to a singular pose a law of the tip came, and when; None if it did not.

    Args:
        found: `ratio` of singular values, `time` [s]; or None.
        language: of the sentence.
    """
    if found is None:
        return None
    details = {"ratio": digits(found["ratio"]), "time": quantity(found["time"], "s")}
    return say("simulation.near_singular", language=language, **details)


def saturation_sentence(
    t: Floats, saturated: NDArray[np.bool_], joints: Sequence[str], language: str | None
) -> str | None:
    """The joint whose effort was clipped the longest, and for which share of the run; None if none was.

    Args:
        t: (k,) times [s].
        saturated: (k, *batch, n) where efforts were clipped.
        joints: names.
        language: of the sentence.
    """
    if not saturated.any():
        return None
    shares = saturated.reshape(-1, saturated.shape[-1]).mean(axis=0)
    worst = int(shares.argmax())
    first = float(t[int(saturated.reshape(len(t), -1).any(axis=1).argmax())])
    details = {"joint": visible(joints[worst]), "share": quantity(float(shares[worst]), "share")}
    return say("simulation.was_saturated", language=language, time=quantity(first, "s"), **details)


def alternating_efforts(t: Floats, tau: Floats) -> tuple[int, float, float, float] | None:
    """The joint whose effort goes up and down from tick to tick, as behind a switch that is too fast for its sampling.

    Args:
        t: (k,) times [s].
        tau: (k, n) efforts [N m | N].

    Returns:
        The joint with the largest mean step against its largest effort, that step [N m | N], since when, and for how
        long in all [s]; None if none does.
    """
    if tau.ndim != 2 or len(tau) <= ALTERNATIONS:
        return None
    step = np.diff(tau, axis=0)
    turns = step[1:] * step[:-1] < 0.0
    # How many turns there are in a row up to each tick.
    count = np.arange(1, len(turns) + 1)[:, None]
    before = np.maximum.accumulate(np.where(turns, 0, count), axis=0)
    lasting = (count - before) >= ALTERNATIONS
    best: tuple[float, int, float, float, float] | None = None
    for joint in np.flatnonzero(lasting.any(axis=0)).tolist():
        ends = np.flatnonzero(lasting[:, joint])
        inside = np.zeros(len(turns), dtype=bool)
        for shift in range(ALTERNATIONS):
            inside[ends - shift] = True
        swing, most = float(np.abs(step[1:][inside, joint]).mean()), float(np.abs(tau[:, joint]).max())
        if swing > SWING * most and (best is None or swing / most > best[0]):
            lasted = float((t[2:] - t[1:-1])[inside].sum())
            best = swing / most, joint, swing, float(t[int(inside.argmax())]), lasted
    return None if best is None else best[1:]


def alternating_sentence(t: Floats, tau: Floats, joints: Sequence[str], language: str | None) -> str | None:
    """Which effort goes up and down from tick to tick, by how much and how long; None if none does.

    Args:
        t, tau: as of `alternating_efforts`.
        joints: names.
        language: of the sentence.
    """
    found = alternating_efforts(t, tau)
    if found is None:
        return None
    joint, swing, begin, lasted = found
    details = {"joint": visible(joints[joint]), "step": digits(swing)}
    details |= {"time": quantity(begin, "s"), "lasted": quantity(lasted, "s")}
    return say("simulation.alternates", language=language, **details)


def chatter_sentence(t: Floats, contact_wrench: Floats | None, language: str | None) -> str | None:
    """How often a contact was made that chatters, and from when on; None if none does.

    Args:
        t: (k,) times [s].
        contact_wrench: (k, *batch, 6) of the environment on the tip, or None.
        language: of the sentence.
    """
    if contact_wrench is None or len(contact_wrench) < 2:
        return None
    touching = contact_wrench.any(axis=-1).reshape(len(t), -1)
    changes = touching[1:] != touching[:-1]
    before = np.vstack([np.zeros((1, changes.shape[1]), dtype=int), changes.cumsum(axis=0)])
    recent = before[1:] - before[np.maximum(np.arange(1, len(before)) - WINDOW, 0)]
    busy = recent >= CHANGES
    if not busy.any():
        return None
    run = int(busy.any(axis=0).argmax())
    begin = max(int(busy[:, run].argmax()) - WINDOW + 1, 0)
    made = int((changes[:, run] & touching[1:, run]).sum() + touching[0, run])
    return say("simulation.chatters", language=language, count=made, time=quantity(float(t[begin]), "s"))


def brief_contact_sentence(t: Floats, contact_wrench: Floats | None, step: float, language: str | None) -> str | None:
    """How many contacts ended within a few steps of the integration: too stiff for it; None if none did.

    Args:
        t: (k,) times [s].
        contact_wrench: (k, *batch, 6) of the environment on the tip, or None.
        step: of the integration [s].
        language: of the sentence.
    """
    found = brief_contacts(t, contact_wrench, step)
    if found is None:
        return None
    count, time = found
    return say("simulation.brief_contact", language=language, count=count, time=quantity(time, "s"), steps=BRIEF)


def brief_contacts(t: Floats, contact_wrench: Floats | None, step: float) -> tuple[int, float] | None:
    """How many contacts lasted less than BRIEF steps, and when the first of them began [s]; arguments as there."""
    if contact_wrench is None or len(contact_wrench) < 3:
        return None
    touching = contact_wrench.any(axis=-1).reshape(len(t), -1)
    edges = np.diff(touching.astype(np.int8), axis=0, prepend=0)
    count, first = 0, np.inf
    for column in edges.T:
        begin, end = np.flatnonzero(column > 0), np.flatnonzero(column < 0)
        begin = begin[: len(end)]
        brief = (t[end] - t[begin]) < (BRIEF - 0.5) * step
        count += int(brief.sum())
        first = min(first, float(t[begin][brief].min(initial=np.inf)))
    return (count, first) if count else None
