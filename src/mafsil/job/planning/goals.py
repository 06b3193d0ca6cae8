"""From poses of a job to configurations of its arm: near the present one, and the same for the same pose."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik import IKResult, SolutionSet, inverse_kinematics, solve_ik
from mafsil.job.language.description import BranchChoice, Task
from mafsil.job.language.units import Tolerances
from mafsil.job.planning.fitting import is_far, revolute
from mafsil.job.remark import Refused
from mafsil.messages.quantities import quantity
from mafsil.robot import Robot

FIXES: dict[Task, int] = {"pose": 6, "axis": 5, "position": 3}
"""Equations of each task: arms with fewer joints meet it only at some places."""
FEW, MANY = 7, 63
"""Further starts where there may be no exact configuration: for the nearest, and for one within the tolerance."""
SAME = 1e-9
"""Poses that differ by less are the same [m, and entries of the rotation]."""
ALIKE = 1e-5
"""Configurations that differ by less are the same [rad | m]."""
STARTS = 24
"""Sampled starts of the search for other configurations."""


class Goals:
    """Configurations for poses, and the ones that were taken before."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._taken: dict[tuple[Task, bytes], JointVector] = {}

    def forget(self) -> None:
        """From here on the arm may take other configurations for the same poses."""
        self._taken.clear()

    def take(self, T: PoseMatrix, task: Task, q: JointVector) -> None:
        """Remember a configuration, unless the pose was taken in another one before."""
        self._taken.setdefault(_key(T, task), q)

    def taken(self, T: PoseMatrix, task: Task) -> JointVector | None:
        """The configuration in which a pose was taken before."""
        return self._taken.get(_key(T, task))

    def configuration(
        self, T: PoseMatrix, task: Task, q0: JointVector, allowed: Tolerances, where: object
    ) -> JointVector:
        """The configuration that reaches a pose, near a given one.

        Arms with fewer joints than the task has equations meet it in the sense of least squares, within the tolerance.

        Args:
            T: (4, 4) of the tip in {s}.
            task: what of it counts.
            q0: (n,) where the search begins [rad | m].
            allowed: what may be left.
            where: how the move is called in a refusal.

        Raises:
            Refused: none was found.
        """
        if self.robot.n >= FIXES[task]:
            answer = solve_ik(self.robot, T, q0, task=task)
            if answer.all_solved:
                return np.asarray(answer.q)
        else:
            answer = self._nearest(T, task, q0, allowed)
            if _within(answer, allowed):
                return np.asarray(answer.nearest)
        raise self._refuse(T, task, answer, allowed, where)

    def others(self, T: PoseMatrix, task: Task, q0: JointVector) -> list[JointVector]:
        """Other configurations for the same pose, the nearest to `q0` first."""
        limits = self.robot.limits
        low = np.where(np.isfinite(limits.lower), limits.lower, q0 - np.pi)
        high = np.where(np.isfinite(limits.upper), limits.upper, q0 + np.pi)
        starts = low + np.random.default_rng(0).random((STARTS, self.robot.n)) * (high - low)
        # Half of the starts lie around where the arm is: a redundant arm has configurations everywhere between.
        starts[::2] = q0 + (starts[::2] - q0) / 3
        answer = solve_ik(self.robot, np.broadcast_to(T, (STARTS, 4, 4)), starts, task=task, restarts=0)
        found = self._wound(answer.q[answer.solved], q0)
        _, first = np.unique(np.round(found / ALIKE), axis=0, return_index=True)
        return list(found[first[np.argsort(np.abs(found[first] - q0).max(axis=1), kind="stable")]])

    def _wound(self, rows: Floats, q0: JointVector) -> Floats:
        """Configurations (k, n) whose revolute joints are whole turns nearer to `q0`, where the limits allow that."""
        limits, is_revolute = self.robot.limits, revolute(self.robot)
        wound = np.where(is_revolute, rows + 2.0 * np.pi * np.round((q0 - rows) / (2.0 * np.pi)), rows)
        return np.where(limits.within(wound), wound, rows)

    def on_branch(self, T: PoseMatrix, branch: BranchChoice, q0: JointVector, where: object) -> list[JointVector]:
        """The configurations of a branch for a pose, wound towards a given one, the nearest first.

        Args:
            T: (4, 4) of the tip in {s}.
            branch: what is asked of it.
            q0: (n,) where the arm is [rad | m].
            where: how the move is called in a refusal.

        Raises:
            Refused: there is none within the limits.
        """
        answer = inverse_kinematics(self.robot, T)
        assert isinstance(answer, SolutionSet)
        asked = {name: value for name in branch.__struct_fields__ if (value := getattr(branch, name)) is not None}
        kinds = list(answer.branches)
        fits = [all(getattr(kind, name) == value for name, value in asked.items()) for kind in kinds]
        rows = np.asarray(answer.q)[np.asarray(fits, dtype=np.bool_) & np.asarray(answer.within)]
        if not len(rows):
            known = sorted({str(kind) for kind, inside in zip(kinds, answer.within, strict=True) if inside})
            words = ", ".join(f"{name} {value}" for name, value in asked.items())
            raise Refused("job.no_branch", move=where, asked=words, known=", ".join(known) or "-")
        rows = self._wound(rows, q0)
        return list(rows[np.argsort(np.abs(rows - q0).max(axis=1), kind="stable")])

    def _nearest(self, T: PoseMatrix, task: Task, q0: JointVector, allowed: Tolerances) -> IKResult:
        """The configuration of least residual near `q0`; near one within the tolerance if that is not within it."""
        answer = solve_ik(self.robot, T, q0, task=task, restarts=FEW)
        if _within(answer, allowed):
            return answer
        turn, way = allowed.orientation, allowed.position
        rough = solve_ik(self.robot, T, q0, task=task, tolerance=way, rotation_tolerance=turn, restarts=MANY)
        fine = solve_ik(self.robot, T, rough.nearest, task=task, restarts=0)
        return fine if _within(fine, allowed) else rough

    def _refuse(self, T: PoseMatrix, task: Task, answer: IKResult, allowed: Tolerances, where: object) -> Refused:
        if is_far(self.robot, T[:3, 3]):
            return Refused("job.unreachable_millimetres", move=where, reason=answer)
        if self.robot.n >= FIXES[task]:
            return Refused("job.unreachable", move=where, reason=answer)
        exact = inverse_kinematics(self.robot, T) if task == "pose" else None
        if isinstance(exact, SolutionSet) and len(exact.q) and not np.any(exact.within):
            # The joints would do, their limits do not.
            return Refused("job.unreachable", move=where, reason=exact)
        details = {
            "joints": self.robot.n,
            "position": quantity(float(answer.position_error), "m"),
            "angle": quantity(float(answer.rotation_error), "rad"),
            "allowed_position": quantity(allowed.position, "m"),
            "allowed_angle": quantity(allowed.orientation, "rad"),
        }
        return Refused(f"job.unreachable_few_{task}", move=where, **details)


def _within(answer: IKResult, allowed: Tolerances) -> bool:
    return bool(answer.position_error <= allowed.position and answer.rotation_error <= allowed.orientation)


def _key(T: PoseMatrix, task: Task) -> tuple[Task, bytes]:
    return task, np.round(T / SAME).astype(np.int64).tobytes()
