"""Stored inputs and outputs that travel with exported code, and how far it may be from them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from mafsil.arrays import Floats
from mafsil.kernels.layout import Signature
from mafsil.kernels.reference import evaluate
from mafsil.kernels.tape import Tape

ROWS = 8
LIMIT = 64.0
"""Units in the last place of the natural scale: what other sines, compilers and orders of rounding may change."""
_REACH = 3.0


@dataclass(frozen=True)
class Vectors:
    """Rows of numbers, port after port.

    Attributes:
        inputs: (rows, elements) for each input port.
        outputs: (rows, elements) for each output port, from the kernel on this processor.
        units: (rows, elements), one unit in the last place of the natural scale of each output.
    """

    inputs: tuple[Floats, ...]
    outputs: tuple[Floats, ...]
    units: tuple[Floats, ...]

    @property
    def rows(self) -> int:
        """How many evaluations."""
        return len(self.outputs[0])


def vectors(kernel: Callable[..., Any], tape: Tape, signature: Signature, *, single: bool = False) -> Vectors:
    """The zero state and others spread over -3..3, with what the kernel answers.

    Args:
        kernel: evaluates batches.
        tape: the same quantity, for the natural scale of every number.
        signature: ports.
        single: inputs and units of float32 numbers.
    """
    inputs = tuple(_spread(signature, single))
    shaped = [x.reshape(ROWS, *port.shape) for x, port in zip(inputs, signature.inputs, strict=True)]
    answer: Any = kernel(*shaped)
    answers = cast("tuple[Any, ...]", answer) if isinstance(answer, tuple) else (answer,)
    outputs = tuple(np.asarray(y, dtype=np.float64).reshape(ROWS, -1) for y in answers)
    scales = [scale for _, scale in evaluate(tape, inputs)]
    return Vectors(inputs, outputs, tuple(_unit(y, s, single) for y, s in zip(outputs, scales, strict=True)))


def _spread(signature: Signature, single: bool) -> list[Floats]:
    count = ROWS * sum(port.size for port in signature.inputs)
    numbers: Floats = (np.arange(1, count + 1, dtype=np.float64) * 0.6180339887498949 % 1.0 * 2.0 - 1.0) * _REACH
    found: list[Floats] = []
    for port in signature.inputs:
        rows, numbers = numbers[: ROWS * port.size].reshape(ROWS, port.size).copy(), numbers[ROWS * port.size :]
        rows[0] = 0.0
        found.append(rows.astype(np.float32).astype(np.float64) if single else rows)
    return found


def _unit(values: Floats, scales: Floats, single: bool) -> Floats:
    size = np.maximum(np.abs(values), np.where(np.isfinite(scales), scales, 0.0))
    size = np.where(np.isfinite(size), size, 1.0)
    return np.spacing(size.astype(np.float32)).astype(np.float64) if single else np.spacing(size)
