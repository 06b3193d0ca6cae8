"""`mafsil ik`: tables for people, JSON for machines, refusals with reasons."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.parallel import ClosedChain

ROBOTS = Path(__file__).resolve().parents[2] / "examples" / "robots"
POSE = ["0.4", "0.1", "0.3", "180", "0", "90"]


def test_all_solutions_as_json(capsys):
    assert main(["ik", "ur5e", "--pose", *POSE, "--degrees", "--all", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["status"] == "solved"
    assert data["complete"]
    assert len(data["solutions"]) == 8
    robot = mf.load("ur5e")
    assert [solution["turn_count"] for solution in data["solutions"]] == [64] * 8
    for solution in data["solutions"]:
        T = robot.forward_kinematics(np.array(solution["q"]))
        np.testing.assert_allclose(T, data["pose"], atol=1e-9)


def test_rows_have_the_numbers_that_the_explanation_speaks_of(capsys):
    arguments = ["ik", "puma560", "--pose", "0.4", "0.1", "0.3", "0", "0", "0"]
    assert main([*arguments, "--all"]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()[2:10]]
    assert [row[0] for row in rows] == [str(k) for k in range(1, 9)]
    inside = [row for row in rows if row[-2] == "inside"]
    assert [row[-1] for row in rows if row[-2] == "outside"] == ["0"] * 7
    assert main(arguments) == 0
    assert capsys.readouterr().out.splitlines()[2].split() == inside[0]


def test_many_members_of_a_continuum_are_told_as_ranges(capsys):
    assert main(["ik", "panda", "--pose", "0.4", "0.1", "0.3", "3.1", "0", "0", "--all"]) == 0
    assert "solutions 1-8 belong" in capsys.readouterr().out


@pytest.mark.parametrize("language", ["en", "ar"])
def test_pictures_of_all_postures(capsys, tmp_path, language):
    path = tmp_path / "postures.png"
    assert main(["ik", "ur5e", "--pose", *POSE, "--all", "--picture", str(path), "--lang", language]) == 0
    assert path.read_bytes().startswith(b"\x89PNG")
    assert str(path) in capsys.readouterr().out
    for place, told in ((tmp_path / "none" / "p.png", "p.png"), (tmp_path / "p.bmp", ".svg")):
        assert main(["ik", "ur5e", "--pose", *POSE, "--picture", str(place), "--lang", language]) == 2
        (line,) = capsys.readouterr().err.strip().splitlines()
        assert told in line


@pytest.mark.parametrize(
    "words",
    [["--pose"], ["--pose", "1", "2"], ["--pose", "a", "b", "c"], ["--pose", "nan", "0", "0"]]
    + [["--pose", "0", "0", "0", *more] for more in (["--task", "x"], ["--frame", "x"], ["--tip", "x"])],
)
def test_wrong_arguments_are_one_sentence(capsys, words):
    assert main(["ik", "ur5e", *words]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


@pytest.mark.parametrize("language", ["en", "ar"])
def test_tables_and_refusals(capsys, language):
    assert main(["ik", "ur5e", "--pose", *POSE, "--degrees", "--lang", language]) == 0
    assert "°" in capsys.readouterr().out
    assert main(["ik", "ur5e", "--pose", "5", "0", "0", "--lang", language]) == 1
    assert capsys.readouterr().err
    assert main(["ik", "ur5e", "--pose", "5", "0", "--lang", language]) == 2
    assert capsys.readouterr().err


def test_mechanisms_with_loops_get_configurations_that_close_them(capsys):
    place = ["0.2121", "-0.2121", "0.65", "0", "0", "10deg"]
    words = ["ik", str(ROBOTS / "stewart.xml"), "--pose", *place, "--tip", "platform"]
    assert main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["status"] == "found"
    chain = ClosedChain(mf.load(ROBOTS / "stewart.xml", tip="platform"))
    (only,) = found["solutions"]
    assert only["within_limits"]
    assert chain.error(only["q"]) < 1e-12
    np.testing.assert_allclose(chain.robot.forward_kinematics(only["q"])[:3, 3], [0.2121, -0.2121, 0.65], atol=1e-9)
    assert main([*words, "--all"]) == 0
    assert "closed loops reach the pose" in capsys.readouterr().out
    far = ["ik", str(ROBOTS / "palletiser.xml"), "--pose", "3", "0", "0.7", "--tip", "forearm"]
    assert main([*far, "--lang", "en"]) == 1
    assert "not found" in capsys.readouterr().err


@pytest.mark.parametrize(
    "pose",
    [
        "0.4 0.1 0.3 0 90deg 0",
        "0.4 0.1 0.3 0.7071 0 0.7071 0",
        "0 0 1 0.4 0 1 0 0.1 -1 0 0 0.3",
        "0 0 1 0.4 0 1 0 0.1 -1 0 0 0.3 0 0 0 1",
    ],
)
def test_a_pose_in_any_form_and_the_solution_nearest_to_a_start(pose, capsys):
    near = ["3", "-1", "1", "7", "0", "0"]
    assert main(["ik", "ur5e", "--pose", *pose.split(), "--near", *near, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    T = [[0, 0, 1, 0.4], [0, 1, 0, 0.1], [-1, 0, 0, 0.3], [0, 0, 0, 1]]
    np.testing.assert_allclose(data["pose"], T, atol=1e-12)
    robot = mf.load("ur5e")
    np.testing.assert_allclose(robot.forward_kinematics(np.array(data["near"])), T, atol=1e-9)
    expected = mf.inverse_kinematics(robot, T).nearest([float(x) for x in near])
    np.testing.assert_allclose(data["near"], expected, atol=1e-12)
    assert data["near"][3] > np.pi


@pytest.mark.parametrize("pose", ["1 2 3 4 0 0 0", "1 0 0 0.4 0 1 0 0.1 0 0 2 0.3", "1 2 3 4 5"])
def test_what_is_no_pose_is_refused(pose, capsys):
    assert main(["ik", "ur5e", "--pose", *pose.split()]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
