"""The builtin for one point: what it takes itself, what it hands on, and that it agrees with the batch bit for bit."""

from __future__ import annotations

import gc
import inspect
import pickle
import subprocess
import sys
import threading
import tracemalloc
import warnings
import weakref
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.errors import InputError
from mafsil.kernels import Port, Signature, compile, runtime, ufunc, warm
from tests.reliability import specimens

LINKS = 3


@pytest.fixture(scope="module")
def arm():
    return specimens.kernel(LINKS)


@pytest.fixture
def watched(arm):
    """An arm whose slow path notes that it was taken."""
    seen: list[tuple[tuple[object, ...], dict[str, object]]] = []

    def note(evaluate, *args, **named):
        seen.append((args, named))
        return evaluate(*args, **named)

    k = compile(arm.signature, arm.build, key=arm.key, fallback=note)
    warm([k])  # otherwise the first call of either kind brings its code by the slow path
    return k, seen


def point(rows: int = 1):
    q, shift = specimens.states(LINKS, rows)
    return (q[0], shift[0]) if rows == 1 else (q, shift)


def test_layout_of_this_interpreter_is_known():
    assert runtime.available()
    assert ufunc.available()


@pytest.mark.parametrize("scalar", [float, np.float64, np.array, lambda x: np.array([x])[0]])
def test_plain_points_stay_in_machine_code(watched, scalar):
    k, seen = watched
    q, shift = point()
    answer = k.call(q, scalar(shift))
    assert not seen
    assert specimens.bits(answer) == specimens.bits(tuple(x[0] for x in k(q[None], np.array([shift]))))
    assert [type(x) for x in answer] == [np.ndarray, np.ndarray, np.float64]
    assert all(x.flags.owndata and x.flags.c_contiguous and x.flags.writeable for x in answer[:2])


def test_unpickled_arrays_stay_in_machine_code(watched):
    k, seen = watched
    q, shift = point()
    for protocol in range(2, 6):
        k.call(pickle.loads(pickle.dumps(q, protocol)), shift)
    assert not seen


class Sub(np.ndarray):
    pass


KNOWN = {
    "list": lambda q, s: ((list(q), s), {}),
    "list of Python floats": lambda q, s: ((q.tolist(), s), {}),
    "tuple": lambda q, s: ((tuple(q), s), {}),
    "float32": lambda q, s: ((q.astype(np.float32), s), {}),
    "integers": lambda q, s: (([1, -2, 8], s), {}),
    "negative stride": lambda q, s: ((q[::-1], s), {}),
    "stride": lambda q, s: ((np.repeat(q, 2)[::2], s), {}),
    "stride of float32": lambda q, s: ((np.repeat(q, 2).astype(np.float32)[::2], s), {}),
    "no stride": lambda q, s: ((np.broadcast_to(q[0], (3,)), s), {}),
    "keyword": lambda q, s: ((q,), {"shift": s}),
    "keywords": lambda q, s: ((), {"shift": s, "q": q}),
    "integer scalar": lambda q, s: ((q, 1), {}),
    "batch": lambda q, s: ((q[None], s), {}),
    "batch of two": lambda q, s: ((np.stack([q, -q]), np.array([s, 2 * s])), {}),
    "batch of numbers": lambda q, s: ((q, np.array([s, 2 * s, 3 * s])), {}),
    "one-element array": lambda q, s: ((q, np.array([s])), {}),
    "strided batch": lambda q, s: ((np.linspace(-1, 1, 60).reshape(4, 15)[::-2, ::5], s), {}),
    "one thread": lambda q, s: ((q, s), {"threads": 1}),
    "batch of many by one thread": lambda q, s: ((np.linspace(-1, 1, 900).reshape(300, 3), s), {"threads": 1}),
    "batch of nine by name": lambda q, s: ((), {"q": np.linspace(-1, 1, 27).reshape(9, 3), "shift": s}),
}

UNUSUAL = {
    "integer array": lambda q, s: ((np.array([1, 2, 3]), s), {}),
    "nested lists": lambda q, s: (([list(q), list(q)], s), {}),
    "list of arrays": lambda q, s: (([np.array(x) for x in q], s), {}),
    "large integer": lambda q, s: (([1.0, 2.0, 2**63], s), {}),
    "batch of float32": lambda q, s: ((np.stack([q, q]).astype(np.float32), s), {}),
    "batch of lists": lambda q, s: ((np.stack([q, q]), [s, s]), {}),
    "big endian": lambda q, s: ((q.astype(">f8"), s), {}),
    "unaligned": lambda q, s: ((np.frombuffer(b"x" + q.tobytes(), np.uint8)[1:].view(np.float64), s), {}),
    "subclass": lambda q, s: ((q.view(Sub), s), {}),
    "numpy integer": lambda q, s: ((q, np.int32(1)), {}),
    "two batch dimensions": lambda q, s: ((np.stack([q, q])[:, None], s), {}),
    "batch of one beside two": lambda q, s: ((np.stack([q, q]), np.array([s])), {}),
    "empty batch": lambda q, s: ((np.zeros((0, 3)), s), {}),
    "threads": lambda q, s: ((q, s), {"threads": 2}),
    "one thread in NumPy's integers": lambda q, s: ((q, s), {"threads": np.int64(1)}),
}


def numbers_of(args, named):
    """Both inputs as float64, by name if need be, and their common batch."""
    given = dict(zip(("q", "shift"), args, strict=False)) | named
    q, shift = (np.asarray(given[name], dtype=np.float64) for name in ("q", "shift"))
    batch = np.broadcast_shapes(q.shape[:-1], shift.shape)
    return np.broadcast_to(q, (*batch, LINKS)), np.broadcast_to(shift, batch)


@pytest.mark.parametrize("name", KNOWN)
def test_known_forms_stay_in_machine_code(watched, name):
    """The bits and types are those that NumPy's machinery gives."""
    k, seen = watched
    args, named = KNOWN[name](*point())
    answer = k.call(*args, **named)
    assert not seen
    named.pop("threads", None)
    q, shift = numbers_of(args, named)
    wanted = k.evaluate(np.array(q), np.array(shift))
    assert specimens.bits(answer) == specimens.bits(wanted)
    assert [np.shape(x) for x in answer] == [np.shape(x) for x in wanted]
    assert [type(x) for x in answer] == [type(x) for x in wanted]
    for a, b in zip(answer, specimens.reference(LINKS, 0, q, shift), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-13)


@pytest.mark.parametrize("name", UNUSUAL)
def test_everything_else_goes_the_slow_path(watched, name):
    k, seen = watched
    args, named = UNUSUAL[name](*point())
    answer = k.call(*args, **named)
    assert len(seen) == 1
    assert seen[0][1].keys() == named.keys()
    assert all(a is b for a, b in zip(seen[0][0], args, strict=True))
    q, shift = numbers_of(args, {})
    for a, b in zip(answer, specimens.reference(LINKS, 0, q, shift), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-13)


@pytest.mark.parametrize("rows", [1, 2, 3, 4, 7, 8, 9, 31, 64, 65, 1000])
def test_small_batches_give_the_bits_of_points_and_keep_bad_rows(watched, rows):
    k, seen = watched
    q, shift = point(max(rows, 2))
    q, shift = q[:rows].copy(), shift[:rows].copy()
    alone = [k.call(q[i], shift[i]) for i in range(rows)]
    want = b"".join(np.stack([a[port] for a in alone]).tobytes() for port in range(3))
    assert specimens.bits(k.call(q, shift)) == want
    assert specimens.bits(k.call(np.asfortranarray(q), shift)) == want
    q[rows // 2, 1] = np.nan
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        spoilt = k.call(q, shift)
    assert not seen
    others = np.arange(rows) != rows // 2
    assert np.isnan(spoilt[0][rows // 2]).any()
    assert all((a[others] == np.stack([b[port] for b in alone])[others]).all() for port, a in enumerate(spoilt))


@pytest.fixture
def watched_squares():
    seen: list[object] = []

    def note(evaluate, *args, **named):
        seen.append(args)
        return evaluate(*args, **named)

    ports = Signature("squares", (Port("x", (5,)),), (Port("y", (5,)),))
    k = compile(ports, partial(squares, 5), key="squares 5", fallback=note)
    warm([k])
    return k, seen


@pytest.mark.parametrize("shape", [(5,), (1, 5), (2, 5), (9, 5)])
def test_results_of_the_caller_are_written_in_machine_code(watched_squares, shape):
    k, seen = watched_squares
    x = np.random.default_rng(1).normal(size=shape)
    out = np.full(shape, np.nan)
    count = sys.getrefcount(out)
    assert k.call(x, out=out) is out
    assert (out == x * x).all()
    out[...] = np.nan
    assert k.call(out=out, x=x) is out
    assert k.call(x.tolist() if x.ndim == 1 else x, out=out) is out
    assert (out == x * x).all()
    assert sys.getrefcount(out) == count
    assert not seen
    assert (k.call(x, out=None) == out).all()


def test_a_point_may_be_written_over_itself(watched_squares):
    k, seen = watched_squares
    memory = np.arange(7.0)
    wanted = memory[1:6] ** 2
    k.call(memory[1:6], out=memory[:5])
    assert (memory[:5] == wanted).all()
    assert not seen


def test_overlapping_batches_are_left_to_numpy(watched_squares):
    k, seen = watched_squares
    for source, target in (((1, 5), (0, 4)), ((0, 4), (1, 5)), ((0, 4), (0, 4))):
        memory = np.random.default_rng(2).normal(size=(5, 5))
        wanted = memory[slice(*source)] ** 2
        k.call(memory[slice(*source)], out=memory[slice(*target)])
        assert (memory[slice(*target)] == wanted).all()
    assert len(seen) == 3


def test_unfit_results_of_the_caller_are_named_and_not_touched(watched_squares):
    k, _ = watched_squares
    x = np.arange(5.0)
    frozen = np.zeros(5)
    frozen.setflags(write=False)
    for out, sentence in (
        (np.zeros(4), r"out \(y\): expected shape \(5,\), got \(4,\)"),
        (np.zeros((1, 5)), r"out \(y\): expected shape \(5,\), got \(1, 5\)"),
        (frozen, "writable float64"),
        (np.zeros(5, np.float32), "writable float64"),
        ([0.0] * 5, "writable float64"),
    ):
        with pytest.raises(InputError, match=sentence):
            k.call(x, out=out)
        assert not np.any(out)
    out = np.full(5, 7.0)
    with pytest.raises(InputError, match=r"x: nan at index \(2,\)"):
        k.call([0.0, 1.0, np.nan, 2.0, 3.0], out=out)
    assert (out == 7.0).all()
    with pytest.raises(InputError, match=r"out \(y\): expected shape \(3, 5\), got \(2, 5\)"):
        k.call(np.zeros((3, 5)), out=np.zeros((2, 5)))
    strided = np.zeros((5, 2))[:, 0]
    assert k.call(x, out=strided) is strided
    assert (strided == x * x).all()


@pytest.mark.parametrize(
    ("args", "named", "sentence"),
    [
        (([1.0, 2.0],), {}, r"x: .* got \(2,\)"),
        (([1.0, "2", 3.0, 4.0, 5.0],), {}, "x: expected real numbers"),
        (([1.0, None, 3.0, 4.0, 5.0],), {}, "x: expected real numbers"),
        (([1.0, float("inf"), 3.0, 4.0, 5.0],), {}, r"x: inf at index \(1,\)"),
        ((), {"y": np.zeros(5)}, "got 0, y"),
        ((np.zeros(5),), {"x": np.zeros(5)}, "got 1, x"),
        ((np.zeros(5), np.zeros(5)), {}, "got 2"),
        ((), {}, "got 0"),
        ((), {"out": np.zeros(5)}, "got 0"),
        ((np.zeros(5),), {"frame": "x"}, "got 1, frame"),
        ((np.zeros((3, 4)),), {}, r"x: .* got \(3, 4\)"),
    ],
)
def test_wrong_calls_are_named_in_every_form(watched_squares, args, named, sentence):
    with pytest.raises(InputError, match=sentence):
        watched_squares[0].call(*args, **named)


def test_names_made_at_run_time_are_names(arm):
    q, shift = point()
    named = {"".join(["sh", "ift"]): shift, "".join(["", "q"]): q}
    assert specimens.bits(arm.call(**named)) == specimens.bits(arm.call(q, shift))


@pytest.mark.parametrize("index", range(LINKS))
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_none_leave_the_fast_path(watched, index, value):
    k, seen = watched
    q, shift = point()
    q = q.copy()
    q[index] = value
    with pytest.raises(ValueError, match=rf"q: .* index \({index},\)"):
        k.call(q, shift)
    with pytest.raises(ValueError, match="shift"):
        k.call(point()[0], float(value))
    assert len(seen) == 2


def squares(size: int):
    import mafsil.expression as ex

    x = ex.symbol("x", size)
    return ex.Function("squares", [x], [x * x], ["x"], ["y"])


@pytest.mark.parametrize("size", [1, 2, 3, 4, 5, 7, 8, 9, 63, 64, 65, 70, 130])
def test_every_element_of_every_length_is_watched(size):
    k = compile(
        Signature("squares", (Port("x", (size,)),), (Port("y", (size,)),)),
        partial(squares, size),
        key=f"squares {size}",
    )
    x = np.linspace(-2.0, 2.0, size)
    assert (k.call(x) == x * x).all()
    for index in range(size):
        bad = x.copy()
        bad[index] = np.nan
        with pytest.raises(ValueError, match=rf"\({index},\)"):
            k.call(bad)


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False, width=64), min_size=4, max_size=4))
@settings(max_examples=200, deadline=None)
def test_finite_numbers_of_any_size_pass(values):
    k = compile(Signature("squares", (Port("x", (4,)),), (Port("y", (4,)),)), partial(squares, 4), key="squares 4")
    x = np.array(values)
    with np.errstate(over="ignore", under="ignore"):
        assert (k.call(x) == x * x).all()


def test_calling_conventions_of_the_interpreter(arm):
    """Vectorcall flags, star arguments, map, partial and bound attributes all reach the same machine code."""
    q, shift = point()
    plain = specimens.bits(arm.call(q, shift))

    class Holder:
        method = arm.call

    ways = [
        arm.call(*[q, shift]),
        next(map(arm.call, [q], [shift])),
        partial(arm.call, q)(shift),
        Holder().method(q, shift),
        arm.call(*(q,), **{"shift": shift}),
        arm.call.__call__(q, shift),
        arm(q, shift),
    ]
    assert {specimens.bits(way) for way in ways} == {plain}


def test_it_documents_itself(arm):
    assert arm.call.__name__ == "planar_arm"
    assert arm.call.__doc__ == "Tip pose, Jacobian and reach of a planar arm."
    assert list(inspect.signature(arm.call).parameters) == ["q", "shift", "out", "threads"]


def test_it_holds_its_code_alive():
    k = compile(Signature("squares", (Port("x", (5,)),), (Port("y", (5,)),)), partial(squares, 5), key="alive")
    builtin, gufunc = k.call, k.ufunc
    image = weakref.ref(k.image)
    del k
    gc.collect()
    assert image() is not None
    assert (builtin(np.arange(5.0)) == np.arange(5.0) ** 2).all()
    del builtin
    gc.collect()
    assert image() is not None
    assert (gufunc(np.ones((2, 5))) == 1.0).all()
    del gufunc
    gc.collect()
    assert image() is None


def test_no_references_are_lost_or_leaked(arm):
    q, shift = point()
    answers = [arm.call(q, shift) for _ in range(3)]
    assert [sys.getrefcount(x) for x in answers[0]] == [sys.getrefcount(x) for x in answers[2]]
    before = sys.getrefcount(q), sys.getrefcount(np.dtype(np.float64)), sys.getrefcount(shift)
    kept = [arm.call(q, shift) for _ in range(1000)]
    del kept
    after = sys.getrefcount(q), sys.getrefcount(np.dtype(np.float64)), sys.getrefcount(shift)
    assert all(abs(a - b) < 20 for a, b in zip(before, after, strict=True))


@pytest.mark.row("C1")
def test_threads_share_the_builtin(arm):
    q, shift = point(64)
    serial = [specimens.bits(arm.call(q[i], shift[i])) for i in range(64)]
    wrong: list[int] = []

    def work() -> None:
        wrong.append(sum(specimens.bits(arm.call(q[i % 64], shift[i % 64])) != serial[i % 64] for i in range(2000)))

    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == [0] * 8


def test_other_threads_have_the_interpreter_while_a_batch_runs(arm):
    """They get it only from a thread that lets it go: this test's own never has to."""
    q, shift = point(4000)
    want = specimens.bits(arm.call(q, shift))
    came: list[bool] = []
    begin = threading.Event()

    def come() -> None:
        begin.wait()
        came.append(True)

    usual = sys.getswitchinterval()
    sys.setswitchinterval(1000.0)
    try:
        waiting = threading.Thread(target=come)
        waiting.start()
        begin.set()
        turns = 0
        while not came and turns < 100_000:
            answer = arm.call(q, shift)
            turns += 1
        waiting.join()
    finally:
        sys.setswitchinterval(usual)
    assert 0 < turns < 100_000
    assert specimens.bits(answer) == want


def test_threads_share_batches(arm):
    q, shift = point(600)
    want = specimens.bits(arm.call(q, shift))
    wrong: list[int] = []

    def work() -> None:
        wrong.append(sum(specimens.bits(arm.call(q, shift)) != want for _ in range(300)))

    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == [0] * 8


@pytest.mark.skipif(sys.platform != "linux", reason="sets the control word through the C library")
def test_flush_to_zero_and_rounding_of_others_change_nothing(arm):
    """A library that leaves flush-to-zero or another rounding direction behind does not change a bit of ours."""
    code = """
import ctypes, numpy as np
from functools import partial
from tests.kernels.test_call_fast import squares
from mafsil.kernels import compile, Port, Signature
k = compile(Signature("squares", (Port("x", (4,)),), (Port("y", (4,)),)), partial(squares, 4), key="squares 4")
x = np.array([1e-155, 3.1e-160, 1 / 3, -1e-154])
want = [k.call(x).tobytes(), k(x[None])[0].tobytes()]
fenv = ctypes.create_string_buffer(64)
m = ctypes.CDLL("libm.so.6")
for direction in (0x400, 0x800, 0xC00):
    assert m.fesetround(direction) == 0
    got = [k.call(x).tobytes(), k(x[None])[0].tobytes()]
    left = m.fegetround()
    m.fesetround(0)
    assert got == want and left == direction, direction
m.fegetenv(fenv)
word = int.from_bytes(fenv.raw[28:32], "little")
fenv[28:32] = (word | 0x8040).to_bytes(4, "little")
m.fesetenv(fenv)
got = [k.call(x).tobytes(), k(x[None])[0].tobytes()]
fenv[28:32] = word.to_bytes(4, "little")
m.fesetenv(fenv)
assert got == want
assert want[0] == want[1]
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_other_layouts_take_the_plain_path(arm, monkeypatch):
    """Where the self-tests fail, the same numbers come from plain Python."""
    monkeypatch.setattr(runtime, "available", lambda: False)
    monkeypatch.setattr(ufunc, "available", lambda: False)
    k = compile(arm.signature, arm.build, key=arm.key)
    assert isinstance(k.ufunc, ufunc.PlainLoop)
    q, shift = specimens.states(LINKS, 12)
    for args in ((q[0], shift[0]), (q, shift), (q[::-2], shift[::-2]), (q.reshape(3, 4, 3), shift[:4]), (q[:0], 1.0)):
        for a, b in zip(k(*args), arm(*args), strict=True):
            assert type(a) is type(b)
            assert np.shape(a) == np.shape(b)
            assert specimens.bits(a) == specimens.bits(b)
    out = tuple(np.empty_like(x) for x in arm(q, shift))
    assert k(q, shift, out=out)[0] is out[0]
    assert specimens.bits(out) == specimens.bits(arm(q, shift))


def test_self_test_notices_a_foreign_layout(monkeypatch):
    for name in (
        "ARRAY_FLAGS",
        "ARRAY_NDIM",
        "ARRAY_SHAPE",
        "ARRAY_STRIDES",
        "LIST_ITEMS",
        "SIZE",
        "ARRAY_DTYPE",
        "ARRAY_DATA",
        "DTYPE_NUMBER",
        "FLOAT_VALUE",
    ):
        with monkeypatch.context() as patch:
            patch.setattr(runtime, name, getattr(runtime, name) + (8 if name != "ARRAY_FLAGS" else 4))
            assert not runtime._same_layout(), name


class Halves(tuple[np.ndarray, np.ndarray]):
    """An answer whose members have names and whose length says something else."""

    __slots__ = ()

    @property
    def low(self):
        return self[0]

    def __len__(self):
        return 1


def halves():
    import mafsil.expression as ex

    x = ex.symbol("x", 2)
    return ex.Function("halves", [x], [x - 1, ex.sqrt(x)], ["x"], ["low", "root"])


def test_results_of_a_point_come_as_the_class_of_answers():
    ports = (Port("low", (2,)), Port("root", (2,)))
    k = compile(Signature("halves", (Port("x", (2,)),), ports), halves, key="halves", answer=Halves)
    warm([k])
    for call in (k.call, pickle.loads(pickle.dumps(k)).call):
        for x in (np.array([-1.0, 4.0]), [-1, 4]):
            found = call(x)
            assert type(found) is Halves
            assert (found.low == [-2.0, 3.0]).all()
            assert len(found) == 1
            assert found[1][1] == 2.0
        assert type(pickle.loads(pickle.dumps(found))) is Halves
        # Not a number at the very end, and batches, are for the caller to look at.
        assert type(call(np.array([4.0, -1.0]))) is tuple
        assert type(call(np.ones((2, 2)))) is tuple
    x, counted = np.array([4.0, -1.0]), np.dtype(np.float64)
    before = sys.getrefcount(x), sys.getrefcount(counted), sys.getrefcount(Halves)
    tracemalloc.start()
    for _ in range(2000):
        k.call(x)
        k.call(x[::-1].copy())
    kept = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    after = sys.getrefcount(x), sys.getrefcount(counted), sys.getrefcount(Halves)
    assert all(abs(a - b) < 20 for a, b in zip(before, after, strict=True))
    assert kept < 20_000
