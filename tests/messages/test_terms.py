"""One term for each notion in the Arabic catalogue, as the book has them; no English left but names and code."""

import re
import tomllib
from pathlib import Path

import pytest

import mafsil.messages as messages

ARABIC = Path(messages.__file__).parent / "ar"
SENTENCES = [
    (path.stem, key, text)
    for path in sorted(ARABIC.glob("*.toml"))
    for key, text in tomllib.loads(path.read_text("utf-8")).items()
]
TERMS = {
    "inertia": ("عطال", r"قصور"),
    "gravity": ("ثقال", r"جاذبي"),
    "singular": ("شاذ", r"منفرد|وضع شاذ"),
    "singularity": ("شذوذ", r"تفرّ?د"),
    "Jacobian": ("يعقوبي", r"جاكوب"),
    "wrench": ("تلو", r"لولب (?:ال)?قو|لوالب (?:ال)?قو"),
    "configuration": ("هيئ", r"تشكيل"),
    "pose": ("وضع", r"وضعي[ةا]ت?\b(?!ن)"),
    "effort": ("عزم", r"جهد|جهود"),
    "contact": ("تماس", r"تلامس"),
    "grasp": ("مسك", r"قبض[ةا]"),
}
"""Of each notion the word that is used, and those that are not (they mean something else here or in the book)."""
FOREIGN_WORDS = re.compile(r"\b[a-z]{3,} [a-z]{3,} [a-z]{3,}\b")


@pytest.mark.parametrize("notion", TERMS)
def test_one_word_for_one_notion(notion):
    preferred, forbidden = TERMS[notion]
    assert any(preferred in text for _, _, text in SENTENCES), notion
    wrong = [f"{area}.{key}: {text}" for area, key, text in SENTENCES if re.search(forbidden, text)]
    assert not wrong


def test_no_english_sentence_is_left():
    """Three English words in a row are a sentence, not a name; lists of units and of coordinates are short words."""
    coordinates = {"roll", "pitch", "yaw"}
    left = [
        f"{area}.{key}: {found.group()}"
        for area, key, text in SENTENCES
        for found in FOREIGN_WORDS.finditer(re.sub(r"\{[^}]*\}", "", text))
        if key != "epilog" and "pip install" not in text and not coordinates & set(found.group().split())
    ]
    assert not left
