"""Scalar arguments over 600 decades: every call either refuses in our words or gives numbers that hold.

`python -m tests.reliability.decades [WORD] [--some]` prints what is wrong with the calls that contain the word.
"""

from __future__ import annotations

import ast
import dataclasses
import inspect
import json
import math
import re
import resource
import signal
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from time import perf_counter
from types import CodeType, ModuleType
from typing import Any

import numpy as np

import mafsil as mf
from mafsil.errors import KernelError, MafsilError, MafsilWarning
from tests.public import public
from tests.reliability.decade_calls import ABSENT, CALLS, LONG, SLOW, space

TENS = (-300, -200, -100, -50, -30, -19, -15, -12, -9, -6, -3, 0, 3, 6, 9, 12, 15, 19, 30, 50, 100, 200, 300)
NEGATIVE = (-1.0, -1e-300, -1e-9, -1e9, -1e300)
VALUES = (0.0, math.nan, math.inf, -math.inf, 5e-324, *NEGATIVE, *(float(f"1e{k}") for k in TENS))
FEW = (0.0, math.nan, math.inf, -1.0, 5e-324, 1e-300, 1e-19, 1e19, 1e300)
SOME = (*VALUES[:7], *VALUES[7::3], 1e300)
"""Every third size: what the tests drive."""
LONGEST = 2.0
"""Seconds that one call may take."""
COMPILED = 20.0
"""Seconds for a call that may have to be compiled first."""
LATE = "no answer in time"
MEMORY = 6 * 2**30
"""Bytes of address space: what asks for more fails."""
UNBOUNDED = ("lower", "upper", "limits", "velocity", "acceleration", "jerk", "effort", "finger_curvature", "clamp")
"""Fields that are documented to be infinite where there is no bound."""
DEPTH = 4


@dataclass(frozen=True)
class Place:
    """One literal of a call.

    Attributes:
        call: the text.
        argument: path of the literal, such as `limits.velocity` or `durations[1]`.
        code: the call with the literal replaced by the name `_driven`.
    """

    call: str
    argument: str
    code: CodeType

    @property
    def function(self) -> str:
        """What is called."""
        return self.call.partition("(")[0]

    @property
    def name(self) -> str:
        """The function and the argument."""
        return f"{self.function}({self.argument})"


def places(call: str) -> Iterator[Place]:
    """Every decimal literal of a call.

    Args:
        call: its text.
    """
    count = sum(1 for _ in _literals(ast.parse(call, mode="eval").body, ""))
    for k in range(count):
        tree = ast.parse(call, mode="eval")
        node, path, put = list(_literals(tree.body, ""))[k]
        put(ast.copy_location(ast.Name("_driven", ast.Load()), node))
        yield Place(call, path, compile(ast.fix_missing_locations(tree), call, "eval"))


def _literals(node: ast.AST, path: str) -> Iterator[tuple[ast.expr, str, Callable[[Any], None]]]:
    """Decimal literals below a node, where they stand, and what puts another node there."""
    if isinstance(node, ast.Lambda):
        return
    for name, value in ast.iter_fields(node):
        for index, each in enumerate(value) if isinstance(value, list) else ((None, value),):
            if not isinstance(each, ast.AST):
                continue
            here = path
            if isinstance(node, ast.keyword):
                here = f"{path}.{node.arg}" if path else str(node.arg)
            elif name in ("elts", "values", "args"):
                here = f"{path}[{index}]"

            def put(new: Any, value: Any = value, name: str = name, index: int | None = index) -> None:
                if index is None:
                    setattr(node, name, new)
                else:
                    value[index] = new

            inner = each.operand if isinstance(each, ast.UnaryOp) else each
            if isinstance(inner, ast.Constant) and type(inner.value) is float:
                yield each, here, put  # type: ignore[misc]
            else:
                yield from _literals(each, here)


class TooLong(BaseException):
    """A call that does not come back."""


def drive(place: Place, value: float, names: dict[str, Any], seconds: float = LONGEST) -> str:
    """What is wrong with the call at that value; empty if nothing is.

    Args:
        place: the literal.
        value: put there.
        names: what the call uses.
        seconds: that the call may take.
    """
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        signal.setitimer(signal.ITIMER_REAL, seconds)
        try:
            answer = eval(place.code, names, {"_driven": value})
            wrong = judge(answer, ABSENT.get(place.function, ()))
        except KernelError as error:
            return f"KernelError: {error}"
        except MafsilError as error:
            return "" if error.message("ar") != error.message("en") else "refused in one language"
        except TooLong:
            return LATE
        except Exception as error:
            where = traceback.extract_tb(error.__traceback__)[-1]
            return f"{type(error).__name__}: {str(error)[:90]} at {where.filename}:{where.lineno}"
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
    foreign = [each for each in said if not issubclass(each.category, MafsilWarning)]
    if foreign:
        return f"{foreign[0].category.__name__}: {foreign[0].message} at {foreign[0].filename}:{foreign[0].lineno}"
    return "NaN accepted" if value != value else wrong


def judge(answer: Any, absent: tuple[str, ...] = ()) -> str:
    """What is wrong with the numbers of an answer that says yes; empty if nothing is.

    Args:
        answer: of any function.
        absent: names of fields in which NaN and infinity have a meaning.
    """
    if not isinstance(answer, np.ndarray | float) and not _yes(answer):
        return ""
    for path, number in numbers(answer, "", DEPTH):
        name = path.rpartition(".")[2].partition("[")[0]
        if name in absent:
            continue
        array = np.asarray(number, dtype=complex if np.iscomplexobj(number) else float)
        if np.isnan(array).any():
            return f"{path or 'answer'} is NaN"
        if np.isinf(array).any() and name not in UNBOUNDED:
            return f"{path or 'answer'} is infinite"
        if "duration" in name and (array < 0).any():
            return f"{path} is negative"
    return ""


def _yes(answer: Any) -> bool:
    try:
        return bool(answer)
    except ValueError:
        return True


def numbers(value: Any, path: str, depth: int) -> Iterator[tuple[str, Any]]:
    """The real and complex numbers and arrays in the public fields of a value."""
    if isinstance(value, float | complex | np.floating):
        yield path, value
    elif isinstance(value, np.ndarray):
        if value.dtype.kind in "fc":
            yield path, value
    elif depth and isinstance(value, dict):
        for key, each in value.items():
            yield from numbers(each, f"{path}.{key}", depth - 1)
    elif depth and isinstance(value, tuple | list):
        fields = getattr(value, "_fields", None)
        for k, each in enumerate(value):
            yield from numbers(each, f"{path}.{fields[k]}" if fields else f"{path}[{k}]", depth - 1)
    elif depth and not isinstance(value, type | ModuleType | mf.Robot):
        if dataclasses.is_dataclass(value):
            for field in dataclasses.fields(value):
                if not field.name.startswith("_"):
                    yield from numbers(getattr(value, field.name, None), f"{path}.{field.name}", depth - 1)
        for name in ("duration", "value"):
            if type(value).__module__.startswith("mafsil") and hasattr(value, name):
                yield from numbers(getattr(value, name), f"{path}.{name}", depth - 1)
        if hasattr(value, "at") and hasattr(value, "duration"):
            sampled = value.at(np.linspace(0.0, value.duration, 5))
            yield f"{path}.at", np.asarray(getattr(sampled, "u", sampled))


def _stop(*_: Any) -> None:
    raise TooLong


def work(calls: tuple[str, ...] = CALLS, values: tuple[float, ...] = VALUES) -> dict[str, Any]:
    """Drive all literals of the calls.

    Returns:
        `wrong`, from the name of an argument to its values and what is wrong there; `arguments` and `calls`, counts;
        `seconds` of each call's text.
    """
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))
    signal.signal(signal.SIGALRM, _stop)
    found: dict[str, Any] = {"wrong": {}, "arguments": 0, "calls": 0, "seconds": {}}
    with tempfile.TemporaryDirectory() as folder:
        names = dict(space(folder))
        for call in calls:
            begun = perf_counter()
            try:
                wrong = judge(eval(call, names), ABSENT.get(call.partition("(")[0], ()))
            except Exception as error:
                wrong = f"{type(error).__name__}: {error}"
            if wrong:
                found["wrong"][call] = {"as it stands": wrong}
                continue
            for place in places(call):
                found["arguments"] += 1
                low, high = LONG.get(place.name, (math.inf, math.inf))
                for value in FEW if place.function in SLOW else values:
                    if low <= abs(value) <= high:
                        continue
                    found["calls"] += 1
                    wrong = drive(place, value, names)
                    if wrong == LATE and drive(place, value, names, COMPILED) != LATE:  # it was compiled
                        wrong = drive(place, value, names)
                    if wrong:
                        found["wrong"].setdefault(place.name, {})[repr(value)] = wrong
            found["seconds"][call] = perf_counter() - begun
    return found


def undriven() -> list[str]:
    """Arguments of public functions whose annotation says float and that no call drives."""
    names = {"mf": mf, **space("")}
    driven = set[tuple[Any, str]]()
    for place in (place for call in CALLS for place in places(call)):
        driven.add((eval(place.function, names), re.split(r"[.\[]", place.argument)[0]))
    listed = ((function, f"{name}.{each}", each) for function, name in functions() for each in _real(function))
    return sorted(name for function, name, each in listed if (function, each) not in driven)


UNDRIVEN_ROOMS = ("figures", "solvers", "verbs")
"""Pictures; numerical mathematics below the robots; methods of `Robot` that pass on to functions that are driven."""


def functions() -> list[tuple[Callable[..., Any], str]]:
    """Every public function with a real argument, once, with its shortest name."""
    rooms = tuple(f"mafsil.{room}." for room in UNDRIVEN_ROOMS)
    every = ((name, each) for name, each in public() if callable(each) and not inspect.isclass(each))
    return [(each, name) for name, each in every if not name.startswith(rooms) and _real(each)]


def _real(function: Callable[..., Any]) -> list[str]:
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return []
    return [each.name for each in parameters if re.search(r"\bfloat\b", str(each.annotation))]


if __name__ == "__main__":
    words = [word for word in sys.argv[1:] if word != "--some"]
    chosen = tuple(call for call in CALLS if re.search("".join(words), call))
    print(json.dumps(work(chosen, SOME if "--some" in sys.argv else VALUES), indent=1))
