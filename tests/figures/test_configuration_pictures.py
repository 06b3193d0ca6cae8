"""Pictures of all configurations: every branch has a panel, in both languages."""

from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.errors import InputError
from mafsil.figures import plot_configurations
from mafsil.figures.configurations import MOST, draw_configurations, draw_planar_configurations, plane
from mafsil.model.denavit_hartenberg import DHRow


def test_every_configuration_has_a_panel(tmp_path: Path) -> None:
    robot = mf.load("puma560")
    T = robot.forward_kinematics(np.array([0.2, 0.3, -1.0, 0.5, 0.6, 0.3]))
    answer = mf.inverse_kinematics(robot, T)
    names = [branch.label() for branch in answer.branches]
    figure = draw_configurations(robot, answer.q, names, answer.within, len(answer))
    assert len(figure.axes) == len(answer) + 1 == 9
    words = " ".join(text.get_text() for text in figure.texts)
    assert all(f"{k}:" in words for k in range(1, 9))
    for language in ("en", "ar"):
        mf.language(language)
        try:
            plot_configurations(robot, answer.q, tmp_path / f"{language}.png", names, answer.within)
        finally:
            mf.language("en")
        assert (tmp_path / f"{language}.png").stat().st_size > 20_000


@pytest.mark.capability("07-10", "07-18")
def test_arms_in_a_plane_are_drawn_in_it_with_their_reach(tmp_path: Path) -> None:
    robot = mf.Robot.from_dh([DHRow(a=1.0), DHRow(a=0.6)], "classic", name="two")
    assert plane(robot) is not None
    assert plane(mf.load("ur5e")) is None
    T = robot.forward_kinematics(np.array([0.3, 1.2]))
    answer = mf.inverse_kinematics(robot, T, task="position")
    assert len(answer) == 2
    names = [branch.label() for branch in answer.branches]
    figure = draw_planar_configurations(robot, answer.q, names, answer.within, 2, ["red", "blue"])
    (axes,) = figure.axes
    assert {round(circle.get_radius(), 9) for circle in axes.patches} == {0.4, 1.6}
    r = float(np.linalg.norm(T[:2, 3]))
    alpha = np.degrees(np.arccos((r * r + 1.0 - 0.36) / (2 * r)))
    beta = np.degrees(np.arccos((1.0 + 0.36 - r * r) / 1.2))
    words = [text.get_text() for text in axes.texts]
    assert [text for text in words if "elbow" in text] == [f"{k + 1}: {name}" for k, name in enumerate(names)]
    assert any(f"alpha$ = {alpha:.1f}" in text for text in words)
    assert any(f"beta$ = {beta:.1f}" in text for text in words)
    plot_configurations(robot, answer.q, tmp_path / "two.png", names, answer.within)
    plot_configurations(mf.load("planar3r"), np.zeros((1, 3)), tmp_path / "three.png")


def test_same_configurations_same_bytes(tmp_path: Path) -> None:
    robot = mf.load("planar2r")
    for name in ("first.svg", "second.svg"):
        plot_configurations(robot, [[0.3, 0.5], [0.7, -0.5]], tmp_path / name)
    assert (tmp_path / "first.svg").read_bytes() == (tmp_path / "second.svg").read_bytes()


def test_many_and_none(tmp_path: Path) -> None:
    robot = mf.load("planar2r")
    plot_configurations(robot, np.zeros((MOST + 5, 2)), tmp_path / "many.png")
    with pytest.raises(InputError, match="configuration"):
        plot_configurations(robot, np.zeros((0, 2)), tmp_path / "none.png")


def test_the_command_draws(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "ur.svg"
    pose = ["0.4", "0.3", "0.3", "0.3", "2.0", "0.4"]
    assert main(["ik", "ur5e", "--pose", *pose, "--all", "--picture", str(path)]) == 0
    assert path.stat().st_size > 10_000
    assert str(path) in capsys.readouterr().out
    assert main(["ik", "ur5e", "--pose", *pose, "--picture", "no.txt"]) != 0
