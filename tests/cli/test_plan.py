"""`mafsil plan`: ways round obstacles of a file, their refusals, the timed motion that is written."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.job.language.reading import parse_scene
from mafsil.job.planning.surroundings import scene_of
from mafsil.model.appearance import with_shapes
from mafsil.parallel import ClosedChain
from tests.collision.arms import LISTED, TOUCHING

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
    assert data["status"] == "found"
    assert data["clearance"] > 0.02
    scene = scene_of(parse_scene(Path(SCENE).read_text("utf-8")))
    checker = mf.collision.Checker(with_shapes(mf.load("panda").mechanism), scene, clearance=0.02, self_collision=False)
    assert checker.check_path(np.array(data["path"]))
    motion = mf.trajectory.read_trajectory(way, joints=mf.load("panda").joint_names)
    t = np.linspace(0.0, motion.duration, 500)
    assert checker.free(motion.at(t).u).all()
    np.testing.assert_allclose(motion.at(motion.duration).u, np.radians([float(x) for x in RIGHT]), atol=1e-9)
    assert asked(capsys, *words)[0] == 0
    code, out, _ = asked(capsys, "--start", *LEFT, "--pose", "0.45", "-0.3", "0.25", "180", "0", "0", "--scene", SCENE)
    assert code == 0
    assert "smallest clearance on the path" in out


def test_what_stands_in_the_way_is_named(capsys, tmp_path):
    inside = ["0", "60", "0", "-60", "0", "110", "45"]
    code, _, err = asked(capsys, "--start", *inside, "--goal", *RIGHT, "--scene", SCENE)
    assert code == 1
    assert "wall" in err
    assert main(["plan", "panda", "--start", *LEFT, "--goal", *RIGHT]) == 1
    assert "did you mean --degrees?" in capsys.readouterr().err
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


def test_a_pose_of_an_arm_with_four_joints_is_a_pose(capsys):
    words = [
        "plan",
        "cobra600",
        "--start",
        "0",
        "0.3",
        "0.05",
        "0",
        "--pose",
        "0.4",
        "0.3",
        "0.3",
        "180deg",
        "0",
        "0.5",
    ]
    assert main([*words, "--json"]) == 0
    path = np.array(json.loads(capsys.readouterr().out)["path"])
    place = mf.load("cobra600").forward_kinematics(path[-1])[:3, 3]
    np.testing.assert_allclose(place, [0.4, 0.3, 0.3], atol=1e-6)


def test_a_typed_pose_of_a_mechanism_with_loops_is_met_to_its_digits(capsys):
    robot = str(Path(__file__).resolve().parents[2] / "examples" / "robots" / "palletiser.xml")
    words = ["plan", robot, "--start", "0", "0", "0", "0", "--pose", "0.60428316", "0", "0.29064473", "0", "0.7", "0"]
    assert main([*words, "--json"]) == 0
    path = np.array(json.loads(capsys.readouterr().out)["path"])
    chain = ClosedChain(mf.load(robot))
    assert chain.error(path).max() < 1e-9
    np.testing.assert_allclose(path[-1][[0, 2]], [1.0, 0.7], atol=1e-6)


@pytest.mark.capability("11-39")
def test_pairs_that_a_semantic_description_lists_are_not_checked(capsys, tmp_path):
    robot, listed = tmp_path / "touching.urdf", tmp_path / "touching.srdf"
    robot.write_text(TOUCHING)
    listed.write_text(LISTED)
    words = ["plan", str(robot), "--start", "0", "0.1", "--goal", "1", "0"]
    assert main(words) == 1
    assert "base" in capsys.readouterr().err
    assert main([*words, "--srdf", str(listed)]) == 0
    assert main([*words, "--srdf", str(listed), "--clearance", "0.02", "--self-clearance", "0.01"]) == 0
    assert main([*words, "--srdf", str(tmp_path / "none.srdf")]) == 2
    assert "none.srdf" in capsys.readouterr().err


@pytest.mark.capability("11-39")
def test_pairs_that_meet_where_the_robot_is_known_to_be_free_are_not_checked(capsys, tmp_path):
    robot = tmp_path / "touching.urdf"
    robot.write_text(TOUCHING)
    words = ["plan", str(robot), "--start", "0", "0.1", "--goal", "1", "0"]
    assert main([*words, "--known-free", "0", "0.1"]) == 0
    assert "known_free=" in capsys.readouterr().out
    assert main([*words, "--known-free", "0", "0.1", "--json"]) == 0
    met = json.loads(capsys.readouterr().out)["not_checked"]
    assert met
    assert all(len(pair) == 2 for pair in met)
    assert main([*words, "--known-free", "0"]) == 2
    assert "known_free" in capsys.readouterr().err


def test_joints_that_may_move_are_named(capsys):
    code, _, err = asked(capsys, "--start", *LEFT, "--goal", *RIGHT, "--scene", SCENE, "--active-joints", "elbow")
    assert code == 2
    assert "joint4" in err
    words = ["--start", *LEFT, "--goal", *RIGHT, "--scene", SCENE, "--active-joints", "joint2", "joint4", "--json"]
    code, out, _ = asked(capsys, *words)
    assert code == 0
    moved = np.ptp(np.array(json.loads(out)["path"]), axis=0)
    assert (moved[[2, 4, 5, 6]] == 0.0).all()
    assert (moved[[0, 1, 3]] > 0.0).all()


@pytest.mark.capability("11-40")
def test_any_of_several_goals_and_a_region_will_do(capsys):
    near, far = ["45", "25", "0", "-100", "0", "130", "45"], RIGHT
    code, out, _ = asked(capsys, "--start", *LEFT, "--goal", *far, *near, "--json")
    assert code == 0
    np.testing.assert_allclose(json.loads(out)["path"][-1], np.radians([float(x) for x in near]), atol=1e-12)
    poses = ["0.45", "-0.3", "0.25", "180", "0", "0"], ["0.5", "0.3", "0.3", "180", "0", "0"]
    code, out, _ = asked(capsys, "--start", *LEFT, "--pose", *poses[0], *poses[1], "--json")
    assert code == 0
    tip = mf.load("panda").forward_kinematics(np.array(json.loads(out)["path"][-1]))[:3, 3]
    assert min(np.linalg.norm(tip - [float(x) for x in pose[:3]]) for pose in poses) < 1e-6
    blocked = ["0.55", "0", "0.3", "180", "0", "0"]
    assert asked(capsys, "--start", *LEFT, "--pose", *blocked, "--scene", SCENE)[0] == 1
    code, out, _ = asked(
        capsys, "--start", *LEFT, "--pose", *blocked, "--scene", SCENE, "--box", "0.1", "0.3", "0.1", "--json"
    )
    assert code == 0
    away = mf.load("panda").forward_kinematics(np.array(json.loads(out)["path"][-1]))[:3, 3] - [0.55, 0.0, 0.3]
    assert (np.abs(away) <= [0.1, 0.3, 0.1]).all()
    for words in (["--goal", *RIGHT, "--box", "0.1"], ["--pose", *poses[0], *poses[1], "--angle", "5"]):
        code, _, err = asked(capsys, "--start", *LEFT, *words)
        assert code == 2
        assert "--pose" in err
    code, _, err = asked(capsys, "--start", *LEFT, "--goal", *RIGHT, *RIGHT[:3])
    assert code == 2
    assert "goal" in err


@pytest.mark.capability("11-40", "11-46")
def test_what_is_kept_on_the_way_is_kept(capsys):
    panda = mf.load("panda")
    words = ["--start", *LEFT, "--goal", *RIGHT, "--scene", SCENE, "--json"]

    def along(*keep):
        code, out, _ = asked(capsys, *words, *keep)
        assert code == 0
        path = np.array(json.loads(out)["path"])
        shares = np.linspace(0.0, 1.0, 20)[:, None]
        return panda.forward_kinematics(np.concatenate([a + shares * (b - a) for a, b in pairwise(path)]))

    T = along("--upright", "15")
    assert np.degrees(np.arccos(T[:, :3, 2] @ T[0, :3, 2])).max() <= 15.0
    T = along("--plane", "0", "0", "1")
    assert np.ptp(T[:, 2, 3]) <= 2e-3
    for keep, said in (
        (["--line", "1", "0"], "line"),
        (["--upright", "200"], "angle"),
        (["--plane", "0", "0", "0"], "normal"),
    ):
        code, _, err = asked(capsys, *words, *keep)
        assert code == 2
        assert said in err
