"""`--lock`, `--tool` and `--payload` of every command that takes a robot: the same as in Python, or a sentence."""

from __future__ import annotations

import json

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.cli.registry import OPERATIONS, UNEQUIPPED
from mafsil.geometry import pose, rotation

ROBOT_COMMANDS = [
    operation for operation in OPERATIONS if any(parameter.name == "robot" for parameter in operation.parameters)
]


def data(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, object]:
    assert main([*words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_a_locked_joint_and_a_tool_move_the_tip(capsys: pytest.CaptureFixture[str]) -> None:
    found = data(
        capsys, "fk", "panda", "0.1", "0", "0", "-1.5", "0", "1.5",
        "--lock", "joint7=45deg", "--tool", "0", "0", "100mm", "0", "0", "90deg",
    )  # fmt: skip
    T = pose.from_rotation_translation(rotation.from_rpy([0, 0, np.pi / 2]), [0, 0, 0.1])
    robot = mf.load("panda").with_locked_joints({"joint7": np.pi / 4}).with_tool(T)
    np.testing.assert_allclose(found["pose"], robot.forward_kinematics([0.1, 0, 0, -1.5, 0, 1.5]), atol=1e-12)


def test_bare_numbers_are_degrees_where_the_command_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    found = data(capsys, "fk", "planar2r", "30", "--lock", "joint2=90", "--degrees")
    expected = mf.load("planar2r").forward_kinematics(np.radians([30, 90]))
    np.testing.assert_allclose(found["pose"], expected, atol=1e-12)


def test_a_payload_loads_the_motors(capsys: pytest.CaptureFixture[str]) -> None:
    found = data(capsys, "dynamics", "planar2r", "--q", "0.1", "0.2", "--payload", "2")
    robot = mf.load("planar2r").with_payload(2.0)
    np.testing.assert_allclose(found["tau"], robot.gravity_torque([0.1, 0.2]), atol=1e-9)


@pytest.mark.parametrize("operation", ROBOT_COMMANDS, ids=lambda operation: operation.name)
def test_every_command_of_a_robot_has_the_options_or_its_own(
    operation: object, capsys: pytest.CaptureFixture[str]
) -> None:
    name = operation.name  # type: ignore[attr-defined]
    assert main([name, "--help"]) == 0
    text = capsys.readouterr().out
    wanted = ["--xacro-arg"] if name in UNEQUIPPED else ["--xacro-arg", "--lock", "--tool", "--payload", "--tip"]
    assert [option for option in wanted if option not in text] == []


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["fk", "panda", "0", "--lock", "joint9=1"], "no moving joint has that name"),
        (["fk", "panda", "0", "--lock", "joint9"], "expected JOINT=VALUE"),
        (["fk", "planar2r", "0", "0", "--tool", "0", "0"], "2 numbers were given"),
        (["fk", "planar2r", "0", "0", "--payload", "heavy"], "payload"),
        (["lint", "panda", "--lock", "joint7=1"], "--lock"),
    ],
)
def test_wrong_words_are_refused(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words) == 2
    assert said in capsys.readouterr().err


def test_a_robot_that_hangs_on_the_moon(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--base", "0", "0", "2", "180deg", "0", "0", "--gravity", "0", "0", "-1.62"]
    q = ["0.1", "-0.5", "0.9", "0.2", "0.3", "0"]
    T_sb = pose.from_rotation_translation(rotation.from_rpy([np.pi, 0, 0]), [0, 0, 2])
    robot = mf.load("ur5e")
    found = data(capsys, "fk", "ur5e", *q, *words)
    np.testing.assert_allclose(found["pose"], T_sb @ robot.forward_kinematics([float(x) for x in q]), atol=1e-12)
    tau = data(capsys, "dynamics", "ur5e", "--q", *q, *words)["tau"]
    upward = mf.Robot(robot.mechanism.with_gravity(np.array([0.0, 0.0, 1.62])))
    np.testing.assert_allclose(tau, upward.gravity_torque([float(x) for x in q]), atol=1e-9)
    assert main(["fk", "ur5e", *q, "--gravity", "0", "1"]) == 2
    assert "gravity" in capsys.readouterr().err
