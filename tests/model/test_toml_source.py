"""TOML of strangers: refused in time where the parser would take minutes, read as ever elsewhere."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

import mafsil as mf
from mafsil.errors import FileError
from mafsil.grasp import read_grasp
from mafsil.job.language.reading import parse_job
from mafsil.toml_source import LONGEST_KEY, parsed_toml
from tests.budget import within

ENDLESS = {
    "bare": "a" + ".a" * 400_000 + " = 1",
    "spaced": "a" + " . a" * 100_000 + " = 1",
    "quoted": '"a"' + '."a"' * 100_000 + " = 1",
    "header": "[" + "a." * 100_000 + "a]",
    "inline": "x = { " + "a." * 100_000 + "a = 1 }",
    "nested": "x = " + "[" * 100_000,
}


@pytest.mark.parametrize("text", ENDLESS.values(), ids=ENDLESS)
@pytest.mark.row("F1")
def test_keys_without_end_are_refused_at_once_by_every_reader(text: str, tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text(text)
    for read in (lambda: mf.load(path), lambda: parse_job(text, "a.toml"), lambda: read_grasp(path)):

        def refuse(read: Callable[[], object] = read) -> None:
            with pytest.raises(FileError):
                read()

        within(1.0, refuse)


@pytest.mark.parametrize(
    "text", ["a" * 900_000, '"' * 900_000, "-" * 900_000, ("a" + " " * 999) * 900, "a.b = 1\n" * 9]
)
def test_looking_for_them_takes_no_time_itself(text: str) -> None:
    def refuse() -> None:
        with pytest.raises(ValueError):  # noqa: PT011 - which sentence does not matter, how long it takes does
            parsed_toml(text)

    within(1.0, refuse)


def test_what_is_no_attack_is_read_as_ever() -> None:
    deep = ".".join(f"k{n}" for n in range(LONGEST_KEY)) + " = 1\n"
    text = (
        deep + 'title = "v1.2.3. A dot. Another. أ.ب"\nnumbers = [1.5, 2.5, 3.5]\n[a."b c".d]\nx = """\n1.2.3.4\n"""\n'
    )
    assert parsed_toml(text) == tomllib.loads(text)
