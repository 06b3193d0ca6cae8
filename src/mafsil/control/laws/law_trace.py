"""Any law as an expression: called with arrays of expressions, it says what it computes and what it remembers.

1. What a law asks of the world is opened: sensors and references of the tip become inputs, as q, qd, the reference of
   the joints and the time are.
2. A session is called once. What this call changes in it is its memory. Where something was not there before, as the
   state of a virtual mass that begins where the tip is, this call is the first one of every run.
3. A fresh session is called with that memory as an input. What it changes is the memory for the next call.

So every law can be traced that is arithmetic of what it measures and remembers, with the quantities of its robot.
"""

from __future__ import annotations

import inspect
import sys
from collections import deque
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from pathlib import Path
from traceback import walk_tb
from typing import Any, TypeAlias, cast

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.control.joints.elastic_laws import ElasticState
from mafsil.control.laws.law import Law
from mafsil.control.laws.task_coordinates import TaskTarget
from mafsil.geometry import pose, rotation
from mafsil.kernels import Port, Signature
from mafsil.kernels.traced_array import Traced
from mafsil.kernels.traced_number import Number, Untraceable
from mafsil.trajectory import Motion

Way: TypeAlias = tuple[str | int, ...]
Parts: TypeAlias = dict[Way, Any]
MOST_ROUNDS = 4
_HOME = "mafsil.control"
ELASTIC = ("motor", "motor_rate")


@dataclass(slots=True)
class _Inputs:
    """What a law asks of the world: inputs by name, in the order in which it asks."""

    arrays: dict[str, Traced] = field(default_factory=dict[str, Traced])
    columns: dict[str, ex.Expression] = field(default_factory=dict[str, ex.Expression])
    shapes: dict[str, tuple[int, ...]] = field(default_factory=dict[str, tuple[int, ...]])
    known: dict[object, Callable[..., Any]] = field(default_factory=dict[object, "Callable[..., Any]"])

    def add(self, name: str, shape: tuple[int, ...]) -> Traced:
        """A new input, numbered if the name is taken."""
        own, k = name, 2
        while own in self.arrays:
            own, k = f"{name}_{k}", k + 1
        self.arrays[own], self.columns[own] = Traced.symbols(own, shape)
        self.shapes[own] = shape
        return self.arrays[own]

    def sensor_input(self, sensor: Callable[..., Any], name: str, size: int) -> Callable[..., Any]:
        """A sensor that reads an input; the same one for the same sensor."""
        key = _same(sensor), name, size
        if key not in self.known:
            reading = self.add(name, (size,))

            def read(_q: Any, _qd: Any) -> Any:
                return reading

            self.known[key] = read
        return self.known[key]

    def target(self, reference: Callable[..., Any]) -> Callable[..., Any]:
        """A reference of the tip from inputs; the same one for the same reference."""
        key = _same(reference)
        if key not in self.known:
            place = self.add("target", (7,))
            R = rotation.from_quaternion(place[3:] / np.linalg.norm(place[3:]))
            T = pose.from_rotation_translation(R, cast("Floats", place[:3]))
            target = TaskTarget(T, *(cast("Any", self.add(name, (6,))) for name in ("target_rate", "target_growth")))

            def wanted(_t: Any) -> TaskTarget:
                return target

            self.known[key] = wanted
        return self.known[key]


def _same(function: Any) -> object:
    """What is equal for the same function: a method of one object is another object each time."""
    return function if isinstance(function, Hashable) else id(function)


@dataclass(frozen=True, slots=True)
class TracedLaw:
    """One call of a law.

    Attributes:
        function: of the inputs that it needs, as columns.
        signature: its ports; with a memory the last input and the last output.
    """

    function: ex.Function
    signature: Signature


def traced_law(law: Law, n: int, period: float, limit: Floats | None, name: str) -> TracedLaw:
    """One call of a law as a function.

    Args:
        law: any; of arms with elastic joints too.
        n: number of coordinates.
        period: between calls [s].
        limit: (n,) at which efforts are clipped [N m | N]; None for no clipping.
        name: of the function.

    Raises:
        Untraceable: it decides by numbers, leaves arithmetic, or has a memory that changes its form.
    """
    inputs = _Inputs()
    q, qd = inputs.add("q", (n,)), inputs.add("qd", (n,))
    elastic = "state" in inspect.signature(type(law).__call__).parameters
    motors = [inputs.add(each, (n,)) for each in ELASTIC] if elastic else []
    reference, t = inputs.add("reference", (3, n)), inputs.add("t", ())
    state: Any = (ElasticState(*cast("Any", (q, qd, *motors))),) if elastic else (q, qd)
    motion = Motion(*cast("Any", (reference[0], reference[1], reference[2])))
    opened = _open(law, inputs)

    def called(session: Any) -> Traced:
        try:
            effort: Any = session(t, *state, motion)
        except (Untraceable, TypeError, ValueError, AttributeError, IndexError) as error:
            reason = error.reason if isinstance(error, Untraceable) else "leaves"
            raise Untraceable(reason, _place(error)) from None
        return np.clip(effort + np.zeros_like(q), *((-limit, limit) if limit is not None else (None, None)))

    effort, memory, following = _with_memory(opened, period, called)
    if memory:
        inputs.columns["memory"] = ex.vertcat(*memory)
        inputs.shapes["memory"] = (len(following.entries),)
    columns = {"effort": effort.column()} | ({"next_memory": following} if memory else {})
    used = {id(x) for x in _symbols(list(columns.values()))}
    kept = [each for each in inputs.columns if each in ("q", "qd", *ELASTIC) or _uses(inputs.columns[each], used)]
    ins = tuple(Port(each, inputs.shapes[each]) for each in kept)
    outs = tuple(Port(each, (len(column.entries),)) for each, column in columns.items())
    function = ex.Function(name, [inputs.columns[each] for each in kept], ex.cse(list(columns.values())))
    return TracedLaw(function, Signature(name, ins, outs))


def traced_parts(law: Any) -> tuple[Any, ...]:
    """The laws inside a law."""
    values = [getattr(law, each.name) for each in fields(law)] if is_dataclass(law) else []
    groups = [cast("tuple[Any, ...]", value) if isinstance(value, tuple) else (value,) for value in values]
    return tuple(part for group in groups for part in group if isinstance(part, Law) and not isinstance(part, type))


def _place(error: BaseException) -> str:
    """The function in which a trace ended, the last one before it comes to expressions or NumPy."""
    named = ""
    for frame, _ in walk_tb(error.__traceback__):
        file = Path(frame.f_code.co_filename)
        if "numpy" in file.parts or file.stem.startswith("traced_"):
            break
        if file != Path(__file__):
            named = f"{file.stem}.{frame.f_code.co_qualname}"
    return named


def _open(law: Any, inputs: _Inputs) -> Any:
    """The law with its sensors and references of the tip as inputs, and so the laws inside it."""
    if not is_dataclass(law):
        return law
    changes: dict[str, Any] = {}
    for each in fields(law):
        value, kind = getattr(law, each.name), str(each.type)
        if "TipReference" in kind:
            changes[each.name] = inputs.target(value)
        elif "Sensor" in kind and value is not None:
            size = len(cast("Any", law).coordinates.rows) if hasattr(law, "coordinates") else 6
            changes[each.name] = inputs.sensor_input(value, "force" if each.name == "sensor" else each.name, size)
        elif isinstance(value, tuple):
            changes[each.name] = tuple(_open(part, inputs) for part in cast("tuple[Any, ...]", value))
        elif is_dataclass(value) and isinstance(value, Law):
            changes[each.name] = _open(value, inputs)
    return replace(cast("Any", law), **changes) if changes else law


def _with_memory(law: Any, period: float, called: Callable[[Any], Traced]) -> tuple[Traced, list[Any], Any]:
    """Efforts, the memory as columns of symbols, and the memory for the next call as one column."""
    # 2.
    session = law.session(period)
    before = _parts(session)
    written = {way: value.tobytes() for way, value in before.items() if isinstance(value, np.ndarray)}
    effort = called(session)
    first = _parts(session)
    if any(way in written and value is before[way] and value.tobytes() != written[way] for way, value in first.items()):
        raise _forgetful(session)
    shapes = {key: _shape(first[key]) for key in _change(before, first)}
    if not shapes:
        return effort, [], None
    # 3.
    later, symbols, nexts = _later_call(law, period, called, shapes, session)
    keep, keys = _parts_in_use(later.column(), symbols, nexts), list(shapes)
    symbols, nexts, keys = [symbols[k] for k in keep], [nexts[k] for k in keep], [keys[k] for k in keep]
    if not keep:
        return later, [], None
    if all(_shape(before.get(key)) == shapes[key] for key in keys):
        starts = [ex.Expression(np.asarray(before[key], dtype=np.float64).reshape(-1)) for key in keys]
        return _grown_from(starts, later, symbols, nexts)
    started = ex.symbol("begun")
    firsts = [_column(first.get(key), shapes[key], session) for key in keys]
    joined = [ex.if_else(started > 0.5, x, y) for x, y in zip(nexts, firsts, strict=True)]
    both = ex.if_else(started > 0.5, later.column(), effort.column())
    return _array(both), [started, *symbols], ex.vertcat(ex.Expression(1.0), *joined)


def _later_call(
    law: Any, period: float, called: Callable[[Any], Traced], shapes: dict[Way, tuple[int, ...] | None], session: Any
) -> tuple[Traced, list[Any], list[ex.Expression]]:
    """Efforts of a later call, the memory before it as columns of symbols, and the memory after it.

    What changes at this call alone is found, joins the shapes, and is looked at once more.
    """
    for _ in range(MOST_ROUNDS):
        later = law.session(period)
        given = {key: Traced.symbols(".".join(map(str, key)), shape or ()) for key, shape in shapes.items()}
        _put_all(later, {key: array for key, (array, _) in given.items()})
        put = _parts(later)
        effort = called(later)
        found = _parts(later)
        new = [key for key in _change(put, found) if key not in shapes]
        if not new:
            nexts = [_column(found.get(key), shape, session) for key, shape in shapes.items()]
            return effort, [column for _, column in given.values()], nexts
        shapes |= {key: _shape(found[key]) for key in new}
    raise _forgetful(session)


def _grown_from(
    starts: list[ex.Expression], effort: Traced, symbols: list[Any], nexts: list[ex.Expression]
) -> tuple[Traced, list[Any], Any]:
    """The same with the memory counted from its start, so that it begins at zero."""
    begun = [x + start for x, start in zip(symbols, starts, strict=True)]
    moved = ex.substitute([effort.column(), *nexts], symbols, begun)
    grown = [x - start for x, start in zip(moved[1:], starts, strict=True)]
    return _array(moved[0]), symbols, ex.vertcat(*grown)


def _change(before: Parts, after: Parts) -> list[Way]:
    return [way for way, value in after.items() if before.get(way, before) is not value]


def _forgetful(session: Any) -> Untraceable:
    return Untraceable("memory", type(session).__name__.strip("_"))


def _column(value: Any, shape: tuple[int, ...] | None, session: Any) -> ex.Expression:
    """What a part of the memory is, as a column; a part that is not always numbers of one shape is no memory."""
    if shape is None or _shape(value) != shape:
        raise _forgetful(session)
    return (value if isinstance(value, Traced) else Traced(np.asarray(value, dtype=object))).column()


def _array(column: ex.Expression) -> Traced:
    numbers = np.empty(len(column.entries), dtype=object)
    numbers[:] = [Number(node) for node in column.entries]
    return Traced(numbers)


def _parts_in_use(effort: ex.Expression, symbols: Sequence[Any], nexts: Sequence[Any]) -> list[int]:
    """Which parts of a memory the efforts depend on, now or later."""
    used = {id(x) for x in _symbols([effort])}
    keep: list[int] = []
    while True:
        more = [k for k in range(len(symbols)) if k not in keep and _uses(symbols[k], used)]
        if not more:
            return sorted(keep)
        keep += more
        used |= {id(x) for x in _symbols([nexts[k] for k in more])}


def _symbols(columns: Sequence[ex.Expression]) -> list[Any]:
    return [entry for x in columns for symbol in ex.symvar(x) for entry in symbol.entries]


def _uses(column: ex.Expression, used: set[int]) -> bool:
    return any(id(entry) in used for entry in column.entries)


def _parts(session: Any) -> Parts:
    """Everything that a session and the objects in it hold, by the way to it."""
    found: Parts = {}
    seen: set[int] = set()
    waiting: list[tuple[Way, Any]] = [((), session)]
    while waiting:
        way, value = waiting.pop()
        inside = [] if id(value) in seen else list(_inside(value))
        seen.add(id(value))
        waiting += [((*way, name), part) for name, part in inside]
        if not inside:
            found[way] = value
    return found


def _inside(value: Any) -> Iterator[tuple[str | int, Any]]:
    """Names and parts of a container, or of an object that a law may change: one of control, or of somebody else."""
    home = type(value).__module__
    if isinstance(value, list | tuple | deque):
        yield from enumerate(cast("list[Any]", value))
    elif isinstance(value, dict):
        yield from ((str(key), part) for key, part in cast("dict[Any, Any]", value).items())
    elif home.startswith(_HOME) or home.partition(".")[0] not in {*sys.stdlib_module_names, "mafsil", "numpy", "scipy"}:
        slots = [name for kind in type(value).__mro__ for name in getattr(kind, "__slots__", ())]
        for name in dict.fromkeys([*getattr(value, "__dict__", {}), *slots]):
            if hasattr(value, name):
                yield name, getattr(value, name)


def _put_all(session: Any, given: dict[Way, Traced]) -> None:
    """Put the memory into a session; parts of one tuple together."""
    whole: dict[Way, dict[int, Traced]] = {}
    for way, value in given.items():
        if way and isinstance(way[-1], int):
            whole.setdefault(way[:-1], {})[way[-1]] = value
        else:
            _put(session, way, value)
    for way, parts in whole.items():
        _put(session, way, tuple(parts[k] for k in sorted(parts)))


def _put(session: Any, way: Way, value: Any) -> None:
    holder = session
    for name in way[:-1]:
        holder = holder[name] if isinstance(name, int) else getattr(holder, name)
    if not way or isinstance(getattr(holder, str(way[-1]), None), list | deque | dict):
        raise _forgetful(session)
    try:
        setattr(holder, str(way[-1]), value)
    except AttributeError:
        raise _forgetful(session) from None


def _shape(value: Any) -> tuple[int, ...] | None:
    """Of numbers; None of anything else."""
    if isinstance(value, Traced):
        return value.entries.shape
    if isinstance(value, np.ndarray) and cast("Any", value).dtype.kind in "fiu":
        return cast("Any", value).shape
    return () if isinstance(value, float) else None
