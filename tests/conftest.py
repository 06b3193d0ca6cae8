"""Makes `tests.oracles` and its neighbours importable, and keeps compiled code away from the user's own cache."""

from __future__ import annotations

import gc
import os
import sys
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

# Machines are shared: how long an example takes says nothing about what it tests.
settings.register_profile("mafsil", deadline=None, max_examples=30)
settings.register_profile("full", deadline=None, max_examples=100)

ROOT = Path(__file__).resolve().parents[1]

if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

# Shared by the workers of one run and by later runs: a cold cache is what its own tests make for themselves.
os.environ.setdefault("MAFSIL_CACHE", str(Path(tempfile.gettempdir()) / f"mafsil-tests-{os.getuid()}"))

# Tests start hundreds of interpreters; each would translate all modules anew, for a second.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# Each worker has one core: threads of BLAS that wait for the core of another one took thirty times the time.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

SHAPED = ("mafsil.geometry", "mafsil.robot", "mafsil.trajectory")
"""Packages whose annotated shapes `--check-shapes` checks."""

LANES = ("kernels", "laws", "oracles", "reliability", "robot", "seams")
"""Folders of tests that hold the code of batches against other code; with `--full` all do."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--check-shapes", action="store_true", help="check annotated shapes at every call of the package")
    parser.addoption("--full", action="store_true", help="all of many equal cases, of which else a few run (hours)")


def pytest_configure(config: pytest.Config) -> None:
    from tests import sizes

    sizes.full = bool(config.getoption("--full"))
    settings.load_profile("full" if sizes.full else "mafsil")
    gc.disable()  # while thousands of tests are collected, all of which stay
    if config.getoption("--check-shapes"):
        from tests.house import shapes

        shapes.watch(*SHAPED)


def pytest_collection_finish() -> None:
    """What is there stays: going through it at each collection of garbage would take a second."""
    gc.enable()
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def _lanes_of_few_rows(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where batches are held against single calls, their code is compiled for the first row already."""
    from tests import sizes

    if sizes.full or request.path.parent.name in LANES:
        monkeypatch.setattr("mafsil.kernels.small_batch.SINGLY", 0)


@pytest.fixture(autouse=True)
def _language_and_warnings_are_left_as_found(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Commands choose the language of the process and print warnings their own way: the next test shall not notice."""
    from mafsil.messages import catalogue

    monkeypatch.setattr(catalogue, "_chosen", catalogue._chosen)
    with warnings.catch_warnings():
        yield
