"""Parallel robots from files, and the command that asks them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mafsil import parallel
from mafsil.cli.main import main
from mafsil.errors import FileError
from mafsil.geometry import pose, rotation
from mafsil.parallel.robot_file import KINDS, read_parallel

EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "parallel"
FIVE_BAR = 'kind = "five_bar"\ncrank_1 = 1\nrod_1 = 1.5\nrod_2 = 1.5\ncrank_2 = 1\nground = 1.2\n'
THREE_RRR = """kind = "3rrr"
base = [[0, 0], [3, 0], [1.5, 2.6]]
platform = [[-0.4, -0.2], [0.4, -0.2], [0, 0.4]]
cranks = [1, 1, 1]
rods = [1.2, 1.2, 1.2]
"""
PLANAR_CABLES = """kind = "cable"
base = [[0, 0], [4, 0], [4, 3], [0, 3]]
platform = [[-0.2, 0.1], [0.2, 0.1], [0.2, -0.1], [-0.2, -0.1]]
lowest = 1
highest = 500
"""


def ask(capsys, *words: object) -> dict:
    code = main(["parallel", *map(str, words), "--json"])
    printed = json.loads(capsys.readouterr().out)
    return {"code": code, **printed}


def written(tmp_path, text: str) -> Path:
    path = tmp_path / "robot.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_examples_are_robots(path):
    assert isinstance(read_parallel(path), (*KINDS.values(), parallel.RodRobot))


def test_the_hexapod_is_asked_there_and_back(capsys):
    file = EXAMPLES / "hexapod.toml"
    there = ask(capsys, file, "--pose", 0.1, -0.2, 1.6, 10, 0, 5, "--degrees", "--load", 0, 0, 0, 0, 0, 100)
    robot = read_parallel(file)
    T = pose.from_rotation_translation(rotation.from_rpy(np.radians([10, 0, 5])), [0.1, -0.2, 1.6])
    assert np.allclose(np.ravel(there["motors"]), robot.lengths(T))
    assert np.allclose(robot.wrench(T, there["efforts"]), [0, 0, 0, 0, 0, 100])
    assert there["nearest_singularity"]["free"] < there["nearest_singularity"]["distance"]
    back = ask(capsys, file, "--motors", *np.ravel(there["motors"]))
    assert any(np.allclose(x, [0.1, -0.2, 1.6, *np.radians([10, 0, 5])], atol=1e-8) for x in back["poses"])


def test_ways_of_the_planar_platform(capsys, tmp_path):
    found = ask(capsys, EXAMPLES / "planar_3rpr.toml", "--motors", 14.98, 15.38, 12, "--ways")
    assert len(found["poses"]) == 6
    assert sum(way["status"] == "proven" for way in found["ways"]) == 6
    picture = tmp_path / "planar.svg"
    assert main(["parallel", str(EXAMPLES / "planar_3rpr.toml"), "--motors", "14.98", "15.38", "12", "--picture",
                 str(picture)]) == 0  # fmt: skip
    assert picture.stat().st_size > 1000


@pytest.mark.parametrize(
    ("text", "x", "load"),
    [
        (FIVE_BAR, [0.5, 1.6], [3.0, -2.0]),
        (THREE_RRR, [1.5, 0.9, 0.1], [0.5, 2.0, -3.0]),
        ((EXAMPLES / "delta.toml").read_text(), [0.1, 0.05, -0.9], [1.0, 2.0, -9.81]),
    ],
)
def test_efforts_do_the_work_of_the_load(text, x, load, capsys, tmp_path):
    file = written(tmp_path, text)
    there = ask(capsys, file, "--pose", *x, "--load", *load)
    assert there["singularity"]["status"] == "regular"

    def motors(place):
        choices = np.array(ask(capsys, file, "--pose", *place)["motors"])
        return np.array([choices[0, 0], choices[1, 1]]) if text == FIVE_BAR else choices[:, 0]

    back = np.array(ask(capsys, file, "--motors", *motors(x))["poses"])
    assert np.abs(back - x).max(axis=1).min() < 1e-8
    h, work = 1e-5, []
    for k in range(len(x)):
        step = h * np.eye(len(x))[k]
        rate = (motors(x + step) - motors(x - step)) / (2 * h)
        work.append(np.dot(there["efforts"], rate))
    order = [1, 2, 0] if text == THREE_RRR else range(len(x))
    expected = np.array(load)[order]
    if text == THREE_RRR:
        expected[2] -= np.cross(np.append(x[:2], 0), [*load[1:], 0])[2]
    assert np.allclose(work, expected, atol=1e-6)


def test_cables_there_and_back(capsys):
    x = [0.3, 0.2, 1.6, 0.1, 0.0, -0.1]
    lengths = np.ravel(ask(capsys, EXAMPLES / "crane.toml", "--pose", *x)["motors"])
    back = ask(capsys, EXAMPLES / "crane.toml", "--motors", *lengths)
    assert np.allclose(back["poses"], [x], atol=1e-8)
    assert main(["parallel", str(EXAMPLES / "crane.toml"), "--motors", *["2"] * 8]) == 1
    assert "no platform pose" in capsys.readouterr().err


def test_cables(capsys, tmp_path):
    found = ask(capsys, EXAMPLES / "crane.toml", "--pose", 0.3, 0.2, 1.6, 0, 0, 0, "--load", 80, -120, 0, 0, 0, 400)
    robot = read_parallel(EXAMPLES / "crane.toml")
    T = pose.from_translation([0.3, 0.2, 1.6])
    assert np.allclose(robot.wrench(T, found["efforts"]), [80, -120, 0, 0, 0, 400])
    plane = written(tmp_path, PLANAR_CABLES)
    up = ask(capsys, plane, "--pose", 2, 1.5, 0, "--load", 0, 0, 50)
    assert up["code"] == 0
    assert min(up["efforts"]) >= 1
    assert main(["parallel", str(plane), "--pose", "2", "1.5", "0", "--load", "0", "0", "5000"]) == 1
    assert "not held" in capsys.readouterr().err


def test_what_cannot_be_answered_is_said(capsys, tmp_path):
    delta, hexapod = EXAMPLES / "delta.toml", EXAMPLES / "hexapod.toml"
    assert main(["parallel", str(delta), "--pose", "5", "0", "-1"]) == 1
    assert "out of reach" in capsys.readouterr().err
    singular = written(tmp_path, 'kind = "3rpr"\nbase = [[0,0],[4,0],[1,3]]\nplatform = [[0,0],[4,0],[1,3]]\n')
    assert main(["parallel", str(singular), "--pose", "1", "2", "0", "--load", "1", "0", "0"]) == 1
    assert "second kind" in capsys.readouterr().err
    for words, said in (
        ([hexapod], "--pose"),
        ([hexapod, "--pose", 1, 2, 3], "x y z roll pitch yaw"),
        ([hexapod, "--motors", 1, 2, "nan", 1, 1, 1], "motors"),
        ([delta, "--motors", 0.1, 0.1, 0.1, "--ways"], "stewart"),
        ([EXAMPLES / "crane.toml", "--pose", 0, 0, 1, 0, 0, 0, "--picture", "x.png"], "picture"),
        ([tmp_path / "none.toml", "--pose", 1], "none.toml"),
    ):
        assert main(["parallel", *map(str, words)]) == 2
        assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("kind = 3", "kind 3"),
        ('kind = "tripod"', "tripod"),
        ('kind = "delta"\nbase = 1', "platform is missing"),
        ('kind = "delta"\nbase = 1\nplatform = 1\narm = 1\nforearm = 1\nlegs = 3', "legs"),
        ('kind = "delta"\nbase = -1\nplatform = 1\narm = 1\nforearm = 1', "base"),
        ('kind = "3rpr"\nbase = "x"\nplatform = [[0,0],[1,0],[0,1]]', "base"),
        ('kind = "stewart"\nbase_radius = 1\nplatform_radius = 1\nbase_angles = [1]\nplatform_angles = [1,2,3,4,5,6]',
         "base_angles"),
        ("kind = ", "TOML"),
    ],
)  # fmt: skip
def test_bad_files_are_named(text, said, tmp_path):
    with pytest.raises(FileError, match=said):
        read_parallel(written(tmp_path, text))


def test_stewart_by_places(tmp_path):
    rng = np.random.default_rng(0)
    base, platform = rng.normal(size=(2, 6, 3))
    file = written(tmp_path, f'kind = "stewart"\nbase = {base.tolist()}\nplatform = {platform.tolist()}\n')
    robot = read_parallel(file)
    assert isinstance(robot, parallel.StewartPlatform)
    assert np.array_equal(robot.base, base)


def test_a_file_that_is_too_large_is_said_to_be(tmp_path):
    with pytest.raises(FileError, match="larger than the 1000000 bytes") as caught:
        read_parallel(written(tmp_path, "# " + "x" * 1_000_001))
    assert "no TOML" not in str(caught.value)


ON_RODS = {
    "rotary_delta": "base = 0.2\nplatform = 0.05\narms = 0.3\nforearms = [0.8, 0.81, 0.79]\nangles = [0, 120, 240]\n",
    "five_bar_on_rods": "base = [[0, 0], [0.3, 0]]\narms = 0.3\nrods = 0.45\n",
    "planar_on_rods": "base = [[0.5, 0], [-0.25, 0.43], [-0.25, -0.43]]\nplatform = [[0.1, 0], [-0.05, 0.09], "
    "[-0.05, -0.09]]\nrods = 0.35\narms = 0.3\n",
    "h4": "base = [[0.3, 0, 0], [-0.3, 0.1, 0], [0, -0.3, 0], [0.1, -0.3, 0]]\nrotating = [[0, 0.06, 0], [0, 0.06, 0], "
    "[0, -0.06, 0], [0, -0.06, 0]]\nfixed = [[0.1, 0, 0], [-0.1, 0, 0], [-0.1, 0, 0], [0.1, 0, 0]]\narms = 0.3\n"
    "rods = 0.8\nangles = [0, 180, 270, 270]\n",
}
PLACES = {
    "rotary_delta": (0.1, -0.05, -0.7), "five_bar_on_rods": (0.2, 0.5), "planar_on_rods": (0.03, 0.05, 0.2),
    "h4": (0.05, 0.03, -0.7, 0.2),
}  # fmt: skip


@pytest.mark.parametrize("kind", ON_RODS)
def test_robots_on_rods_are_asked_there_and_back(kind, tmp_path, capsys):
    path, x = written(tmp_path, f'kind = "{kind}"\n{ON_RODS[kind]}'), PLACES[kind]
    load = [1.0] * len(x)
    there = ask(capsys, path, "--pose", *x, "--load", *load)
    assert there["code"] == 0
    answer = there.get("answer", there)
    motors = np.array(answer["motors"])[:, 0]
    back = ask(capsys, path, "--motors", *motors)
    poses = np.array(back.get("answer", back)["poses"])
    assert np.abs(poses - x).max(axis=1).min() < 1e-8
    wrong = written(tmp_path, f'kind = "{kind}"\nscrews = 3\n{ON_RODS[kind]}')
    with pytest.raises(FileError, match="unknown key screws"):
        read_parallel(wrong)
