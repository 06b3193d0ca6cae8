"""What a sensor or a law can do wrong in a run: each fault is named, and ends the run with what has been recorded."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, cast

import numpy as np

from mafsil import control
from mafsil.arrays import Floats, JointVector
from mafsil.errors import InputError
from mafsil.messages.visible import visible
from mafsil.simulation.recording import SimulationStatus

if TYPE_CHECKING:
    from mafsil.control import Law, TaskCoordinates
    from mafsil.trajectory import Motion

LONGEST = 200
"""Characters of what a law says about its failure."""


class Stopped(InputError):
    """A run cannot go on; many runs at once let it through, a single one ends with its status.

    Attributes:
        status: how it ended.
        fault: what was wrong, in a few words.
    """

    def __init__(self, status: SimulationStatus, fault: str, time: float, law: str) -> None:
        super().__init__(status.key, fault=fault, time=time, end=time, law=law, step=0.0)
        self.status, self.fault = status, fault


def law_name(law: object) -> str:
    """What a law is called: its class or function; of one around another one, that of the inner law."""
    if isinstance(law, control.laws.LawWrapper):
        return law_name(law.law)
    named = law.function if isinstance(law, control.laws.FunctionLaw) else law
    return str(getattr(named, "__name__", type(named).__name__))


def law_efforts(law: Law, t: float, q: JointVector, qd: JointVector, reference: Motion, whole: object) -> JointVector:
    """The efforts of a law at one tick, real and of the shape of q.

    The law may look at the state, which is that of the arm, and not write into it.

    Args:
        law: of the session.
        t: time [s].
        q, qd: (*batch, n) measured.
        reference: at this time.
        whole: the law of the scenario, for its name.

    Raises:
        InputError: at the first tick, efforts of a wrong shape or kind.
        Stopped: a measured number that is not finite; the law raises; later on, efforts of a wrong shape or kind.
    """
    q.setflags(write=False)
    qd.setflags(write=False)
    try:
        command = law(t, q, qd, reference)
    except Exception as error:
        words = visible(f"{type(error).__name__}: {error}")[:LONGEST]
        raise Stopped(SimulationStatus.LAW_RAISED, words, t, law_name(whole)) from error
    if type(command) is np.ndarray and command.shape == q.shape and command.dtype.kind in "fiu":
        return command
    if t == 0.0:
        raise InputError("simulation.efforts", expected=q.shape, got=_say(command))
    raise Stopped(SimulationStatus.LAW_NONSENSE, _say(command), t, law_name(whole))


def require_measured(t: float, q: JointVector, qd: JointVector, names: tuple[str, ...], law: Law) -> None:
    """Refuse a measured state that is not finite.

    Args:
        t: time [s].
        q, qd: (*batch, n) measured.
        names: of the joints.
        law: for its name.

    Raises:
        Stopped: a sensor gave a number that is not finite; it names the joint.
    """
    if isfinite(np.vdot(q, q) + np.vdot(qd, qd)):
        return
    bad = ~(np.isfinite(q) & np.isfinite(qd)).reshape(-1, q.shape[-1]).all(axis=0)
    if bad.any():
        raise Stopped(SimulationStatus.BLIND, visible(names[int(bad.argmax())]), t, law_name(law))


def require_efforts(t: float, command: JointVector, law: Law) -> None:
    """Refuse efforts that are not finite, before limits clip them.

    Args:
        t: time [s].
        command: (*batch, n) of the law.
        law: for its name.

    Raises:
        Stopped: some are infinite or NaN.
    """
    if not isfinite(np.vdot(command, command)) and not np.isfinite(command).all():
        raise Stopped(SimulationStatus.NOT_FINITE, "", t, law_name(law))


def task_of(law: object) -> TaskCoordinates | None:
    """The coordinates in which a law moves the tip; None of laws of the joints."""
    found = getattr(law, "coordinates", None)
    if isinstance(found, control.TaskCoordinates):
        return found
    inside: tuple[object, ...] = ()
    if isinstance(law, control.laws.Combined):
        inside = law.laws
    elif isinstance(law, control.laws.LawWrapper):
        inside = (law.law,)
    elif isinstance(law, control.contact.ContactSwitch):
        inside = (law.free,)
    return next((task for part in inside if (task := task_of(part)) is not None), None)


def _say(command: object) -> str:
    if not isinstance(command, np.ndarray):
        return type(command).__name__
    array = cast("Floats", command)
    return f"{array.shape} {array.dtype}"
