"""`mafsil derive`: text, pages, LaTeX, JSON, files, errors."""

import json

import pytest

from mafsil import messages
from mafsil.cli.main import main


@pytest.fixture(autouse=True)
def _language(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(messages.catalogue, "_chosen", None)
    monkeypatch.delenv("MAFSIL_LANG", raising=False)


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    code = main(list(words))
    out, err = capsys.readouterr()
    return code, out, err


def test_text_on_the_screen(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "derive", "fk", "planar2r")
    assert (code, err) == (0, "")
    assert "p_x = L1 c1 + L2 c12" in out
    code, out, _ = run(capsys, "derive", "jacobian", "planar2r", "--lang", "ar")
    assert code == 0
    assert "det J = L1 L2 s2" in out
    assert "المحدِّد" in out


@pytest.mark.parametrize(
    ("name", "start"), [("d.html", "<!doctype html>"), ("d.tex", r"\documentclass"), ("d.txt", "Forward")]
)
def test_files_by_their_ending(capsys: pytest.CaptureFixture[str], tmp_path, name: str, start: str) -> None:
    code, out, _ = run(capsys, "derive", "fk", "rrrp", "--out", str(tmp_path / name))
    assert code == 0
    assert name in out
    assert (tmp_path / name).read_text("utf-8").startswith(start)


def test_format_without_a_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(capsys, "derive", "fk", "rrrp", "--format", "html")[1].startswith("<!doctype html>")
    assert run(capsys, "derive", "fk", "rrrp", "--format", "latex")[1].startswith(r"\documentclass")


def test_json_holds_every_step(capsys: pytest.CaptureFixture[str]) -> None:
    data = json.loads(run(capsys, "derive", "fk", "planar3r", "--json")[1])
    lines = {tuple(line["left"]): line["right"] for step in data["steps"] for line in step["lines"]}
    assert lines[("p_x",)] == ["L1 c1 + L2 c12 + L3 c123"]
    assert data["worst_error"] < 1e-12


def test_errors_are_one_sentence(capsys: pytest.CaptureFixture[str], tmp_path) -> None:
    assert run(capsys, "derive", "fk", "no_such_robot")[0] == 2
    assert run(capsys, "derive", "statics", "rrrp")[0] == 2
    code, _, err = run(capsys, "derive", "fk", "rrrp", "--out", str(tmp_path / "none" / "d.txt"))
    assert code == 2
    assert len(err.strip().splitlines()) == 1
