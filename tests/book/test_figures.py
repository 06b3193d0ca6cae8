"""What all figures of the book share: words in both languages, sliders, files, refusals."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.book.entry import EntryStatus, shown
from mafsil.cli.main import main
from mafsil.errors import InputError

EARLY = [number for number in mf.book.figures() if int(number.split(".")[0]) <= 6]


def test_every_figure_of_the_first_chapters_is_there() -> None:
    last = {1: 2, 2: 16, 3: 12, 4: 15, 5: 10, 6: 9}
    assert [f"{chapter}.{k}" for chapter, n in last.items() for k in range(1, n + 1)] == EARLY


@pytest.mark.parametrize("number", EARLY)
def test_a_figure_says_everything_in_both_languages(number: str) -> None:
    """Title, caption, choices where it is rebuilt, facts and the headings of several panels."""
    figure = mf.book.figure(number)
    parts = ["", "caption", *(fact.name for fact in figure.facts)]
    parts += ["chosen"] if figure.status is EntryStatus.REBUILT else []
    parts += figure.panels if len(figure.panels) > 1 else []
    for language in ("en", "ar"):
        for part in parts:
            assert figure.words(part, language), (part, language)
        for fact in figure.facts:
            if not fact.agrees:
                assert figure.words("erratum", language)
    assert re.search("[\u0600-\u06ff]", figure.explain("ar"))
    assert figure.explain("en").startswith(f"Figure {number}: ")
    assert figure.to_dict()["number"] == number
    assert figure


@pytest.mark.parametrize("number", [number for number in EARLY if mf.book.figure(number).parameters])
def test_sliders_move_something_and_end(number: str) -> None:
    """At both ends of every slider the figure computes and its drawn coordinates are finite; beyond, it is refused."""
    figure = mf.book.figure(number)
    for name, slider in figure.parameters.items():
        for value in (slider.least, slider.greatest):
            moved = mf.book.figure(number, **{name: value})
            assert moved.parameters[name].value == value
            for panel in moved.panels.values():
                assert all(np.isfinite(element.points).all() for element in panel.elements)
        with pytest.raises(InputError, match=name):
            mf.book.figure(number, **{name: slider.greatest + 1.0})


def test_a_figure_is_written_and_shows_itself(tmp_path: Path) -> None:
    figure = mf.book.figure("2.5", crank=0.4)
    for ending in ("png", "svg", "pdf"):
        figure.save(tmp_path / f"figure.{ending}")
        assert (tmp_path / f"figure.{ending}").stat().st_size > 2000
    page = figure._repr_html_()
    assert page.startswith("<figure><svg")
    assert "Gruebler" in page


def test_unknown_numbers_and_sliders_are_refused() -> None:
    with pytest.raises(InputError, match=r"2\.5"):
        mf.book.figure("2.55")
    with pytest.raises(InputError, match="crank"):
        mf.book.figure("2.5", krank=0.1)


def test_numbers_are_shown_without_rounding_dust() -> None:
    assert shown([1e-17, -2.0, 0.12345]) == "(0, -2, 0.1235)"
    assert shown(np.int64(6)) == "6"


def test_the_command_line_explains_lists_and_draws(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["book", "figure", "2.5", "--picture", "x.png"]) == 0
    assert "2.5" in capsys.readouterr().out
    assert Path("x.png").stat().st_size > 1000
    assert main(["book", "example", "2.4", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["facts"]["rank"]["value"] == 3
    assert main(["book", "figure", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["figure"]) == 102
    assert main(["book", "remark", "2", "--picture", "x.png"]) == 2
