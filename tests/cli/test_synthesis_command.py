"""`mafsil synthesis`: tasks in files, their answers, and files that are no tasks."""

import json
from pathlib import Path

import numpy as np
import pytest

from mafsil.cli.main import main
from mafsil.errors import MafsilError
from mafsil.mobility.synthesis import synthesise_file
from mafsil.mobility.synthesis.task_file import function_of

EXAMPLES = Path(__file__).parents[2] / "examples" / "synthesis"


@pytest.mark.parametrize("name", ["five_poses", "timed_path", "logarithm", "six_bar", "spherical"])
@pytest.mark.parametrize("language", ["en", "ar"])
def test_examples_have_linkages(name, language, capsys):
    assert main(["synthesis", str(EXAMPLES / f"{name}.toml"), "--lang", language]) == 0
    shown = capsys.readouterr().out
    assert len(shown.split("\n")) > 5


def test_the_data_and_the_picture(tmp_path, capsys):
    picture = tmp_path / "bar.png"
    call = ["synthesis", str(EXAMPLES / "five_poses.toml"), "--json", "--candidate", "6", "--picture", str(picture)]
    assert main(call) == 0
    data = json.loads(capsys.readouterr().out)
    data = data.get("answer", data)
    assert len(data["candidates"]) == 6
    assert data["candidates"][5]["defects"] == ["circuit"]
    assert picture.stat().st_size > 10_000


def test_cognates_and_pictures_of_other_linkages(tmp_path, capsys):
    call = ["synthesis", str(EXAMPLES / "five_poses.toml"), "--json", "--cognates"]
    assert main(call) == 0
    data = json.loads(capsys.readouterr().out)
    assert data.get("answer", data)["cognates"]["difference"] < 1e-9
    assert main(["synthesis", str(EXAMPLES / "six_bar.toml"), "--cognates"]) != 0
    assert "four-bars" in "".join(capsys.readouterr())
    for name in ("six_bar", "spherical"):
        picture = tmp_path / f"{name}.png"
        assert main(["synthesis", str(EXAMPLES / f"{name}.toml"), "--picture", str(picture)]) == 0
        assert picture.stat().st_size > 10_000


def test_an_honest_no(tmp_path, capsys):
    file = tmp_path / "hinge.toml"
    file.write_text("degrees = true\nposes = [[1, 0, 0], [0, 1, 90], [-1, 0, 180]]", "utf-8")
    assert main(["synthesis", str(file)]) == 1
    assert "single revolute joint" in "".join(capsys.readouterr())
    assert main(["synthesis", str(file), "--candidate", "1"]) != 0


def test_the_error_of_a_function_is_shown(capsys):
    assert main(["synthesis", str(EXAMPLES / "logarithm.toml"), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert 0 < data.get("answer", data)["structural_error"] < 1e-3


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "give exactly one of"),
        ("poses = [[0, 0, 0]]\npoints = [[0, 0]]", "poses, points"),
        ("poses = [[0, 0, 0]]", "3 to 5"),
        ("poses = [[0, 0], [1]]", "poses"),
        ("orientations = [[0, 0, 0], [1, 0, 0]]", "three to five"),
        ("points = [[0, 0], [1, 0], [2, 1]]\ntiming = [0, 1, 2]\nform = 'watt'", "5 to 5"),
        ("points = [[0, 0], [1, 0], [2, 1]]\ntiming = [0, 1, 2]\nform = 'klann'", "watt"),
        ("poses = [[0, 0, 0], [1, 0.6, 1], [2, 0.8, 2]]\n[limits]\nlongest = 'x'", "longest"),
        ("poses = [[0, 0, 0], [1, 0.6, 1], [2, 0.8, 2]]\n[limits]\nheight = 1", "height"),
        ("poses = 'here'", "poses"),
        ("poses = [[0, 0, 0]]\nspeed = 3", "speed"),
        ("degrees = 1\nposes = [[0, 0, 0]]", "degrees"),
        ("points = [[0, 0], [1, 0], [2, 1]]\ntiming = [0, 1]", "timing"),
        ("function = 3", "[function]"),
        ("[function]\nformula = 'x'", "interval"),
        ("[function]\nformula = 'x'\ninterval = [0, 1]\ninputs = [0, 1]\noutputs = [0, 1]\ncount = 9", "count"),
        ("[function]\nformula = '__import__(\"os\")'\ninterval = [0, 1]\ninputs = [0, 1]\noutputs = [0, 1]", "formula"),
        ("poses = [", "TOML"),
    ],
)
def test_files_that_are_no_tasks(text, words, tmp_path):
    file = tmp_path / "task.toml"
    file.write_text(text, "utf-8")
    with pytest.raises(MafsilError) as caught:
        synthesise_file(file)
    assert words in caught.value.message("en")
    assert caught.value.message("ar") != caught.value.message("en")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(MafsilError, match=r"none\.toml"):
        synthesise_file(tmp_path / "none.toml")


def test_formulas():
    x = np.linspace(0.5, 2, 7)
    np.testing.assert_allclose(
        function_of("-2*x**2 + sin(pi*x)/3 - sqrt(x)", "f")(x), -2 * x**2 + np.sin(np.pi * x) / 3 - np.sqrt(x)
    )
    for wrong in ("y", "x.real", "x[0]", "exec(x)", "lambda: x", "x if x else 1", "'a'", "True", "x" * 300, "(" * 150):
        with pytest.raises(MafsilError, match="formula"):
            function_of(wrong, "f")
