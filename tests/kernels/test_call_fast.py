"""The builtin for one point: what it takes itself, what it hands on, and that it agrees with the batch bit for bit."""

from __future__ import annotations

import gc
import inspect
import pickle
import subprocess
import sys
import threading
import weakref
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.kernels import Port, Signature, compile, runtime, ufunc
from tests.reliability import specimens

LINKS = 3


@pytest.fixture(scope="module")
def arm():
    return specimens.kernel(LINKS)


@pytest.fixture
def watched(arm):
    """An arm whose slow road notes that it was taken."""
    seen: list[tuple[tuple[object, ...], dict[str, object]]] = []

    def note(evaluate, *args, **named):
        seen.append((args, named))
        return evaluate(*args, **named)

    k = compile(arm.signature, arm.build, key=arm.key, fallback=note)
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


UNUSUAL = {
    "list": lambda q, s: ((list(q), s), {}),
    "float32": lambda q, s: ((q.astype(np.float32), s), {}),
    "integer": lambda q, s: (([1, 2, 3], s), {}),
    "big endian": lambda q, s: ((q.astype(">f8"), s), {}),
    "negative stride": lambda q, s: ((q[::-1], s), {}),
    "stride": lambda q, s: ((np.repeat(q, 2)[::2], s), {}),
    "unaligned": lambda q, s: ((np.frombuffer(b"x" + q.tobytes(), np.uint8)[1:].view(np.float64), s), {}),
    "subclass": lambda q, s: ((q.view(Sub), s), {}),
    "keyword": lambda q, s: ((q,), {"shift": s}),
    "batch": lambda q, s: ((q[None], s), {}),
    "integer scalar": lambda q, s: ((q, 1), {}),
    "numpy integer": lambda q, s: ((q, np.int32(1)), {}),
    "one-element array": lambda q, s: ((q, np.array([s])), {}),
    "empty batch": lambda q, s: ((np.zeros((0, 3)), s), {}),
    "threads": lambda q, s: ((q, s), {"threads": 2}),
}


@pytest.mark.parametrize("name", UNUSUAL)
def test_everything_else_goes_the_slow_road(watched, name):
    k, seen = watched
    args, named = UNUSUAL[name](*point())
    answer = k.call(*args, **named)
    assert len(seen) == 1
    assert seen[0][1].keys() == named.keys()
    assert all(a is b for a, b in zip(seen[0][0], args, strict=True))
    q, shift = (np.asarray(x, dtype=np.float64) for x in (*args, *named.values())[:2])
    q = np.broadcast_to(q, (*np.broadcast_shapes(q.shape[:-1], shift.shape), LINKS))
    for a, b in zip(answer, specimens.reference(LINKS, 0, q, shift), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-13)


@pytest.mark.parametrize("index", range(LINKS))
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_none_leave_the_fast_road(watched, index, value):
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
    import casadi as ca

    x = ca.SX.sym("x", size)
    return ca.Function("squares", [x], [x * x], ["x"], ["y"])


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


def test_other_layouts_take_the_plain_road(arm, monkeypatch):
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
        "ARRAY_DTYPE",
        "ARRAY_DATA",
        "DTYPE_NUMBER",
        "FLOAT_VALUE",
    ):
        with monkeypatch.context() as patch:
            patch.setattr(runtime, name, getattr(runtime, name) + (8 if name != "ARRAY_FLAGS" else 4))
            assert not runtime._same_layout(), name
