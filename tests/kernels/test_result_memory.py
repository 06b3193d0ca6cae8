"""Pages of large results that are used again: never while anybody sees them, never more than said, with a quiet end."""

from __future__ import annotations

import gc
import os
import pickle
import random
import subprocess
import sys
import threading
import weakref

import numpy as np
import pytest

from mafsil.errors import InputError
from mafsil.kernels import result_memory as memory

pytestmark = pytest.mark.skipif(not memory.available(), reason="no pool on this system")
DOUBLES = memory.SMALLEST // 8


@pytest.fixture(autouse=True)
def fresh(monkeypatch: pytest.MonkeyPatch):
    """An empty pool of 64 MiB."""
    monkeypatch.setenv(memory.MEMORY_VARIABLE, "64")
    gc.collect()
    memory.release()
    yield
    memory.release()


def place(array: np.ndarray) -> int:
    return array.__array_interface__["data"][0]


def test_pages_are_used_again_when_the_last_view_is_gone() -> None:
    a, written = memory.new((DOUBLES,))
    assert not written
    assert a.flags.c_contiguous
    assert a.flags.writeable
    assert a.dtype == np.float64
    at = place(a)
    assert at % 4096 == 0
    a[:] = 1.0
    assert memory.idle_bytes() == 0
    del a
    assert memory.idle_bytes() == 8 * DOUBLES
    b, written = memory.new((DOUBLES // 2, 2))
    assert written
    assert place(b) == at
    assert b.shape == (DOUBLES // 2, 2)
    assert memory.idle_bytes() == 0


VIEWS = {
    "slice": lambda a: a[5:7],
    "view of a view": lambda a: a[1:][1:].reshape(2, -1)[1],
    "base": lambda a: a.base,
    "array of the base": lambda a: np.asarray(a.base),
    "memoryview": memoryview,
    "bytes view": lambda a: np.frombuffer(a, np.uint8),
    "transposed": lambda a: a[:6].reshape(2, 3).T,
    "broadcast": lambda a: np.broadcast_to(a[:1], (4, 1)),
    "strided": lambda a: np.lib.stride_tricks.as_strided(a, (3,), (16,)),
    "iterator": iter,
    "flat": lambda a: a.flat,
    "subclass": lambda a: a.view(np.recarray),
    "object": lambda a: {"kept": [a]},
}


@pytest.mark.parametrize("name", VIEWS)
def test_nothing_lies_over_a_result_that_somebody_sees(name: str) -> None:
    a, _ = memory.new((DOUBLES + 2,))
    a[:] = 3.0
    at, view = place(a), VIEWS[name](a)
    del a
    others = [memory.new((DOUBLES + 2,))[0] for _ in range(3)]
    for other in others:
        other[:] = 4.0
        assert place(other) != at
    assert memory.idle_bytes() == 0
    del view
    gc.collect()
    again, written = memory.new((DOUBLES + 2,))
    assert written
    assert place(again) == at


def test_small_and_too_large_results_are_numpys() -> None:
    for shape in ((DOUBLES - 1,), (0, 7), (), (9 << 20,)):
        array, written = memory.new(shape)
        assert array.flags.owndata
        assert not written
    with pytest.raises((MemoryError, ValueError)):
        memory.new((1 << 60,))


def test_idle_memory_is_bounded() -> None:
    for count in (1, 2, 4, 9):
        arrays = [memory.new((DOUBLES,))[0] for _ in range(count)]
        del arrays
        assert memory.idle_bytes() <= memory.MOST_BLOCKS * 8 * DOUBLES
    large = [memory.new((3 * DOUBLES + k,))[0] for k in range(7)]
    for array in large:
        array[::512] = 1.0
    del array, large
    assert 0 < memory.idle_bytes() <= 64 << 20
    memory.release()
    assert memory.idle_bytes() == 0


def test_a_block_is_not_wasted_on_a_much_smaller_result() -> None:
    a, _ = memory.new((4 * DOUBLES,))
    del a
    b, written = memory.new((DOUBLES,))
    assert not written
    assert b.size == DOUBLES
    _c, written = memory.new((3 * DOUBLES,))
    assert written


def test_the_environment_bounds_it_or_turns_it_off(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(memory.MEMORY_VARIABLE, "0")
    assert memory.new((DOUBLES,))[0].flags.owndata
    monkeypatch.setenv(memory.MEMORY_VARIABLE, "5")
    assert not memory.new((DOUBLES,))[0].flags.owndata
    assert memory.new((2 * DOUBLES,))[0].flags.owndata
    for wrong in ("-1", "many", "1.5", "١"):
        monkeypatch.setenv(memory.MEMORY_VARIABLE, wrong)
        with pytest.raises(InputError, match=memory.MEMORY_VARIABLE):
            memory.new((DOUBLES,))
    monkeypatch.delenv(memory.MEMORY_VARIABLE)
    total = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    assert memory._limit() == total // 8


def test_threads_never_share_a_block() -> None:
    """Results made, filled, checked and dropped by many threads at once, some kept for a while."""
    wrong: list[int] = []

    def work(number: int) -> None:
        chance, kept = random.Random(number), []
        for turn in range(60):
            array, _ = memory.new((DOUBLES + 512 * chance.randrange(3),))
            stamp = 1000.0 * number + turn
            array[::4096] = stamp
            kept.append((array[1:], stamp, array[0:1]))
            if len(kept) > 2:
                view, expected, first = kept.pop(chance.randrange(3))
                if not (view[4095::4096] == expected).all() or first[0] != expected:
                    wrong.append(number)

    workers = [threading.Thread(target=work, args=(k,)) for k in range(6)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert not wrong
    assert memory.idle_bytes() <= 64 << 20


def test_results_in_cycles_come_back() -> None:
    a, _ = memory.new((DOUBLES,))
    ring: list[object] = [a]
    ring.append(ring)
    watch = weakref.ref(a)
    del a, ring
    gc.collect()
    assert watch() is None
    assert memory.idle_bytes() == 8 * DOUBLES


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_forked_child_changes_nothing_of_its_parent() -> None:
    a, _ = memory.new((DOUBLES,))
    b, _ = memory.new((DOUBLES,))
    a[:], b[:] = 1.0, 2.0
    at = place(b)
    del b  # idle in both processes
    pid = os.fork()
    if pid == 0:
        a[:] = 5.0
        mine, written = memory.new((DOUBLES,))
        mine[:] = 6.0
        os._exit(0 if written and place(mine) == at and (a == 5.0).all() else 1)
    theirs, _ = memory.new((DOUBLES,))
    theirs[:] = 7.0
    assert os.waitpid(pid, 0)[1] == 0
    assert (a == 1.0).all()
    assert (theirs == 7.0).all()


def test_results_pickle_and_copy_as_arrays() -> None:
    a, _ = memory.new((DOUBLES,))
    a[:] = np.arange(DOUBLES)
    assert (pickle.loads(pickle.dumps(a)) == a).all()
    assert a.copy().flags.owndata
    with pytest.raises(ValueError, match="own its data"):
        a.resize((3,), refcheck=False)


END = """
import numpy as np
from mafsil.kernels import result_memory as memory
kept = [memory.new((memory.SMALLEST // 8,))[0] for _ in range(3)]
dropped = kept.pop()
np.kept = kept[0]          # outlives the modules
class Late:
    def __init__(self, array): self.array = array
    def __del__(self): self.array[:] = 1.0; del self.array
late = Late(kept[1])
ring = [late]; ring.append(ring)
print("ok")
"""


def test_the_end_of_the_process_is_quiet() -> None:
    done = subprocess.run([sys.executable, "-X", "dev", "-c", END], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "ok\n")
    assert not done.stderr
