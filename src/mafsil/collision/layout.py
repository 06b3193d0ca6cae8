"""The bodies of an arm and the joints that move them as arrays, the form that the compiled loops read.

An arm as the compiled loops read it, whatever the scene; what each thread asks it with.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from threading import get_ident
from typing import Any, TypeAlias

import numpy as np

from mafsil.arrays import Floats, Truth
from mafsil.code_store import digest_of
from mafsil.collision import clearance_tables
from mafsil.collision.arm_loops import Arm
from mafsil.collision.clearance_loops import Clearances
from mafsil.collision.clearance_tables import Regions
from mafsil.collision.joints import CENTRE, POSE, SOURCES, TWIST, ArmKernels, Joints, arm_kernels, last_of
from mafsil.collision.pairs import Body
from mafsil.collision.piece_loops import BALL, BODY, POINT, Pieces, boxes_of
from mafsil.collision.pieces import pieces_of
from mafsil.collision.placing_loops import Motion
from mafsil.collision.scene import Scene
from mafsil.collision.workshop_loops import (
    STATES,
    Bench,
    Groups,
    Kinematics,
    Workshop,
    World,
    bench_for,
    few_around,
    whole_agenda,
)
from mafsil.kernels import Kernel
from mafsil.kernels.identity import fingerprint, machine, meaning
from mafsil.kernels.loops.entry import Held
from mafsil.kernels.loops.lanes import WIDTH, in_lanes
from mafsil.kernels.loops.loop import hold
from mafsil.kernels.loops.specialisation import made_by
from mafsil.model import Mechanism
from mafsil.model.fingerprint import fingerprint as mechanism_print
from mafsil.robot import Robot

Still: TypeAlias = Sequence[Sequence[bool]]


def arm_of(bodies: tuple[Body, ...], pairs: list[tuple[int, int]], still: Still | None = None) -> Arm:
    """The bodies as arrays.

    Args:
        bodies: of the arm.
        pairs: indices of those that are checked against each other.
        still: for each body, which of its shapes no joint moves out of their place; None for none.
    """
    flags = [(False,) * len(body.shapes) for body in bodies] if still is None else still
    order = [sorted(range(len(row)), key=row.__getitem__) for row in flags]
    pieces = pieces_of([(body.shapes[i][0], body.shapes[i][1], b) for b, body in enumerate(bodies) for i in order[b]])
    first = np.searchsorted(pieces.rows[:, BODY], np.arange(len(bodies) + 1))
    moving = [first[b] + len(row) - sum(row) for b, row in enumerate(flags)]
    spread = boxes_of(pieces)
    table = [
        [body.link, first[b], first[b + 1], moving[b], *_ball(pieces, spread, first[b], first[b + 1])]
        for b, body in enumerate(bodies)
    ]
    return Arm(pieces, np.array(table, np.float64), np.array(pairs, np.int64).reshape(-1, 2))


def groups_of(arm: Arm) -> Groups:
    """The pieces of the bodies eight side by side."""
    pieces, begin = arm.pieces, arm.bodies[:, 1:4].astype(np.int64)
    starts = np.concatenate([[0], np.cumsum(-(-(begin[:, 1] - begin[:, 0]) // WIDTH))])
    count, bits = int(starts[-1]), 1 << np.arange(WIDTH)
    lanes, members = in_lanes(4 * count)[: 4 * WIDTH * count], np.zeros((count, 3), np.int64)
    balls = lanes.reshape(-1, 4, WIDTH)
    for b in range(len(begin)):
        first, last, moving, g, end = (int(x) for x in (*begin[b], starts[b], starts[b + 1]))
        i = np.arange(first, first + (end - g) * WIDTH)
        rows = pieces.rows[np.minimum(i, last - 1)]  # What is left of the last group holds the last piece again.
        balls[g:end] = rows[:, BALL:].reshape(-1, WIDTH, 4).swapaxes(1, 2)
        flags: tuple[Truth, ...] = (i < last, i < moving, (i < last) & (rows[:, 0] == POINT))
        for column, which in enumerate(flags):
            members[g:end, column] = np.where(which.reshape(-1, WIDTH), bits, 0).sum(axis=1)
    return Groups(lanes, members, starts)


def _ball(pieces: Pieces, spread: Floats, first: int, last: int) -> Floats:
    """(4,) a ball around some pieces: about the middle of their extent, by their balls or by their boxes."""
    box = spread[first:last]
    low, high = box[:, :3].min(axis=0), box[:, 3:].max(axis=0)
    centre = (low + high) / 2
    balls = pieces.rows[first:last, BALL:]
    by_balls = (np.linalg.norm(balls[:, :3] - centre, axis=1) + balls[:, 3]).max()
    return np.array([*centre, min(by_balls, float(np.linalg.norm(high - low)) / 2)])


def motion_of(mechanism: Mechanism, joints: Joints, arm: Arm) -> Motion:
    """How the joints of an arm move its bodies, and how far bodies can get from axes.

    From a joint's axis to a body lead the frames of the joints between: their distances add up, whatever the angles.
    `Regions` have another bound; the lesser holds.
    """
    links = arm.bodies[:, 0].astype(np.int64)
    rows, bodies, n = len(joints.link), len(links), mechanism.n
    table = np.zeros((rows, 11))
    table[:, 0], table[:, 1], table[:, 2] = joints.link, joints.column, joints.factor
    revolute = joints.screw[:, :3].any(axis=1)
    table[:, 3] = revolute
    table[:, 4] = np.where(revolute, np.linalg.norm(joints.screw[:, 3:], axis=1), 0.0)
    table[:, 5:8], table[:, 8:] = joints.screw[:, :3], joints.screw[:, 3:]
    reach, stretch = np.zeros((rows, bodies)), np.zeros((rows, bodies, n))
    of_link = {int(link): j for j, link in enumerate(joints.link)}
    for b in range(bodies):
        far, grows = float(np.linalg.norm(arm.bodies[b, 4:7]) + arm.bodies[b, 7]), np.zeros(n)
        link = int(links[b])
        while link > 0:
            j, joint = of_link.get(link), mechanism.joints[link - 1]
            if j is not None:
                reach[j, b], stretch[j, b] = far, grows
                along = float(np.linalg.norm(joints.screw[j, 3:]))
                grows = grows.copy()
                grows[joints.column[j]] += along * abs(float(joints.factor[j]))
                far += along * (0.0 if joint.mimic is None else abs(joint.mimic.offset))
            far += float(np.linalg.norm(joint.T_pj[:3, 3]))
            link = mechanism.parents[link - 1]
    moves = np.ascontiguousarray(joints.moves[:, links])
    endless = np.full(n, np.inf)
    levers = Regions(mechanism, joints, arm, -endless, endless).levers()
    reach = np.minimum(reach, np.where(moves, levers, np.inf))
    return Motion(
        table, moves, reach, stretch, np.flatnonzero(stretch.any(axis=(0, 1))),
        last_of(moves), last_of(moves[:, arm.pairs[:, 0]] & moves[:, arm.pairs[:, 1]]),
    )  # fmt: skip


def kinematics_of(
    kernel: Kernel, lanes: ArmKernels, mechanism: Mechanism, arm: Arm
) -> tuple[Kinematics, list[object]]:  # fmt: skip
    """The kernels of an arm for compiled loops, with fresh arrays; and what must live as long as it is used.

    Args:
        kernel: of link poses.
        lanes: of what is asked of eight configurations at once.
        mechanism, arm: to which they belong.
    """
    n, links, joints = mechanism.n, len(mechanism.links), lanes.in_motion.signature.inputs[1].size
    q, poses, rows = np.zeros((STATES, n)), np.zeros((STATES, links, 4, 4)), np.ones(1, np.int64)
    addresses = np.array([q.ctypes.data, poses.ctypes.data], np.uint64)
    strides = np.array([q.strides[0], poses.strides[0], q.strides[1], *poses.strides[1:]], np.int64)
    row_of_link = np.full(links, -1)
    row_of_link[lanes.links] = np.arange(len(lanes.links))
    sizes = TWIST * (1 + joints), POSE * len(lanes.links), CENTRE * (len(arm.bodies) + len(arm.pieces.rows))
    given, placed = in_lanes(n + joints), in_lanes(sum(sizes))
    placed[: TWIST * WIDTH] = 0.0
    ends = WIDTH * np.cumsum(sizes)
    twists, posed, balls = placed[: ends[0]], placed[ends[0] : ends[1]], placed[ends[1] :]
    found = Kinematics(
        kernel.addresses.batch, addresses.ctypes.data, rows.ctypes.data, strides.ctypes.data, rows, q, poses,
        lanes.at_rest.addresses.lanes, lanes.in_motion.addresses.lanes, given.ctypes.data, posed.ctypes.data,
        twists[TWIST * WIDTH :].ctypes.data, given, twists, posed, balls, row_of_link,
    )  # fmt: skip
    return found, [kernel, lanes, addresses, strides]


CHUNK = 256
"""States whose link poses are in memory at once: they stay in the processor's cache."""


def poses_in_parts(robot: Robot, rows: Floats) -> Iterator[tuple[int, Floats]]:
    """Link poses (m, L, 4, 4) of parts of configurations (k, n), with the index of the first."""
    room = np.empty((min(CHUNK, len(rows)), len(robot.mechanism.links), 4, 4))
    for begin in range(0, len(rows), CHUNK):
        part = rows[begin : begin + CHUNK]
        yield begin, robot.link_poses(part, out=room[: len(part)])


def basis_of(mechanism: Mechanism) -> str:
    """Digest of what distances between bodies of a robot follow from, beside their pieces: its joints, all code."""
    code = fingerprint("mafsil.collision"), meaning((arm_kernels.__module__,), SOURCES), made_by(), machine()
    return digest_of(mechanism_print(mechanism), *code)


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
        return motion_of(self.robot.mechanism, self._joints, self.arm)

    @cached_property
    def groups(self) -> Groups:
        """Its pieces eight side by side."""
        return groups_of(self.arm)

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
            self.arm, self.motion, regions, limits, self._poses, self._nearest_in_cells, basis_of(self.robot.mechanism)
        )

    def workshop(self, scene: Scene, clearance: Floats) -> Held[Workshop]:
        """What this thread asks about the arm in a scene, with clearances (1 + pairs,) as in `World` [m]."""
        around, thread = scene.surroundings, get_ident()
        world = World(
            self.arm, around, self.groups, few_around(self.regions, self.arm, around), self.clearances,
            self._kinematics_here(), self.motion, whole_agenda(self.arm, around), clearance,
        )  # fmt: skip
        if thread not in self._benches:
            self._benches[thread] = bench_for(world)
        return hold(Workshop(world, self._benches[thread]))

    def _kinematics_here(self) -> Kinematics:
        """The kernel of link poses for compiled loops, with arrays of this thread alone."""
        thread, known = get_ident(), self._kinematics
        if thread not in known:
            kernel = self.robot.kernel("link_poses")
            known[thread] = kinematics_of(kernel, self.kernels, self.robot.mechanism, self.arm)
        return known[thread][0]

    def _poses(self, rows: Floats) -> Iterator[tuple[int, Floats]]:
        return poses_in_parts(self.robot, rows)

    def __reduce__(self) -> tuple[Any, ...]:
        """What another process can use: all but what lies at an address of this one."""
        return LaidArm, (self.robot, self._joints, self.arm)
