"""Values that users write refuse NaN, infinities and wrong shapes, in our words, where they are made."""

from __future__ import annotations

import pytest

from tests.reliability.values import MADE, WRITTEN, misses, names, public_classes


@pytest.fixture(scope="module")
def known():
    return names()


@pytest.mark.parametrize("text", WRITTEN, ids=lambda text: text.partition("(")[0])
def test_wrong_numbers_are_refused(text, known):
    assert misses(text, known) == []


def test_every_public_class_with_numbers_is_driven_or_made_by_us(known):
    calls = {text.partition("(")[0]: type(eval(text, known)) for text in WRITTEN}
    written = {kind for name, kind in calls.items() if name.rpartition(".")[2] == kind.__name__}
    assert written == set(calls.values()), "a class is driven by its constructor, not by its makers alone"
    assert {kind.__name__ for kind in public_classes() if kind not in written} == set(MADE.split())
    assert len(written) > 80


def test_a_class_that_takes_everything_is_found_out(known):
    text = "Open(low=0.0, high=[1.0, 2.0])"
    namespace: dict[str, object] = {}
    exec(
        "from dataclasses import dataclass\n@dataclass\nclass Open:\n    low: 'float'\n    high: 'Floats'\n",
        namespace,
    )
    found = misses(text, {**known, "Open": namespace["Open"]})
    assert len(found) > 15
    assert all(each.endswith("taken") for each in found)
