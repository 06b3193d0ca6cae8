"""`mafsil check-homework`: typed or in files, in degrees, in two languages; exit 0 right, 1 wrong, 2 unreadable."""

import json

import pytest

from mafsil import messages
from mafsil.cli.main import main

TABLE = """
convention = "modified"
units = { angle = "deg", length = "mm" }
[[joint]]
[[joint]]
a = 1000.0
[[joint]]
a = 800.0
"""


@pytest.fixture(autouse=True)
def _language(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(messages.catalogue, "_chosen", None)
    monkeypatch.delenv("MAFSIL_LANG", raising=False)


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    code = main(["check-homework", *words])
    out, err = capsys.readouterr()
    return code, out, err


def test_typed_rows_in_degrees(capsys: pytest.CaptureFixture[str]) -> None:
    rows = ["0 0 0 0", "0 90 0 0", "0.4318 0 0.15005 0", "0.0203 -90 0.4318 0", "0 90 0 0", "0 -90 0 0"]
    code, out, err = run(capsys, "puma560", "--dh", *rows, "--degrees")
    assert (code, err) == (0, ""), out
    assert "all correct" in out
    code, out, err = run(capsys, "puma560", "--dh", *rows)
    assert code == 1
    assert "degrees" in out
    assert "puma560" in err
    rows[2] = "a=0.4318 d=-0.15005"
    code, out, _ = run(capsys, "puma560", "--dh", *rows, "--degrees", "--json")
    data = json.loads(out)
    assert (code, data["correct"]) == (1, False)
    assert [(f["mistake"], f["row"], f["entry"]) for f in data["findings"]] == [("sign", 3, "d")]


def test_a_table_in_a_file(capsys: pytest.CaptureFixture[str], tmp_path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(TABLE)
    assert run(capsys, "planar3r", str(file))[0] == 0
    file.write_text(TABLE.replace("1000.0", "900.0", 1))
    code, out, _ = run(capsys, "planar3r", str(file))
    assert code == 1
    assert "row 2 a: 0.9 should be 1;" in out
    code, out, _ = run(capsys, "planar3r", str(file), "--lang", "ar")
    assert "القيمة خاطئة" in out
    assert "\u2066a\u2069" in out or "\u2066" in out
    assert "<U+" not in out


def test_screws_typed_and_in_a_file(capsys: pytest.CaptureFixture[str], tmp_path) -> None:
    assert run(capsys, "planar2r", "--screws", "0 0 1 0 0 0", "0 0 1 0 -1 0")[0] == 0
    code, out, _ = run(capsys, "planar2r", "--screws", "0 0 1 0 0 0", "0 0 1 0 1 0")
    assert code == 1
    assert "v is ω × q" in out
    file = tmp_path / "screws.toml"
    rows = "".join(f"[[joint]]\nscrew = {s}\n" for s in ("[0, 0, 1, 0, 0, 0]", "[0, 0, 1, 0, -1, 0]"))
    file.write_text(f'convention = "space"\nhome = {{ xyz = [2, 0, 0] }}\n{rows}')
    assert run(capsys, "planar2r", str(file))[0] == 0


def test_jacobians_typed_and_in_a_file(capsys: pytest.CaptureFixture[str], tmp_path) -> None:
    rows = [" -L1*s1 - L2*s12, -L2*s12", "L1*c1 + L2*c12, L2*c12"]
    assert run(capsys, "planar2r", "--kind", "tip", "--jacobian", *rows)[0] == 0
    code, out, _ = run(capsys, "planar2r", "--kind", "tip", "--jacobian", rows[0], "L1*c1 + L1*c12, L2*c12")
    assert code == 1
    assert "L1 * c1 + L1 * c12 should be L1 * c1 + L2 * c12" in out
    own = [row.replace("L1", "u").replace("L2", "w") for row in rows]
    assert run(capsys, "planar2r", "--kind", "tip", "--jacobian", *own, "--letter", "u=1", "w=1m")[0] == 0
    numbers = ["-1, -1", "1, 0"]
    assert run(capsys, "planar2r", "--kind", "tip", "--jacobian", *numbers, "--q", "0", "90", "--degrees")[0] == 0
    file = tmp_path / "mine.toml"
    file.write_text('kind = "tip"\njacobian = [["-L1*s1 - L2*s12", "-L2*s12"], ["L1*c1 + L2*c12", "L2*c12"]]\n')
    assert run(capsys, "planar2r", str(file))[0] == 0


@pytest.mark.parametrize(
    "words",
    [
        ["planar2r"],
        ["planar2r", "no_such.toml"],
        ["planar2r", "--dh", "0 0 0 0"],
        ["planar2r", "--dh", "0 0 0 0 0", "0"],
        ["planar2r", "--dh", "b=3", "0"],
        ["planar2r", "--dh", "zero", "0"],
        ["planar2r", "--screws", "0 0 1", "0 0 1"],
        ["planar2r", "--screws", "0 0 1 0 0 0", "0 0 1 0 -1 0", "--kind", "tip"],
        ["planar2r", "--jacobian", "L1*s1"],
        ["planar2r", "--jacobian", "x9, 0", "--kind", "tip"],
        ["planar2r", "--dh", "0", "0", "--screws", "0 0 1 0 0 0"],
        ["planar2r", "--jacobian", "L1, L2", "--letter", "u"],
    ],
)
def test_what_cannot_be_read_is_one_sentence(capsys: pytest.CaptureFixture[str], words: list[str]) -> None:
    code, out, err = run(capsys, *words)
    assert code == 2
    assert out == ""
    assert len(err.strip().splitlines()) == 1


def test_files_of_another_form(capsys: pytest.CaptureFixture[str], tmp_path) -> None:
    file = tmp_path / "frames.toml"
    file.write_text('convention = "frames"\n[[joint]]\nxyz = [0, 0, 0]\n')
    assert run(capsys, "planar2r", str(file))[0] == 2
    file.write_text("jacobian = 3")
    assert run(capsys, "planar2r", str(file))[0] == 2
    file.write_text("jacobian = [")
    assert run(capsys, "planar2r", str(file))[0] == 2


def test_a_job_is_checked_by_a_command_of_its_own(tmp_path, capsys):
    path = tmp_path / "job.toml"
    path.write_text('robto = "panda"\n[[mvoe]]\njonts = [0, 0]\n', encoding="utf-8")
    assert main(["check-job", str(path)]) == 2
    assert "did you mean: robot" in capsys.readouterr().err
    table = tmp_path / "arm.toml"
    table.write_text('convention = "modified"\n[[joint]]\nkind = "R"\n', encoding="utf-8")
    assert main(["check-homework", str(table)]) == 2
    assert "--dh" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("word", "names"),
    [("check", "check-homework, check-job"), ("bench", "compare"), ("Doctor", "info"), ("sho", "show")],
)
def test_words_of_other_tools_lead_to_a_command(word, names, capsys):
    assert main([word, "panda"]) == 2
    assert f"did you mean: {names}?" in capsys.readouterr().err
