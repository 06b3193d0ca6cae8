"""The glossary is what the package does: its names exist, and the words that it rules out occur nowhere."""

from __future__ import annotations

import ast
import importlib
import re
import sys
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import mafsil as mf

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src" / "mafsil"
sys.path.append(str(ROOT / "docs"))
glossary = importlib.import_module("make_glossary")
TERMS = glossary.terms()
WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
PREFIXES = r"(?:[وف]?(?:ال|بال|كال|لل|ب|ك|ل)?)"
EXCEPTIONS: dict[str, str] = {
    "figures/gimbals.py: ring": "a ring of a gimbal",
    "messages/isolates.py: mark": "Unicode's name of the character",
    "model/faults.py: mark": "Unicode's byte order mark",
    "model/source.py: mark": "Unicode's byte order mark",
    "model/xacro/files.py: mark": "PyYAML's name of a place in the text",
}
"""`file: word` that stays, and why."""


def _words(identifier: str) -> set[str]:
    """`NearestPose_x` has the words nearest, pose, x."""
    return {word.lower() for word in WORD.findall(identifier)}


@cache
def _identifiers(path: Path) -> frozenset[str]:
    """All names that a file defines or uses: definitions, arguments, attributes, variables, keywords."""
    found: set[str] = {path.stem}
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        match node:
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                found.add(name)
            case ast.Name(id=name) | ast.Attribute(attr=name):
                found.add(name)
            case ast.arg(arg=name) | ast.keyword(arg=str(name)):
                found.add(name)
            case _:
                pass
    return frozenset(found)


FILES = sorted(SOURCE.rglob("*.py"))
TEXTS = {path: path.read_text("utf-8") for path in FILES}
RULED_OUT = {
    word: term.english for term in TERMS for word in term.avoided_in(arabic=False) if re.fullmatch(r"[a-z]+", word)
}
MAY_BE_RULED_OUT = re.compile("|".join(f"(?<![a-z]){w}(?![a-z])|{w.title()}(?![a-z])|{w.upper()}" for w in RULED_OUT))
"""What a text holds where an identifier in it has such a word: only those files are parsed."""
RULED_OUT_ARABIC = {word: term.english for term in TERMS for word in term.avoided_in(arabic=True)}


def test_pages_are_current() -> None:
    for name, text in (("glossary.md", glossary.english_page(TERMS)), ("glossary.ar.md", glossary.arabic_page(TERMS))):
        assert (ROOT / "docs" / name).read_text("utf-8") == text, "run python docs/make_glossary.py"


def test_each_notion_stands_once() -> None:
    for names in ([term.english for term in TERMS], [(term.area, term.arabic) for term in TERMS]):
        assert len(names) == len(set(names)), sorted(name for name in names if names.count(name) > 1)
    assert {term.area for term in TERMS} <= set(glossary.AREAS)


def test_no_term_is_ruled_out_by_another() -> None:
    for term in TERMS:
        assert not [word for word in RULED_OUT if word in re.findall(r"[a-z]+", term.english.lower())], term.english
        assert not [word for word in RULED_OUT_ARABIC if _occurs(word, term.arabic)], term.english
        assert not [word for word in RULED_OUT_ARABIC if _occurs(word, term.line_ar)], term.line_ar
        assert re.search("[\u0600-\u06ff=]", term.line_ar), term.english


@pytest.mark.parametrize("term", TERMS, ids=lambda term: term.english)
def test_names_in_code_exist(term: Any) -> None:
    for name in term.code:
        owner, _, member = name.rpartition(".")
        assert _is_known(member), name
        if owner:
            assert hasattr(_public(owner), member), name


@pytest.mark.parametrize("package", sorted({path.relative_to(SOURCE).parts[0] for path in FILES}))
def test_words_that_are_ruled_out_name_nothing(package: str) -> None:
    found = {
        f"{path.relative_to(SOURCE).as_posix()}: {word}"
        for path, text in TEXTS.items()
        if path.relative_to(SOURCE).parts[0] == package and MAY_BE_RULED_OUT.search(f"{path.stem}\n{text}")
        for name in _identifiers(path)
        for word in _words(name) & RULED_OUT.keys()
    } - EXCEPTIONS.keys()
    assert not found


def test_exceptions_are_needed() -> None:
    for place in EXCEPTIONS:
        name, _, word = place.partition(": ")
        assert any(word in _words(identifier) for identifier in _identifiers(SOURCE / name)), place


@pytest.mark.parametrize("word", RULED_OUT_ARABIC)
def test_arabic_words_that_are_ruled_out_are_not_said(word: str) -> None:
    for path in sorted((SOURCE / "messages" / "ar").glob("*.toml")):
        for key, text in tomllib.loads(path.read_text("utf-8")).items():
            assert not _occurs(word, text), f"{path.stem}.{key} says {word} for {RULED_OUT_ARABIC[word]}: {text}"


def _occurs(word: str, text: str) -> bool:
    """Whether an Arabic word stands in a text, with or without article, conjunction and preposition."""
    bare = "".join(letter for letter in text if not "\u064b" <= letter <= "\u0652")
    plain = "".join(letter for letter in word if not "\u064b" <= letter <= "\u0652")
    return re.search(rf"(?<![\u0600-\u06ff]){PREFIXES}{plain}(?![\u0600-\u06ff])", bare) is not None


def _is_known(name: str) -> bool:
    """Whether a file, or something in one, has a name; files are parsed where their text has it."""
    if hasattr(mf.Robot, name) or any(path.stem == name for path in FILES):
        return True
    return any(name in _identifiers(path) for path in FILES if name in _text_words(path))


@cache
def _text_words(path: Path) -> frozenset[str]:
    return frozenset(re.findall(r"\w+", TEXTS[path]))


def _public(name: str) -> object:
    """A class of the package, wherever it is defined."""
    for path in FILES:
        if re.search(rf"^class {name}\b", TEXTS[path], flags=re.M):
            module = ".".join(path.relative_to(SOURCE.parent).with_suffix("").parts)
            return getattr(importlib.import_module(module), name)
    raise AssertionError(name)
