"""F1 at the size of a pull request; hypothesis looks where the mutator does not."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.model import mjcf, sdf, urdf
from tests.reliability import fuzz_reader
from tests.reliability.model_invariants import violations
from tests.reliability.robot_files import SEEDS

FILES = 1_000


@pytest.mark.row("F1")
@pytest.mark.slow
def test_damaged_files() -> None:
    found = fuzz_reader.work(20_261_121, FILES)
    assert found["files"] == FILES
    assert found["accepted"] > FILES // 20
    assert found["repaired"] > 0
    assert {name: value for name, value in found.items() if name.startswith("bad_") and value} == {}


@pytest.mark.row("F1")
@settings(max_examples=80, deadline=None)
@given(st.binary(max_size=300))
def test_any_bytes(data: bytes) -> None:
    for reader in (urdf, mjcf, sdf):
        assert not reader.diagnose(data).ok


@pytest.mark.row("F1")
@settings(max_examples=80, deadline=None)
@given(st.sampled_from(sorted(SEEDS)), st.data())
def test_any_text_as_any_value(kind: str, data: st.DataObject) -> None:
    """One attribute of a sound file gets any text at all."""
    reader = fuzz_reader.READERS[kind]
    pieces = data.draw(st.sampled_from(SEEDS[kind])).decode().split('"')
    where = 2 * data.draw(st.integers(0, len(pieces) // 2 - 1)) + 1
    pieces[where] = data.draw(st.text(max_size=20))
    report = reader.diagnose('"'.join(pieces).encode("utf-8", "surrogatepass"))
    for diagnostic in report:
        assert diagnostic.line_of_text("en") != diagnostic.line_of_text("ar")
    assert report.mechanism is not None or report.errors
    assert report.mechanism is None or violations(report.mechanism) == []
