"""Peers as a further method, where they are installed: the same mechanism built in their memory, the same states."""

from __future__ import annotations

from collections.abc import Callable, Collection
from importlib import import_module
from importlib.util import find_spec

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError, ModelError
from mafsil.mechanics.catalogue import quantity
from mafsil.mechanics.states import States
from mafsil.robot import Robot
from mafsil.verification.verification import Check

PEERS = {"pinocchio": "mafsil.verification.pinocchio_peer", "mujoco": "mafsil.verification.mujoco_peer"}
"""Their names as Python imports them, and the module that knows how to ask them."""


def standing(against: Collection[str]) -> tuple[tuple[str, str], ...]:
    """For every peer the key of the sentence: compared, installed but not compared, or not installed."""
    return tuple(
        (name, f"verification.peer_{'compared' if name in against else 'idle' if find_spec(name) else 'missing'}")
        for name in PEERS
    )


def peer_checks(
    name: str, robot: Robot, s: States, limit: float, error: Callable[[str, Floats, Floats], Floats]
) -> tuple[list[Check], list[tuple[str, str]]]:
    """Checks of all that the peer computes too, and what was left out.

    Args:
        name: of the peer.
        robot: the robot.
        s: states.
        limit: relative error allowed.
        error: how far two arrays of a quantity are apart, per state.

    Raises:
        InputError: the peer is not installed.
    """
    if find_spec(name) is None:
        raise InputError("verification.not_installed", peer=name)
    answers, missing = import_module(PEERS[name]).answers(robot.mechanism, s)
    checks: list[Check] = []
    for routine, theirs in answers.items():
        try:
            ours = _ours(robot, routine, s)
        except ModelError:
            missing = [*missing, (f"{routine}, {name}", "verification.no_inverse")]
            continue
        gaps = error(routine.partition("(")[0], ours, np.asarray(theirs))
        checks.append(Check(routine, f"verification.{name}", float(gaps.max()), limit, int(gaps.argmax())))
    return checks, missing


def _ours(robot: Robot, routine: str, s: States) -> Floats:
    name, _, with_wrench = routine.partition("(")
    inputs = [getattr(s, key) for key in quantity(name).inputs]
    return np.asarray(getattr(robot, name)(*inputs, *([s.tip_wrench] if with_wrench else [])))
