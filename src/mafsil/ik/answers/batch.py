"""All solutions of many poses at once: padded arrays, and the careful answer to any one of them by its index."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer
from mafsil.arrays import Floats, JointVector, PoseMatrix, as_batch
from mafsil.errors import InputError
from mafsil.ik.answers.branch import Branch, pose_table
from mafsil.ik.answers.one_pose import one_pose
from mafsil.ik.answers.setting import Setting, folding, nearly_there, structure_decides
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.result import FARTHEST, STATUSES, clean_poses, printed_pose
from mafsil.kernels.lazy import lazy
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.messages.tables import on_screen

if TYPE_CHECKING:
    import mafsil.ik.refine_loops as winding_loops
else:
    winding_loops = lazily("mafsil.ik.refine_loops")

_MEMBERS = np.array(STATUSES, dtype=np.object_)

ROWS = 64
"""More than any table of solutions has: a row and a number of a branch make one number."""


class Columns(NamedTuple):
    """The arrays of a batch, one after another over all poses.

    Attributes:
        q, valid, within, residual, codes, free, status: as of `SolutionBatch`, of the joints that move the frame.
    """

    q: JointVector
    valid: NDArray[np.bool_]
    within: NDArray[np.bool_]
    residual: Floats
    codes: NDArray[np.int16]
    free: NDArray[np.int32]
    status: NDArray[np.int8]


class SolutionBatch(Answer, data="solved q valid within residual"):
    """All solutions of many poses.

    Row k of a pose is the same root of the closed form for every pose, so that rows do not change places in a batch.

    Attributes:
        q: (*batch, k, n) coordinates; only rows that are `valid` are solutions, others hold the configuration that
            comes closest.
    """

    def __init__(
        self,
        q: JointVector,
        columns: Callable[[], Columns],
        request: tuple[Setting, PoseMatrix, JointVector, float],
        moving: Callable[[], None] | None = None,
    ) -> None:
        """What is not read costs nothing.

        Args:
            q: (k, rows, m) coordinates of the joints that move the frame.
            columns: gives the other arrays.
            request: the arm, the poses, the coordinates of the whole robot, the tolerance.
            moving: certifies in the columns the solutions that may move though no joint of the closed form is free.
        """
        self.setting, self.T, self.others, self.tolerance = request
        part = self.setting.part
        q = q.reshape(*self.T.shape[:-2], *q.shape[1:])
        self.q = q if part.places is None else part.lift(q, self.others)
        self._made, self._moving = columns, moving

    @lazy
    def _columns(self) -> Columns:
        return self._made()

    @lazy
    def _certified(self) -> Columns:
        """The columns with the continua that are seen on the arm only."""
        columns = self._columns
        if self._moving is not None:
            self._moving()
        return columns

    @lazy
    def valid(self) -> NDArray[np.bool_]:
        """(*batch, k) which rows are solutions, each of them once."""
        return self._columns.valid.reshape(self.q.shape[:-1])

    @lazy
    def within(self) -> NDArray[np.bool_]:
        """(*batch, k) which of them are within the joint limits."""
        return self._columns.within.reshape(self.q.shape[:-1])

    @lazy
    def residual(self) -> Floats:
        """(*batch, k) error of forward kinematics, distance [m] or angle [rad], the larger."""
        return self._columns.residual.reshape(self.q.shape[:-1])

    @lazy
    def codes(self) -> NDArray[np.int16]:
        """(*batch, k) roots of the closed form, see `mafsil.mechanics.closed_form.table`."""
        return self._columns.codes.reshape(self.q.shape[:-1])

    @lazy
    def free(self) -> NDArray[np.int32]:
        """(*batch, k) sum of 2^i over the coordinates i that may be chosen: the solution may move."""
        free = self.setting.part.lifted_bits(self._certified.free)
        return np.asarray(free, dtype=np.int32).reshape(self.q.shape[:-1])

    @lazy
    def status_codes(self) -> NDArray[np.int8]:
        """(*batch,) index into `IKStatus`'s members, in order."""
        return self._certified.status.reshape(self.q.shape[:-2])

    def __len__(self) -> int:
        return len(self.q)

    def __bool__(self) -> bool:
        return bool(self.solved.all())

    def __iter__(self) -> Iterator[SolutionSet]:
        if self.q.ndim > 3:
            raise InputError("ik.many_dimensions", shape=self.status_codes.shape)
        return (self[i] for i in range(len(self.q)))

    def __repr__(self) -> str:
        return self.printed()

    def printed(self, *, degrees: bool = False) -> str:
        """The counts and a row for each pose, which are the same in both units.

        Args:
            degrees: angles in degrees.
        """
        solved = say("ik.batch", solved=int(self.solved.sum()), count=self.solved.size)
        return on_screen("\n".join([solved, *self._table()]))

    def _table(self) -> list[str]:
        return pose_table(self.valid, self.within, self.residual, self.status_codes)

    @property
    def count(self) -> NDArray[np.int64]:
        """(*batch,) number of solutions."""
        return self.valid.sum(axis=-1)

    @lazy
    def in_doubt(self) -> NDArray[np.bool_]:
        """(*batch,) whether a description of six digits leaves the count open; see `SolutionSet.in_doubt`."""
        setting, shape = self.setting, self.valid.shape
        if structure_decides(setting):
            return np.ones(shape[:-1], dtype=np.bool_)
        found, rows = self.valid.reshape(-1, shape[-1]), self.q.reshape(-1, *self.q.shape[-2:])
        doubt = nearly_there(setting, self.T.reshape(-1, 4, 4), setting.part.own(self.others))
        pose_of, row = np.nonzero(found)
        doubt[pose_of[folding(setting, setting.part.own(rows[pose_of, row]))]] = True
        return doubt.reshape(shape[:-1])

    @property
    def solved(self) -> NDArray[np.bool_]:
        """(*batch,) which poses have a solution within the limits."""
        return np.asarray(self.within.any(axis=-1), dtype=np.bool_)

    @property
    def labels(self) -> NDArray[np.str_]:
        """(*batch, k) branches as words, such as `right/up/noflip`; empty where there is no solution."""
        names, words = self.setting.branch_names, np.full(self.valid.shape, "", dtype="<U32")
        if names is None:
            words[self.valid] = str(Branch())
            return words
        keys = np.full(self.valid.shape, -1, dtype=np.int64)
        numbers = names.numbers(self.setting.part.own(self.q[self.valid]))
        keys[self.valid] = numbers * ROWS + np.nonzero(self.valid)[-1]
        for key in np.unique(keys[keys >= 0]):
            words[keys == key] = str(names.branch(*divmod(int(key), ROWS)))
        return words

    def branch(self, *index: int) -> Branch:
        """The branch of one row: indices of the pose, then of the row."""
        names = self.setting.branch_names
        if names is None:
            return Branch()
        return names.branch(int(names.numbers(self.setting.part.own(self.q[index]))), index[-1])

    @property
    def status(self) -> NDArray[np.object_]:
        """(*batch,) what can be said about each pose, members of `IKStatus`."""
        return _MEMBERS[self.status_codes]

    def explain(  # pyright: ignore[reportIncompatibleMethodOverride]
        self, *index: int, language: str | None = None, degrees: bool = False
    ) -> str:
        """The answer to one pose in sentences; without an index how many poses have which status.

        Args:
            index: of the pose.
            language: `en` or `ar`; the current one if None.
            degrees: angles in degrees.

        Raises:
            InputError: the row is not a pose.
        """
        if index:
            return self[index].explain(language, degrees=degrees)
        lines = [say("ik.batch", language=language, solved=int(self.solved.sum()), count=self.solved.size)]
        for code in np.unique(self.status_codes):
            count = int((self.status_codes == code).sum())
            first = ", ".join(str(int(i[0])) for i in np.nonzero(self.status_codes == code))
            status = STATUSES[int(code)].sentence(language)
            lines.append(say("ik.batch_status", language=language, status=status, count=count, first=first))
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Plain data; arrays are those of the answer."""
        return Answer.to_dict(self) | {"branches": self.labels}

    def __getitem__(self, index: int | tuple[int, ...]) -> SolutionSet:
        """The careful answer to one pose, with families and reasons.

        Raises:
            InputError: the row is not a pose.
        """
        T = finite_poses(self.T[index].reshape(1, 4, 4))[0]
        if not clean_poses(T[None])[1][0]:
            T = printed_pose(f"T_sd[{index}]", self.T[index].reshape(4, 4))
        return one_pose(self.setting, T, self.setting.part.own(self.others), self.tolerance, self.others)

    def nearest(self, q: ArrayLike) -> JointVector:
        """(*batch, n) for every pose the solution nearest to a configuration, within the limits if any is; NaN if none.

        Args:
            q: (n,) or (*batch, n).
        """
        setting, part, rows = self.setting, self.setting.part, self.q.shape[-2]
        given = as_batch("q", q, self.q.shape[-1:], finite=True)
        own = part.own(self.q)
        start = np.broadcast_to(part.own(given), (*own.shape[:-2], own.shape[-1]))
        nearest = winding_loops.nearest_rows(
            own.reshape(-1, rows, own.shape[-1]),
            self.valid.reshape(-1, rows),
            np.ascontiguousarray(start).reshape(-1, own.shape[-1]),
            setting.lower,
            setting.upper,
            setting.revolute,
        )
        return part.lift(nearest.reshape(start.shape), given)


def finite_poses(T: PoseMatrix) -> PoseMatrix:
    """Poses (k, 4, 4) with zeros, which are no poses either, for NaN, infinities and numbers that would overflow."""
    finite = np.asarray((np.abs(T) < FARTHEST).all(axis=(1, 2)), dtype=np.bool_)
    return T if finite.all() else np.where(finite[:, None, None], T, 0.0)
