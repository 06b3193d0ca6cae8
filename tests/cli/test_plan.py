"""`mafsil plan`: ways round obstacles of a file, their refusals, the timed motion that is written."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.job.reading import parse_scene
from mafsil.job.surroundings import scene_of, with_shapes

SCENE = str(Path(__file__).parents[2] / "examples" / "scenes" / "wall.toml")
LEFT, RIGHT = ["45", "20", "0", "-110", "0", "130", "45"], ["-45", "20", "0", "-110", "0", "130", "45"]


def asked(capsys, *words):
    code = main(["plan", "panda", "--degrees", *words])
    out, err = capsys.readouterr()
    return code, out, err


@pytest.mark.capability("11-40", "11-50")
def test_a_way_round_a_wall_is_printed_and_written(capsys, tmp_path):
    way = tmp_path / "way.csv"
    words = ["--start", *LEFT, "--goal", *RIGHT, "--scene", SCENE, "--clearance", "0.02"]
    code, out, _ = asked(capsys, *words, "--out", str(way), "--json")
    data = json.loads(out)
    assert code == 0
    assert data["status"] == "FOUND"
    assert data["clearance"] > 0.02
    scene = scene_of(parse_scene(Path(SCENE).read_text("utf-8")))
    checker = mf.collision.Checker(with_shapes(mf.load("panda").mechanism), scene, margin=0.02, self_collision=False)
    assert checker.check_path(np.array(data["path"]))
    motion = mf.trajectory.read(way, joints=mf.load("panda").joint_names)
    t = np.linspace(0.0, motion.duration, 500)
    assert checker.free(motion.at(t).u).all()
    np.testing.assert_allclose(motion.at(motion.duration).u, np.radians([float(x) for x in RIGHT]), atol=1e-9)
    assert asked(capsys, *words)[0] == 0
    code, out, _ = asked(capsys, "--start", *LEFT, "--pose", "0.45", "-0.3", "0.25", "180", "0", "0", "--scene", SCENE)
    assert code == 0
    assert "nearest on the way" in out


def test_what_stands_in_the_way_is_named(capsys, tmp_path):
    inside = ["0", "60", "0", "-60", "0", "110", "45"]
    code, _, err = asked(capsys, "--start", *inside, "--goal", *RIGHT, "--scene", SCENE)
    assert code == 1
    assert "wall" in err
    code, _, err = asked(capsys, "--start", *LEFT)
    assert code == 2
    assert "--pose" in err
    broken = tmp_path / "scene.toml"
    broken.write_text("[[obstacle]]\nposition = [0, 0, 0]\nbal = 1\n")
    code, _, err = asked(capsys, "--start", *LEFT, "--goal", *RIGHT, "--scene", str(broken))
    assert code == 2
    assert "scene.toml:3" in err
    code, _, err = asked(capsys, "--start", *LEFT, "--goal", *RIGHT, "--scene", str(tmp_path / "none.toml"))
    assert code == 2
    assert "none.toml" in err
