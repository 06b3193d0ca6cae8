"""Poses that are asked for, before any search (whether they are poses and within reach), and the answers of searches.

How inverse kinematics of a pose ended: one status for exact lists and for searches, each with its sentence.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, PoseMatrix, require_finite
from mafsil.errors import InputError, InputWarning, UnknownNameError, warn
from mafsil.ik.tolerances import MILLIMETRES, ON_LIMIT, REACHED
from mafsil.lazy_module import lazily
from mafsil.mechanics.arm_pattern import FARTHEST, ORTHOGONALITY
from mafsil.messages import say
from mafsil.model import Joint, JointKind, Mechanism

if TYPE_CHECKING:
    import mafsil.geometry.membership as membership
    import mafsil.geometry.pose as pose
else:
    membership = lazily("mafsil.geometry.membership")
    pose = lazily("mafsil.geometry.pose")


ROUNDING = 1e-15
"""The same, of matrices that need no repair."""
_EYE: Floats = np.eye(3)


class IKStatus(Status):
    """What can be said about a pose.

    OUT_OF_REACH and NOT_OF_THIS_ARM are said only where a closed form, a complete list or a bound of the reach proves
    it. BEYOND_LIMITS is proven where `inverse_kinematics` says it; of `solve_ik` it means that a solution was found
    beyond the limits and none within. What a search did not find is NOT_FOUND, NOT_FOUND_WITHIN_LIMITS, BUDGET_SPENT,
    TIME_SPENT or FEW_JOINTS, none of which proves anything.
    """

    SOLVED = ("ik.status_solved", True)
    CONTINUUM = ("ik.status_continuum", True)
    BEYOND_LIMITS = ("ik.status_beyond_limits", False)
    OUT_OF_REACH = ("ik.status_out_of_reach", False)
    NOT_OF_THIS_ARM = ("ik.status_not_of_this_arm", False)
    NOT_FOUND = ("ik.status_not_found", False)
    NOT_A_POSE = ("ik.status_not_a_pose", False)
    NOT_FOUND_WITHIN_LIMITS = ("ik.status_not_found_within_limits", False)
    FEW_JOINTS = ("ik.status_few_joints", False)
    BUDGET_SPENT = ("ik.status_budget_spent", False)
    TIME_SPENT = ("ik.status_time_spent", False)


STATUSES = tuple(IKStatus)
"""All of them in order; arrays of codes hold indices into it."""
CODES = {status: code for code, status in enumerate(STATUSES)}
"""The index of each."""
_MEMBERS = np.array(STATUSES, dtype=np.object_)
FIELDS = (
    "nearest", "codes", "T_reached", "position_error", "rotation_error", "iterations", "attempts", "reach", "distance",
    "worst_joint", "moving",
)  # fmt: skip
"""Names of what an answer holds."""
SENTENCES = {
    IKStatus.SOLVED: "ik.solved",
    IKStatus.OUT_OF_REACH: "ik.out_of_reach",
    IKStatus.BEYOND_LIMITS: "ik.beyond_limits",
    IKStatus.FEW_JOINTS: "ik.few_joints",
    IKStatus.BUDGET_SPENT: "ik.budget_spent",
    IKStatus.TIME_SPENT: "ik.time_spent",
    IKStatus.NOT_A_POSE: "ik.not_a_pose",
}
"""How a search explains a status, with its numbers."""
LISTED = 20
"""Poses of a batch whose sentences are listed at once."""


def rounded_up(x: float) -> float:
    """The next number of three digits that is larger by some rounding at least."""
    if not 0.0 < x < np.inf:
        return x
    unit = 10.0 ** (np.floor(np.log10(x)) - 2)
    return float(np.ceil(x * (1 + REACHED) / unit) * unit)


class IKResult(Answer, data="solved q=nearest position_error rotation_error iterations attempts"):
    """What was found for each pose of a batch.

    A field is found when it is asked for first, so that a single answer costs no more than what is used of it.

    Attributes:
        nearest: (*batch, n) the solution where `solved`; else no solution but the configuration nearest to the pose
            that was seen (`solution` hides those), NaN where the row is not a pose [rad | m].
        codes: (*batch,) index into `STATUSES`.
        T_reached: (*batch, 4, 4) pose of the frame at q, in {s}.
        position_error: (*batch,) distance between the desired and the reached origin [m], as far as it counts.
        rotation_error: (*batch,) angle between them [rad], as far as it counts.
        iterations: (*batch,) steps of the attempt that solved it or came nearest.
        attempts: (*batch,) starts tried.
        reach: (*batch,) proven bound of the distance of the frame from the first joint [m].
        distance: (*batch,) distance of the desired position from the first joint [m].
        worst_joint: (*batch,) name of the joint that a solution without limits exceeds most, or that lies beyond its
            limit by so little that it counts as on it; empty elsewhere.
        moving: number of joints that move the frame.
    """

    __slots__ = (*FIELDS, "_find")

    nearest: JointVector
    codes: NDArray[np.int8]
    T_reached: PoseMatrix
    position_error: Floats
    rotation_error: Floats
    iterations: NDArray[np.int64]
    attempts: NDArray[np.int64]
    reach: Floats
    distance: Floats
    worst_joint: NDArray[np.str_]
    moving: int
    _find: Callable[[str], Any]

    def __init__(self, find: Callable[[str], Any], **known: Any) -> None:
        """An answer.

        Args:
            find: gives the field of a name.
            known: fields that need not be found.
        """
        _set(self, "_find", find)
        for name, value in known.items():
            _set(self, name, value)

    def __getattr__(self, name: str) -> Any:
        if name not in FIELDS:
            raise AttributeError(name) if name.startswith("_") else UnknownNameError("IKResult", name, dir(self))
        value = self._find(name)
        _set(self, name, value)
        return value

    def __setattr__(self, name: str, _value: Any) -> None:
        raise AttributeError(name)

    def __reduce__(self) -> tuple[Any, ...]:
        return _restore, ({name: getattr(self, name) for name in FIELDS},)

    def with_joints(self, nearest: JointVector) -> IKResult:
        """The same answer with other joint vectors, such as those of the whole robot."""
        return IKResult(lambda name: getattr(self, name), nearest=nearest)

    def __bool__(self) -> bool:
        return self.all_solved

    def __len__(self) -> int:
        return len(self.codes) if self.codes.ndim else 1

    def __iter__(self) -> Iterator[IKResult]:
        if not self.codes.ndim:
            return iter((self,))
        return (self[i] for i in range(len(self.codes)))

    def __getitem__(self, index: int | slice | tuple[int, ...]) -> IKResult:
        """The answer to some of the poses of a batch."""
        return IKResult(lambda name: np.asarray(getattr(self, name)[index]), moving=self.moving)

    @property
    def q(self) -> JointVector:
        """(*batch, n) as `nearest`; of a single answer that is no solution, with a warning.

        Warns:
            InputWarning: the pose was not reached.
        """
        if not self.codes.ndim and not self.solved:
            warn(InputWarning("ik.unsolved_q", residual=rounded_up(float(self.residual))))
        return self.nearest

    @property
    def solution(self) -> JointVector:
        """(*batch, n) the solutions; NaN where a pose is not solved."""
        return np.where(self.solved[..., None], self.nearest, np.nan)

    @property
    def solved(self) -> NDArray[np.bool_]:
        """(*batch,) whether q reaches the pose within the tolerance and the limits."""
        return self.codes == CODES[IKStatus.SOLVED]

    @property
    def all_solved(self) -> bool:
        """Whether every pose was reached."""
        return bool(self.solved.all())

    @property
    def residual(self) -> Floats:
        """(*batch,) the larger of position error [m] and rotation error [rad]."""
        return np.maximum(self.position_error, self.rotation_error)

    @property
    def status(self) -> Any:
        """The status of the pose, a member of `IKStatus`; of a batch an array (*batch,) of them."""
        return STATUSES[int(self.codes)] if not self.codes.ndim else _MEMBERS[self.codes]

    def explain(self, *index: int, language: str | None = None) -> str:  # pyright: ignore[reportIncompatibleMethodOverride]
        """The status of one pose as a sentence with its numbers.

        Of a batch, without an index, how many are solved, and the sentences of those that are not.
        """
        if self.codes.ndim > len(index):
            part = self[index] if index else self
            lines = [say("ik.batch", language=language, solved=int(part.solved.sum()), count=part.codes.size)]
            for row in np.argwhere(~part.solved)[:LISTED].tolist():
                lines.append(f"{row}: {part.explain(*row, language=language)}")
            return "\n".join(lines)
        status, joint = STATUSES[int(self.codes[index])], str(self.worst_joint[index])
        sentence = say(
            "ik.solved_on_limit" if status is IKStatus.SOLVED and joint else SENTENCES[status],
            language=language,
            measured=ON_LIMIT,
            position_error=float(self.position_error[index]),
            rotation_error=float(self.rotation_error[index]),
            attempts=int(self.attempts[index]),
            iterations=int(self.iterations[index]),
            reach=float(self.reach[index]),
            distance=float(self.distance[index]),
            joint=joint,
            joints=self.moving,
            accepting=f"{rounded_up(float(self.residual[index])):.3g}",
        )
        if status is IKStatus.OUT_OF_REACH and self.distance[index] > MILLIMETRES * self.reach[index]:
            sentence += "; " + say("ik.part_millimetres", language=language)
        return sentence


_set = object.__setattr__


def _restore(fields: dict[str, Any]) -> IKResult:
    """An answer from another process."""
    return IKResult(fields.__getitem__, **fields)


def clean_poses(T: PoseMatrix) -> tuple[PoseMatrix, NDArray[np.bool_]]:
    """Poses with their rotations brought to working precision, and which rows were poses at all.

    Args:
        T: (k, 4, 4).

    Returns:
        (k, 4, 4), identity in rows that are no poses, and (k,).
    """
    if len(T) == 1 and (defect := _defect(T[0])) <= ORTHOGONALITY:
        clean = np.array(T, dtype=np.float64)
        if defect > ROUNDING:
            clean[:, :3, :3] = _orthogonal(clean[:, :3, :3])
        clean[:, 3] = [0.0, 0.0, 0.0, 1.0]
        return clean, np.ones(1, dtype=np.bool_)
    with np.errstate(invalid="ignore", over="ignore"):
        x, y, z, p = np.ascontiguousarray(T[:, :3].transpose(2, 1, 0))
        lengths = [np.abs((v * v).sum(axis=0) - 1.0) for v in (x, y, z)]
        leans = [np.abs((v * w).sum(axis=0)) for v, w in ((x, y), (y, z), (z, x))]
        defect = np.max([*lengths, *leans], axis=0)
        proper = (x * np.cross(y, z, axis=0)).sum(axis=0) > 0.0
        ends = np.abs(T[:, 3] - np.array([0.0, 0.0, 0.0, 1.0])).max(axis=1, initial=0.0)
        valid = (defect <= ORTHOGONALITY) & proper & (ends <= ORTHOGONALITY) & (np.abs(p) < FARTHEST).all(axis=0)
    clean = np.where(valid[:, None, None], T, np.eye(4))
    rough = np.flatnonzero(valid & (defect > ROUNDING))
    if len(rough):
        clean[rough, :3, :3] = _orthogonal(clean[rough, :3, :3])
    clean[:, 3] = [0.0, 0.0, 0.0, 1.0]
    return clean, valid


def printed_pose(name: str, T: PoseMatrix) -> PoseMatrix:
    """The pose that a matrix was before it was printed with few digits.

    Args:
        name: of the argument.
        T: (*batch, 4, 4).

    Raises:
        InputError: it is none even so; names the row, its distance and the likely cause.

    Warns:
        InputWarning: of the digits that were left out.
    """
    largest = float(np.abs(require_finite(name, T)).max())
    if largest >= FARTHEST:
        raise InputError("ik.farthest", name=name, value=largest, limit=FARTHEST)
    return pose.project(membership.require("pose", name, T))


def _orthogonal(R: Floats) -> Floats:
    """(k, 3, 3) nearly orthogonal matrices made so: each Newton step for the polar factor squares the defect."""
    for _ in range(2):
        R = R @ (1.5 * _EYE - 0.5 * (R.transpose(0, 2, 1) @ R))
    return R


def _defect(T: PoseMatrix) -> float:
    """How far one matrix is from a pose, infinite of what is none; plain Python is quicker for so few numbers."""
    (a, b, c, p), (d, e, f, q), (g, h, i, r), (*low, one) = T.tolist()
    defects = (
        a * a + d * d + g * g - 1.0, b * b + e * e + h * h - 1.0, c * c + f * f + i * i - 1.0,
        a * b + d * e + g * h, b * c + e * f + h * i, c * a + f * d + i * g, *low, one - 1.0,
    )  # fmt: skip
    # Comparisons with NaN are false: what is no number has no defect that could be mended.
    if not all(-ORTHOGONALITY <= defect <= ORTHOGONALITY for defect in defects):
        return inf
    proper = a * (e * i - h * f) + d * (h * c - b * i) + g * (b * f - e * c) > 0.0
    if not (proper and abs(p) < FARTHEST and abs(q) < FARTHEST and abs(r) < FARTHEST):
        return inf
    return max(map(abs, defects[:6]))


def reach_bound(mechanism: Mechanism, frame: str | None) -> tuple[Floats, float]:
    """A sphere that the origin of a frame cannot leave.

    The centre is the origin of the first moving joint; the radius is the sum of the distances between consecutive
    joints on the way to the frame, with the strokes of prismatic and helical joints (infinite if unlimited).

    Returns:
        (3,) centre in {s} [m], and radius [m].
    """
    carrier = {joint.child: joint for joint in mechanism.joints}
    link = mechanism.tip if frame is None else frame
    path: list[Joint] = []
    while link in carrier:
        path.insert(0, carrier[link])
        link = path[0].parent
    T = np.asarray(mechanism.T_sb)
    while path and not path[0].moves:
        T = T @ path.pop(0).T_pj
    if not path:
        return (T @ (mechanism.T_lt if frame is None else np.eye(4)))[:3, 3], 0.0
    radius = _stroke(path[0]) + sum(float(np.linalg.norm(joint.T_pj[:3, 3])) + _stroke(joint) for joint in path[1:])
    last = float(np.linalg.norm(mechanism.T_lt[:3, 3])) if frame is None else 0.0
    return (T @ path[0].T_pj)[:3, 3], radius + last


def _stroke(joint: Joint) -> float:
    """Largest distance that a joint moves its child's origin along its axis [m]."""
    if joint.kind in (JointKind.REVOLUTE, JointKind.FIXED):
        return 0.0
    if joint.mimic is not None:
        return float("inf")
    per_unit = 1.0 if joint.kind is JointKind.PRISMATIC else abs(joint.pitch)
    return per_unit * max(abs(joint.limits.lower), abs(joint.limits.upper))
