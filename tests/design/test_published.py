"""Published arms from their tables as parametric arms: reach within one percent of the maker's statement."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from scipy.optimize import minimize

from mafsil.design import ParametricArm

# Lengths: the makers' tables; reach [m]: data sheets, from the shoulder (second axis) to the
# centre of the wrist, of the Panda to the flange.
PUMA = {
    "convention": "modified", "parameters": {"a2": 0.4318, "a3": 0.0203, "d3": 0.15005, "d4": 0.4318},
    "joint": [{}, {"alpha": "-pi / 2"}, {"a": "a2", "d": "d3"}, {"a": "a3", "d": "d4", "alpha": "-pi / 2"},
              {"alpha": "pi / 2"}, {"alpha": "-pi / 2"}],
}  # fmt: skip
IIWA7 = {
    "convention": "classic", "parameters": {"bs": 0.34, "se": 0.4, "ew": 0.4},
    "joint": [{"d": "bs", "alpha": "-pi / 2"}, {"alpha": "pi / 2"}, {"d": "se", "alpha": "pi / 2"},
              {"alpha": "-pi / 2"}, {"d": "ew", "alpha": "-pi / 2"}, {"alpha": "pi / 2"}, {}],
}  # fmt: skip
PANDA = {
    "convention": "modified",
    "parameters": {"d1": 0.333, "d3": 0.316, "a": 0.0825, "d5": 0.384, "a7": 0.088, "flange": 0.107},
    "joint": [{"d": "d1"}, {"alpha": "-pi / 2"}, {"d": "d3", "alpha": "pi / 2"}, {"a": "a", "alpha": "pi / 2"},
              {"a": "-a", "d": "d5", "alpha": "-pi / 2"}, {"alpha": "pi / 2"}, {"a": "a7", "alpha": "pi / 2"}],
    "tool": {"xyz": [0.0, 0.0, "flange"]},
}  # fmt: skip


@pytest.mark.parametrize(
    ("table", "shoulder", "stated"), [(PUMA, 0.0, 0.8636), (IIWA7, 0.34, 0.8), (PANDA, 0.333, 0.855)]
)
def test_reach_of_published_arms(table: dict, shoulder: float, stated: float) -> None:
    robot = ParametricArm.of(table).robot()
    offset = table["parameters"].get("d3", 0.0) if table is PUMA else 0.0

    def beside(q: np.ndarray) -> float:
        away = robot.fk(q)[:3, 3] - [0.0, 0.0, shoulder]
        # The Puma's data sheet leaves out its sideways offset.
        return -float(np.sqrt(max(away @ away - offset**2, 0.0)))

    starts = np.random.default_rng(0).uniform(-pi / 2, pi / 2, (12, robot.n))
    reach = max(-minimize(beside, q, method="BFGS").fun for q in starts)
    assert reach == pytest.approx(stated, rel=0.01)
