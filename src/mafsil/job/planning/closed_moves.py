"""Jobs of mechanisms with loops: lists of joints name the driven ones, and motions keep the loops closed."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np

from mafsil.arrays import Floats, Integers, JointVector, PoseMatrix
from mafsil.control import Law, closed_computed_torque, closed_gravity_compensation
from mafsil.control.laws import driven_trajectory, follow_with_loops
from mafsil.control.laws.feedback import DAMPING_RATIO, NATURAL_FREQUENCY
from mafsil.errors import InputError
from mafsil.job.language.description import Bounds, Job, Move, Task
from mafsil.job.language.text import Places
from mafsil.job.language.units import Tolerances
from mafsil.job.planning.joint_motion import joint_motion, motion_on_path
from mafsil.job.planning.tip_motion import SHORTEST, TipMotion, motion_along
from mafsil.job.remark import Refused
from mafsil.job.tolerances import WITHIN_LIMITS
from mafsil.messages.visible import visible
from mafsil.model import JointLimits
from mafsil.parallel import ClosedChain, closed_inverse_kinematics
from mafsil.robot import Robot
from mafsil.trajectory import JointPath, Trajectory, check
from mafsil.trajectory.path import PathMotion
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.profiles import rest
from mafsil.trajectory.splines import PiecewisePolynomial

LAWS = ("computed_torque", "pd_gravity")
"""The laws that know loops."""
FREQUENCY, DAMPING = 20.0, 1.0
"""Of the error dynamics, where the job names none [rad/s, 1]."""
SAME = 1e-6
"""Configurations that differ by less are one [rad | m]."""


def listed_joints(robot: Robot, count: int) -> Integers:
    """Indices of the coordinates that a list of so many numbers names: all, or the driven ones where there are loops.

    Args:
        robot: of the job.
        count: of numbers.
    """
    if count == robot.n or not robot.mechanism.loops:
        return np.arange(robot.n)
    return np.flatnonzero([joint.actuated for joint in robot.mechanism.coordinates])


def require_closed_job(job: Job, robot: Robot, places: Places) -> None:
    """Refuse what jobs of mechanisms with loops cannot say.

    Args:
        job: what is asked.
        robot: a mechanism with loops.
        places: for the lines of errors.

    Raises:
        JobError: branches, another law, friction that is to be compensated, MuJoCo, or no driven joint.
    """
    name = visible(robot.name)
    if not len(listed_joints(robot, -1)):
        raise places.error("job.loops_no_drive", ("robot",), robot=name)
    if job.start.pose is not None and job.start.pose.branch is not None:
        raise places.error("job.loops_branch", ("start", "pose", "branch"), robot=name)
    for k, move in enumerate(job.move):
        if move.pose is not None and move.pose.branch is not None:
            raise places.error("job.loops_branch", ("move", k, "pose", "branch"), robot=name)
    if job.controller.kind not in LAWS:
        raise places.error("job.loops_law", ("controller", "kind"), robot=name, known=", ".join(LAWS))
    if job.controller.friction:
        raise places.error("job.loops_friction", ("controller", "friction"), robot=name)
    if job.simulation.plant == "mujoco":
        raise places.error("job.loops_mujoco", ("simulation", "plant"), robot=name)


class ClosedMoves:
    """Motions of the driven joints of one mechanism, and configurations with closed loops for its goals.

    Args:
        robot: with loops, and the tool with which it starts.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot, self.chain = robot, ClosedChain(robot)
        self.turns = robot.mechanism.angular

    def closed_configuration(self, values: JointVector, near: JointVector, where: object) -> JointVector:
        """(n,) the closed configuration in which the driven joints are as given.

        Args:
            values: (a,) of the driven joints, or (n,) of all, the others as a guess [rad | m].
            near: (n,) which way the loops are closed, where the values do not say it.
            where: how the move is called in a refusal.

        Raises:
            Refused: none was found; it says how far the loops gape.
        """
        guess, a = near.copy(), self.chain.actuated
        if len(values) == self.chain.n:
            guess, values = values.copy(), values[a]
        guess[a] = values
        found = self.chain.close_loops(guess, hold=a, tries=1)
        if not found:
            raise Refused("job.loops_open", move=where, reason=found)
        return found.q

    def at_pose(
        self, robot: Robot, T: PoseMatrix, task: Task, near: JointVector, allowed: Tolerances, where: object
    ) -> list[JointVector]:
        """Configurations with closed loops and within the limits whose tip is at a pose, the nearest first.

        Where none reaches it exactly, as where the mechanism has fewer freedoms than the task asks, those within the
        tolerance.

        Args:
            robot: with the tool that is mounted.
            T: (4, 4) of the tip in {s}.
            task: what of it counts.
            near: (n,) where the search begins.
            allowed: what may be left.
            where: how the move is called in a refusal.

        Raises:
            Refused: none was found; it says how near the nearest comes.
        """
        chain = self.chain if robot is self.robot else ClosedChain(robot)
        found = closed_inverse_kinematics(chain, T, near, task=task)
        if not len(found):
            found = closed_inverse_kinematics(
                chain, T, near, task=task, tolerance=allowed.position, rotation_tolerance=allowed.orientation
            )
        if not found:
            raise Refused("job.loops_unreached", move=where, reason=found)
        return list(found.q[found.within])

    def motion(
        self, q: JointVector, points: list[JointVector], move: Move, limits: JointLimits, where: object
    ) -> Trajectory:
        """All joints from a configuration while the driven ones go from point to point.

        Args:
            q: (n,) where it begins, closed.
            points: (a,) or (n,) each, after the beginning [rad | m].
            move: duration and law of time.
            limits: of all joints, for this move.
            where: how the move is called in a refusal.

        Raises:
            Refused: the limits do not allow it, the loops cannot be closed on the way, or a joint leaves its range.
        """
        a = self.chain.actuated
        way = [q[a], *(point[a] if len(point) == self.chain.n else point for point in points)]
        planned = joint_motion(self.robot, way, move, limits_of(limits, a), where, a)
        return self._follow(planned.trajectory, q, limits, where)

    def along(self, q: JointVector, path: JointPath, move: Move, limits: JointLimits, where: object) -> Trajectory:
        """All joints while the driven ones follow what a path of all of them does with them.

        Args:
            q: (n,) where it begins, closed.
            path: of all joints; between its points its loops may gape a little, the motion's do not.
            move, limits, where: as for `motion`.

        Raises:
            Refused: as `motion`.
        """
        a, curve = self.chain.actuated, path.curve
        driven = JointPath(PiecewisePolynomial(curve.knots, curve.coefficients[..., a]))
        planned = motion_on_path(self.robot, driven, move, limits_of(limits, a), where, a)
        return self._follow(planned.trajectory, q, limits, where)

    def on_tip_path(
        self, robot: Robot, q: JointVector, path: TipPath | None, bounds: Bounds, move: Move, limits: JointLimits,
        slack: float, where: object,
    ) -> TipMotion:  # fmt: skip
        """All joints while the tip keeps to a path, within the bounds of the tip and of the driven joints.

        Args:
            robot: with the tool that is mounted.
            q: (n,) where it begins, closed.
            path: of the tip; None if it leads nowhere.
            bounds, move, limits, slack, where: as for `mafsil.job.planning.tip_motion.tip_motion`.

        Raises:
            Refused: a point of the path cannot be reached, or as `motion`.
        """
        if path is None:
            duration = move.duration or SHORTEST
            return TipMotion(rest(q, duration), duration)
        chain = self.chain if robot is self.robot else ClosedChain(robot)
        followed = follow_with_loops(chain, path, q, task="pose" if move.pose is None else move.pose.task, slack=slack)
        if followed.value is None or not followed.succeeded:
            raise Refused("job.no_path", move=where, reason=followed)
        a, joints = chain.actuated, followed.value
        driven = np.isin(np.arange(chain.n), a)
        bound = {name: np.where(driven, getattr(limits, name), np.inf) for name in ("velocity", "acceleration", "jerk")}
        motion = motion_along(robot, joints, path, bounds, move, replace(limits, **bound), where).trajectory
        assert isinstance(motion, PathMotion)
        columns = PiecewisePolynomial(joints.knots, joints.coefficients[..., a])
        trajectory = self._follow(replace(motion, path=columns), q, limits, where)
        return TipMotion(trajectory, trajectory.duration)

    def require_at(self, trajectory: Trajectory, q: JointVector, where: object) -> None:
        """Refuse a motion whose loops are closed another way at its end than they should be.

        Args:
            trajectory: of all joints.
            q: (n,) where it should end.
            where: how the move is called in a refusal.

        Raises:
            Refused: it ends elsewhere.
        """
        apart = trajectory.at(trajectory.duration).u - q
        apart = np.abs(np.where(self.turns, np.remainder(apart + np.pi, 2 * np.pi) - np.pi, apart))
        if apart.max() > SAME:
            k = int(apart.argmax())
            raise Refused("job.loops_other_way", move=where, joint=visible(self.robot.joint_names[k]))

    def _follow(self, driven: Trajectory, q: JointVector, limits: JointLimits, where: object) -> Trajectory:
        try:
            found = driven_trajectory(self.chain, driven, q)
        except InputError as error:
            raise Refused("job.loops_way", move=where, reason=error.message()) from None
        verdict = check(found, _ranges(limits), tolerance=WITHIN_LIMITS)
        if not verdict:
            worst = verdict.violations[0]
            details = {"joint": visible(self.robot.joint_names[int(worst.joint)]), "time": worst.time}
            raise Refused("job.loops_range", move=where, **details)
        return found


def closed_law(job: Job, model: Robot, trajectory: Trajectory) -> Law:
    """The law of a job for a mechanism with loops.

    Args:
        job: whose controller it is.
        model: as the controller knows it.
        trajectory: of the stretch: gains that the job leaves out fit the inertia along it.
    """
    chain, own = ClosedChain(model), job.controller
    if own.kind == "computed_torque":
        frequency = FREQUENCY if own.frequency is None else own.frequency
        damping = DAMPING if own.damping is None else own.damping
        return closed_computed_torque(chain, natural_frequency=frequency, damping_ratio=damping)
    inertia = _felt_inertia(chain, trajectory)
    kp = inertia * NATURAL_FREQUENCY**2 if own.kp is None else np.asarray(own.kp)
    kd = 2.0 * DAMPING_RATIO * np.sqrt(inertia * kp) if own.kd is None else own.kd
    return closed_gravity_compensation(chain, kp, kd)


def holding_efforts(chain: ClosedChain, q: Floats) -> Floats:
    """(k, n) efforts of the driven joints that hold configurations (k, n) still; zero for the others."""
    still = np.zeros_like(q)
    found = np.zeros_like(q)
    found[..., chain.actuated] = chain.inverse_dynamics(q, still, still).tau
    return found


def limits_of(limits: JointLimits, columns: Integers) -> JointLimits:
    """The limits of some of the joints."""
    return JointLimits(**{each.name: getattr(limits, each.name)[columns] for each in fields(limits)})


def _ranges(limits: JointLimits) -> JointLimits:
    """Only the ranges: rates of passive joints are what the loops make of them."""
    free = np.full(len(limits.lower), np.inf)
    return replace(limits, velocity=free, acceleration=free, jerk=free)


def _felt_inertia(chain: ClosedChain, trajectory: Trajectory, places: int = 24) -> Floats:
    """(a,) the largest inertia that each driven joint feels along a motion, the others held as the loops allow."""
    q = trajectory.at(np.linspace(0.0, trajectory.duration, places)).u
    M, a = chain.terms(q).M, chain.actuated
    felt: list[float] = []
    for column in a.tolist():
        unit = np.zeros(q.shape)
        unit[..., column] = 1.0
        rates = chain.rates(q, unit, hold=a)
        felt.append(float(np.einsum("ki,kij,kj->k", rates, M, rates).max()))
    return np.array(felt)
