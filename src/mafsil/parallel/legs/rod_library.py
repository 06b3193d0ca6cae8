"""Parallel robots on rods by their dimensions: Deltas, hexapods, five-bars, pairs of SCARAs, 3-RRR, 3-PRR, H4."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, radians, real_array, single, spread
from mafsil.errors import InputError
from mafsil.parallel.legs.rod_robot import LegDrive, PlatformMotion, RodRobot
from mafsil.parallel.planar.five_bar import FiveBar
from mafsil.parallel.planar.planar_legs import PlanarThreeRPR, PlanarThreeRRR
from mafsil.parallel.platforms.delta import DeltaRobot
from mafsil.parallel.platforms.stewart import StewartPlatform

Z = np.array([0.0, 0.0, 1.0])


def rotary_delta(
    base: ArrayLike, platform: ArrayLike, arms: ArrayLike, forearms: ArrayLike,
    angles: ArrayLike = (0.0, 2 * np.pi / 3, 4 * np.pi / 3),
) -> RodRobot:  # fmt: skip
    """A Delta with rotary motors, each leg with numbers of its own; positive angles swing the arms down.

    Args:
        base, platform: radii of the motors and of the ends of the forearms, one or three [m].
        arms, forearms: lengths, one or three [m].
        angles: (3,) of the legs about z [rad].
    """
    u = _spokes(angles, 3)
    at, end = (spread(n, r, (3,))[:, None] * u for n, r in (("base", base), ("platform", platform)))
    return RodRobot(
        PlatformMotion.POINT, LegDrive.CRANK, at, real_array("forearms", forearms), np.zeros(3), end,
        np.cross(u, -Z), real_array("arms", arms), u,
    )  # fmt: skip


def linear_delta(
    towers: ArrayLike, rods: ArrayLike, platform: ArrayLike, rails: ArrayLike = (0.0, 0.0, 1.0)
) -> RodRobot:
    """A Delta with linear motors: towers anywhere, of any direction; Keops has rails that meet in a point.

    Args:
        towers: (3, 3) places of the joints of the rods on the carriages at 0, or (3, 2) at z = 0 [m].
        rods: lengths, one or three [m].
        platform: (3, 3) or (3, 2) ends of the rods on the platform, from its middle [m].
        rails: directions of the slides, one or three.
    """
    at, end = (_in_space(name, value, 3) for name, value in (("towers", towers), ("platform", platform)))
    return RodRobot(
        PlatformMotion.POINT, LegDrive.LINEAR, at, real_array("rods", rods), np.zeros(3), end,
        real_array("rails", rails),
    )  # fmt: skip


def hexapod_on_rods(
    base: ArrayLike, platform: ArrayLike, rods: ArrayLike, *, axes: ArrayLike, arms: ArrayLike | None = None,
    zeros: ArrayLike | None = None,
) -> RodRobot:  # fmt: skip
    """A platform on six rods: RUS with cranks (arms given), else PUS with slides.

    Args:
        base, platform: (6, 3) places of the motors in {s}, ends of the rods in {b} [m].
        rods: lengths, one or six [m].
        axes: (6, 3) of the cranks, or directions of the slides.
        arms: lengths of the cranks, one or six [m].
        zeros: (6, 3) directions of the cranks at angle 0; away from the middle of the base if None.
    """
    at = single("base", base, (6, 3))
    away = at - at.mean(axis=0) if zeros is None else real_array("zeros", zeros)
    drive = LegDrive.LINEAR if arms is None else LegDrive.CRANK
    long = np.ones(()) if arms is None else real_array("arms", arms)
    n, l = real_array("axes", axes), real_array("rods", rods)
    return RodRobot(PlatformMotion.POSE, drive, at, l, single("platform", platform, (6, 3)), np.zeros(3), n, long, away)


def five_bar_on_rods(base: ArrayLike, arms: ArrayLike, rods: ArrayLike, tip: ArrayLike = (0.0, 0.0)) -> RodRobot:
    """Two cranks in a plane whose rods meet in a point: a five-bar, or a pair of SCARAs.

    Args:
        base: (2, 2) places of the motors [m].
        arms, rods: lengths, one or two [m].
        tip: (2,) the moving point, from where the rods meet [m]; kept parallel.
    """
    at, end = _in_space("base", base, 2), -_in_space("tip", np.tile(real_array("tip", tip), (2, 1)), 2)
    l, arm = real_array("rods", rods), real_array("arms", arms)
    return RodRobot(PlatformMotion.PLANE_POINT, LegDrive.CRANK, at, l, np.zeros(3), end, Z, arm)


def planar_on_rods(
    base: ArrayLike, platform: ArrayLike, rods: ArrayLike, *, arms: ArrayLike | None = None,
    slides: ArrayLike | None = None,
) -> RodRobot:  # fmt: skip
    """A body in a plane on three legs: 3-RRR (arms given), 3-PRR (slides given).

    Args:
        base, platform: (3, 2) motors in {s}, ends of the rods in {b} [m].
        rods: lengths, one or three [m].
        arms: lengths of the cranks [m].
        slides: (3, 2) directions of the slides.
    """
    at, end = _in_space("base", base, 3), _in_space("platform", platform, 3)
    if (arms is None) == (slides is None):
        raise InputError("parallel.arms_or_slides")
    drive = LegDrive.LINEAR if arms is None else LegDrive.CRANK
    n = Z if slides is None else _in_space("slides", slides, 3)
    long = np.ones(()) if arms is None else real_array("arms", arms)
    return RodRobot(PlatformMotion.PLANE, drive, at, real_array("rods", rods), end, np.zeros(3), n, long)


def h4(
    base: ArrayLike, rotating: ArrayLike, fixed: ArrayLike, arms: ArrayLike, rods: ArrayLike, angles: ArrayLike
) -> RodRobot:
    """Four cranks and an articulated plate, which moves in space and turns about z: H4, I4, Par4.

    Args:
        base: (4, 3) places of the motors [m].
        rotating: (4, 3) from the middle of the plate to the hinges that turn with it [m].
        fixed: (4, 3) from these to the ends of the parallelograms, which do not turn [m].
        arms, rods: lengths, one or four [m].
        angles: (4,) of the planes of the cranks about z [rad]; positive motor angles swing the arms down.
    """
    u = _spokes(angles, 4)
    return RodRobot(
        PlatformMotion.SCHOENFLIES, LegDrive.CRANK, single("base", base, (4, 3)), real_array("rods", rods),
        real_array("rotating", rotating), real_array("fixed", fixed), np.cross(u, -Z), real_array("arms", arms), u,
    )  # fmt: skip


OnRods: TypeAlias = RodRobot | StewartPlatform | PlanarThreeRPR | PlanarThreeRRR | DeltaRobot | FiveBar
"""Robots whose legs are rods."""


def as_rod_robot(robot: OnRods) -> RodRobot:
    """The same robot on rods, so that indices, workspace and calibration are at hand.

    Args:
        robot: of any class whose legs are rods.
    """
    none = np.zeros(3)
    match robot:
        case RodRobot():
            return robot
        case StewartPlatform():
            return RodRobot(PlatformMotion.POSE, LegDrive.EXTEND, robot.base, np.zeros(6), robot.platform, none)
        case PlanarThreeRPR():
            base, platform = _in_space("base", robot.base, 3), _in_space("platform", robot.platform, 3)
            return RodRobot(PlatformMotion.PLANE, LegDrive.EXTEND, base, none, platform, none)
        case PlanarThreeRRR():
            return planar_on_rods(robot.base, robot.platform, robot.rods, arms=robot.cranks)
        case DeltaRobot():
            return rotary_delta(robot.base, robot.platform, robot.arm, robot.forearm)
        case FiveBar():
            base, arms = np.array([[0.0, 0.0], [robot.ground, 0.0]]), [robot.crank_1, robot.crank_2]
            return five_bar_on_rods(base, arms, [robot.rod_1, robot.rod_2])


def _spokes(angles: ArrayLike, m: int) -> Floats:
    a = radians("angles", single("angles", angles, (m,)), places=True)
    return np.stack([np.cos(a), np.sin(a), np.zeros(m)], axis=-1)


def _in_space(name: str, value: ArrayLike, m: int) -> Floats:
    """(m, 3) of (m, 2) or (m, 3)."""
    given = real_array(name, value)
    if given.shape == (m, 2):
        given = np.concatenate([given, np.zeros((m, 1))], axis=1)
    return single(name, given, (m, 3))
