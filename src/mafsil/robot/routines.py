"""The quantities of the catalogue as attributes of a robot: `robot.mass_matrix(q)`.

Type checkers read `routines.pyi` instead, which `docs/make_robot_stub.py` writes from the same rows. A robot without
moving joints has constants, for which there is nothing to compile (`Motionless`).
"""

from __future__ import annotations

from inspect import Parameter, Signature
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, as_batch
from mafsil.errors import InputError
from mafsil.kernels.lazy import lazy
from mafsil.mechanics.catalogue import CATALOGUE, quantity
from mafsil.mechanics.quantity import Quantity
from mafsil.model import Mechanism


class Routine(lazy[Any]):
    """A quantity as an attribute: of a robot its compiled routine, made at the first use; of the class, its words.

    Args:
        row: of the catalogue.
    """

    def __init__(self, row: Quantity) -> None:
        def compute(robot: Any) -> Any:
            return robot.routine(row.name)

        compute.__name__, compute.__doc__ = row.name, row.doc()
        super().__init__(compute)
        self.row = row
        self.__name__ = row.name

    def __call__(self, robot: Any, *arrays: Any, **named: Any) -> Any:
        """`Robot.mass_matrix(robot, q)`, as of any method."""
        return getattr(robot, self.row.name)(*arrays, **named)

    @property
    def __signature__(self) -> Signature:
        own = Parameter("self", Parameter.POSITIONAL_ONLY)
        return Signature([own, *signature_of(self.row).parameters.values()])


class Routines:
    """One attribute for each quantity of the catalogue."""


for _row in CATALOGUE.values():
    setattr(Routines, _row.name, Routine(_row))


def signature_of(row: Quantity) -> Signature:
    """What `inspect.signature` says of a robot's routine: `row.parameters` as an object."""
    named = (*(("frame",) if row.framed else ()), "out", "threads")
    return Signature(
        [
            *(Parameter(name, Parameter.POSITIONAL_OR_KEYWORD) for name in row.inputs),
            *(Parameter(name, Parameter.POSITIONAL_OR_KEYWORD, default=None) for name in row.optional),
            *(Parameter(name, Parameter.KEYWORD_ONLY, default=None) for name in named),
            Parameter("degrees", Parameter.KEYWORD_ONLY, default=False),
        ]
    )


class Motionless:
    """A routine of configurations (*batch, 0) that gives the same poses for each.

    Args:
        mechanism: whose routine; it has no moving joint.
        name: of the routine.
    """

    def __init__(self, mechanism: Mechanism, name: str) -> None:
        self._mechanism, self._name = mechanism, name
        self._poses = _link_poses(mechanism)
        row = quantity(name)
        self.__name__, self.__doc__, self.__signature__ = name, row.doc(), signature_of(row)

    def __call__(
        self,
        q: ArrayLike,
        *,
        frame: str | None = None,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
    ) -> Floats:
        """(*batch, 4, 4) pose of the tip frame or of the link `frame`, or (*batch, L, 4, 4) of all links, in {s}.

        Args:
            q: (*batch, 0).
            frame: link name, for forward kinematics.
            out: array of the result's shape to write into.
            threads, degrees: of no effect; there is nothing to compute, and no angle.

        Raises:
            InputError: a wrong shape, or a frame for what has none.
            ModelError: no such link.
        """
        batch = as_batch("q", q, (0,)).shape[:-1]
        value = self._value(frame)
        result = np.empty(batch + value.shape) if out is None else out
        if result.shape != batch + value.shape:
            raise InputError("input.shape", name="out", expected=batch + value.shape, got=result.shape, hint="")
        result[...] = value
        return result

    def _value(self, frame: str | None) -> Floats:
        mechanism = self._mechanism
        if self._name == "link_poses":
            if frame is not None:
                raise InputError("robot.no_frame", name=self._name)
            return self._poses
        if frame is None:
            return self._poses[mechanism.link_names.index(mechanism.tip)] @ mechanism.T_lt
        return self._poses[mechanism.link_names.index(mechanism.link(frame).name)]

    def __reduce__(self) -> tuple[type[Motionless], tuple[Mechanism, str]]:
        return Motionless, (self._mechanism, self._name)


def _link_poses(mechanism: Mechanism) -> PoseMatrix:
    """(L, 4, 4) poses of the links, each in the order of the joints that lead to it."""
    poses = [np.eye(4)]
    for joint, parent in zip(mechanism.joints, mechanism.parents, strict=True):
        poses.append(poses[parent] @ joint.T_pj)
    return np.stack(poses)
