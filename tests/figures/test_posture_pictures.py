"""Pictures of all postures: every branch has a panel, in both languages."""

from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.errors import InputError
from mafsil.figures import save_postures
from mafsil.figures.postures import MOST, draw_postures


def test_every_posture_has_a_panel(tmp_path: Path) -> None:
    robot = mf.load("puma560")
    T = robot.forward_kinematics(np.array([0.2, 0.3, -1.0, 0.5, 0.6, 0.3]))
    answer = mf.inverse_kinematics(robot, T)
    names = [branch.label() for branch in answer.branches]
    figure = draw_postures(robot, answer.q, names, answer.within, len(answer))
    assert len(figure.axes) == len(answer) + 1 == 9
    words = " ".join(text.get_text() for text in figure.texts)
    assert all(f"{k}:" in words for k in range(1, 9))
    for language in ("en", "ar"):
        mf.language(language)
        try:
            save_postures(robot, answer.q, tmp_path / f"{language}.png", names, answer.within)
        finally:
            mf.language("en")
        assert (tmp_path / f"{language}.png").stat().st_size > 20_000


def test_same_postures_same_bytes(tmp_path: Path) -> None:
    robot = mf.load("planar2r")
    for name in ("first.svg", "second.svg"):
        save_postures(robot, [[0.3, 0.5], [0.7, -0.5]], tmp_path / name)
    assert (tmp_path / "first.svg").read_bytes() == (tmp_path / "second.svg").read_bytes()


def test_many_and_none(tmp_path: Path) -> None:
    robot = mf.load("planar2r")
    save_postures(robot, np.zeros((MOST + 5, 2)), tmp_path / "many.png")
    with pytest.raises(InputError, match="posture"):
        save_postures(robot, np.zeros((0, 2)), tmp_path / "none.png")


def test_the_command_draws(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "ur.svg"
    pose = ["0.4", "0.3", "0.3", "0.3", "2.0", "0.4"]
    assert main(["ik", "ur5e", "--pose", *pose, "--all", "--picture", str(path)]) == 0
    assert path.stat().st_size > 10_000
    assert str(path) in capsys.readouterr().out
    assert main(["ik", "ur5e", "--pose", *pose, "--picture", "no.txt"]) != 0
