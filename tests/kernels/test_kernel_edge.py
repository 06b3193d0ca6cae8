"""The edge of a kernel: shapes, types, batches, results of the caller, bad rows, threads."""

from __future__ import annotations

import warnings
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.errors import InputError
from mafsil.kernels import Port, Signature, batch, compile, small_batch
from tests.reliability import specimens

LINKS = 3


@pytest.fixture(scope="module")
def arm():
    return specimens.kernel(LINKS)


@pytest.fixture
def eager(monkeypatch):
    """Every batch of two rows or more is split."""
    monkeypatch.setattr(small_batch, "HANDED_OVER_NS", 3)


def same(a, b) -> bool:
    return specimens.bits(a) == specimens.bits(b) and all(x.shape == y.shape for x, y in zip(a, b, strict=True))


@pytest.mark.parametrize("q_batch", [(), (1,), (4,), (3, 1), (2, 3, 4), (0,), (3, 0)])
@pytest.mark.parametrize("s_batch", [(), (1,), (4,), (3, 4)])
def test_batches_broadcast(arm, q_batch, s_batch):
    random = np.random.default_rng(3)
    q, shift = random.uniform(-3, 3, (*q_batch, LINKS)), random.uniform(-1, 1, s_batch)
    try:
        shape = np.broadcast_shapes(q_batch, s_batch)
    except ValueError:
        with pytest.raises(InputError, match="do not broadcast"):
            arm(q, shift)
        return
    answer = arm(q, shift)
    assert [np.shape(x) for x in answer] == [(*shape, 4, 4), (*shape, 2, LINKS), shape]
    full = specimens.reference(LINKS, 0, np.broadcast_to(q, (*shape, LINKS)), np.broadcast_to(shift, shape))
    for a, b in zip(answer, full, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-13)


@given(
    st.integers(1, 70), st.integers(1, 4), st.sampled_from(["C", "F", "reversed", "strided", "broadcast"]), st.data()
)
@settings(max_examples=60, deadline=None)
def test_every_row_is_computed_as_if_alone(rows, threads, layout, data):
    arm = specimens.kernel(LINKS)
    q, shift = specimens.states(LINKS, rows, rows)
    q = {
        "C": lambda: q,
        "F": lambda: np.asfortranarray(q),
        "reversed": lambda: q[::-1].copy()[::-1],
        "strided": lambda: np.repeat(np.repeat(q, 2, 0), 3, 1)[::2, ::3],
        "broadcast": lambda: np.broadcast_to(q[0], q.shape),
    }[layout]()
    before, small_batch.HANDED_OVER_NS = small_batch.HANDED_OVER_NS, data.draw(st.sampled_from([3, 40, 10**6]))
    try:
        answer = arm(q, shift, threads=threads)
    finally:
        small_batch.HANDED_OVER_NS = before
    alone = [arm.call(np.ascontiguousarray(q[i]), shift[i]) for i in range(rows)]
    assert specimens.bits(answer) == b"".join(np.stack([a[port] for a in alone]).tobytes() for port in range(3))


@pytest.mark.parametrize("threads", [1, 2, 8])
@pytest.mark.parametrize("shape", [(50,), (50, 3), (3, 50), (2, 5, 7), (1, 33)])
def test_splitting_changes_no_bit(arm, eager, threads, shape):
    random = np.random.default_rng(5)
    q, shift = random.uniform(-3, 3, (*shape, LINKS)), random.uniform(-1, 1, shape[-1:])
    whole = arm.ufunc(q, shift)
    assert same(arm(q, shift, threads=threads), whole)
    out = tuple(np.full_like(x, np.nan) for x in whole)
    assert arm(q, shift, threads=threads, out=out)[0] is out[0]
    assert same(out, whole)
    striped = tuple(np.full((2 * x.shape[0], *x.shape[1:]), 7.0)[::2] for x in whole)
    assert same(arm(q, shift, out=striped, threads=threads), whole)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_bad_row_spoils_itself_only(arm, eager, bad):
    q, shift = specimens.states(LINKS, 100)
    clean = arm(q, shift)
    spoiled = q.copy()
    rows = np.zeros(100, dtype=bool)
    rows[[0, 3, 7, 8, 50, 99]] = True
    spoiled[rows, 1] = bad
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        answer = arm(spoiled, shift)
        through_ufunc = arm.ufunc(spoiled, shift)
    for a, u, c in zip(answer, through_ufunc, clean, strict=True):
        assert (a[~rows] == c[~rows]).all()
        assert np.isnan(a[rows]).reshape(rows.sum(), -1).any(axis=1).all()
        assert (np.isnan(a) == np.isnan(u)).all()


def test_results_over_arguments_are_ordered():
    k = compile(Signature("roll", (Port("x", (3,)),), (Port("y", (3,)),)), roll, key="roll")
    rows = 5000
    x = np.arange(3.0 * rows).reshape(rows, 3)
    want = k(x)
    memory = np.empty((rows + 1, 3))
    for source, result in ((memory[1:], memory[:-1]), (memory[:-1], memory[1:]), (memory[1:], memory[1:])):
        source[...] = x
        before, small_batch.HANDED_OVER_NS = small_batch.HANDED_OVER_NS, 10
        try:
            k(source, out=result, threads=4)
        finally:
            small_batch.HANDED_OVER_NS = before
        assert (result == want).all()


def roll():
    import mafsil.expression as ex

    x = ex.symbol("x", 3)
    return ex.Function("roll", [x], [ex.vertcat(x[1] * 2, x[2] * 2, x[0] + 1)], ["x"], ["y"])


WRONG = {
    "short": (lambda q, s: ((q[:2], s), {}), r"q: expected shape \(\*batch, 3\), got \(2,\)"),
    "long": (lambda q, s: ((np.zeros(4), s), {}), r"q: .* got \(4,\)"),
    "one for all": (lambda q, s: (([0.1], s), {}), r"q: .* got \(1,\)"),
    "number for a vector": (lambda q, s: ((0.1, s), {}), r"q: .* got \(\)"),
    "text": (lambda q, s: (("abc", s), {}), "q: expected real numbers, got str"),
    "complex": (lambda q, s: ((q + 0j, s), {}), "q: expected real numbers"),
    "object": (lambda q, s: (([None] * 3, s), {}), "q: expected real numbers"),
    "ragged": (lambda q, s: (([[1, 2], [3]], s), {}), "q: its rows have different lengths"),
    "masked": (lambda q, s: ((np.ma.array(q), s), {}), "q: expected real numbers, got masked"),
    "boolean": (lambda q, s: ((np.ones(3, bool), s), {}), "q: expected real numbers"),
    "none": (lambda q, s: ((None, s), {}), "q: expected real numbers"),
    "nan": (lambda q, s: (([0, np.nan, 0], s), {}), r"q: nan at index \(1,\)"),
    "infinite scalar": (lambda q, s: ((q, np.inf), {}), r"shift: inf is not a finite number"),
    "missing": (lambda q, s: ((q,), {}), "planar_arm takes q, shift; got 1"),
    "too many": (lambda q, s: ((q, s, s), {}), "planar_arm takes q, shift; got 3"),
    "twice": (lambda q, s: ((q, s), {"q": q}), "planar_arm takes q, shift; got 2, q"),
    "unknown": (lambda q, s: ((q,), {"shfit": s}), "got 1, shfit"),
    "few outs": (lambda q, s: ((q, s), {"out": np.zeros((4, 4))}), r"out needs 3 array\(s\), got 1"),
    "no outs": (lambda q, s: ((q, s), {"out": (1, 2, 3)}), "writable float64"),
    "zero threads": (lambda q, s: ((q, s), {"threads": 0}), "threads: expected a positive number, got 0"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_input_is_named(arm, name):
    make, sentence = WRONG[name]
    args, named = make(*(x[0] for x in specimens.states(LINKS, 1)))
    with pytest.raises(InputError, match=sentence):
        arm(*args, **named)


def test_wrong_results_are_refused(arm):
    q, shift = specimens.states(LINKS, 4)
    good = arm(q, shift)
    frozen = np.zeros((4, 4, 4))
    frozen.setflags(write=False)
    for first in (frozen, np.zeros((4, 4, 4), np.float32), np.zeros((4, 4, 4)).tolist()):
        with pytest.raises(InputError, match=r"out \(T\).*writable"):
            arm(q, shift, out=(first, *good[1:]))
    with pytest.raises(InputError, match=r"out \(J\): expected shape \(4, 2, 3\), got \(5, 2, 3\)"):
        arm(q, shift, out=(good[0], np.zeros((5, 2, 3)), good[2]))


def test_single_precision_is_widened_first(arm):
    q, shift = specimens.states(LINKS, 9)
    narrow = q.astype(np.float32), shift.astype(np.float32)
    assert same(arm(*narrow), arm(*(x.astype(np.float64) for x in narrow)))
    assert arm(*narrow)[0].dtype == np.float64


def test_matrices_of_rank_two_and_three():
    for shape in ((2, 3), (2, 2, 2)):
        size = int(np.prod(shape))
        k = compile(
            Signature("affine", (Port("A", shape),), (Port("B", shape),)), partial(affine, size), key=f"affine {shape}"
        )
        a = np.random.default_rng(0).normal(size=(6, *shape))
        want = a.reshape(6, size) * 2 + np.arange(size)
        assert (k(a).reshape(6, size) == want).all()
        turned = np.moveaxis(np.ascontiguousarray(np.moveaxis(a, -1, 1)), 1, -1)
        assert (k(turned).reshape(6, size) == want).all()
        assert (k(a[0]).ravel() == want[0]).all()


def affine(size: int):
    import mafsil.expression as ex

    x = ex.symbol("x", size)
    return ex.Function("affine", [x], [2 * x + np.arange(size)], ["A"], ["B"])


@pytest.mark.row("K6")
@pytest.mark.parametrize("threads", [1, None])
def test_a_large_batch_is_done_in_pieces_between_which_ctrl_c_is_heard(threads):
    """One piece would hold the interpreter's main thread until the last row."""
    rows, calls = 1_000_000, []

    def interrupted(_x, out):
        calls.append(len(out[0]))
        if len(calls) == 2:
            raise KeyboardInterrupt

    evaluate = batch.Evaluator(
        Signature("f", (Port("x"),), (Port("y"),)), batch.Loops(lambda: interrupted, lambda: interrupted), lambda: 1
    )
    with pytest.raises(KeyboardInterrupt):
        evaluate(np.zeros(rows), threads=threads)
    assert sum(calls) < rows / 2
    assert max(calls) <= 1 << 16
