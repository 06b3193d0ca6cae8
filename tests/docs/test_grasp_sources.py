"""The page on grasps names the sources of its theorems."""

from __future__ import annotations

from pathlib import Path

import pytest

PAGE = Path(__file__).resolve().parents[2] / "docs" / "grasping.md"


@pytest.mark.capability("03-73")
@pytest.mark.parametrize("author", ["Coulomb", "Nguyen", "Li, H. Liu, H.-G. Cai", "Mishra", "Winston", "Ferrari"])
def test_the_page_names_its_sources(author: str) -> None:
    assert author in PAGE.read_text("utf-8").partition("## Sources")[2]
