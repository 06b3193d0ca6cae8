"""Values that compiled loops are handed once: read as they are, kept alive, told apart by their types."""

from __future__ import annotations

import gc
import sys
from threading import Thread

import numpy as np

from mafsil.kernels.loops.loop import hold
from tests.solvers.held_probe_loops import Inner, Outer, weighed


def value(rows: int = 3, dtype: type = np.int64) -> Outer:
    inner = Inner(np.arange(2.0 * rows).reshape(rows, 2), np.arange(rows) % 2 == 0, 7)
    return Outer(inner, 0.5, np.arange(4, dtype=dtype))


def test_loops_read_and_write_what_is_held():
    made = value()
    held = hold(made)
    expected = 0.5 * 6 + 7 + 1.0 * (0.0 + 1.0) + 3.0 * (4.0 + 5.0)
    assert weighed(held, np.array([1.0, 2.0, 3.0])) == expected
    assert made.inner.rows[0].tolist() == [0.0, 2.0]
    assert weighed(held, np.array([1.0, 2.0, 3.0])) == expected + 1.0


def test_a_held_value_lives_as_long_as_it_is_held():
    held = hold(value(1000))
    gc.collect()
    junk = [np.full((1000, 2), np.nan) for _ in range(200)]
    assert (
        weighed(held, np.ones(1000)) == 10.0 + held.value.inner.rows[::2].sum() - 0.5 * held.value.inner.rows[0].sum()
    )
    assert len(junk) == 200


def test_calls_count_no_owners():
    held = hold(value())
    before = sys.getrefcount(held.value.inner.rows)
    for _ in range(100):
        weighed(held, np.ones(3))
    after = sys.getrefcount(held.value.inner.rows)
    assert after == before


def test_values_of_other_types_are_told_apart():
    plain, narrow = hold(value()), hold(value(dtype=np.int32))
    turned = value()
    turned = hold(turned._replace(inner=turned.inner._replace(rows=np.asfortranarray(turned.inner.rows))))
    assert len({type(plain), type(narrow), type(turned)}) == 3
    assert hold(value(5)).held_kind == plain.held_kind
    x = np.array([1.0, 2.0, 3.0])
    assert weighed(plain, x) == weighed(narrow, x) == weighed(turned, x)


def test_threads_share_what_is_held():
    held, found = hold(value()), []
    threads = [Thread(target=lambda: found.append(weighed(held, np.zeros(3)))) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [10.0] * 8
