"""How long one evaluation takes in a batch, about: what decides whether a second thread is worth its call."""

from __future__ import annotations

from mafsil.kernels.layout import Signature

OPERATION_NS = 0.2
"""One operation of one row on one lane [ns]; sines, quotients and spills included, measured over the mechanics of arms
and trees on AVX-512 at 4 GHz: 0.15 to 0.3."""
BYTE_NS = 0.013
"""One byte of a result, transposed and written [ns]."""
HANDED_OVER_NS = 250_000
"""Work that pays for being handed to another thread [ns]: waking one takes some 75 us, and on a busy machine it comes
later still, while the caller waits."""

SINGLY = 4000
"""Rows that a kernel evaluates one after another before its code for lanes is compiled: an operation of one row takes
1 ns, its compilation 60 us."""


def row_ns(operations: int, lanes: int, signature: Signature) -> float:
    """Nanoseconds of one row of a batch on one core of a quick machine; slower ones take up to twice as long.

    Args:
        operations: of one evaluation.
        lanes: rows that are evaluated together.
        signature: gives the bytes of the results.
    """
    size = 8 * sum(port.size for port in signature.outputs)
    return max(operations * OPERATION_NS / max(lanes, 1) + size * BYTE_NS, 1.0)


def rows_for_one_thread(row: float) -> int:
    """Rows of the largest batch that is worth no second thread.

    Args:
        row: nanoseconds of one row.
    """
    return max(1, int((2 * HANDED_OVER_NS - 1) / row))
