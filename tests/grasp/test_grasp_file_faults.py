"""Sketches and options as they should not be: every one is refused in our own words, none ends in a traceback."""

from __future__ import annotations

import json

import pytest

from mafsil.cli.main import main
from mafsil.errors import MafsilError
from mafsil.grasp.grasp_file import parse_grasp_file, read_grasp

RECTANGLE = [[-2, -1], [2, -1], [2, 1], [-2, 1]]
CORNER = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def contact(point=(0.5, 1), normal=(0, -1), **more):
    return {"point": list(point) if isinstance(point, tuple) else point, "normal": normal, **more}


def described(**more):
    return {"contact": [contact()], **more}


FAULTS = {
    "no table": [],
    "nested point": {"contact": [contact([[0, 1]])]},
    "ragged point": {"contact": [contact([0, [1]])]},
    "text": {"contact": [contact(["a", 1])]},
    "no number": {"contact": [contact(mu="x")]},
    "whole number without end": {"contact": [contact(mu=10**400)]},
    "curvature without end": {"contact": [contact(curvature=10**400)]},
    "coordinate without end": {"contact": [contact([10**400, 0])]},
    "nan": {"contact": [contact([float("nan"), 0])]},
    "nan curvature": {"contact": [contact(finger_curvature=float("nan"))]},
    "load list": described(load=[1, 2, 3]),
    "nested moment": described(load={"moment": [[1]], "force": [0, 1]}),
    "body list": described(body=[]),
    "nested outline": described(body={"outline": [RECTANGLE, RECTANGLE]}),
    "two corners": described(body={"outline": RECTANGLE[:2]}),
    "one corner often": described(body={"outline": RECTANGLE[:1] * 5}),
    "a line": described(body={"outline": [[-1, 1], [1, 1], [2, 1]]}),
    "crossing": described(body={"outline": [[-2, -1], [2, 1], [2, -1], [-2, 1]]}),
    "endless outline": described(body={"outline": [[-1e308, -1], [1e308, -1], [0, 1]]}),
    "many corners": described(body={"outline": [[0, 0]] * 6000}),
    "off the outline": {"contact": [contact([0, 0])], "body": {"outline": RECTANGLE}},
    "no mesh": {"contact": [contact([0, 0, 0], [0, 0, 1])], "body": {"mesh": "none.stl"}},
    "mesh in the plane": described(body={"mesh": "none.stl"}),
}


@pytest.mark.parametrize("name", FAULTS)
def test_faulty_grasp_files_are_refused_by_name(name, tmp_path):
    path = tmp_path / "grasp.json"
    path.write_text(json.dumps(FAULTS[name]))
    with pytest.raises(MafsilError) as caught:
        read_grasp(path)
    for language in ("en", "ar"):
        assert caught.value.message(language)


@pytest.mark.parametrize("language", ["en", "ar"])
@pytest.mark.parametrize(
    "options",
    [["--facets", "2"], ["--facets", "1000000000"], ["--facets", "1" + "0" * 400], ["--facets", "x"], ["--mu", "0.5"]],
)
def test_faulty_options_are_refused(options, language, tmp_path, capsys):
    path = tmp_path / "pinch.json"
    tips = [contact([1, 0, 0], [-1, 0, 0], mu=0.5, gamma=0.1), contact([-1, 0, 0], [1, 0, 0], mu=0.5, gamma=0.1)]
    path.write_text(json.dumps({"contact": tips}))
    assert main(["grasp", str(path), *options, "--lang", language]) == 2
    assert "--debug" not in capsys.readouterr().err


@pytest.mark.parametrize(
    "options", [["--mu", "-1"], ["--mu", "nan"], ["--gamma", "-1"], ["--opening", "0"], ["--mu", "x"]]
)
def test_faulty_options_of_a_mesh_are_refused(options, tmp_path, capsys):
    path = tmp_path / "corner.obj"
    path.write_text(CORNER)
    assert main(["grasp", str(path), *options]) == 2
    assert "--debug" not in capsys.readouterr().err


def test_options_of_a_mesh_are_read_as_people_type_them(tmp_path, capsys):
    path = tmp_path / "corner.obj"
    path.write_text(CORNER)
    assert main(["grasp", str(path), "--mu", "0.9", "--gamma", "50mm", "--opening", "2", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["grasps"][0]["contact"][0]["mu"] == 0.9
    assert found["grasps"][0]["contact"][0]["gamma"] == 0.05


@pytest.mark.capability("03-49")
@pytest.mark.parametrize("size", [1e-250, 1e-6, 1e6, 1e250])
def test_what_holds_does_not_depend_on_the_unit_of_force(size):
    tips = [contact([-1, 0], [1, 0], mu=0.5), contact([1, 0], [-1, 0], mu=0.5)]
    held = parse_grasp_file({"contact": tips, "load": {"force": [0, -size]}}, source="data")
    forces = held.grasp.resist(held.load)
    assert forces.holds
    assert forces.total_push / size == pytest.approx(2.0)
    assert not held.grasp.resist([0, 0, -size], push=0.9 * size).holds


def test_outlines_may_be_closed_by_their_first_corner():
    assert parse_grasp_file(described(body={"outline": [*RECTANGLE, RECTANGLE[0]]}), source="data").outline is not None
