"""Wall-clock times of rivals in one run: taken in turns, so that what else the machine does hits all of them."""

from __future__ import annotations

import gc
import os
import platform
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from statistics import median
from time import perf_counter

Task = Callable[[], object]

BRIEF, BRIEFER = {"repeats": 60, "seconds": 0.003}, {"repeats": 15, "seconds": 0.003}
"""Many turns shorter than a time slice: the least of them is undisturbed even on a busy machine."""
ONCE = "MAFSIL_BENCHMARK_ONCE" in os.environ
"""Whether each task runs a single time: what tests ask for, which see that a script still runs."""


@dataclass(frozen=True)
class Timing:
    """Seconds of one call: the smallest and the median of the repeats."""

    least: float
    median: float


def race(tasks: Mapping[str, Task], *, repeats: int = 9, seconds: float = 0.02) -> dict[str, Timing]:
    """Time each task `repeats` times in turns; every repeat runs it for about `seconds`.

    Args:
        tasks: what to run, by name.
        repeats: rounds.
        seconds: length of one repeat; the number of calls in it is found first.
    """
    counts = {name: 1 if ONCE else _count(task, seconds) for name, task in tasks.items()}
    taken: dict[str, list[float]] = {name: [] for name in tasks}
    collecting = gc.isenabled()
    gc.disable()
    try:
        for _ in range(1 if ONCE else repeats):
            for name, task in tasks.items():
                taken[name].append(_elapsed(task, counts[name]) / counts[name])
    finally:
        if collecting:
            gc.enable()
    return {name: Timing(min(each), median(each)) for name, each in taken.items()}


def verdict(kind: str, ratios: Sequence[float], target: float) -> str:
    """How many rows are as many times quicker than their rival as they should be."""
    reached = sum(ratio >= target for ratio in ratios)
    return f"{kind}: {reached} of {len(ratios)} rows reach {target:g} times; worst {min(ratios):.1f} times"


def machine(*packages: str) -> dict[str, str]:
    """Processor, cores, Python and the versions of packages."""
    details = {
        "processor": _processor(),
        "cores": str(len(os.sched_getaffinity(0))),
        "system": platform.platform(),
        "python": platform.python_version(),
    }
    return details | {name: version(name) for name in packages}


def _count(task: Task, seconds: float) -> int:
    task()
    count = 1
    while (elapsed := _elapsed(task, count)) < seconds / 4:
        count *= 4
    return max(1, round(count * seconds / elapsed))


def _elapsed(task: Task, count: int) -> float:
    rounds = range(count)
    start = perf_counter()
    for _ in rounds:
        task()
    return perf_counter() - start


def _processor() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.processor()
