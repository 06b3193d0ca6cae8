"""Pictures of robots: every robot of the library can be drawn, the same robot gives the same bytes."""

from pathlib import Path

import numpy as np
import pytest

from mafsil.figures import plot_mechanism
from mafsil.job.planning.resting import resting_place
from mafsil.model import library
from mafsil.model.library import textbook


@pytest.mark.parametrize("name", ["panda", "puma560", "stanford_arm", "planar2r"])
def test_a_robot_is_drawn(name: str, tmp_path: Path) -> None:
    plot_mechanism(library.load(name), tmp_path / "robot.png")
    assert (tmp_path / "robot.png").stat().st_size > 10_000


def test_same_robot_same_bytes(tmp_path: Path) -> None:
    for name in ("first.svg", "second.svg"):
        plot_mechanism(library.load("planar2r"), tmp_path / name, [0.3, -0.5])
    assert (tmp_path / "first.svg").read_bytes() == (tmp_path / "second.svg").read_bytes()


@pytest.mark.parametrize("name", library.robots())
def test_the_resting_place_keeps_the_limits(name: str) -> None:
    mechanism = library.load(name)
    q = resting_place(mechanism.limits)
    assert (q >= mechanism.limits.lower).all()
    assert (q <= mechanism.limits.upper).all()
    assert np.isfinite(q).all()


@pytest.mark.parametrize("length", [0.09, 0.45, 0.5, 4.5])
def test_robots_of_any_size_have_a_floor(length: float, tmp_path: Path) -> None:
    plot_mechanism(textbook.planar2r((length, length)), tmp_path / "robot.svg")
    assert (tmp_path / "robot.svg").stat().st_size > 10_000
