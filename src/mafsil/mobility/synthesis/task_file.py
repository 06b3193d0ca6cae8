"""Tasks of synthesis in files: poses, points or a function, as TOML.

degrees = true                       # angles in degrees; radians otherwise

poses = [[0, 0, 0], [1, 0.6, 17], [2.1, 0.8, 46]]     # motion: (x, y, phi)
fixed = [[0, -1], [2, -1]]           # three poses: pivots to choose from, or `moving`
samples = 100

points = [[0, 0], [1, 0.5], [2, 0.6]]                 # path
timing = [0, 40, 80]                 # angles of the crank; left out: any
form = "watt"                        # or "stephenson": a six-bar, of five points with timing

orientations = [[0, 0, 0], [10, 0, 5], [20, 5, 9]]    # motion about a point: rotation vectors

[function]                           # function: three to five precision points by Chebyshev
formula = "log10(x)"
interval = [1, 2]
inputs = [30, 90]
outputs = [240, 330]
count = 4
ground = 1.0
arc = 70                             # between the axes of a spherical four-bar, instead of `ground`
form = "watt"                        # or "stephenson": a six-bar, of five precision points

[limits]                             # of each kind
pivots = [[-1, -1], [2, 1]]          # corners of the region of fixed pivots
transmission = 40                    # least transmission angle
longest = 3.0                        # link
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np

from mafsil.arrays import Floats, as_batch, whole
from mafsil.errors import FileError
from mafsil.geometry import rotation
from mafsil.mobility.synthesis.answers import Synthesis
from mafsil.mobility.synthesis.assessment import LinkageLimits
from mafsil.mobility.synthesis.crank_chain import ChainSynthesis
from mafsil.mobility.synthesis.function_task import FunctionTask, chebyshev_spacing
from mafsil.mobility.synthesis.motion import synthesise_motion
from mafsil.mobility.synthesis.path import synthesise_path
from mafsil.mobility.synthesis.six_bar import Form
from mafsil.mobility.synthesis.six_bar_synthesis import synthesise_six_bar_function, synthesise_six_bar_path
from mafsil.mobility.synthesis.spherical import synthesise_spherical_function, synthesise_spherical_motion
from mafsil.toml_source import read_toml

AIMS = {
    "poses": {"poses", "fixed", "moving", "samples", "degrees", "limits"},
    "points": {"points", "timing", "form", "samples", "degrees", "limits"},
    "orientations": {"orientations", "samples", "degrees", "limits"},
    "function": {"function", "degrees", "limits"},
}
FUNCTION_KEYS = {"formula", "interval", "inputs", "outputs", "count", "ground", "arc", "form"}
FUNCTIONS: dict[str, Callable[[Any], Any]] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "exp": np.exp, "log": np.log, "log10": np.log10, "sqrt": np.sqrt,
    "abs": np.abs, "atan": np.arctan,
}  # fmt: skip
OPERATORS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: np.add, ast.Sub: np.subtract, ast.Mult: np.multiply, ast.Div: np.divide, ast.Pow: np.power,
    ast.USub: np.negative, ast.UAdd: np.positive,
}  # fmt: skip
OTHER_KEYS = ("samples", "degrees", "function", "limits", "form")
FORMS = ("watt", "stephenson")
LIMIT_KEYS = {"pivots", "transmission", "longest"}
LONGEST_FORMULA = 200


def synthesise_file(path: str | Path) -> tuple[Synthesis | ChainSynthesis, FunctionTask | None]:
    """The synthesis that a file asks for, and its function if it asks for one.

    Raises:
        FileError: missing, unreadable, no TOML, unknown or missing keys, values of another kind.
        InputError: poses, points or angles that cannot be a task.
    """
    data = read_toml(path)
    source = Path(path).name
    given = [key for key in AIMS if key in data]
    if len(given) != 1:
        raise FileError("synthesis.file_kind", path=source, got=", ".join(given) or "-")
    _known(data, AIMS[given[0]], source)
    if not isinstance(data.get("degrees", False), bool):
        raise FileError("synthesis.file_value", path=source, name="degrees", expected="true | false")
    unit = np.pi / 180 if data.get("degrees", False) else 1.0
    lists = {key: _numbers(data[key], key, source) for key in data if key not in OTHER_KEYS}
    sampled: dict[str, Any] = {"samples": data["samples"]} if "samples" in data else {}
    limits = _limits(data.get("limits", {}), unit, source)
    if given[0] == "poses":
        poses = lists.pop("poses")
        scale = np.array([1.0, 1.0, unit]) if poses.shape[-1:] == (3,) else 1.0
        return synthesise_motion(poses * scale, **lists, **sampled, limits=limits), None
    if given[0] == "points":
        timing = lists["timing"] * unit if "timing" in lists else None
        if "form" in data:
            form = _form(data["form"], source)
            angles = np.zeros(0) if timing is None else timing
            return synthesise_six_bar_path(lists["points"], angles, form=form, **sampled, limits=limits), None
        return synthesise_path(lists["points"], timing, **sampled, limits=limits), None
    if given[0] == "orientations":
        turns = rotation.exp(as_batch("orientations", lists["orientations"] * unit, (3,)))
        return synthesise_spherical_motion(turns, **sampled, limits=limits), None
    return _function(data["function"], unit, source, limits)


def _function(
    entry: object, unit: float, source: str, limits: LinkageLimits
) -> tuple[Synthesis | ChainSynthesis, FunctionTask]:
    """The synthesis of a table [function].

    Args:
        entry: the table.
        unit: radians of one unit of angle.
        source: name of the file, for errors.
        limits: what the linkages must keep to.
    """
    table = _table_of(entry, "function", FUNCTION_KEYS, source)
    pairs = {name: _pair(table.get(name), name, source) for name in ("interval", "inputs", "outputs")}
    formula = table.get("formula")
    if not isinstance(formula, str):
        raise FileError("synthesis.file_value", path=source, name="formula", expected='"log10(x)"')
    inputs, outputs = ((unit * pairs[name][0], unit * pairs[name][1]) for name in ("inputs", "outputs"))
    task = FunctionTask(function_of(formula, source), pairs["interval"], inputs, outputs)
    if "arc" in table or "form" in table:
        count = table.get("count", 3 if "arc" in table else 5)
        x = chebyshev_spacing(*task.interval, whole("count", count, 3, 5))
        pairs_of_angles = task.crank_angles(x), task.rocker_angles(task.values(x))
        if "form" in table:
            form = _form(table["form"], source)
            return synthesise_six_bar_function(*pairs_of_angles, form=form, limits=limits), task
        arc = _number(table["arc"], "arc", source) * unit
        return synthesise_spherical_function(*pairs_of_angles, ground=arc, limits=limits), task
    return task.synthesise(table.get("count", 3), ground=table.get("ground", 1.0), limits=limits), task


def _limits(entry: object, unit: float, source: str) -> LinkageLimits:
    """The limits of a table [limits].

    Args:
        entry: the table.
        unit: radians of one unit of angle.
        source: name of the file, for errors.
    """
    table = _table_of(entry, "limits", LIMIT_KEYS, source)
    box = _numbers(table["pivots"], "pivots", source) if "pivots" in table else None
    angle, longest = (
        _number(table[name], name, source) if name in table else None for name in ("transmission", "longest")
    )
    return LinkageLimits(box, None if angle is None else angle * unit, longest)


def _table_of(entry: object, name: str, keys: set[str], source: str) -> dict[str, Any]:
    """A table of the file with known keys."""
    if not isinstance(entry, dict):
        raise FileError("synthesis.file_value", path=source, name=name, expected=f"[{name}]")
    table = cast("dict[str, Any]", entry)
    _known(table, keys, source)
    return table


def _form(value: object, source: str) -> Form:
    """Watt's or Stephenson's."""
    if value in FORMS:
        return value
    raise FileError("synthesis.file_value", path=source, name="form", expected='"watt" | "stephenson"')


def _number(value: object, name: str, source: str) -> float:
    """One number."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FileError("synthesis.file_value", path=source, name=name, expected="1.0")
    return float(value)


def function_of(formula: str, source: str) -> Callable[[Floats], Floats]:
    """The function of a formula in x.

    Args:
        formula: numbers, x, pi, + - * / **, brackets, and the names of FUNCTIONS.
        source: name of the file, for errors.

    Raises:
        FileError: it is something else.
    """
    error = FileError("synthesis.file_function", path=source, text=formula[:60], known=", ".join(FUNCTIONS))
    if len(formula) > LONGEST_FORMULA:
        raise error
    try:
        tree = ast.parse(formula.strip(), mode="eval").body
        _value(tree, np.ones(1))
    except (SyntaxError, ValueError, KeyError, TypeError, RecursionError, MemoryError, OverflowError):
        raise error from None

    def function(x: Floats) -> Floats:
        with np.errstate(all="ignore"):
            return np.asarray(_value(tree, x) + 0.0 * x, dtype=np.float64)

    return function


def _value(node: ast.AST, x: Floats) -> Any:
    """The value of a formula; KeyError or TypeError for what is not allowed in one."""
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            return np.float64(value)
        case ast.Name(id="x"):
            return x
        case ast.Name(id="pi"):
            return np.float64(np.pi)
        case ast.BinOp(left=left, op=op, right=right):
            with np.errstate(all="ignore"):
                return OPERATORS[type(op)](_value(left, x), _value(right, x))
        case ast.UnaryOp(op=op, operand=operand):
            return OPERATORS[type(op)](_value(operand, x))
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]):
            with np.errstate(all="ignore"):
                return FUNCTIONS[name](_value(argument, x))
        case _:
            raise TypeError


def _known(table: dict[str, Any], keys: set[str], source: str) -> None:
    for key in table:
        if key not in keys:
            raise FileError("synthesis.file_key", path=source, name=key, known=", ".join(sorted(keys)))


def _numbers(value: object, name: str, source: str) -> Floats:
    """An array of a list of numbers, or of lists of as many numbers each.

    Args:
        value: as read from TOML.
        name: of the key, for errors.
        source: name of the file, for errors.
    """
    try:
        array = np.asarray(value)
    except ValueError:
        array = np.asarray(None)
    if array.dtype.kind not in "fiu" or not array.ndim:
        raise FileError("synthesis.file_value", path=source, name=name, expected="[[1.0, 2.0], ...]")
    return array.astype(np.float64)


def _pair(value: object, name: str, source: str) -> tuple[float, float]:
    """Two numbers.

    Args:
        value: as read from TOML.
        name: of the key, for errors.
        source: name of the file, for errors.
    """
    pair = _numbers(value, name, source)
    if pair.shape != (2,):
        raise FileError("synthesis.file_value", path=source, name=name, expected="[1.0, 2.0]")
    return float(pair[0]), float(pair[1])
