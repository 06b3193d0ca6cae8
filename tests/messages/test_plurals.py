"""Numbers and their nouns: two forms in English, six in Arabic."""

import tomllib
from pathlib import Path

import pytest

import mafsil.messages as messages
from mafsil.messages import say
from mafsil.messages.catalogue import category, count_noun

CATALOGUE = Path(messages.__file__).parent


@pytest.mark.parametrize(
    ("count", "expected"),
    [
        *[(0, "zero"), (1, "one"), (2, "two"), (3, "few"), (10, "few"), (11, "many"), (99, "many"), (100, "other")],
        *[(101, "other"), (102, "other"), (103, "few"), (111, "many"), (200, "other"), (1003, "few")],
    ],
)
def test_categories_of_arabic(count, expected):
    """Those of the Unicode locale data."""
    assert category(count, "ar") == expected


def test_categories_of_english():
    assert [category(count, "en") for count in (0, 1, 2, 21)] == ["other", "one", "other", "other"]


def test_a_joint_is_not_named_twice():
    assert (
        say("mobility.unknown_joint", language="en", joint="joint9", known="a")
        == "there is no joint9; the joints are a"
    )
    assert "no joint elbow;" in say("mobility.unknown_joint", language="en", joint="elbow", known="a")


def test_a_sentence_takes_the_form_of_its_number():
    details = {"robot": "r", "warnings": 0, "notes": 2}
    assert say("lint.summary", language="en", errors=1, **details) == "r: 1 error, 0 warnings, 2 notes"
    assert say("lint.summary", language="ar", errors=1, **details) == "r: خطأ واحد، لا تحذيرات، ملاحظتان"
    assert say("lint.refused", language="ar", robot="r", errors=3) == "في r 3 أخطاء"
    assert say("lint.refused", language="ar", robot="r", errors=11) == "في r 11 خطأً"


def test_every_noun_has_all_its_forms_and_is_used():
    english, arabic = (tomllib.loads((CATALOGUE / code / "plurals.toml").read_text("utf-8")) for code in ("en", "ar"))
    every = "".join(path.read_text("utf-8") for path in CATALOGUE.glob("*/*.toml"))
    for noun in english:
        assert len(english[noun].split(" | ")) == 2
        assert len(arabic[noun].split(" | ")) == 6
        assert f":#{noun}}}" in every, noun
        for count in (3, 11, 100):
            assert str(count) in count_noun(count, arabic[noun], "ar")
