"""F2: each hostile file gets its code, its line and its repair, in both languages."""

from __future__ import annotations

import json

import pytest

from mafsil.errors import FileError
from mafsil.model import urdf
from mafsil.model.diagnostics import Severity
from tests.model.urdf.hostile_files import CASES, Case, chain, sound

pytestmark = pytest.mark.row("F2")


def test_the_sound_file_is_sound() -> None:
    report = urdf.diagnose(sound())
    assert report.ok
    assert report.codes == ()


def test_a_chain_of_3000_links_is_read() -> None:
    assert urdf.read(chain(3_000)).n == 2_999


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_code_line_and_repair(case: Case) -> None:
    report = urdf.diagnose(case.data)
    found = [d for d in report if d.code == case.code]
    assert found, report.lines()
    assert found[0].line == case.line
    assert (found[0].repair is not None) == case.repair
    assert report.ok == case.accepted
    assert (found[0].severity is Severity.ERROR) == (not case.accepted)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_sentences_in_both_languages(case: Case) -> None:
    for diagnostic in urdf.diagnose(case.data):
        english, arabic = diagnostic.line_of_text("en"), diagnostic.line_of_text("ar")
        assert english != arabic
        assert all("\u0600" <= c <= "\u06ff" for c in "".join(w for w in arabic if "\u0600" <= w))
        assert any("\u0600" <= c <= "\u06ff" for c in arabic)
        assert all(c.isprintable() for c in english + arabic)
        assert json.loads(json.dumps(diagnostic.to_dict()))["code"] == diagnostic.code


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_repair(case: Case) -> None:
    if case.code in ("F0104", "F0105", "F0106"):
        with pytest.raises(FileError):
            urdf.repair(case.data)
        return
    text, changes = urdf.repair(case.data)
    assert urdf.diagnose(text).ok == case.mended
    offers = [d.repair for d in urdf.diagnose(case.data) if d.code == case.code and d.repair is not None]
    assert bool(changes) >= (case.mended and not all(offer.guess for offer in offers))
    assert all(change.sentence("en") != change.sentence("ar") for change in changes)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_read_raises_the_first_error_with_its_place(case: Case) -> None:
    if case.accepted:
        urdf.read(case.data)
        return
    with pytest.raises(FileError) as caught:
        urdf.read(case.data)
    errors = urdf.diagnose(case.data).errors
    assert errors[0].code in str(caught.value)
    assert errors[0].sentence("ar") in caught.value.message("ar")
    if case.mended:
        assert urdf.read(case.data, repair=True).links
