"""Of many equal cases a few run with the tests, and all with `--full`."""

from __future__ import annotations

import pytest

from tests import sizes


def test_a_few_are_spread_over_all_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sizes, "full", False)
    assert sizes.few(range(100), 4) == [0, 33, 66, 99]
    assert sizes.few(range(3), 4) == [0, 1, 2]
    assert sizes.few("abcdefg", 6) == ["a", "b", "c", "e", "f", "g"]
    assert sizes.size(10, 1000) == 10


def test_all_are_run_in_full(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sizes, "full", True)
    assert sizes.few(range(100), 4) == list(range(100))
    assert sizes.size(10, 1000) == 1000
