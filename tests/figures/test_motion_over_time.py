"""The picture of a trajectory over time is drawn, the same from the same numbers."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil import figures
from mafsil.errors import InputError
from mafsil.trajectory import MotionLimits, cubic_through, double_s, linear_blends


def test_a_trajectory_is_drawn_with_its_jumps_and_limits(tmp_path):
    pytest.importorskip("matplotlib")
    plan = linear_blends([[0.0, 1.0], [2.0, 0.0], [1.0, 1.0]], 1.0, acceleration=12.0)
    limits = MotionLimits.of(2, velocity=3.0, acceleration=(-12.0, 12.0))
    for name in ("one.svg", "two.svg"):
        figures.plot_trajectory(plan.trajectory, tmp_path / name, limits=limits, names=("turn", "lift"))
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()
    figures.plot_trajectory(double_s(0.0, 1.0, jerk=5.0).value, tmp_path / "arabic.png", language="ar")
    assert (tmp_path / "arabic.png").stat().st_size > 10_000
    with pytest.raises(InputError):
        figures.plot_trajectory(cubic_through(np.zeros((4, 3, 2)), 1.0), tmp_path / "batch.png")
    with pytest.raises(InputError):
        figures.plot_trajectory(plan.trajectory, tmp_path / "one.txt")
