"""Poses of a robot without moving joints: constants, for which there is nothing to compile."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, as_batch
from mafsil.errors import InputError
from mafsil.mechanics.catalogue import quantity
from mafsil.model import Mechanism
from mafsil.robot.routines import signature_of


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
