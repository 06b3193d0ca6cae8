"""Four tasks in touch with the world, ready to run: chalk on a board, an eraser, a door, a peg in a hole.

Each is a scenario that begins at a given configuration; the tip's z axis points towards what is touched. Change what is
to be studied by `dataclasses.replace`: law, plant, noise, period.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector3, as_batch, number, positive
from mafsil.control import (
    Gains,
    Impedance,
    Law,
    TaskCoordinates,
    TaskTarget,
    Wall,
    combine,
    hybrid_control,
    impedance_control,
    task_dynamics,
)
from mafsil.control.contact import AtPoints, Door, Hole, TipDamping, TipForceSensor
from mafsil.control.contact.environment import Environment
from mafsil.control.laws import TipMotion
from mafsil.robot import Robot, of_robot
from mafsil.simulation.plant import Plant
from mafsil.simulation.scenario import Scenario
from mafsil.trajectory import line_path, time_law
from mafsil.trajectory.profiles import rest

BOARD_STIFFNESS, BOARD_DAMPING = 2e4, 100.0
"""Of boards that are touched [N/m, N s/m]."""
SLOW = 5e-3
"""Speed of sliding below which their friction falls off: what steps of half a millisecond bear [m/s]."""
FREQUENCY = 20.0
"""Of the motion along a board [rad/s]."""
FORCE_INTEGRAL = 40.0
"""Gain of the integral of the force error [1/s]."""
SOFT, TURN_SOFT = 400.0, 20.0
"""Impedance of a hand that gives way [N/m, N m/rad]."""


@of_robot
def chalk_on_board(
    robot: Robot,
    q: ArrayLike,
    *,
    length: float = 0.05,
    normal_force: float = 5.0,
    friction: float = 0.2,
    duration: float = 1.0,
) -> Scenario:
    """A line drawn on a board that the tip touches: one direction of force, five of motion.

    Args:
        robot: of six joints or more.
        q: (n,) where the tip touches the board, its z axis into it.
        length: of the line along the tip's x axis [m].
        normal_force: force into the board [N].
        friction: coefficient of the chalk.
        duration: [s].

    Raises:
        InputError: a wrong shape, a length, force or duration that is not positive.
    """
    place, T = _start(robot, q)
    board = _board(T, friction, 1)
    A = np.concatenate([np.zeros(3), T[:3, 2]])[None]
    return _on_board(robot, place, board, A, positive("normal_force", normal_force), _line(T, length, duration), 0.0)


@of_robot
def eraser_on_board(
    robot: Robot, q: ArrayLike, *, length: float = 0.05, normal_force: float = 8.0, half_width: float = 0.02,
    friction: float = 0.2, duration: float = 1.0,
) -> Scenario:  # fmt: skip
    """A flat eraser wiped over a board: force along its normal, no moments about the two axes in it, motion otherwise.

    Args:
        robot: of six joints or more.
        q: (n,) where the eraser touches the board, the tip's z axis into it.
        length: wiped along the tip's x axis [m].
        normal_force: force into the board [N].
        half_width: from the middle of the eraser to its corners, along x and y [m].
        friction: coefficient at each corner.
        duration: [s].

    Raises:
        InputError: a wrong shape, a length, force or duration that is not positive.
    """
    place, T = _start(robot, q)
    w = positive("half_width", half_width)
    corners = np.array([[w, w, 0], [w, -w, 0], [-w, -w, 0], [-w, w, 0]])
    board = AtPoints(_board(T, friction, len(corners)), corners)
    A = np.zeros((3, 6))
    A[0, :3], A[1, :3], A[2, 3:] = T[:3, 0], T[:3, 1], T[:3, 2]
    return _on_board(robot, place, board, A, positive("normal_force", normal_force), _line(T, length, duration), w)


@of_robot
def open_a_door(
    robot: Robot, q: ArrayLike, *, radius: float = 0.4, angle: float = -0.5, wrong: float = 0.05, duration: float = 2.0
) -> Scenario:
    """A door opened by an arm that takes its radius for another: a soft hand gives way, a stiff one fights it.

    Args:
        robot: of six joints or more.
        q: (n,) where the tip holds the handle; the hinge is parallel to its x axis, beside it along -y.
        radius: from the hinge to the handle [m].
        angle: by which it is opened; above zero along the tip's z axis, below zero it is pulled [rad].
        wrong: share by which the arm takes the radius to be larger.
        duration: [s].

    Raises:
        InputError: a wrong shape, a radius or duration that is not positive.
    """
    angle, wrong = number("angle", angle), number("wrong", wrong)
    place, T = _start(robot, q)
    r = positive("radius", radius)
    hinge, axis = T[:3, 3] - r * T[:3, 1], T[:3, 0]
    door = Door(
        hinge, axis, T, stiffness=2e4, damping=200.0, rotational_stiffness=50.0, rotational_damping=1.0, friction=0.5
    )
    taken = Door(T[:3, 3] - (1.0 + wrong) * r * T[:3, 1], axis, T, stiffness=1.0)
    law = time_law("quintic").unit().scale_time(positive("duration", duration))

    def tip(t: float) -> TaskTarget:
        s, rate, growth = (float(part[..., 0]) * angle for part in law.at(t))
        there = taken.handle_pose(s)
        arm = there[:3, 3] - taken.hinge
        turn = rate * axis
        V = np.concatenate([turn, np.cross(turn, arm)])
        bend = np.cross(growth * axis, arm) + np.cross(turn, np.cross(turn, arm))
        return TaskTarget(there, V, np.concatenate([growth * axis, bend]))

    soft = impedance_control(robot, _soft(robot, place), tip, shift_acceleration=True)
    return _scenario(robot, place, door, soft, duration)


@of_robot
def peg_in_hole(
    robot: Robot,
    q: ArrayLike,
    *,
    off: float = 1e-3,
    depth: float = 0.03,
    clearance: float = 2e-4,
    duration: float = 2.0,
) -> Scenario:
    """A peg put into a chamfered hole that is not quite where the arm takes it to be.

    Args:
        robot: of six joints or more.
        q: (n,) where the end of the peg is 5 mm before the hole, the tip's z axis into it.
        off: by which the hole is aside, along the tip's x axis [m].
        depth: of the hole [m].
        clearance: radius of the hole less that of the peg [m].
        duration: [s].

    Raises:
        InputError: a wrong shape, a depth, clearance or duration that is not positive.
    """
    place, T = _start(robot, q)
    z = T[:3, 2]
    hole = Hole(
        T[:3, 3] + 0.005 * z + off * T[:3, 0], -z, clearance=clearance, depth=positive("depth", depth),
        chamfer=3e-3, stiffness=BOARD_STIFFNESS, damping=BOARD_DAMPING, friction=0.1,
    )  # fmt: skip
    peg = AtPoints(hole, np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -depth / 2.0]]))
    path = line_path(T, _move(T, (0.005 + depth + 0.005) * z))
    tip = TipMotion(path, time_law("quintic").unit().scale_time(positive("duration", duration)))
    soft = impedance_control(robot, _soft(robot, place), tip, shift_acceleration=True)
    return _scenario(robot, place, peg, soft, duration)


def _start(robot: Robot, q: ArrayLike) -> tuple[Floats, PoseMatrix]:
    place = as_batch("q", q, (robot.n,), finite=True).reshape(robot.n)
    return place, robot.forward_kinematics(place)


def _board(T: PoseMatrix, friction: float, points: int) -> Wall:
    """A board through the tip's origin, which its z axis points into, as one of so many points meets it."""
    return Wall(T[:3, 3], -T[:3, 2], BOARD_STIFFNESS / points, BOARD_DAMPING / points, friction, slow=SLOW)


def _line(T: PoseMatrix, length: float, duration: float) -> TipMotion:
    law = time_law("quintic").unit().scale_time(positive("duration", duration))
    return TipMotion(line_path(T, _move(T, positive("length", length) * T[:3, 0])), law)


def _move(T: PoseMatrix, by: Vector3) -> PoseMatrix:
    found = T.copy()
    found[:3, 3] += by
    return found


def _on_board(
    robot: Robot, place: Floats, board: Environment, A: Floats, normal_force: float, tip: TipMotion, half_width: float
) -> Scenario:
    """Force into the board along the last row of A, no moment along the others, motion along the rest."""
    task = TaskCoordinates()
    inertia = task_dynamics(robot, place).inertia
    stiffness = np.array([BOARD_STIFFNESS * half_width**2] * (len(A) - 1) + [BOARD_STIFFNESS])
    damping = 2.0 * np.sqrt(stiffness * np.einsum("ki,ij,kj->k", A, inertia, A))
    force = hybrid_control(
        robot, tip, A, normal_force * A[-1], gains=Gains.from_natural_frequency(6, FREQUENCY),
        sensor=TipForceSensor(robot, board, task), force_ki=FORCE_INTEGRAL,
    )  # fmt: skip
    law = combine(force, TipDamping(robot, task, (A.T * damping) @ A))
    return _scenario(robot, place, board, law, tip.law.duration)


def _soft(robot: Robot, place: Floats) -> Impedance:
    """A hand that gives way, critically damped for the arm's inertia at the start."""
    inertia = np.diagonal(task_dynamics(robot, place).inertia)
    stiffness = np.repeat([TURN_SOFT, SOFT], 3)
    return Impedance.of(6, damping=2.0 * np.sqrt(stiffness * inertia), stiffness=stiffness)


def _scenario(robot: Robot, place: Floats, environment: Environment, law: Law, duration: float) -> Scenario:
    plant = Plant(robot, friction=False, environment=environment)
    return Scenario(
        robot=robot, plant=plant, trajectory=rest(place, duration), law=law, step=5e-4, period=1e-3, saturate=False,
        integrator="semi_implicit_euler",
    )  # fmt: skip
