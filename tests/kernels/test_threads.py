"""The pool: every part done once, errors surface, forks and nested use survive."""

from __future__ import annotations

import os
import sys
import threading
import time

import pytest

from mafsil import threads
from mafsil.errors import InputError


@pytest.mark.parametrize("count", [0, 1, 2, 7, 100])
@pytest.mark.parametrize("workers", [1, 2, 8])
def test_every_part_once(count, workers):
    done: list[int] = []
    threads.run(done.append, count, workers)
    assert sorted(done) == list(range(count))


def test_parts_run_at_the_same_time():
    barrier = threading.Barrier(3)
    threads.run(lambda _: barrier.wait(10) and None, 3, 3)


@pytest.mark.parametrize("workers", [1, 4])
def test_the_first_error_comes_through_after_all_have_stopped(workers):
    running = []

    def task(part: int) -> None:
        running.append(part)
        time.sleep(0.001)
        running.remove(part)
        if part == 3:
            raise ZeroDivisionError(part)

    with pytest.raises(ZeroDivisionError):
        threads.run(task, 20, workers)
    assert not running
    threads.run(task, 3, workers)


def test_a_part_may_use_the_pool_itself():
    done: list[int] = []
    threads.run(lambda _: threads.run(done.append, 5, 4), 6, 4)
    assert len(done) == 30


def test_many_callers_share_the_pool():
    sums: list[int] = []

    def call() -> None:
        parts: list[int] = []
        for _ in range(50):
            threads.run(parts.append, 10, 4)
        sums.append(sum(parts))

    callers = [threading.Thread(target=call) for _ in range(8)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()
    assert sums == [50 * 45] * 8


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_forked_child_has_its_own_pool():
    threads.run(lambda _: None, 4, 4)
    pid = os.fork()
    if pid == 0:
        barrier = threading.Barrier(3)
        threads.run(lambda _: barrier.wait(10) and None, 3, 3)
        os._exit(0)
    assert os.waitpid(pid, 0)[1] == 0


def test_no_more_threads_to_be_had(monkeypatch):
    monkeypatch.setattr(threads, "_shared", None)

    def refuse(_self):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    done: list[int] = []
    threads.run(done.append, 10, 4)
    assert sorted(done) == list(range(10))


def test_the_environment_and_the_caller_choose(monkeypatch):
    monkeypatch.setenv("MAFSIL_THREADS", "3")
    assert threads.available() == 3
    for wrong in ("0", "-1", "many"):
        monkeypatch.setenv("MAFSIL_THREADS", wrong)
        with pytest.raises(InputError, match="MAFSIL_THREADS"):
            threads.available()
    monkeypatch.delenv("MAFSIL_THREADS")
    if sys.platform == "linux":
        assert threads.available() == len(os.sched_getaffinity(0))
    for wrong in (0, -2, "x", None):
        with pytest.raises(InputError):
            threads.check_count(wrong)
