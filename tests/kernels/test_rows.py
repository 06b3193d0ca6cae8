"""Blocks of outputs: every element is written, in place, whatever the size of the port and the number of lanes."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil.expression as ex
from mafsil.kernels import target
from mafsil.kernels.audit import Program
from mafsil.kernels.layout import Port, Signature
from mafsil.kernels.reduce import reduce
from mafsil.kernels.rows import block_length, blocks
from mafsil.kernels.schedule import segments
from mafsil.kernels.tape import read

LEVELS = {8: "", 4: "-avx512f", 2: "-sse3,-ssse3,-sse4.1,-sse4.2,-avx"}


def mixed(size: int) -> tuple[ex.Function, Signature]:
    """An output of that size with constants, inputs, equal values and values of every depth."""
    x = ex.symbol("x", 5)
    parts = [x[0], 0.0, ex.sin(x[1]), 1.0, x[2] * x[3], x[2] * x[3], ex.sqrt(x[4] ** 2 + 1)]
    rows = [parts[k % 7] if k < 7 or k % 7 in (0, 1, 3) else parts[k % 7] * (k + 1) for k in range(size)]
    return ex.Function("mixed", [x], [ex.vertcat(*rows)]), Signature("mixed", (Port("x", (5,)),), (Port("y", (size,)),))


@pytest.mark.parametrize("width", [1, 2, 4, 8])
@pytest.mark.parametrize("size", [1, 2, 3, 4, 5, 7, 8, 9, 49])
def test_blocks_cover_every_element_of_a_port(size: int, width: int) -> None:
    tape = reduce(read(mixed(size)[0]))
    covered: set[int] = set()
    for block in blocks(tape, width):
        assert len(block.nodes) == block_length(size, width) <= width
        elements = range(block.first, block.first + len(block.nodes))
        assert block.nodes == tuple(tape.outputs[0][e] for e in elements)
        covered.update(elements)
    assert covered == set(range(size))


@pytest.mark.parametrize("length", [1, 4, 1000])
def test_a_block_ends_where_its_last_value_is_known(length: int) -> None:
    tape = reduce(read(mixed(29)[0]))
    found = blocks(tape, 8)
    pieces, _ = segments(tape, length, found)
    assert sorted(b.first for piece in pieces for b in piece.blocks) == sorted(b.first for b in found)
    leaves = {i for i, node in enumerate(tape.nodes) if node.op in ("input", "const")}
    for piece in pieces:
        here = leaves | {i for group in piece.groups for i in group} | set(piece.known)
        assert all(set(block.nodes) <= here for block in piece.blocks)


@pytest.mark.parametrize("lanes", LEVELS)
@pytest.mark.parametrize("size", [1, 3, 6, 13])
def test_rows_of_any_stride(size: int, lanes: int) -> None:
    """Contiguous rows take the straight way, all others the one over spare rows; gaps between rows stay untouched."""
    function, signature = mixed(size)
    program = Program(reduce(read(function)), signature, target.host(LEVELS[lanes]))
    x = np.random.default_rng(size).normal(size=(2 * lanes + 1, 5))
    (expected,) = program.batch(x)
    for k, row in enumerate(x):
        assert (program.single(row)[0] == expected[k]).all()
    for gap in (0, 3):
        wide = np.full((len(x), size + gap), -7.0)
        program.batch(x, out=[wide[:, :size]])
        assert (wide[:, :size] == expected).all()
        assert (wide[:, size:] == -7.0).all()
    spread = np.full((len(x), 2 * size), -7.0)
    program.batch(x, out=[spread[:, ::2]])
    assert (spread[:, ::2] == expected).all()
    assert (spread[:, 1::2] == -7.0).all()
