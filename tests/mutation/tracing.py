"""Which public things of mafsil a test calls itself, told from those that are called on the way."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from tests.mutation.collection import ROOT, run

SOURCE = str(ROOT / "src" / "mafsil")
TESTS = str(ROOT / "tests")


class Tracer:
    """Counts calls from code of tests to code of mafsil, as `package.module:Class.method`."""

    def __init__(self) -> None:
        self.calls: Counter[str] = Counter()
        self._quantities = _names_of_quantities()

    def pytest_runtest_call(self) -> None:
        """Only the test itself is looked at, not what pytest does around it."""
        sys.setprofile(self._on_event)

    def pytest_runtest_teardown(self) -> None:
        """The test is over."""
        sys.setprofile(None)

    def _on_event(self, frame: FrameType, event: str, argument: Any) -> None:
        if event == "call" and frame.f_code.co_filename.startswith(SOURCE):
            caller = frame.f_back
            while caller is not None and _is_glue(caller.f_code):
                caller = caller.f_back
            if caller is not None and caller.f_code.co_filename.startswith(TESTS):
                self.calls[_name(frame.f_code)] += 1
        elif event == "c_call" and frame.f_code.co_filename.startswith(TESTS):
            name = getattr(argument, "__name__", "")
            if name in self._quantities:
                self.calls[f"quantity:{name}"] += 1


def _is_glue(code: CodeType) -> bool:
    """Wrappers such as `called` and generated `__init__` methods stand between a test and what it calls."""
    return code.co_filename.startswith("<") or (code.co_filename.endswith("arrays.py") and code.co_name == "call")


def _name(code: CodeType) -> str:
    module = ".".join(Path(code.co_filename).relative_to(ROOT / "src").with_suffix("").parts)
    return f"{module.removesuffix('.__init__')}:{code.co_qualname}"


def _names_of_quantities() -> set[str]:
    from mafsil.mechanics.catalogue import CATALOGUE

    return set(CATALOGUE)


def calls_of(tests: list[str]) -> dict[str, int]:
    """How often the tests call each public thing."""
    tracer = Tracer()
    run(tests, [tracer])
    public = {name: count for name, count in tracer.calls.items() if "._" not in name and ":_" not in name}
    return {name: count for name, count in public.items() if "<" not in name}
