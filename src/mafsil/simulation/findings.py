"""What a recording shows besides its end: efforts that were clipped, contact that chatters."""

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
