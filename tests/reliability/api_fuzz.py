"""F3: hostile calls of every routine of a Robot: the right answer, bit by bit, or our own error; never a crash.

`python -m tests.reliability.api_fuzz --calls 10000000 --resume DIR`

Calls run in a child process; a shard whose child dies counts as a crash and names the call. Case k of shard s is made
from the seed (s, k) alone: `python -m tests.reliability.api_fuzz --case s k` repeats it.
"""

from __future__ import annotations

import argparse
import multiprocessing
import sys
import traceback
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from mafsil.errors import MafsilError
from mafsil.mechanics.catalogue import CATALOGUE
from mafsil.mechanics.quantity import INPUTS
from mafsil.robot import Robot, load
from tests.oracles.ours import ALL
from tests.reliability import figures

ROBOTS = ("planar3r", "cobra600", "panda")
LARGEST = "panda"
"""Asked for the quantities of every day only; the small robots for all, which compile in no time."""
BATCHES = ((), (), (1,), (5,), (3, 1, 2), (0,), (2, 0), (33,), (4097,))


@dataclass
class Argument:
    """What is handed in, and the float64 array that it means; None if it means none."""

    given: Any
    meant: np.ndarray | None


@dataclass
class Case:
    """One call: what is called, with what, and whether a refusal would be wrong."""

    robot: str
    routine: str
    positional: list[Argument]
    named: dict[str, Argument]
    options: dict[str, Any]
    harmless: bool

    def __str__(self) -> str:
        shown = [repr(a.given)[:200] for a in self.positional]
        shown += [f"{name}={a.given!r}"[:200] for name, a in self.named.items()]
        shown += [f"{name}={value!r}"[:200] for name, value in self.options.items()]
        return f"load({self.robot!r}).{self.routine}({', '.join(shown)})"


@cache
def robot(name: str) -> Robot:
    return load(name)


Form = Callable[[np.ndarray, np.random.Generator], Any]


def _gaps(x: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    wide = np.full(tuple(3 * size + 1 for size in x.shape), 1e9)
    view = wide[(..., *(slice(0, 3 * size, 3) for size in x.shape))]
    view[...] = x
    return view


def _reversed(x: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    back = (..., *(slice(None, None, -1) for _ in x.shape))
    return np.ascontiguousarray(x[back])[back]


def _misaligned(x: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    buffer = np.zeros(x.nbytes + 1, np.uint8)
    view = buffer[1:].view(np.float64).reshape(x.shape)
    view[...] = x
    return view


def _read_only(x: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    copy = x.copy()
    copy.setflags(write=False)
    return copy


class _Subclass(np.ndarray):
    """Some other array."""


class _ArrayLike:
    """An object with an `__array__` of its own."""

    def __init__(self, x: np.ndarray) -> None:
        self.x = x

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return self.x.copy()


HARMLESS: dict[str, Form] = {
    "plain": lambda x, rng: x,
    "list": lambda x, rng: x.tolist(),
    "float32": lambda x, rng: x.astype(np.float32),
    "float16": lambda x, rng: x.astype(np.float16),
    "int": lambda x, rng: np.round(x).astype(rng.choice(["i1", "i4", "i8"])),
    "unsigned": lambda x, rng: np.abs(np.round(x)).astype(rng.choice(["u1", "u8"])),
    "other byte order": lambda x, rng: x.astype(">f8"),
    "longdouble": lambda x, rng: x.astype(np.longdouble),
    "Fortran": lambda x, rng: np.asfortranarray(x),
    "gaps": _gaps,
    "reversed": _reversed,
    "misaligned": _misaligned,
    "read-only": _read_only,
    "subclass": lambda x, rng: x.view(_Subclass),
    "array-like": lambda x, rng: _ArrayLike(x),
    "tuple of arrays": lambda x, rng: tuple(x),
}
HOSTILE: dict[str, Form] = {
    "complex": lambda x, rng: x.astype(complex),
    "bool": lambda x, rng: x > 0,
    "object": lambda x, rng: x.astype(object),
    "text": lambda x, rng: x.astype(str),
    "bytes": lambda x, rng: x.tobytes(),
    "masked": lambda x, rng: np.ma.masked_greater(x, 0.5),
    "time": lambda x, rng: x.astype("i8").astype("m8[s]"),
    "record": lambda x, rng: np.zeros(x.shape, [("a", float), ("b", float)]),
    "None": lambda x, rng: None,
    "name": lambda x, rng: "q",
    "number": lambda x, rng: float(rng.normal()),
    "zero-dimensional": lambda x, rng: np.array(1.0),
    "dict": lambda x, rng: {"q": x},
    "generator": lambda x, rng: (y for y in x),
    "set": lambda x, rng: {1.0, 2.0},
    "ragged": lambda x, rng: [[1.0], [1.0, 2.0]],
    "contains itself": lambda x, rng: _endless(),
    "too large a number": lambda x, rng: [10**400] * x.shape[-1],
    "class": lambda x, rng: np.ndarray,
    "one too many": lambda x, rng: np.concatenate([x, x[..., :1]], -1),
    "one too few": lambda x, rng: x[..., :-1],
    "transposed": lambda x, rng: x.T,
    "column": lambda x, rng: x[..., None],
    "33 dimensions": lambda x, rng: x.reshape((1,) * 33 + x.shape),
    "other batch": lambda x, rng: np.broadcast_to(x.reshape(-1, x.shape[-1])[:1], (7, x.shape[-1])) if x.size else x,
    "huge view": lambda x, rng: np.broadcast_to(x.reshape(-1, x.shape[-1])[0], (2**40, x.shape[-1])) if x.size else x,
}
SPECIAL = (np.nan, np.inf, -np.inf, 1e308, -1e300, 5e-324, -0.0, 1e-160, 2.0**60, 1e9)


def _endless() -> list[Any]:
    loop: list[Any] = []
    loop.append(loop)
    return loop


def case(seed: int, number: int) -> Case:
    """The call of that number."""
    rng = np.random.default_rng([seed, number])
    name, routine = str(rng.choice(ROBOTS)), str(rng.choice(list(CATALOGUE)))
    if name == LARGEST:
        routine = str(rng.choice(ALL)).split()[0]
    row, n = CATALOGUE[routine], robot(name).n
    inputs = [*row.inputs, *(row.optional[:1] if rng.random() < 0.5 else row.optional if rng.random() < 0.3 else ())]
    batch = BATCHES[int(rng.integers(len(BATCHES)))]
    harmless, arguments = True, []
    for each in inputs:
        core = tuple(n if size == "n" else int(size) for size in INPUTS[each])
        shape = (*(batch if rng.random() < 0.7 else batch[len(batch) // 2 :]), *core)
        argument, fine = _argument(rng, shape)
        arguments.append(argument)
        harmless &= fine
    options, plain = _options(rng, name, routine, batch, arguments)
    split = len(inputs) if rng.random() < 0.7 else int(rng.integers(len(inputs) + 1))
    named = dict(zip(inputs[split:], arguments[split:], strict=True))
    positional = arguments[:split]
    if rng.random() < 0.02:
        harmless, positional = False, positional[:-1]
    return Case(name, routine, positional, named, options, harmless and plain)


def _argument(rng: np.random.Generator, shape: tuple[int, ...]) -> tuple[Argument, bool]:
    x = np.round(rng.uniform(-3, 3, shape), 2).astype(np.float32).astype(np.float64)
    if rng.random() < 0.15 and x.size:
        flat = x.reshape(-1)
        flat[rng.integers(x.size, size=1 + x.size // 50)] = rng.choice(SPECIAL)
        return Argument(x, x.copy()), False
    hostile = rng.random() < 0.12
    forms = HOSTILE if hostile else HARMLESS
    form = forms[str(rng.choice(list(forms)))]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        given = form(x, rng)
    meant = meaning(given)
    return Argument(given, meant), not hostile and meant is not None and meant.shape == shape


def meaning(given: Any) -> np.ndarray | None:
    """The float64 array that real numbers in `given` stand for."""
    if given is None or isinstance(given, np.ma.MaskedArray):
        return None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            array = np.asarray(given)
            real = array.dtype.kind in "fiu" or (array.dtype.kind == "O" and not array.size)
            return np.array(array, dtype=np.float64) if real and array.size < 1e6 else None
    except Exception:
        return None


def _options(
    rng: np.random.Generator, name: str, routine: str, batch: tuple[int, ...], arguments: list[Argument]
) -> tuple[dict[str, Any], bool]:
    options: dict[str, Any] = {}
    plain = True
    if rng.random() < 0.15:
        options["threads"] = [1, 2, 8, 10**9, 0, -1, "2", 1.5, True, None, np.int64(2), [1]][int(rng.integers(12))]
        plain &= options["threads"] in (1, 2, 8, None) and options["threads"] is not True
    if rng.random() < 0.15:
        links = robot(name).mechanism.link_names
        options["frame"] = [None, links[0], links[-1], "", "nowhere", 5, b"base", [1], {}, np.nan][
            int(rng.integers(10))
        ]
        plain &= options["frame"] is None
    if rng.random() < 0.2:
        options["out"], fit = _out(rng, name, routine, batch, arguments)
        plain &= fit
    if rng.random() < 0.01:
        options["outt"] = 1
        plain = False
    return options, plain


def _out(
    rng: np.random.Generator, name: str, routine: str, batch: tuple[int, ...], arguments: list[Argument]
) -> tuple[Any, bool]:
    shape = (*batch, *result_core(name, routine))
    kinds = (
        "fit",
        "float32",
        "read-only",
        "shape",
        "gaps",
        "reversed",
        "text",
        "list",
        "over the input",
        "object",
        "same",
    )
    match str(rng.choice(kinds)):
        case "fit":
            return np.full(shape, np.nan), False
        case "float32":
            return np.zeros(shape, np.float32), False
        case "read-only":
            return _read_only(np.zeros(shape), rng), False
        case "shape":
            return np.zeros((*shape, 2)), False
        case "gaps":
            return _gaps(np.zeros(shape), rng), False
        case "reversed":
            return _reversed(np.zeros(shape), rng), False
        case "text":
            return "out", False
        case "list":
            return np.zeros(shape).tolist(), False
        case "over the input":
            source = arguments[0].given
            if isinstance(source, np.ndarray) and source.dtype == np.float64 and source.flags.c_contiguous:
                size = int(np.prod(shape))
                if 0 < size <= source.size and source.flags.writeable:
                    return source.reshape(-1)[source.size - size :].reshape(shape), False
            return np.full(shape, np.nan), False
        case "object":
            return np.zeros(shape, object), False
        case _:
            return arguments[0].given, False


def result_core(name: str, routine: str) -> tuple[int, ...]:
    """Core shape of a routine's result."""
    sizes = {"n": robot(name).n, "L": len(robot(name).mechanism.links)}
    return tuple(size if isinstance(size, int) else sizes[size] for size in CATALOGUE[routine].shape)


def verdict(case: Case) -> str:
    """`right`, `refused`, or what went wrong, a name that begins with `bad_`."""
    r = robot(case.robot)
    arguments = [*case.positional, *case.named.values()]
    before = [None if a.meant is None else a.meant.copy() for a in arguments]
    try:
        answer = getattr(r, case.routine)(
            *(a.given for a in case.positional), **{k: a.given for k, a in case.named.items()}, **case.options
        )
    except MafsilError as error:
        if not str(error) or not error.message("ar"):
            return "bad_sentence"
        return "bad_refusal" if case.harmless else "refused"
    except Exception:
        traceback.print_exc()
        return "bad_exception"
    inputs = [x for x in before if x is not None]
    if len(inputs) != len([a for a in arguments if a.given is not None]):
        return "bad_accepted"
    row = CATALOGUE[case.routine]
    names = [name for name, a in zip((*row.inputs, *row.optional), arguments, strict=False) if a.given is not None]
    return _judged(case, r, answer, dict(zip(names, inputs, strict=True)))


def _judged(case: Case, r: Robot, answer: Any, meant: dict[str, np.ndarray]) -> str:
    if not meant.keys() >= set(CATALOGUE[case.routine].inputs):
        return "bad_accepted"
    inputs = list(meant.values())
    cores = [tuple(r.n if size == "n" else int(size) for size in INPUTS[name]) for name in meant]
    if any(x.shape[x.ndim - len(core) :] != core or x.ndim < len(core) for x, core in zip(inputs, cores, strict=True)):
        return "bad_accepted"
    if any(x.ndim > 32 for x in inputs):
        return "right"  # NumPy's own helpers, needed for the judgement, end at 32 dimensions
    batch = np.broadcast_shapes(*(x.shape[: x.ndim - len(core)] for x, core in zip(inputs, cores, strict=True)))
    core = result_core(case.robot, case.routine)
    if not isinstance(answer, np.ndarray | np.float64 | float) or np.shape(answer) != (*batch, *core):
        return "bad_shape"
    flat = [
        np.ascontiguousarray(np.broadcast_to(x, (*batch, *c))).reshape(-1, *c)
        for x, c in zip(inputs, cores, strict=True)
    ]
    if not batch and not all(np.isfinite(x).all() for x in inputs):
        return "bad_accepted"
    expected = _row_by_row(case, r, dict(zip(meant, flat, strict=True)), core)
    found = np.asarray(answer, dtype=np.float64).reshape(expected.shape)
    return "right" if np.array_equal(found, expected, equal_nan=True) else "bad_answer"


def _row_by_row(case: Case, r: Robot, inputs: dict[str, np.ndarray], core: tuple[int, ...]) -> np.ndarray:
    """The answer for clean copies: each row on its own, bad rows NaN or whatever the batch gives for them alone."""
    optional = tuple(name for name in CATALOGUE[case.routine].optional if name in inputs)
    kernel = r.kernel(case.routine, case.options.get("frame"), optional)
    flat = list(inputs.values())
    rows = len(flat[0])
    chosen = range(rows) if rows <= 64 else [*range(16), *range(rows - 16, rows)]
    expected = np.array(kernel(*flat, threads=1)).reshape(rows, *core) if rows else np.empty((0, *core))
    for k in chosen:
        point = [x[k].copy() for x in flat]
        try:
            expected[k] = kernel(*point)
        except MafsilError:  # not finite, or overflowing: a value in batches, refused alone
            expected[k] = kernel(*(x[None] for x in point))[0]
    return expected


def work(seed: int, calls: int) -> dict[str, int]:
    """Make and judge that many calls in a child."""
    context = multiprocessing.get_context("fork")
    reached, counts = context.Value("q", 0), context.SimpleQueue()
    child = context.Process(target=_child, args=(seed, calls, reached, counts))
    child.start()
    total = {"calls": 0, "right": 0, "refused": 0, "bad_crash": 0}
    while child.is_alive() or not counts.empty():
        if counts.empty():
            child.join(0.05)
            continue
        for name, count in counts.get().items():
            total[name] = total.get(name, 0) + count
    if child.exitcode:
        print(f"crash {child.exitcode}: --case {seed} {reached.value}", file=sys.stderr)
        total["bad_crash"] += 1
    return total


def _child(seed: int, calls: int, reached: Any, counts: Any) -> None:
    for first in range(0, calls, 500):
        found: dict[str, int] = {"calls": min(500, calls - first)}
        for number in range(first, min(first + 500, calls)):
            reached.value = number
            outcome = verdict(case(seed, number))
            found[outcome] = found.get(outcome, 0) + 1
            if outcome.startswith("bad_"):
                print(f"{outcome}: --case {seed} {number}: {case(seed, number)}", file=sys.stderr, flush=True)
        counts.put(found)


def main() -> int:
    if "--case" in sys.argv:
        parser = argparse.ArgumentParser()
        parser.add_argument("--case", nargs=2, type=int)
        chosen = case(*parser.parse_args().case)
        print(chosen)
        print(verdict(chosen))
        return 0
    options = figures.arguments(__doc__ or "", "calls", 5000, 100_000)
    return 0 if figures.run("F3", options, work)["passed"] else 1


if __name__ == "__main__":
    sys.exit(main())
