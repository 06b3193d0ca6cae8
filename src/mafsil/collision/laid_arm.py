"""An arm as the compiled loops read it, whatever the scene; what each thread asks it with."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from threading import get_ident
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.collision import clearance_tables, layout
from mafsil.collision.arm_kernels import ArmKernels, arm_kernels
from mafsil.collision.arm_loops import Arm
from mafsil.collision.clearance_loops import Clearances
from mafsil.collision.joints import Joints
from mafsil.collision.regions import Regions
from mafsil.collision.scene import Scene
from mafsil.collision.speed_loops import Motion
from mafsil.collision.workshop_loops import Bench, Groups, Kinematics, Workshop, World, bench_for
from mafsil.kernels.loops.held import Held
from mafsil.kernels.loops.holding import hold
from mafsil.robot import Robot

CHUNK = 256
"""States whose link poses are in memory at once: they stay in the processor's cache."""


def poses_in_parts(robot: Robot, rows: Floats) -> Iterator[tuple[int, Floats]]:
    """Link poses (m, L, 4, 4) of parts of configurations (k, n), with the index of the first."""
    room = np.empty((min(CHUNK, len(rows)), len(robot.mechanism.links), 4, 4))
    for begin in range(0, len(rows), CHUNK):
        part = rows[begin : begin + CHUNK]
        yield begin, robot.link_poses(part, out=room[: len(part)])


class LaidArm:
    """Bodies and joints as arrays, computed at their first use and shared by all scenes.

    Args:
        robot: the arm.
        joints: of the robot.
        arm: its bodies, and which pairs of them are checked.
    """

    def __init__(self, robot: Robot, joints: Joints, arm: Arm) -> None:
        self.robot, self.arm, self._joints = robot, arm, joints
        self._kinematics: dict[int, tuple[Kinematics, list[object]]] = {}
        self._benches: dict[int, Bench] = {}
        self._nearest_in_cells: clearance_tables.NearestInCells = {}

    def with_arm(self, arm: Arm) -> LaidArm:
        """The same bodies, of which other pairs are checked, or other pieces against the surroundings."""
        other = LaidArm(self.robot, self._joints, arm)
        other.__dict__["kernels"] = self.kernels  # A cached property is an entry of the dictionary.
        other._nearest_in_cells = self._nearest_in_cells
        return other

    @cached_property
    def kernels(self) -> ArmKernels:
        """Its links and bodies in eight configurations at once."""
        return arm_kernels(self.robot.mechanism, self._joints, self.arm.bodies)

    @cached_property
    def motion(self) -> Motion:
        """How the joints move the bodies."""
        return layout.motion_of(self.robot.mechanism, self._joints, self.arm)

    @cached_property
    def groups(self) -> Groups:
        """Its pieces eight side by side."""
        return layout.groups_of(self.arm)

    @cached_property
    def regions(self) -> Floats:
        """(b, 4) balls in {s} that bodies never leave."""
        endless = np.full(self.robot.n, np.inf)
        return Regions(self.robot.mechanism, self._joints, self.arm, -endless, endless).in_space()

    @cached_property
    def clearances(self) -> Clearances:
        """What is known of pairs of bodies."""
        limits = self.robot.limits
        regions = Regions(self.robot.mechanism, self._joints, self.arm, limits.lower, limits.upper)
        return clearance_tables.clearances_of(
            self.arm, self.motion, regions, limits, self._poses, self._nearest_in_cells
        )

    def workshop(self, scene: Scene, clearance: Floats) -> Held[Workshop]:
        """What this thread asks about the arm in a scene, with clearances (1 + pairs,) as in `World` [m]."""
        around, thread = scene.surroundings, get_ident()
        few = layout.few_around(self.regions, self.arm, around)
        world = World(
            self.arm, around, self.groups, few, self.clearances, self._kinematics_here(), self.motion,
            layout.everything(self.arm, around), clearance,
        )  # fmt: skip
        if thread not in self._benches:
            self._benches[thread] = bench_for(world)
        return hold(Workshop(world, self._benches[thread]))

    def _kinematics_here(self) -> Kinematics:
        """The kernel of link poses for compiled loops, with arrays of this thread alone."""
        thread, known = get_ident(), self._kinematics
        if thread not in known:
            kernel = self.robot.kernel("link_poses")
            known[thread] = layout.kinematics_of(kernel, self.kernels, self.robot.mechanism, self.arm)
        return known[thread][0]

    def _poses(self, rows: Floats) -> Iterator[tuple[int, Floats]]:
        return poses_in_parts(self.robot, rows)

    def __reduce__(self) -> tuple[Any, ...]:
        """What another process can use: all but what lies at an address of this one."""
        return LaidArm, (self.robot, self._joints, self.arm)
