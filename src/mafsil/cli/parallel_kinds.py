"""What `mafsil parallel` asks of each kind of parallel robot, under one name each."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation
from mafsil.parallel import (
    CableRobot,
    DeltaRobot,
    FiveBar,
    PlanarThreeRPR,
    PlanarThreeRRR,
    RodRobot,
    SingularKinds,
    StewartPlatform,
    cable_poses,
    cable_tensions,
    mode_path,
    nearest_singularity,
)
from mafsil.parallel.cables import CablePoses, CableTensions
from mafsil.parallel.legs import LegDrive, PlatformMotion, RodPoses
from mafsil.parallel.planar import PlanarPoses
from mafsil.parallel.platforms import ModePath, NearestSingularity, PlatformModes, PlatformPoints, SphericalPlatform
from mafsil.parallel.robot_file import ParallelRobot

Found = PlatformModes | PlanarPoses | PlatformPoints | CablePoses | CableTensions | RodPoses

SPATIAL = ("x", "y", "z", "roll", "pitch", "yaw")
PLANAR = ("x", "y", "phi")
ANGLES = ("roll", "pitch", "yaw", "phi")
SPATIAL_WRENCH = ("mx", "my", "mz", "fx", "fy", "fz")
PLANAR_WRENCH = ("mz", "fx", "fy")


class ParallelCommand:
    """A robot of one kind; what a kind does not answer is None.

    Attributes:
        pose: names of the numbers of a pose.
        wrench: names of the components of a load.
        rotary: whether coordinates of motors are angles.
        count: of motors.
    """

    pose: tuple[str, ...] = SPATIAL
    wrench: tuple[str, ...] = SPATIAL_WRENCH
    rotary: bool = False
    count: int = 3

    def motors(self, x: Floats) -> Floats:
        """(m, k) coordinates of the motors at a pose, k choices each; the nearest where `misfit` is not zero."""
        raise NotImplementedError

    def poses(self, motors: Floats) -> tuple[Found | None, Floats]:
        """What was found for coordinates of the motors, and the poses as rows."""
        raise NotImplementedError

    def misfit(self, x: Floats) -> Floats | None:
        """By how much the rod of each motor is too short (positive) or too long for a pose [m], where that is known."""
        return None

    def singularity(self, x: Floats) -> SingularKinds | None:
        """At a pose, with the first choice of each motor."""
        return None

    def nearest(self, x: Floats) -> NearestSingularity | None:
        """The nearest singular pose."""
        return None

    def way(self, x: Floats, y: Floats) -> ModePath | None:
        """From pose to pose past singular ones."""
        return None

    def efforts(self, x: Floats, F: Floats) -> tuple[Found | None, Floats]:
        """(m,) of the motors so that the platform exerts a wrench at a pose that is not singular."""
        raise NotImplementedError

    def draw(self, x: Floats, path: str) -> None:
        """A picture at a pose into a file.

        Raises:
            InputError: this kind has none; the file is no picture.
        """
        raise InputError("cli.parallel_no_picture")


class LegsCommand(ParallelCommand):
    """A platform on legs that change their lengths.

    Args:
        robot: in space or in the plane.
    """

    def __init__(self, robot: StewartPlatform | PlanarThreeRPR) -> None:
        self.robot = robot

    def motors(self, x: Floats) -> Floats:
        """One length each."""
        return self.robot.lengths(self._own(x))[:, None]

    def singularity(self, x: Floats) -> SingularKinds | None:
        """Of the second kind, if any."""
        return self.robot.singularity(self._own(x))

    def nearest(self, x: Floats) -> NearestSingularity | None:
        """By searches."""
        return nearest_singularity(self.robot, self._own(x))

    def way(self, x: Floats, y: Floats) -> ModePath | None:
        """By random trees."""
        return mode_path(self.robot, self._own(x), self._own(y))

    def efforts(self, x: Floats, F: Floats) -> tuple[Found | None, Floats]:
        """Forces of the legs."""
        return None, self.robot.leg_forces(self._own(x), F)

    def _own(self, x: Floats) -> Floats:
        """A pose as the robot takes it."""
        return x


class StewartCommand(LegsCommand):
    """A platform on six legs."""

    count = 6
    robot: StewartPlatform

    def poses(self, motors: Floats) -> tuple[Found | None, Floats]:
        """All assembly modes."""
        found = self.robot.forward_kinematics(motors)
        return found, numbers(found.T[: int(found.count)])

    def draw(self, x: Floats, path: str) -> None:
        """In space."""
        from mafsil.figures import plot_platform

        plot_platform(self.robot, matrix(x), path)

    def _own(self, x: Floats) -> Floats:
        return matrix(x)


class ThreeRPRCommand(LegsCommand):
    """A planar platform on three sliders."""

    pose, wrench = PLANAR, PLANAR_WRENCH
    robot: PlanarThreeRPR

    def poses(self, motors: Floats) -> tuple[Found | None, Floats]:
        """All, by the sextic."""
        found = self.robot.forward_kinematics(motors)
        return found, found.x[: int(found.count)]

    def draw(self, x: Floats, path: str) -> None:
        """In the plane."""
        from mafsil.figures import plot_planar_platform

        plot_planar_platform(self.robot, x, path)


class CranksCommand(ParallelCommand):
    """A platform on cranks with rods; a motor has two angles for a pose.

    Args:
        robot: of which the angles of one motor are known from those of no other.
    """

    rotary = True

    def __init__(self, robot: PlanarThreeRRR | DeltaRobot | FiveBar) -> None:
        self.robot = robot

    def motors(self, x: Floats) -> Floats:
        """Two angles each: the knee outside, or the elbow left of the line to the point, first."""
        return self.robot.inverse_kinematics(x).q

    def misfit(self, x: Floats) -> Floats | None:
        """Of the rods."""
        return self.robot.inverse_kinematics(x).misfit


class ThreeRRRCommand(CranksCommand):
    """A planar platform on three cranks."""

    pose, wrench = PLANAR, PLANAR_WRENCH
    robot: PlanarThreeRRR

    def poses(self, motors: Floats) -> tuple[Found | None, Floats]:
        """All, by the sextic."""
        found = self.robot.forward_kinematics(motors)
        return found, found.x[: int(found.count)]

    def singularity(self, x: Floats) -> SingularKinds | None:
        """Of any kind."""
        return self.robot.singularity(x, self.motors(x)[:, 0])

    def efforts(self, x: Floats, F: Floats) -> tuple[Found | None, Floats]:
        """By virtual work."""
        return None, self.robot.torques(x, self.motors(x)[:, 0], F)


class DeltaCommand(CranksCommand):
    """A Delta robot."""

    pose, wrench = SPATIAL[:3], SPATIAL_WRENCH[3:]
    robot: DeltaRobot

    def poses(self, motors: Floats) -> tuple[Found | None, Floats]:
        """Both places."""
        found = self.robot.forward_kinematics(motors)
        return found, np.array(list(found)).reshape(-1, 3)

    def singularity(self, x: Floats) -> SingularKinds | None:
        """Of any kind."""
        return self.robot.singularity(self.motors(x)[:, 0], x)

    def efforts(self, x: Floats, F: Floats) -> tuple[Found | None, Floats]:
        """Torques."""
        return None, self.robot.torques(self.motors(x)[:, 0], x, F)

    def draw(self, x: Floats, path: str) -> None:
        """In space."""
        from mafsil.figures import plot_delta

        plot_delta(self.robot, self.motors(x)[:, 0], path)


class FiveBarCommand(CranksCommand):
    """A five-bar with motors at both ground pivots."""

    pose, wrench, count = PLANAR[:2], PLANAR_WRENCH[1:], 2
    robot: FiveBar

    def poses(self, motors: Floats) -> tuple[Found | None, Floats]:
        """Both places."""
        found = self.robot.forward_kinematics(motors)
        return found, np.array(list(found)).reshape(-1, 2)

    def singularity(self, x: Floats) -> SingularKinds | None:
        """Of any kind, with the cranks outside."""
        return self.robot.motor_singularity(self._outside(x), x)

    def efforts(self, x: Floats, F: Floats) -> tuple[Found | None, Floats]:
        """By virtual work, with the cranks outside."""
        return None, self.robot.torques(self._outside(x), x, F)

    def draw(self, x: Floats, path: str) -> None:
        """In the plane, with the cranks outside."""
        from mafsil.figures import plot_five_bar

        angles = self._outside(x)
        mode = int(np.linalg.norm(self.robot.forward_kinematics(angles).x - x, axis=-1).argmin())
        plot_five_bar(self.robot, self.robot.chain_angles(angles, mode)[:4], path)

    def _outside(self, x: Floats) -> Floats:
        alpha, beta = self.robot.inverse_kinematics(x).q
        return np.array([alpha[0], beta[1]])


class CablesCommand(ParallelCommand):
    """A platform in cables, in space."""

    def __init__(self, robot: CableRobot) -> None:
        self.robot, self.count = robot, robot.m

    def motors(self, x: Floats) -> Floats:
        """One length each."""
        return self.robot.lengths(self._own(x))[:, None]

    def poses(self, motors: Floats) -> tuple[Found | None, Floats]:
        """The one near the middle of the frame, if the lengths fit it."""
        middle = self.robot.base.mean(axis=0) - self.robot.platform.mean(axis=0)
        guess = np.append(middle, 0.0) if self.robot.planar else pose.from_translation(middle)
        found = cable_poses(self.robot, motors, guess)
        return found, self._typed(found.x)[None] if found else np.zeros((0, len(self.pose)))

    def efforts(self, x: Floats, F: Floats) -> tuple[Found | None, Floats]:
        """Tensions, if cables can hold it."""
        found = cable_tensions(self.robot, self._own(x), -F)
        return found, found.tensions

    def _own(self, x: Floats) -> Floats:
        return matrix(x)

    def _typed(self, x: Floats) -> Floats:
        return numbers(x)


class PlanarCablesCommand(CablesCommand):
    """A platform in cables, in the plane."""

    pose, wrench = PLANAR, PLANAR_WRENCH

    def _own(self, x: Floats) -> Floats:
        return x

    def _typed(self, x: Floats) -> Floats:
        return x


class SphericalCommand(ParallelCommand):
    """A body on three legs about one point."""

    pose, wrench, rotary = SPATIAL[3:], SPATIAL_WRENCH[:3], True

    def __init__(self, robot: SphericalPlatform) -> None:
        self.robot = robot

    def motors(self, x: Floats) -> Floats:
        """Two angles each."""
        return self.robot.inverse_kinematics(rotation.from_rpy(x)).q

    def poses(self, motors: Floats) -> tuple[Found | None, Floats]:
        """All that were found, at most eight."""
        found = self.robot.forward_kinematics(motors)
        return found, rotation.to_rpy(found.x[: int(found.count)])

    def misfit(self, x: Floats) -> Floats | None:
        """Angles by which links miss."""
        return self.robot.inverse_kinematics(rotation.from_rpy(x)).misfit

    def singularity(self, x: Floats) -> SingularKinds | None:
        """Of any kind."""
        return self.robot.singularity(rotation.from_rpy(x), self.motors(x)[:, 0])

    def efforts(self, x: Floats, F: Floats) -> tuple[Found | None, Floats]:
        """By virtual work."""
        return None, self.robot.torques(rotation.from_rpy(x), self.motors(x)[:, 0], F)


class RodsCommand(ParallelCommand):
    """A platform on rods."""

    def __init__(self, robot: RodRobot) -> None:
        self.robot, self.count, self.rotary = robot, robot.m, robot.drive is LegDrive.CRANK
        self.pose, self.wrench = ON_RODS[robot.motion]

    def motors(self, x: Floats) -> Floats:
        """Both coordinates of each."""
        return self.robot.inverse_kinematics(self._own(x)).q

    def poses(self, motors: Floats) -> tuple[Found | None, Floats]:
        """All of them."""
        found = self.robot.forward_kinematics(motors)
        T = found.T[: int(found.count)]
        return found, numbers(T) if self.pose is SPATIAL else self.robot.coordinates(T)

    def misfit(self, x: Floats) -> Floats | None:
        """Of the rods."""
        return self.robot.inverse_kinematics(self._own(x)).misfit

    def singularity(self, x: Floats) -> SingularKinds | None:
        """With the first choice of each motor."""
        return self.robot.singularity(self._own(x), self.robot.branch(self._own(x)))

    def efforts(self, x: Floats, F: Floats) -> tuple[Found | None, Floats]:
        """With the first choice of each motor."""
        return None, self.robot.efforts(self._own(x), self.robot.branch(self._own(x)), F)

    def _own(self, x: Floats) -> Floats:
        return matrix(x) if self.pose is SPATIAL else x


ON_RODS = {
    PlatformMotion.POSE: (SPATIAL, SPATIAL_WRENCH),
    PlatformMotion.SCHOENFLIES: (("x", "y", "z", "phi"), ("mz", "fx", "fy", "fz")),
    PlatformMotion.POINT: (SPATIAL[:3], SPATIAL_WRENCH[3:]),
    PlatformMotion.PLANE: (PLANAR, PLANAR_WRENCH),
    PlatformMotion.PLANE_POINT: (PLANAR[:2], PLANAR_WRENCH[1:]),
}
"""Names of the numbers of poses and of loads, by what the platform does."""


COMMANDS: dict[type[ParallelRobot], Callable[[Any], ParallelCommand]] = {
    StewartPlatform: StewartCommand,
    PlanarThreeRPR: ThreeRPRCommand,
    PlanarThreeRRR: ThreeRRRCommand,
    DeltaRobot: DeltaCommand,
    FiveBar: FiveBarCommand,
    CableRobot: CablesCommand,
    SphericalPlatform: SphericalCommand,
    RodRobot: RodsCommand,
}


def wrap_robot(robot: ParallelRobot) -> ParallelCommand:
    """A robot with the questions of the command."""
    if isinstance(robot, CableRobot) and robot.planar:
        return PlanarCablesCommand(robot)
    return COMMANDS[type(robot)](robot)


def matrix(x: Floats) -> Floats:
    """(4, 4) from x, y, z, roll, pitch, yaw."""
    return pose.from_rotation_translation(rotation.from_rpy(x[3:]), x[:3])


def numbers(T: Floats) -> Floats:
    """(*batch, 6) x, y, z, roll, pitch, yaw from poses (*batch, 4, 4)."""
    return np.concatenate([T[..., :3, 3], rotation.to_rpy(T[..., :3, :3])], axis=-1)
