"""A compiled kernel held against NumPy and against mpmath, in units of the last place."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.expression import Function
from mafsil.kernels import target as targets
from mafsil.kernels.compiler import shared_code
from mafsil.kernels.layout import Signature
from mafsil.kernels.lower import lower
from mafsil.kernels.reduce import reduce
from mafsil.kernels.reference import evaluate, exact
from mafsil.kernels.streaming import STREAMED
from mafsil.kernels.tape import Tape, read
from mafsil.kernels.target import Target

Rows = NDArray[np.float64]


class Program:
    """A tape in machine code, called through ctypes: no caches, no gates, nothing before the two entries."""

    def __init__(self, tape: Tape, signature: Signature, target: Target | None = None) -> None:
        self.signature = signature
        self.target = target or targets.host()
        self.tape = tape
        self.ir = lower(tape, signature, self.target, alone=False)
        self.object_code = targets.compile(self.ir, self.target)
        self.code = targets.load(self.object_code, imports=shared_code(self.target))
        pointers = [ctypes.c_void_p] * len(signature.ports)
        self._batch = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4)(self.code.batch)
        self._single = ctypes.CFUNCTYPE(None, *pointers)(self.code.single)

    def batch(self, *inputs: ArrayLike, out: Sequence[Rows] | None = None, streamed: bool = False) -> list[Rows]:
        """All rows by the batch entry, strides as they are; outputs are filled with NaN before.

        Args:
            inputs: one (rows, *core) array per input; a single row is broadcast by an outer stride of 0.
            out: arrays to write into.
            streamed: results go past the caches (`streaming`).
        """
        arrays = [np.asarray(x, dtype=np.float64) for x in inputs]
        rows = max((len(x) for x in arrays), default=1)
        if out is None:
            out = [np.full((rows, *port.shape), np.nan) for port in self.signature.outputs]
        self.call([*arrays, *out], rows, STREAMED if streamed else None)
        return list(out)

    def call(self, arrays: Sequence[Rows], rows: int, data: int | None = None) -> None:
        """The batch entry on these arrays, an outer length of 1 meaning broadcast."""
        outer = [0 if len(x) == 1 and rows != 1 else x.strides[0] for x in arrays]
        steps = [*outer, *(step for x in arrays for step in x.strides[1:])]
        args = (ctypes.c_void_p * len(arrays))(*(x.ctypes.data for x in arrays))
        self._batch(args, (ctypes.c_ssize_t * 1)(rows), (ctypes.c_ssize_t * len(steps))(*steps), data)

    def single(self, *inputs: ArrayLike) -> list[Rows]:
        """One row by the single entry."""
        arrays = [np.ascontiguousarray(x, dtype=np.float64) for x in inputs]
        out = [np.full(port.shape, np.nan) for port in self.signature.outputs]
        self._single(*(x.ctypes.data for x in (*arrays, *out)))
        return out


@dataclass(frozen=True)
class AuditReport:
    """How far a kernel is from the truth.

    Attributes:
        worst_ulp: largest distance from mpmath, in units of the last place of the natural scale.
        where: (row, output port, element) of it.
        worst_ulp_numpy: largest distance from the expression as it was written, evaluated in NumPy, in the same units.
        rows: samples compared with NumPy.
        exact_rows: samples compared with mpmath.
        undefined: numbers where one side is NaN or infinite and the other is not.
        batch_equals_single: both entries give the same bits.
    """

    worst_ulp: float
    where: tuple[int, str, int]
    worst_ulp_numpy: float
    rows: int
    exact_rows: int
    undefined: int
    batch_equals_single: bool

    def __str__(self) -> str:
        row, port, element = self.where
        return (
            f"{self.worst_ulp:.2f} ulp from mpmath ({self.exact_rows} rows; row {row}, {port}[{element}]), "
            f"{self.worst_ulp_numpy:.2f} ulp from NumPy ({self.rows} rows), {self.undefined} undefined, "
            f"batch {'=' if self.batch_equals_single else '!='} single"
        )


def audit(
    function: Function,
    signature: Signature,
    samples: Sequence[ArrayLike],
    *,
    target: Target | None = None,
    exact_rows: int = 20,
    digits: int = 40,
) -> AuditReport:
    """Compile `function` and compare it on `samples` with NumPy, operation by operation, and with mpmath.

    Args:
        function: one column per port.
        signature: its ports.
        samples: one (rows, *core) array per input.
        target: machine to compile for; None is this one.
        exact_rows: how many of the rows are also evaluated by mpmath.
        digits: digits of mpmath.
    """
    tape = read(function)
    program = Program(reduce(tape), signature, target)
    inputs = [np.asarray(x, dtype=np.float64) for x in samples]
    flat = [x.reshape(len(x), -1) for x in inputs]
    found = [x.reshape(len(x), -1) for x in program.batch(*inputs)]
    plain = evaluate(tape, flat)
    scales = [scale for _, scale in plain]
    distances = [ulps(a, b, s) for a, (b, s) in zip(found, plain, strict=True)]
    undefined = sum(int((np.isfinite(a) != np.isfinite(b)).sum()) for a, (b, _) in zip(found, plain, strict=True))
    worst, where = 0.0, (0, signature.outputs[0].name, 0)
    for row in range(min(exact_rows, len(flat[0]))):
        truth = exact(tape, [x[row].tolist() for x in flat], digits)
        for k, port in enumerate(signature.outputs):
            for element, value in enumerate(truth[k]):
                distance = exact_ulps(found[k][row, element], value, scales[k][row, element])
                if distance > worst:
                    worst, where = distance, (row, port.name, element)
    return AuditReport(
        worst_ulp=worst,
        where=where,
        worst_ulp_numpy=max((float(np.nanmax(d, initial=0.0)) for d in distances), default=0.0),
        rows=len(flat[0]),
        exact_rows=min(exact_rows, len(flat[0])),
        undefined=undefined,
        batch_equals_single=_same_bits(program, inputs, found),
    )


def ulps(found: Rows, expected: Rows, scale: Rows) -> Rows:
    """|found - expected| in units of the last place of the scale; 0 where both are undefined alike."""
    with np.errstate(all="ignore"):
        unit = np.spacing(np.maximum(np.abs(expected), np.where(np.isfinite(scale), scale, 0.0)))
        distance = np.abs(found - expected) / unit
    same = (found == expected) | (np.isnan(found) & np.isnan(expected))
    return np.where(same, 0.0, np.where(np.isfinite(found) & np.isfinite(expected), distance, 0.0))


def exact_ulps(found: float, expected: Any, scale: float = 0.0) -> float:
    """|found - expected| in units of the last place of the scale, `expected` an mpmath number or None."""
    mp: Any = import_module("mpmath")  # of the tests: the package runs without it

    if expected is None or not np.isfinite(found):
        return 0.0
    nearest = float(expected)
    size = max(abs(nearest), scale if np.isfinite(scale) else 0.0)
    unit = float(np.spacing(min(size, 1.7e308)))
    return float(abs(mp.mpf(float(found)) - expected) / mp.mpf(unit))


def _same_bits(program: Program, inputs: Sequence[Rows], found: Sequence[Rows]) -> bool:
    """The single entry repeats the batch's rows, bit for bit (NaN equals NaN)."""
    for row in range(len(inputs[0])):
        alone = program.single(*(x[row] for x in inputs))
        for k, values in enumerate(alone):
            if not np.array_equal(values.ravel(), found[k][row], equal_nan=True):
                return False
    return True
