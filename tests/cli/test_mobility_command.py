"""`mafsil mobility`: files of bodies and joints, names of mechanisms, robots; yes, no, and errors."""

import json
from pathlib import Path

import pytest

from mafsil.cli.main import main

EXAMPLE = str(Path(__file__).parents[2] / "examples" / "linkages" / "four_bar.toml")


def test_a_file_of_bodies_and_joints(capsys):
    assert main(["mobility", EXAMPLE]) == 0
    out = capsys.readouterr().out
    assert "four-bar: mobility 1, as counted by Gruebler" in out
    assert "3 (4 - 1 - 4) + 4 = 1" in out


@pytest.mark.parametrize(("name", "mobility"), [("delta", 9), ("bennett", 1), ("ur5e", 6), ("puma560", 6)])
def test_names_and_json(name, mobility, capsys):
    assert main(["mobility", name, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["mobility"] == mobility
    assert (
        data["count"]["m"] * (data["count"]["links"] - 1 - data["count"]["joints"]) + sum(data["count"]["freedoms"])
        == (data["count"]["mobility"])
    )


def test_joints_locked_driven_and_in_all_choices(capsys):
    assert main(["mobility", "five_bar", "--locked-joints", "O", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["mobility"] == 1
    assert main(["mobility", "five_bar", "--actuated", "O", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["actuation"]["status"] == "underactuated"
    assert main(["mobility", "five_bar", "--subsets", "2", "--json"]) == 0
    subsets = json.loads(capsys.readouterr().out)["mobility_with_locked_joints"]
    assert len(subsets) == 10
    assert {one["mobility"] for one in subsets} == {0}


BALLS = """
[[joint]]
name = "U"
kind = "universal"
bodies = ["ground", "foot"]
second = [1, 0, 0]
[[joint]]
name = "R"
kind = "revolute"
bodies = ["ground", "crank"]
at = [0, 0, 1]
axis = [0, 1, 0]
[[joint]]
name = "A"
kind = "spherical"
bodies = ["crank", "rod"]
at = [0.5, 0, 1]
[[joint]]
name = "B"
kind = "spherical"
bodies = ["rod", "foot"]
at = [0.2, 0, 0]
"""


@pytest.mark.capability("02-60")
def test_surfaces_are_followed_and_drawn(capsys, tmp_path):
    (tmp_path / "balls.toml").write_text(BALLS)
    words = ["mobility", str(tmp_path / "balls.toml"), "--surfaces"]
    assert main([*words, "--picture", str(tmp_path / "surface.png"), "--json"]) == 0
    surfaces = json.loads(capsys.readouterr().out)["surfaces"]["surfaces"]
    assert [one["genus"] for one in surfaces] == [1, 1]
    assert surfaces[0]["coordinates"] == ["U.1", "U.2", "R"]
    assert surfaces[0]["left_out"] == ["A", "B"]
    assert (tmp_path / "surface.png").read_bytes().startswith(b"\x89PNG")


def test_what_does_not_move_ends_with_a_no(capsys):
    assert main(["mobility", "stretched_four_bar"]) == 1
    assert "blocked at second order" in capsys.readouterr().err
    assert main(["mobility", "ur5e", "--q", "0", "0", "0", "0", "0", "0"]) == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["no_such_thing"], "no_such_thing"),
        (["five_bar", "--locked-joints", "Q"], "there is no joint Q"),
        (["five_bar", "--subsets", "x"], "subsets"),
        (["four_bar", "--rule", "spatial"], ""),
        (["ur5e", "--q", "0"], "q"),
        (["four_bar", "--picture", "here.txt"], "here.txt"),
    ],
)
def test_errors_are_one_sentence(words, said, capsys):
    code = main(["mobility", *words])
    err = capsys.readouterr().err
    assert (code == 0) == (said == "")
    assert said in err
    assert "Traceback" not in err


def test_in_arabic(capsys, monkeypatch):
    assert main(["mobility", "bennett", "--lang", "ar"]) == 0
    assert "غروبلر" in capsys.readouterr().out


PRESS = str(Path(__file__).parents[2] / "examples" / "linkages" / "press.toml")


def test_a_press_driven_once_round(tmp_path, capsys):
    files = [str(tmp_path / f"press.{ending}") for ending in ("html", "csv", "svg", "dxf", "png")]
    call = ["linkage", PRESS, "--turn", "--speed", "6", "--rows", "48", "--out", *files[:4], "--picture", files[4]]
    assert main([*call, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    data = data.get("answer", data)
    assert data["status"] == "round"
    assert len(data["torque"]) == 48
    html, csv, svg, dxf, png = (Path(each).read_bytes() for each in files)
    assert b"crank A goes round" in html
    assert csv.count(b"\n") == 49
    assert b'width="' in svg
    assert png[:4] == b"\x89PNG"
    codes = dxf.decode("ascii").split("\n")
    entities = [value for code, value in zip(codes[::2], codes[1::2], strict=False) if code == "0"]
    assert entities.count("ARC") == 4 == entities.count("LINE") - 2
    assert entities[-1] == "EOF"


def test_links_and_their_lengths(capsys):
    assert main(["linkage", "four_bar"]) == 0
    shown = capsys.readouterr().out
    assert "B - C" in shown
    assert "4.000000" in shown
    assert main(["linkage", "four_bar", "--picture", "a.png"]) != 0
    assert "--turn" in capsys.readouterr().err
    assert main(["linkage", "bennett", "--out", "a.svg"]) != 0
    assert "planar" in capsys.readouterr().err
    assert main(["linkage", "five_bar", "--turn"]) != 0
    assert "driven joint" in capsys.readouterr().err
    assert main(["linkage", "peaucellier", "--turn", "--rows", "12"]) == 0
    assert "O1, P1, E1" in capsys.readouterr().out
