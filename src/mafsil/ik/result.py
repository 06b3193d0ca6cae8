"""The answer of numerical inverse kinematics: joint vectors, a status with a sentence for every pose, and residuals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.solvers import Status


class IKStatus(Status):
    """How the search for one pose ended."""

    SOLVED = ("ik.solved", True)
    OUT_OF_REACH = ("ik.out_of_reach", False)
    BEYOND_LIMITS = ("ik.beyond_limits", False)
    FEW_JOINTS = ("ik.few_joints", False)
    BUDGET_SPENT = ("ik.budget_spent", False)
    TIME_SPENT = ("ik.time_spent", False)
    NOT_A_POSE = ("ik.not_a_pose", False)


STATUSES = tuple(IKStatus)


@dataclass(frozen=True, eq=False)
class IKResult:
    """What was found for each pose of a batch.

    Attributes:
        q: (*batch, n) the solution; the configuration nearest to the pose that was seen where there is none; NaN where
            the row is not a pose [rad | m].
        codes: (*batch,) index into `STATUSES`.
        T_reached: (*batch, 4, 4) pose of the frame at q, in {s}.
        position_error: (*batch,) distance between the wanted and the reached origin [m], as far as it counts.
        rotation_error: (*batch,) angle between them [rad], as far as it counts.
        iterations: (*batch,) steps of the attempt that solved it or came nearest.
        attempts: (*batch,) starts tried.
        reach: (*batch,) proven bound of the distance of the frame from the first joint [m].
        distance: (*batch,) distance of the wanted position from the first joint [m].
        worst_joint: (*batch,) name of the joint that a solution without limits exceeds most; empty elsewhere.
    """

    q: JointVector
    codes: NDArray[np.int8]
    T_reached: PoseMatrix
    position_error: Floats
    rotation_error: Floats
    iterations: NDArray[np.int64]
    attempts: NDArray[np.int64]
    reach: Floats
    distance: Floats
    worst_joint: NDArray[np.str_]

    @property
    def solved(self) -> NDArray[np.bool_]:
        """(*batch,) whether q reaches the pose within the tolerance and the limits."""
        return self.codes == STATUSES.index(IKStatus.SOLVED)

    @property
    def all_solved(self) -> bool:
        """Whether every pose was reached."""
        return bool(self.solved.all())

    @property
    def residual(self) -> Floats:
        """(*batch,) the larger of position error [m] and rotation error [rad]."""
        return np.maximum(self.position_error, self.rotation_error)

    def status(self, *index: int) -> IKStatus:
        """The status of one pose of the batch; of the pose itself if there is no batch."""
        return STATUSES[int(self.codes[index])]

    def explain(self, *index: int, language: str | None = None) -> str:
        """The status of one pose as a sentence with its numbers."""
        return self.status(*index).sentence(
            language,
            position_error=float(self.position_error[index]),
            rotation_error=float(self.rotation_error[index]),
            attempts=int(self.attempts[index]),
            iterations=int(self.iterations[index]),
            reach=float(self.reach[index]),
            distance=float(self.distance[index]),
            joint=str(self.worst_joint[index]),
            joints=self.q.shape[-1],
        )
