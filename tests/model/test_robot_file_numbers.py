"""The number grammar of robot files."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from mafsil.model.reading import LARGEST, decimal, proposal, written


@given(st.floats(-LARGEST, LARGEST))
def test_what_is_written_is_read(value: float) -> None:
    assert decimal(written(value)) == (value, None)


@given(st.text(max_size=12))
def test_only_plain_decimals_are_numbers(text: str) -> None:
    value, fault = decimal(text)
    if fault is None:
        assert set(text) <= set("0123456789+-.eE")
        assert value == float(text)
    better = proposal(text)
    assert better is None or decimal(better)[0] == float(better)
