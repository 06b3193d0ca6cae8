"""Compiled kernels: every operation, every tail, any strides, memory bounds, NaN, on several instruction sets."""

from __future__ import annotations

import ctypes
import functools
import importlib
import math
import mmap
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil.expression as ex
from mafsil.errors import KernelError
from mafsil.kernels import target
from mafsil.kernels.audit import Program, audit, ulps
from mafsil.kernels.layout import Port, Signature
from mafsil.kernels.lower import TILE_BYTES, lower
from mafsil.kernels.reduce import reduce
from mafsil.kernels.reference import evaluate
from mafsil.kernels.schedule import segments
from mafsil.kernels.tape import Node, Tape, read
from tests.oracles.casadi_expression import casadi_rows

LEVELS = {
    "host": "",
    "avx2": "-avx512f",
    "avx2 without fma": "-avx512f,-fma",
    "sse2": "-sse3,-ssse3,-sse4.1,-sse4.2,-avx",
}
UNARY = {
    "sin": ex.sin, "cos": ex.cos, "tan": ex.tan, "asin": ex.asin, "acos": ex.acos, "atan": ex.atan, "exp": ex.exp,
    "log": ex.log, "sqrt": ex.sqrt, "tanh": ex.tanh,
    "floor": ex.floor, "ceil": ex.ceil, "fabs": ex.fabs, "sign": ex.sign,
    "not": ex.logic_not, "neg": lambda x: -x, "sq": ex.sumsqr,
    "twice": lambda x: 2 * x, "inv": lambda x: 1 / x, "cube": lambda x: x**3, "power": lambda x: x**2.7,
}  # fmt: skip
BINARY = {
    "add": lambda x, y: x + y, "sub": lambda x, y: x - y, "mul": lambda x, y: x * y, "div": lambda x, y: x / y,
    "pow": lambda x, y: x**y, "atan2": ex.atan2, "fmin": ex.fmin,
    "fmax": ex.fmax, "copysign": ex.copysign, "lt": lambda x, y: x < y, "le": lambda x, y: x <= y,
    "eq": ex.equal, "ne": ex.unequal, "and": ex.logic_and, "or": ex.logic_or,
    "if_else": lambda x, y: ex.if_else(x < 0.5, y, x * y), "if_else_zero": lambda x, y: ex.if_else(x, y, 0),
}  # fmt: skip
EDGES = [0.0, -0.0, 1.0, -1.0, 0.5, 2.0, -3.0, 7.5, 1e-300, 5e-324, 1e300, -1e22, math.inf, -math.inf, math.nan]


def example() -> tuple[ex.Function, Signature]:
    """Three inputs of different shapes, four outputs, a bit of everything."""
    q, A, s = ex.symbol("q", 7), ex.symbol("A", 6), ex.symbol("s", 1)
    y = ex.vertcat(ex.sin(q) * ex.cos(q[0]), ex.dot(q, q), ex.atan2(A[0], A[1]) * s)
    B = ex.vertcat(*[A[i] * q[i] - s for i in range(6)])
    r = ex.if_else(s > 0, ex.sqrt(s), -s)
    e = ex.exp(-q[:3]) / (1 + A[2] ** 2)
    signature = Signature(
        "example",
        (Port("q", (7,)), Port("A", (2, 3)), Port("s")),
        (Port("y", (9,)), Port("B", (3, 2)), Port("r"), Port("e", (3,))),
    )
    return ex.Function("example", [q, A, s], [y, B, r, e]), signature


@pytest.fixture(scope="module", params=list(LEVELS))
def program(request: pytest.FixtureRequest) -> Program:
    function, signature = example()
    return Program(reduce(read(function)), signature, target.host(LEVELS[request.param]))


def inputs(rows: int, seed: int = 0) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [rng.normal(size=(rows, 7)), rng.normal(size=(rows, 2, 3)), rng.normal(size=(rows,))]


def same(a: list[np.ndarray], b: list[np.ndarray]) -> bool:
    return all(np.array_equal(x.view(np.int64), y.view(np.int64)) for x, y in zip(a, b, strict=True))


@pytest.mark.row("R2")
@pytest.mark.parametrize("level", list(LEVELS))
@pytest.mark.parametrize("op", list(UNARY))
def test_unary_operations_agree_with_casadi(op: str, level: str) -> None:
    x = ex.symbol("x", 1)
    signature = Signature(op, (Port("x"),), (Port("y"),))
    values = np.array([*EDGES, *np.random.default_rng(1).normal(size=60), 0.3, 0.9, 1.5, 30.0, -30.0])
    _agrees(ex.Function(op, [x], [UNARY[op](x)]), signature, [values], level)


@pytest.mark.row("R2")
@pytest.mark.parametrize("level", list(LEVELS))
@pytest.mark.parametrize("op", list(BINARY))
def test_binary_operations_agree_with_casadi(op: str, level: str) -> None:
    x, y = ex.symbol("x", 1), ex.symbol("y", 1)
    signature = Signature(op, (Port("x"), Port("y")), (Port("z"),))
    random = np.random.default_rng(2).normal(size=(60, 2)) * 3
    pairs = np.array([(a, b) for a in EDGES for b in EDGES] + random.tolist())
    _agrees(ex.Function(op, [x, y], [BINARY[op](x, y)]), signature, [pairs[:, 0], pairs[:, 1]], level)


def _agrees(function: ex.Function, signature: Signature, columns: list[np.ndarray], level: str) -> None:
    """Within 4 ulp of CasADi; NaN and infinities where CasADi has them."""
    program = Program(reduce(read(function)), signature, target.host(LEVELS[level]))
    (found,) = program.batch(*columns)
    (expected,) = casadi_rows(function, [c[:, None] for c in columns])
    expected = expected[:, 0]
    assert np.array_equal(np.isnan(found), np.isnan(expected)), [
        c[np.isnan(found) != np.isnan(expected)] for c in columns
    ]
    finite = np.isfinite(expected) & np.isfinite(found)
    assert np.array_equal(found[~finite & ~np.isnan(found)], expected[~finite & ~np.isnan(found)])
    assert ulps(found, expected, np.zeros_like(found)).max() <= 4
    for k in range(len(found)):
        assert np.array_equal(program.single(*(c[k] for c in columns))[0], found[k], equal_nan=True)


@pytest.mark.row("R2")
@pytest.mark.row("D2")
def test_every_batch_size_equals_the_single_entry(program: Program) -> None:
    columns = inputs(4 * program.target.lanes + 3)
    alone = [program.single(*(x[k] for x in columns)) for k in range(len(columns[0]))]
    for rows in range(1, len(columns[0]) + 1):
        found = program.batch(*(x[:rows] for x in columns))
        assert same(found, [np.stack([row[k] for row in alone[:rows]]) for k in range(4)]), rows


def test_no_rows_touch_nothing(program: Program) -> None:
    out = [np.full((1, *port.shape), 7.0) for port in program.signature.outputs]
    program.call([*inputs(1), *out], 0)
    assert all((x == 7.0).all() for x in out)


@pytest.mark.parametrize("rows", [1, 2, 7, 8, 9, 23])
def test_any_strides_give_the_same_bits(program: Program, rows: int) -> None:
    q, A, s = inputs(rows)
    expected = program.batch(q, A, s)
    wide = np.full((2 * rows, 3, 14), 1e9)
    wide[::2, 1, ::2] = q
    views = {
        "Fortran": (np.asfortranarray(q), np.asfortranarray(A), s),
        "negative": (q[::-1].copy()[::-1], A[:, ::-1, ::-1].copy()[:, ::-1, ::-1], s[::-1].copy()[::-1]),
        "gaps": (wide[::2, 1, ::2], np.repeat(A, 3, axis=0)[::3], np.repeat(s, 5)[::5]),
        "transposed core": (q, np.ascontiguousarray(A.transpose(0, 2, 1)).transpose(0, 2, 1), s),
    }
    for name, view in views.items():
        assert same(program.batch(*view), expected), name
    spaced = [np.full((2 * rows, *port.shape[::-1]), np.nan) for port in program.signature.outputs]
    out = [x.transpose(0, *range(x.ndim - 1, 0, -1))[::-2] for x in spaced]
    program.batch(q, A, s, out=out)
    assert same([np.ascontiguousarray(x) for x in out], expected)
    assert all(np.isnan(x[::2]).all() for x in spaced)


@pytest.mark.parametrize("rows", [2, 8, 13])
def test_an_input_may_be_one_row_for_all(program: Program, rows: int) -> None:
    q, A, s = inputs(rows)
    for mask in range(1, 7):
        chosen = [x[:1] if mask >> k & 1 else x for k, x in enumerate((q, A, s))]
        full = [np.repeat(x, rows, axis=0) if len(x) == 1 else x for x in chosen]
        assert same(program.batch(*chosen), program.batch(*full))


@settings(max_examples=40, deadline=None)
@given(rows=st.integers(1, 40), bad=st.integers(0, 39), value=st.sampled_from([math.nan, math.inf, -math.inf, 1e300]))
def test_a_bad_row_leaves_the_others_alone(rows: int, bad: int, value: float) -> None:
    program = _host_program()
    q, A, s = inputs(rows)
    expected = program.batch(q, A, s)
    spoiled = q.copy()
    spoiled[bad % rows, 2] = value
    found = program.batch(spoiled, A, s)
    others = np.arange(rows) != bad % rows
    assert same([np.ascontiguousarray(x[others]) for x in found], [np.ascontiguousarray(x[others]) for x in expected])
    if not math.isfinite(value):
        assert np.isnan(found[0][bad % rows, 2])


_PROGRAMS: list[Program] = []


def _host_program() -> Program:
    if not _PROGRAMS:
        function, signature = example()
        _PROGRAMS.append(Program(reduce(read(function)), signature))
    return _PROGRAMS[0]


class Fenced:
    """Arrays that end, or begin, exactly at a page that must not be touched."""

    def __init__(self, shape: tuple[int, ...], at_end: bool) -> None:
        page = mmap.PAGESIZE
        size = 8 * math.prod(shape)
        pages = -(-size // page)
        self.map = mmap.mmap(-1, (pages + 2) * page)
        start = ctypes.addressof(ctypes.c_char.from_buffer(self.map))
        libc = ctypes.CDLL(None, use_errno=True)
        for guard in (start, start + (pages + 1) * page):
            assert libc.mprotect(ctypes.c_void_p(guard), ctypes.c_size_t(page), 0) == 0
        offset = page + (pages * page - size if at_end else 0)
        self.array = np.frombuffer(self.map, dtype=np.float64, count=math.prod(shape), offset=offset).reshape(shape)
        self.array[...] = np.nan


@pytest.mark.skipif(not hasattr(mmap, "PROT_READ"), reason="needs mprotect")
@pytest.mark.parametrize("at_end", [True, False])
def test_no_byte_outside_the_arrays_is_touched(program: Program, at_end: bool) -> None:
    for rows in (*range(1, 2 * program.target.lanes + 2), 200):
        columns = inputs(rows)
        fenced = [Fenced(x.shape, at_end).array for x in columns]
        for place, x in zip(fenced, columns, strict=True):
            place[...] = x
        out = [Fenced((rows, *port.shape), at_end).array for port in program.signature.outputs]
        program.batch(*fenced, out=out)
        assert same(out, program.batch(*columns))


def test_outputs_may_overwrite_inputs(program: Program) -> None:
    """All inputs of a row are read before its outputs are written."""
    x = ex.symbol("x", 4)
    function = ex.Function("turn", [x], [ex.vertcat(x[3], x[0] + x[2], x[1], x[0])])
    signature = Signature("turn", (Port("x", (4,)),), (Port("y", (4,)),))
    compiled = Program(reduce(read(function)), signature, program.target)
    for rows in (1, 5, 8, 19):
        data = np.random.default_rng(0).normal(size=(rows, 4))
        (expected,) = compiled.batch(data)
        assert np.array_equal(compiled.batch(data, out=[data])[0], expected)


def test_a_dead_branch_may_be_nan() -> None:
    x = ex.symbol("x", 1)
    function = ex.Function("f", [x], [ex.if_else(x > 0, ex.log(x), 0) + ex.if_else(x > 0, 0, 1 / x)])
    program = Program(reduce(read(function)), Signature("f", (Port("x"),), (Port("y"),)))
    x = np.array([1.0, 0.5, -2.0, -1e300, 3.0])
    expected = np.where(x > 0, np.log(np.abs(x)), 1 / x)
    assert np.allclose(program.batch(x)[0], expected, rtol=1e-15)


@pytest.mark.row("D2")
@pytest.mark.parametrize("lanes", [2, 4, 8])
def test_lanes_do_not_change_bits(lanes: int) -> None:
    function, signature = example()
    columns = inputs(37)
    columns[0][::5] *= 1e7
    reduced = reduce(read(function))
    expected = Program(reduced, signature).batch(*columns)
    for level in ("", "-avx512f", "-avx512f,+fma"):
        other = target.host(level, lanes)
        if other.fma == target.host().fma:
            assert same(Program(reduced, signature, other).batch(*columns), expected)


@pytest.mark.row("D2")
def test_targets_without_fma_stay_close() -> None:
    function, signature = example()
    columns = inputs(500)
    reduced = reduce(read(function))
    here = Program(reduced, signature).batch(*columns)
    scales = evaluate(reduced, [x.reshape(len(x), -1) for x in columns])
    for level in ("avx2 without fma", "sse2"):
        there = Program(reduced, signature, target.host(LEVELS[level])).batch(*columns)
        for a, b, (_, scale) in zip(here, there, scales, strict=True):
            assert ulps(a.reshape(len(a), -1), b.reshape(len(b), -1), scale).max() <= 2


@pytest.mark.parametrize("level", list(LEVELS))
def test_code_calls_nothing_outside(level: str) -> None:
    signature = Signature("all", (Port("x", (2,)),), (Port("y", (len(UNARY) + len(BINARY),)),))
    x = ex.symbol("x", 2)
    values = [f(x[0]) for f in UNARY.values()] + [f(x[0], x[1]) for f in BINARY.values()]
    machine = target.host(LEVELS[level])
    ir = lower(reduce(read(ex.Function("all", [x], [ex.vertcat(*values)]))), signature, machine)
    called = set(re.findall(r"(?:callq?|jmp)\s+([A-Za-z_][\w@.]*)", target.assembly(ir, machine)))
    assert {name for name in called if not name.startswith("mafsil_")} == set()


@pytest.mark.row("R2")
def test_audit_of_a_mixed_kernel() -> None:
    function, signature = example()
    report = audit(function, signature, inputs(300), exact_rows=30)
    assert report.batch_equals_single
    assert report.undefined == 0
    assert report.worst_ulp <= 4
    assert report.worst_ulp_numpy <= 4
    assert "ulp from mpmath" in str(report)


def test_wrong_ports_are_refused() -> None:
    x = ex.symbol("x", 3)
    tape = read(ex.Function("f", [x], [x]))
    with pytest.raises(KernelError, match="elements"):
        lower(tape, Signature("f", (Port("x", (3,)),), (Port("y", (4,)),)), target.host())


def test_what_does_not_fit_the_stack_is_refused() -> None:
    machine = target.host(lanes=4)
    tape = Tape((Node("const", (), 1.0),), (), ((0,) * (TILE_BYTES // 32 + 1),))
    with pytest.raises(KernelError, match=f"{TILE_BYTES // 32 + 1} numbers"):
        lower(tape, Signature("wide", (), (Port("y", (TILE_BYTES // 32 + 1,)),)), machine)


def test_broken_ir_is_refused() -> None:
    with pytest.raises(KernelError, match="refused"):
        target.compile("define void @f() { nonsense }", target.host())


def test_missing_symbols_are_refused() -> None:
    code = target.compile("define void @f() { ret void }", target.host())
    with pytest.raises(KernelError, match="refused"):
        target.load(code, ("g",))


def test_constants_and_empty_ports() -> None:
    x = ex.symbol("x", 0)
    function = ex.Function("f", [x], [ex.Expression([1.5, -2.0]), ex.Expression(3.0)])
    signature = Signature("f", (Port("x", (0,)),), (Port("y", (2,)), Port("z")))
    program = Program(reduce(read(function)), signature)
    y, z = program.batch(np.zeros((5, 0)))
    assert (y == [1.5, -2.0]).all()
    assert (z == 3.0).all()


@pytest.mark.parametrize("size", [1, 2, 3, 4, 5, 6, 9, 16, 17])
def test_every_width_of_a_port_is_carried_right(program: Program, size: int) -> None:
    x = ex.symbol("x", size)
    signature = Signature("f", (Port("x", (size,)),), (Port("y", (size,)),))
    compiled = Program(reduce(read(ex.Function("f", [x], [3 * x]))), signature, program.target)
    for rows in (1, 5, 8, 16, 21):
        data = np.arange(rows * size, dtype=float).reshape(rows, size)
        assert np.array_equal(compiled.batch(data)[0], 3 * data)


@pytest.mark.parametrize("angles", [9, 20])
def test_more_angles_than_a_vector_holds(program: Program, angles: int) -> None:
    x = ex.symbol("x", angles)
    y = ex.sin(x) + ex.cos(x) + ex.exp(x)
    signature = Signature("f", (Port("x", (angles,)),), (Port("y", (angles,)),))
    data = np.random.default_rng(5).normal(size=(11, angles))
    for tape in (read(ex.Function("f", [x], [y])), reduce(read(ex.Function("f", [x], [ex.cse(y)])))):
        compiled = Program(tape, signature, program.target)
        (found,) = compiled.batch(data)
        assert np.allclose(found, np.sin(data) + np.cos(data) + np.exp(data), rtol=1e-15, atol=1e-15)
        assert all(np.array_equal(compiled.single(row)[0], values) for row, values in zip(data, found, strict=True))


@pytest.mark.parametrize("length", [5, 40])
def test_a_tape_in_pieces_gives_the_same_bits(program: Program, length: int, monkeypatch: pytest.MonkeyPatch) -> None:
    module = importlib.import_module("mafsil.kernels.lower")
    monkeypatch.setattr(module, "segments", functools.partial(segments, length=length))
    function, signature = example()
    tape = reduce(read(function))
    pieces, cells = segments(tape, length)
    assert len(pieces) > 1
    assert cells > 0
    compiled = Program(tape, signature, program.target)
    assert "mafsil_tile.1.1" in compiled.ir
    columns = inputs(21)
    expected = program.batch(*columns)
    assert same(compiled.batch(*columns), expected)
    for row in range(21):
        alone = compiled.single(*(x[row] for x in columns))
        assert all(np.array_equal(a, b[row]) for a, b in zip(alone, expected, strict=True))


def test_pieces_in_place(monkeypatch: pytest.MonkeyPatch) -> None:
    """A piece may write an output that another piece still needs as an input."""
    module = importlib.import_module("mafsil.kernels.lower")
    monkeypatch.setattr(module, "segments", functools.partial(segments, length=2))
    x = ex.symbol("x", 3)
    y = ex.vertcat(x[2], x[0] * x[1], ex.sin(x[0]) + x[2] * x[1])
    compiled = Program(reduce(read(ex.Function("f", [x], [y]))), Signature("f", (Port("x", (3,)),), (Port("y", (3,)),)))
    data = np.random.default_rng(6).normal(size=(9, 3))
    (expected,) = compiled.batch(data)
    assert np.allclose(expected[:, 2], np.sin(data[:, 0]) + data[:, 2] * data[:, 1], rtol=1e-15)
    alone = data[4].copy()
    single = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(compiled.code.single)
    single(alone.ctypes.data, alone.ctypes.data)
    assert np.array_equal(alone, expected[4])


def test_a_module_alone_and_one_that_calls_what_all_share_give_the_same_bits() -> None:
    x = ex.symbol("x", 3)
    tape = reduce(read(ex.Function("f", [x], [ex.vertcat(ex.sin(x), ex.exp(x[0]) * x[1])])))
    signature, machine = Signature("f", (Port("x", (3,)),), (Port("y", (4,)),)), target.host()
    rows = np.random.default_rng(2).normal(0, 3, (37, 3)) * 10.0 ** np.arange(37)[:, None]
    linked = Program(tape, signature)
    alone = Program(tape, signature)
    ir = lower(tape, signature, machine)
    assert all(name in ir and f"declare void @{name}(" not in ir for name in ("mafsil_huge", "mafsil_in_any"))
    code = target.load(target.compile(ir, machine))
    alone._batch = type(alone._batch)(code.batch)
    for streamed in (False, True):
        assert np.array_equal(linked.batch(rows, streamed=streamed), alone.batch(rows, streamed=streamed))
