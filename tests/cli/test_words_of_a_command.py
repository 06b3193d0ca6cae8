"""What people type: options anywhere, lists written as they like, names in capitals, slips of the finger, `-`."""

import io
import json
from pathlib import Path

import numpy as np
import pytest

from mafsil.cli.main import main
from mafsil.cli.parser import put_options_first
from mafsil.robot import load

ROOT = Path(__file__).parents[2]
Q = ["0.1", "-0.3", "0.2", "-2.2", "0", "2.0", "0.7"]


def out_of(capsys, *words: str) -> str:
    assert main([*words]) == 0, capsys.readouterr().err
    return capsys.readouterr().out


@pytest.mark.parametrize(
    "words",
    [
        ["fk", "panda", "--json", *Q],
        ["fk", "--json", "panda", *Q],
        ["--json", "fk", "panda", *Q],
        ["fk", "--frame", "link7", "panda", "--json", *Q, "--tip", "link7"],
        ["fk", "panda", ",".join(Q), "--json"],
        ["fk", "panda", ", ".join(Q), "--json"],
        ["fk", "panda", *(word + "," for word in Q), "--json"],
        ["fk", "panda", "[" + Q[0], *Q[1:-1], Q[-1] + "]", "--json"],
        ["fk", "PANDA", *Q, "--json"],
    ],
    ids=lambda words: " ".join(words)[:40],
)
def test_one_question_in_many_spellings(capsys, words):
    pose = json.loads(out_of(capsys, *words))["pose"]
    frame = {"frame": "link7"} if "link7" in words else {}
    expected = load("panda").forward_kinematics(np.array(Q, float), **frame)
    np.testing.assert_allclose(pose, expected, atol=1e-12)


def test_a_list_behind_an_option_ends_at_the_robot(capsys):
    first = json.loads(out_of(capsys, "dynamics", "planar2r", "--q", "0.1", "-0.2", "--json"))
    assert json.loads(out_of(capsys, "dynamics", "--json", "--q", "0.1", "-0.2", "planar2r")) == first
    assert json.loads(out_of(capsys, "dynamics", "--q", "0.1,-0.2", "planar2r", "--json")) == first
    assert main(["dynamics", "planar2r", "--q", "0.1", "x"]) == 2
    assert "q[joint2]: 'x' is not a number" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["fk", "panda", "--degree", *Q], ["unknown option --degree", "did you mean: --degrees", "mafsil fk --help"]),
        (["ik", "panda", "--pos", "0", "0", "0"], ["did you mean: --pose", "mafsil ik --help"]),
        (["show", "panda", "-degrees"], ["did you mean: --degrees", "mafsil show --help"]),
        (["show", "panda", "--zzz=3"], ["unknown option --zzz", "mafsil show --help"]),
        (["show", "panda", "ur5"], ["ur5", "mafsil show --help"]),
        (["fk", "panda", "0"], ["panda has 7 joints, but 1 number was given"]),
        (["lst"], ["did you mean: list"]),
    ],
)
def test_slips_are_met_with_the_right_words(capsys, words, said):
    assert main(words) == 2
    error = capsys.readouterr().err
    for part in said:
        assert part in error


def test_robot_first_and_the_other_order_too():
    assert put_options_first(["derive", "panda", "fk"])[-2:] == ["panda", "fk"]
    assert put_options_first(["derive", "fk", "panda"])[-2:] == ["panda", "fk"]
    assert put_options_first(["identify", "a.csv", "b.urdf", "--degrees"])[-2:] == ["b.urdf", "a.csv"]
    assert put_options_first(["identify", "b.urdf", "a.csv"])[-2:] == ["b.urdf", "a.csv"]


@pytest.mark.parametrize(
    ("words", "file", "key"),
    [
        (["show", "-"], "examples/robots/ur5.urdf", "links"),
        (["grasp", "-"], "examples/grasps/midpoints.toml", "closure"),
    ],
)
def test_standard_input_stands_for_a_file(capsys, monkeypatch, words, file, key):
    class Input:
        buffer = io.BytesIO((ROOT / file).read_bytes())

    monkeypatch.setattr("sys.stdin", Input())
    main([*words, "--json"])
    from_input = json.loads(capsys.readouterr().out)
    main([words[0], str(ROOT / file), "--json"])
    assert from_input[key] == json.loads(capsys.readouterr().out)[key]


def test_empty_standard_input_is_said(capsys, monkeypatch):
    class Input:
        buffer = io.BytesIO(b" \n")

    monkeypatch.setattr("sys.stdin", Input())
    assert main(["show", "-"]) == 2
    assert "standard input (-) is empty" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["fk", "panda", "10", "20", "-90", "1", "0", "0", "0"], "joint1 = 10, joint2 = 20, joint3 = -90"),
        (["ik", "ur5e", "--pose", "0.4", "-0.2", "0.5", "180", "0", "0"], "roll = 180"),
        (["singularity", "puma560", "0", "-45", "0", "0", "0", "0"], "joint2 = -45"),
        (["statics", "puma560", "0", "-45", "0", "0", "0", "0"], "joint2 = -45"),
        (["dynamics", "puma560", "--q", "0", "-45", "0", "0", "0", "0"], "joint2 = -45"),
        (["convert", "--rpy", "0", "0", "90"], "90"),
    ],
)
def test_large_angles_are_asked_about_and_kept(capsys, words, named):
    assert f"note: {named}: more than one turn in radians; did you mean --degrees?" in out_of(capsys, *words)
    assert "--degrees?" not in out_of(capsys, *words, "--degrees")
    small = [word if word.startswith("-") or not word.replace(".", "").isdigit() else "0.1" for word in words]
    small = [word if word not in ("-45", "-90") else "-0.5" for word in small]
    assert "--degrees?" not in out_of(capsys, *small)
    if words[0] == "fk":
        data = json.loads(out_of(capsys, *words, "--json"))
        assert data["q"][0] == 10.0


def test_a_marked_angle_and_a_slide_are_not_asked_about(capsys):
    assert "--degrees?" not in out_of(capsys, "fk", "planar2r", "400deg", "7pi")
    assert "--degrees?" not in out_of(capsys, "fk", "rrrp", "0", "0", "0", "9")


@pytest.mark.parametrize("terminal", [True, False])
def test_the_reason_of_a_no_is_read_once_on_a_terminal(capsys, monkeypatch, terminal):
    monkeypatch.setattr("sys.stdout.isatty", lambda: terminal)
    monkeypatch.setattr("sys.stderr.isatty", lambda: terminal)
    assert main(["ik", "planar2r", "--pose", "9", "0", "0"]) == 1
    out, err = capsys.readouterr()
    assert "out of reach" in out
    assert ("out of reach" in err) == (not terminal)


def test_a_list_of_texts_leaves_the_last_word_to_the_robot_that_is_missing():
    from mafsil.cli.parser import _end_of_values
    from mafsil.cli.registry import Parameter

    rows = Parameter("dh", "text", many=True)
    words = ["--dh", "-L1 0 0 q1", "L2 0 0 q2", "arm.urdf"]
    assert _end_of_values(rows, words, 1, missing=1) == 3
    assert _end_of_values(rows, words, 1, missing=0) == 4
