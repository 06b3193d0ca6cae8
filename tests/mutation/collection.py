"""Which tests name which capability, as pytest collects them."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
QUIET = ["-q", "-p", "no:cacheprovider", "-p", "no:xdist", "--no-header", "--no-summary", "-W", "ignore"]


class Collector:
    """Keeps the tests of each capability while pytest collects."""

    def __init__(self) -> None:
        self.tests: dict[str, list[str]] = {}

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """All tests are known."""
        for item in session.items:
            for marker in item.iter_markers("capability"):
                for name in marker.args:
                    self.tests.setdefault(name, []).append(item.nodeid)


def tests_of_capabilities() -> dict[str, list[str]]:
    """Capability -> node ids of the tests that name it; imports all test modules, so that children need not."""
    collector = Collector()
    pytest.main(["--collect-only", *QUIET, str(ROOT / "tests")], plugins=[collector])
    return dict(sorted(collector.tests.items(), key=lambda each: [int(n) for n in each[0].split("-")]))


def run(tests: list[str], plugins: list[object] | None = None) -> bool:
    """Whether all of the tests pass; the first failure ends the run."""
    return pytest.main(["-x", *QUIET, "-p", "no:randomly", *tests], plugins=plugins or []) == pytest.ExitCode.OK
