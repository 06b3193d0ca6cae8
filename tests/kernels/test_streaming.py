"""Results past the caches: the bits of plain stores and nothing else written, whatever size, place, stride and tail."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil.expression as ex
from mafsil.kernels import Port, Signature, compile, result_memory, small_batch, target
from mafsil.kernels.audit import Program
from mafsil.kernels.lower import lower
from mafsil.kernels.reduce import reduce
from mafsil.kernels.streaming import LINE, STREAM, pitch, stage_size, streams
from mafsil.kernels.tape import read

LEVELS = {8: "", 4: "-avx512f", 2: "-sse3,-ssse3,-sse4.1,-sse4.2,-avx"}
UNTOUCHED = -7.0
HERE = target.host().triple
pytestmark = pytest.mark.skipif(not streams(HERE), reason="no stores past the caches on this processor")


def spread(sizes: tuple[int, ...]) -> ex.Function:
    """Outputs of these sizes, every element different."""
    x = ex.symbol("x", 3)
    outputs = [ex.vertcat(*(x[k % 3] * (k + 1) + port for k in range(size))) for port, size in enumerate(sizes)]
    return ex.Function("spread", [x], outputs)


def ports(sizes: tuple[int, ...]) -> Signature:
    return Signature("spread", (Port("x", (3,)),), tuple(Port(f"y{k}", (size,)) for k, size in enumerate(sizes)))


@cache
def program(sizes: tuple[int, ...], lanes: int) -> Program:
    return Program(reduce(read(spread(sizes))), ports(sizes), target.host(LEVELS[lanes]))


def placed(rows: int, size: int, offset: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows that begin `offset` doubles behind a page's begin, and the memory around them, which must stay untouched."""
    around = np.full(rows * size + 1600, UNTOUCHED)
    skip = (-around.ctypes.data % 4096) // 8 + offset
    return around[skip : skip + rows * size].reshape(rows, size), around


def bits(x: np.ndarray) -> bytes:
    return np.ascontiguousarray(x).tobytes()


@given(
    sizes=st.sampled_from([(1,), (2,), (3,), (7,), (8,), (16,), (42,), (49,), (512,), (1,) * 3, (16, 42), (512, 5)]),
    lanes=st.sampled_from([8, 4, 2]),
    rows=st.integers(0, 70),
    offsets=st.lists(st.integers(0, 9), min_size=3, max_size=3),
    seed=st.integers(0, 9),
)
@settings(max_examples=250, deadline=None)
def test_staged_rows_have_the_bits_of_plain_stores(sizes, lanes, rows, offsets, seed) -> None:
    """Every size, every number of rows beyond whole tiles, every place within a line, NaN and infinities among them."""
    code = program(sizes, lanes)
    random = np.random.default_rng(seed)
    x = random.choice([0.0, -0.0, np.nan, -np.inf, np.inf, 5e-324, 1.5], (rows, 3))
    x = np.where(random.random((rows, 3)) < 0.3, x, random.normal(size=(rows, 3)))
    plain = [np.full((rows, size), np.nan) for size in sizes]
    code.call([x, *plain], rows)
    staged = [placed(rows, size, offset) for size, offset in zip(sizes, offsets, strict=False)]
    code.call([x, *(array for array, _ in staged)], rows, data=1)
    for want, (found, around) in zip(plain, staged, strict=True):
        assert bits(found) == bits(want)
        assert (around == UNTOUCHED).sum() >= around.size - found.size
        found[...] = UNTOUCHED
        assert (around == UNTOUCHED).all()


@pytest.mark.parametrize("lanes", LEVELS)
@pytest.mark.parametrize("size", [5, 16, 512])
def test_rows_that_are_not_side_by_side_are_written_plainly(size: int, lanes: int) -> None:
    code = program((size,), lanes)
    x = np.random.default_rng(size).normal(size=(3 * lanes + 1, 3))
    (want,) = code.batch(x)
    for apart, step in ((size + 3, 1), (2 * size, 2)):
        wide = np.full((len(x), apart), UNTOUCHED)
        code.batch(x, out=[wide[:, : size * step : step]], streamed=True)
        assert bits(wide[:, : size * step : step]) == bits(want)
        assert (wide == UNTOUCHED).sum() == wide.size - want.size
    upward = np.full((len(x), size), UNTOUCHED)
    code.batch(x[::-1], out=[upward[::-1]], streamed=True)
    assert bits(upward) == bits(want)


def test_huge_rows() -> None:
    """Rows as long as those of a tree's derivatives, more than the nearest cache holds."""
    code = program((3 * 1024,), 8)
    x = np.random.default_rng(0).normal(size=(37, 3))
    for offset in (0, 1, 2, 7):
        found, around = placed(37, 3 * 1024, offset)
        code.call([x, found], 37, data=1)
        assert bits(found) == bits(code.batch(x)[0])
        assert (around != UNTOUCHED).sum() == found.size


@pytest.mark.parametrize("size", [1, 7, 8, 16, 42, 49, 64, 128, 512, 1024, 3072])
@pytest.mark.parametrize("width", [2, 4, 8])
def test_staged_rows_do_not_meet_in_one_set_of_the_nearest_cache(size: int, width: int) -> None:
    port = Port("y", (size,))
    apart = pitch(port, width)
    assert apart in (8 * size, 8 * size + LINE)
    assert 8 * stage_size(port, width) >= LINE + width * apart
    if 8 * size >= LINE:
        sets = [row * apart // LINE % 64 for row in range(width)]
        assert max(map(sets.count, sets)) <= 2


@pytest.mark.parametrize(
    "triple", ["aarch64-unknown-linux-gnu", "wasm32-unknown-unknown", "riscv64-unknown-elf", "thumbv7em-none-eabi"]
)
def test_other_processors_have_no_trace_of_it(triple: str) -> None:
    """Their modules do without the stores and fences of x86-64, and are accepted by their back ends."""
    machine = target.describe_target(triple, "", "")
    ir = lower(reduce(read(spread((9,)))), ports((9,)), machine)
    assert not re.search(rf"{STREAM}|nontemporal|x86", ir)
    assert target.translate(ir, machine, "object")


def test_the_instructions_are_there() -> None:
    machine = target.host()
    text = target.assembly(lower(reduce(read(spread((42,)))), ports((42,)), machine), machine)
    assert re.search(r"movnt(pd|ps|dq|i)", text)
    assert "sfence" in text


@pytest.fixture
def large(monkeypatch: pytest.MonkeyPatch):
    """A kernel whose results of a few kilobytes count as large, in memory and for the caches."""
    monkeypatch.setattr(result_memory, "SMALLEST", 4096)
    monkeypatch.setattr(result_memory, "last_level", lambda: 8192)
    monkeypatch.setattr(small_batch, "HANDED_OVER_NS", 300)
    result_memory.release()
    yield compile(ports((16, 42)), lambda: spread((16, 42)), key="spread 16 42")
    result_memory.release()


@pytest.mark.parametrize("threads", [1, 2, 5])
@pytest.mark.parametrize("shape", [(1000,), (40, 31), (3, 7, 50)])
def test_large_batches_have_the_bits_of_small_ones(large, threads: int, shape: tuple[int, ...]) -> None:
    x = np.random.default_rng(1).normal(size=(*shape, 3))
    rows = [large(row) for row in x.reshape(-1, 3)]
    want = [np.stack([row[port] for row in rows]).reshape(*shape, -1) for port in (0, 1)]
    for _ in range(3):  # fresh pages, then written ones
        answer = large(x, threads=threads)
        assert [bits(a) for a in answer] == [bits(w) for w in want]
        del answer
    out = tuple(np.full_like(w, np.nan) for w in want)
    assert large(x, out=out, threads=threads)[0] is out[0]
    assert [bits(a) for a in out] == [bits(w) for w in want]
    wide = tuple(np.full((*shape, size + 5), UNTOUCHED)[..., 2:-3] for size in (16, 42))
    large(x, out=wide, threads=threads)
    assert [bits(a) for a in wide] == [bits(w) for w in want]
    assert (wide[0].base == UNTOUCHED).sum() == wide[0].base.size - wide[0].size


def test_a_result_over_its_own_argument(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(result_memory, "SMALLEST", 4096)
    monkeypatch.setattr(result_memory, "last_level", lambda: 4096)
    x = ex.symbol("x", 3)
    k = compile(
        Signature("turned", (Port("x", (3,)),), (Port("y", (3,)),)),
        lambda: ex.Function("turned", [x], [ex.vertcat(x[2], x[0], 2 * x[1])]),
        key="turned",
    )
    a = np.random.default_rng(2).normal(size=(1000, 3))
    want = np.stack([a[:, 2], a[:, 0], 2 * a[:, 1]], axis=1)
    shifted = np.vstack([a, a[:5]])
    assert (k(shifted[:1000], out=shifted[5:]) == want).all()
    assert (k(a, out=a) == want).all()
