"""Remarks of the book of the form "because ..., therefore ...", each with the numbers that decide it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import pi
from typing import ClassVar

import numpy as np

import mafsil.control as control
import mafsil.one_joint as oj
from mafsil.book.entry import BESIDE, Entry, EntryStatus, Fact, Index
from mafsil.one_joint.drives import Gear, matching_ratio
from mafsil.robot import as_robot

Remarks = Callable[[], Iterable[Fact]]


@dataclass(frozen=True, eq=False, repr=False)
class Remark(Entry):
    """A remark of the book: what follows from which numbers; see `Entry`."""

    AREA: ClassVar[str] = "book_remarks"


_INDEX: Index[Remarks] = Index((), "book.unknown_remark")


def _remarks(number: str, *beside: str) -> Callable[[Remarks], Remarks]:
    """Declare the numbers of a remark, and the figures and examples whose `explain` says it."""

    def declare(compute: Remarks) -> Remarks:
        _INDEX.declare(number, compute)
        for entry in beside:
            BESIDE.setdefault(entry, []).append(lambda language: remark(number).words("caption", language))
        return compute

    return declare


def remark(number: str, /) -> Remark:
    """A remark of the book.

    Args:
        number: "1" to "6", as the reference of figures and remarks counts them.

    Raises:
        InputError: no remark of that number.
    """
    return Remark(number, EntryStatus.FIXED, {}, tuple(_INDEX[number]()))


def remarks() -> list[str]:
    """Numbers of all remarks."""
    return _INDEX.numbers()


@_remarks("1", "10.10")
def feedforward() -> Iterable[Fact]:
    """The torque that the model leaves out, as a spring constant about both middles."""
    left_out, d = 9.81 * (0.1 - 0.08), 1e-6
    slopes = [-left_out * (np.cos(middle + d) - np.cos(middle - d)) / (2 * d) for middle in (-pi / 2, pi / 2)]
    return Fact("left_out", left_out, unit="N m"), Fact("down", slopes[0], unit="N m/rad"), Fact("up", slopes[1])


@_remarks("2", "10.11")
def computed_torque() -> Iterable[Fact]:
    """Gains and order of the error of computed torque without an integral."""
    wn, zeta = 5.0, 1.0
    arm = oj.JointArm.of(0.5, 0.0, 0.0, 0.1)
    error = oj.JointLaw.computed_torque(arm, wn**2, 0.0, 2 * zeta * wn).error_dynamics(arm)
    return Fact("order", len(np.atleast_1d(error.roots))), Fact("kp", wn**2), Fact("kd", 2 * zeta * wn)


@_remarks("3", "10.17")
def impedance() -> Iterable[Fact]:
    """How far a path is missed by a virtual spring and damper, soft and ten times stiffer."""
    w, mass = 2.0, 1.0

    def missed(stiffness: float, damping: float) -> float:
        felt = control.Impedance.of(1, inertia=mass, damping=damping, stiffness=stiffness)
        return mass * w**2 / float(np.abs(felt.frequency_response(w)).max())

    return Fact("soft", missed(50.0, 10.0)), Fact("stiff", missed(500.0, 100.0))


@_remarks("4", "10.5")
def settling() -> Iterable[Fact]:
    """Settling by the rule and in truth at three gains above critical damping."""
    loop = oj.SecondOrder.of_joint(0.5, 10.1, [204.02, 400.0, 800.0])
    return Fact("rule", loop.settling_by_rule, unit="s"), Fact("true", loop.settling_time(), unit="s")


@_remarks("5")
def choice_of_space() -> Iterable[Fact]:
    """Determinants of J and M of a stretched planar 2R arm."""
    robot, q = as_robot("planar2r"), [0.3, 0.0]
    return (
        Fact("jacobian", float(np.linalg.det(robot.jacobian(q)[3:5]))),
        Fact("mass", float(np.linalg.eigvalsh(robot.mass_matrix(q)).min())),
    )


@_remarks("6", "10 gear")
def gears() -> Iterable[Fact]:
    """Motor's share at the matching ratio."""
    ratio = float(matching_ratio(1.0, 1e-3))
    return Fact("ratio", ratio), Fact("share", float(Gear.of(ratio, 1e-3).motor_share(1.0)))
