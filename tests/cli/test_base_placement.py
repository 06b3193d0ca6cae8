"""`mafsil base-placement`: a base pose for the targets of a file, the map, and refusals."""

from __future__ import annotations

import json
from pathlib import Path

from mafsil.cli.main import main

EXAMPLES = Path(__file__).parents[2] / "examples"
TARGETS, SCENE = str(EXAMPLES / "targets" / "six_places.csv"), str(EXAMPLES / "scenes" / "table.toml")


def test_a_place_is_printed_and_drawn(capsys, tmp_path):
    picture = tmp_path / "where.png"
    words = ["base-placement", "ur5", "--degrees", "--targets", TARGETS, "--scene", SCENE]
    words += ["--y", "-0.4", "0.4", "--stands-on", "table"]
    assert main([*words, "--picture", str(picture), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["status"] == "found"
    assert len(data["configurations"]) == 6
    assert picture.stat().st_size > 5000
    assert main(words) == 0
    assert "best base" in capsys.readouterr().out


def test_what_cannot_be_reached_is_said(capsys, tmp_path):
    code = main(["base-placement", "ur5", "--degrees", "--targets", TARGETS, "--x", "2", "2.2"])
    assert code == 1
    assert "target 0 is not reached" in capsys.readouterr().err
    assert main(["base-placement", "ur5", "--targets", TARGETS, "--x", "2"]) == 2
    assert "from and to" in capsys.readouterr().err
    broken = tmp_path / "targets.csv"
    broken.write_text("x,y,z\n1,2,3\n")
    assert main(["base-placement", "ur5", "--targets", str(broken)]) == 2
    assert "roll" in capsys.readouterr().err
