"""A hint when joint angles look like degrees: FK of degrees is a right answer to a question that nobody asked."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from typing import Any, cast

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputWarning, warn
from mafsil.model import Mechanism

TURN = 2.0 * pi
_ROWS = (list, tuple)
_NESTED = (list, tuple, np.ndarray)
LARGE = 9.0
"""Angles up to here [rad] are not examined: a joint of one turn either way may stand there, wound once."""

TYPED = 1e6
"""What is larger [rad] nobody typed, in degrees either: a motion that blew up, whose numbers are all whole."""


class DegreesHint:
    """Looks at the coordinates of single calls that come as lists or otherwise not as arrays, and warns once.

    Args:
        mechanism: of the robot.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self._revolute = mechanism.angular.tolist()
        self._lower = (mechanism.limits.lower - TURN).tolist()
        self._upper = (mechanism.limits.upper + TURN).tolist()
        self._names = mechanism.joint_names
        self._given = False

    def __call__(self, q: Any, name: str = "q") -> None:
        """Warn if an angle lies more than a turn beyond its limits, or all angles are whole numbers and one is large.

        Args:
            q: coordinates of one configuration, already accepted; batches are left alone.
            name: the argument's name, for the sentence.

        Warns:
            InputWarning: they look like degrees.
        """
        # A batch as a list takes longer than its answer, and numbers in an array were computed.
        if self._given or (isinstance(q, np.ndarray) and (q.ndim != 1 or cast("Floats", q).dtype == np.float64)):
            return
        values: Any = q.tolist() if isinstance(q, np.ndarray) else q
        if not isinstance(values, _ROWS):
            return
        row = cast("Sequence[float]", values)
        if len(row) != len(self._names):
            return
        if not row or isinstance(row[0], _NESTED) or not LARGE <= max(map(abs, row)) <= TYPED:
            return
        k = self._suspicious(row)
        if k is not None:
            self._given = True
            angle = float(row[k])
            warn(InputWarning("robot.degrees", name=name, joint=self._names[k], value=angle, turns=abs(angle) / TURN))

    def _suspicious(self, values: Sequence[float]) -> int | None:
        """Index of the angle that gives it away."""
        angles = [k for k, revolute in enumerate(self._revolute) if revolute]
        whole = all(float(values[k]).is_integer() for k in angles)
        for k in sorted(angles, key=lambda k: -abs(values[k])):
            beyond = not self._lower[k] <= values[k] <= self._upper[k]
            if abs(values[k]) >= LARGE and (beyond or whole):
                return k
        return None


def remark_on_degrees(robot: Any, name: str, q: object) -> None:
    """Warn once for a robot if one configuration, as the user gave it, looks like degrees.

    Args:
        robot: a Robot, or its open tree.
        name: the argument's name, for the sentence.
        q: (n,) numbers as given: what comes as an array of floats was computed, and is left alone.

    Warns:
        InputWarning: it does.
    """
    robot._degrees_hint(q, name)
