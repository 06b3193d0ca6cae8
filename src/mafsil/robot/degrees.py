"""Arguments at the door of a robot: by position or by name, in radians or, with `degrees=True`, in degrees.

With `degrees=True`, joint coordinates, rates and accelerations are given in deg, deg/s and deg/s^2 (lengths stay), and
so is what comes out as such; everything else stays SI: Jacobians and derivatives are per radian, plans and recordings,
from which other functions compute, hold radians. Angles that look like degrees without it are hinted at.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial, wraps
from inspect import signature
from math import pi
from typing import Any, ParamSpec, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch
from mafsil.errors import InputError, InputWarning, warn
from mafsil.mechanics.quantity import Quantity
from mafsil.model import Mechanism
from mafsil.model.loading import RobotLike, as_mechanism

OPTIONS = ("out", "threads", "degrees")
"""What every routine takes by name."""
TIP_LETTERS = ("b", "t", "tip")
"""Letters that a wrench in the tip frame may carry, besides the name of the tip link."""
P = ParamSpec("P")
Result = TypeVar("Result")
MOTION = ("q", "qd", "qdd")
"""Inputs of quantities that are joint coordinates or their time derivatives."""
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


def takes_degrees(*names: str) -> Callable[[Callable[P, Result]], Callable[P, Result]]:
    """A function of a robot that is given radians, also where `degrees=True` says that the caller gave degrees.

    The robot is its first argument; `degrees` is among the others, for its readers and for what it gives back.

    Args:
        names: of its arguments that hold joint coordinates or their time derivatives, or None.
    """

    def door(function: Callable[P, Result]) -> Callable[P, Result]:
        @wraps(function)
        def call(*args: P.args, **named: P.kwargs) -> Result:
            if not named.get("degrees", False):
                return function(*args, **named)
            bound = signature(function).bind(*args, **named)
            robot = cast("RobotLike", next(iter(bound.arguments.values())))
            mechanism = as_mechanism(robot, keeps_loops=True)
            for name in names:
                value: Any = bound.arguments.get(name)
                if value is not None:
                    bound.arguments[name] = in_radians(mechanism, name, value)
            return function(*bound.args, **bound.kwargs)

        return call

    return door


def in_radians(mechanism: Mechanism, name: str, value: ArrayLike) -> Floats:
    """(*batch, n) joint coordinates, or their time derivatives, given with angles in degrees; lengths stay.

    Args:
        mechanism: of the robot.
        name: of the argument, for the error.
        value: (*batch, n) [deg | m].

    Raises:
        InputError: a wrong shape, or no real numbers.
    """
    return as_batch(name, value, (mechanism.n,)) * radians_per_unit(mechanism)


def radians_per_unit(mechanism: Mechanism) -> Floats:
    """(n,) what a coordinate [deg | m] is multiplied by to be [rad | m]."""
    return np.where(mechanism.angular, pi / 180.0, 1.0)


def evaluate_in_degrees(
    mechanism: Mechanism, row: Quantity, routine: Callable[..., Floats], arrays: Sequence[Any], named: dict[str, Any]
) -> Floats:
    """A routine's result where the caller gave `degrees=True`.

    Args:
        mechanism: of the robot.
        row: the quantity.
        routine: which takes radians.
        arrays, named: arguments of the call without `degrees`.
    """
    given = [*zip((*row.inputs, *row.optional), arrays, strict=False)]
    if len(given) < len(arrays):
        raise InputError("robot.too_many", name=row.name, count=len(arrays), inputs=", ".join(row.inputs))
    q = [in_radians(mechanism, name, value) if name in MOTION else value for name, value in given]
    options = {name: in_radians(mechanism, name, x) if name in MOTION else x for name, x in named.items()}
    result = routine(*q, **options)
    return np.divide(result, radians_per_unit(mechanism), out=result) if row.is_joint_motion else result


class DegreesView:
    """An answer of inverse kinematics whose coordinates, sentences and tables have angles in degrees.

    Args:
        answer: with coordinates in radians: under one of the names `JOINTS`, as rows when it is iterated, or in its
            parts.
        robot: whose coordinates they are.
    """

    JOINTS = ("q", "nearest", "q_nearest", "multi_turn_solutions")

    def __init__(self, answer: Any, robot: Any) -> None:
        self._answer, self._robot = answer, robot

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        value = getattr(self._answer, name)
        if name not in self.JOINTS:
            return value
        return self._convert(value) if isinstance(value, np.ndarray) else partial(self._call, name, value)

    def _call(self, name: str, method: Callable[..., Any], *args: Any, **named: Any) -> Any:
        args = (self._robot.radians(args[0]),) if name == "nearest" and args else args
        named = {key: self._robot.radians(x) if key == "q" else x for key, x in named.items()}
        return self._convert(method(*args, **named))

    def _convert(self, value: Any) -> Any:
        return self._robot.degrees(value) if isinstance(value, np.ndarray) else DegreesView(value, self._robot)

    def __getitem__(self, index: Any) -> Any:
        return self._convert(self._answer[index])

    def __iter__(self) -> Any:
        return map(self._convert, self._answer)

    def __len__(self) -> int:
        return len(self._answer)

    def __bool__(self) -> bool:
        return bool(self._answer)

    def __repr__(self) -> str:
        return str(self._answer.printed(degrees=True))

    def explain(self, *args: Any, **named: Any) -> str:
        """The sentences of the answer, angles in degrees; arguments as of its own `explain`."""
        return str(self._answer.explain(*args, **named, degrees=True))

    def violations(self, k: int) -> Any:
        """The joints that a solution needs beyond their limits, angles in degrees."""
        return self._answer.violations(k, degrees=True)

    def to_dict(self) -> dict[str, Any]:
        """Plain data of the answer, coordinates in degrees."""
        return self._answer.to_dict() | {"q": self.q}


def arrange(
    row: Quantity, arrays: tuple[ArrayLike, ...], named: dict[str, ArrayLike], tip: str = "tip"
) -> dict[str, ArrayLike]:
    """Inputs by name in the order of the catalogue, optional ones at the end only if given.

    Args:
        row: the quantity.
        arrays: given by position.
        named: given by name.
        tip: name of the tip link, in whose frame a tip wrench is.

    Raises:
        InputError: too many, unknown, given twice, or missing.
    """
    names = (*row.inputs, *row.optional)
    if len(arrays) > len(names):
        raise InputError("robot.too_many", name=row.name, count=len(arrays), inputs=", ".join(names))
    given: dict[str, Any] = dict(zip(names, arrays, strict=False))
    for name, value in named.items():
        if name not in names or name in given:
            options = ", ".join(["frame", *OPTIONS] if row.framed else OPTIONS)
            details = {"name": name, "inputs": ", ".join(names), "options": options}
            raise InputError("robot.unexpected", routine=row.name, **details)
        given[name] = value
    missing = [name for name in row.inputs if name not in given]
    if missing:
        raise InputError("robot.missing", name=row.name, missing=", ".join(missing), inputs=", ".join(names))
    return {
        name: in_tip(name, given[name], tip) if name == "tip_wrench" else given[name]
        for name in names
        if name in row.inputs or given.get(name) is not None
    }


def twin_form(
    row: Quantity, count: int, named: tuple[str, ...], frame: str | None, optional: tuple[str, ...]
) -> str | int | tuple[str, ...] | None:
    """Under what a builtin for this form of a call is kept (`Evaluator.twins`); None if the form has none of its own.

    Such a form gives all inputs by position and a frame alone; or optional inputs by position, without a gap; or some
    inputs by name, whose tuple then stands for it.

    Args:
        row: the quantity.
        count: number of arguments given by position.
        named: names of those given by name, besides `frame`, in their order.
        frame: link name, or None.
        optional: which optional inputs are there (and not None).
    """
    extra = count - len(row.inputs)
    if frame is not None:
        return None if extra or named or optional else frame
    if extra > 0:
        return count if not named and optional == row.optional[:extra] else None
    return named if set(optional) <= set(named) else None


def in_tip(name: str, value: ArrayLike, tip: str) -> ArrayLike:
    """A wrench at the tip as given, if its type and frame letter (where it has one) say that it is in the tip frame.

    Args:
        name: of the argument, for the error.
        value: numbers, or a `Wrench`.
        tip: name of the tip link.

    Raises:
        InputError: a `Wrench` of another frame, or another typed value; what to do stands in the sentence.
    """
    kind, given = type(value).__name__, value
    if isinstance(value, np.ndarray | list | tuple) or not hasattr(value, "frame"):
        return given
    frame = getattr(value, "frame", None)
    if kind != "Wrench":
        raise InputError("input.kind", name=name, expected="Wrench", got=kind)
    if frame is not None and frame not in (*TIP_LETTERS, tip):
        raise InputError("robot.wrench_frame", name=name, frame=frame, known=", ".join((*TIP_LETTERS, tip)))
    return value
