"""Who works on many runs: this process, some processes here, or a cluster that dask knows."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from importlib import import_module
from typing import TYPE_CHECKING, Any

from mafsil.errors import InputError

if TYPE_CHECKING:
    from mafsil.simulation.many_runs import Executor

MOST_WORKERS = 1024


@contextmanager
def cluster_executor(where: str | None) -> Generator[Executor | None]:
    """An executor for `monte_carlo`, closed at the end; None for this process.

    Args:
        where: a number of worker processes, or the address of a dask scheduler such as `tcp://10.0.0.5:8786`.

    Raises:
        InputError: dask's `distributed` is not installed, too many workers, nobody answers at the address.
    """
    if where is None:
        yield None
        return
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise InputError("simulation.no_distributed") from None
    if where.strip().isdigit():
        count = int(where)
        if not 1 <= count <= MOST_WORKERS:
            raise InputError("input.range", name="cluster", value=count, low=1, high=MOST_WORKERS)
        options = {"processes": True, "threads_per_worker": 1, "dashboard_address": None, "silence_logs": 40}
        with distributed.LocalCluster(n_workers=count, **options) as local, distributed.Client(local) as client:
            yield client
        return
    try:
        client = distributed.Client(where, timeout="10s")
    except (OSError, ValueError, TypeError) as fault:
        raise InputError("simulation.no_cluster", address=where, fault=str(fault) or type(fault).__name__) from None
    with client:
        yield client
