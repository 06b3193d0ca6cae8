"""One batch over many cores: a small pool that lasts, shared by all packages and re-created after a fork."""

from __future__ import annotations

import itertools
import operator
import os
import threading
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any

from mafsil.errors import InputError

THREADS_VARIABLE = "MAFSIL_THREADS"
"""Environment variable with the number of threads of a batch; the default is the number of cores we may run on."""


def available() -> int:
    """Threads of a batch when the caller does not say: MAFSIL_THREADS, or the cores this process may use."""
    setting = os.environ.get(THREADS_VARIABLE, "")
    if setting:
        return check_count(setting, THREADS_VARIABLE)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def check_count(count: int | str, name: str = "threads") -> int:
    """A positive whole number of threads.

    Raises:
        InputError: not one.
    """
    try:
        number = int(count) if isinstance(count, str) else operator.index(count)
    except (TypeError, ValueError):
        number = 0
    if number < 1:
        raise InputError("input.positive", name=name, value=count)
    return number


def run(task: Callable[[int], None], count: int, threads: int) -> None:
    """`task(0) ... task(count - 1)`, the caller working along; the first exception is raised after all have stopped.

    Args:
        task: releases the lock for most of its time; must not depend on the order.
        count: number of parts.
        threads: how many work at once, the caller included.
    """
    if threads <= 1 or count <= 1:
        for part in range(count):
            task(part)
        return
    job = _Job(task, count)
    _pool().offer(job, min(threads, count) - 1)
    job.work()
    job.join()


class _Job:
    """Parts handed out one by one; nobody waits for a helper that has not begun."""

    def __init__(self, task: Callable[[int], None], count: int) -> None:
        self._task = task
        self._count = count
        self._next = itertools.count().__next__
        self._stopped = False
        self._done: SimpleQueue[BaseException | None] = SimpleQueue()

    def work(self) -> None:
        """Do parts until none is left."""
        while (part := self._next()) < self._count:
            error: BaseException | None = None
            try:
                if not self._stopped:
                    self._task(part)
            except BaseException as caught:
                error, self._stopped = caught, True
            self._done.put(error)

    def join(self) -> None:
        """Wait for every part and raise the first error."""
        errors: list[BaseException] = []
        try:
            for _ in range(self._count):
                error = self._done.get()
                if error is not None:
                    errors.append(error)
        except BaseException:
            self._stopped = True
            raise
        if errors:
            raise errors[0]


class _Pool:
    """Threads that wait for jobs; as many as were ever asked for at once."""

    def __init__(self) -> None:
        self._jobs: SimpleQueue[_Job] = SimpleQueue()
        self._lock = threading.Lock()
        self._size = 0

    def offer(self, job: _Job, helpers: int) -> None:
        """Let up to `helpers` threads work on the job; without them the caller does it all."""
        self._grow(helpers)
        for _ in range(helpers):
            self._jobs.put(job)

    def _grow(self, size: int) -> None:
        if self._size >= size:
            return
        with self._lock:
            while self._size < size:
                try:
                    threading.Thread(target=self._serve, name="mafsil", daemon=True).start()
                except RuntimeError:  # no more threads from the system, or the interpreter is leaving
                    return
                self._size += 1

    def _serve(self) -> None:
        while True:
            job = self._jobs.get()
            job.work()
            del job


_shared: _Pool | None = None
_creating = threading.Lock()


def _pool() -> _Pool:
    global _shared
    with _creating:
        if _shared is None:
            _shared = _Pool()
        return _shared


def _forget() -> None:
    """A forked child has none of its parent's threads, and maybe a lock that one of them held."""
    global _shared, _creating
    _shared, _creating = None, threading.Lock()


def _watch_forks() -> None:
    register: Any = getattr(os, "register_at_fork", None)
    if register:
        register(after_in_child=_forget)


_watch_forks()
