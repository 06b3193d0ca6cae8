"""Search among designs: published optima of plane arms, fronts with limits, equal seeds."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest

import mafsil as mf
from mafsil.design import ParametricArm, TaskSet, optimise
from mafsil.design.search import is_undominated
from tests.design.test_tasks import plane_arm


def plane(*lengths: str, low: float = 0.1, high: float = 1.0) -> ParametricArm:
    """An arm of massless links along x."""
    parameters = {name: {"value": (low + high) / 2, "low": low, "high": high} for name in lengths}
    joints = [{"a": name} for name in (0.0, *lengths[:-1])]
    return ParametricArm.of(
        {"convention": "modified", "parameters": parameters, "joint": joints, "tool": {"xyz": [lengths[-1], 0.0, 0.0]}}
    )


def test_isotropic_arm_of_two_links() -> None:
    """Salisbury & Craig 1982: isotropic where l1 = sqrt(2) l2, at the distance l2 from the base."""
    found = optimise(
        plane("l1", "l2"), TaskSet.of({"points": [[0.5, 0.0, 0.0]]}), ["condition"], population=16, generations=60
    )
    (best,) = found.points
    assert best.proved
    assert best.measures["condition"] > 0.999
    assert best.values["l2"] == pytest.approx(0.5, rel=2e-3)
    assert best.values["l2"] / best.values["l1"] == pytest.approx(1 / sqrt(2), rel=2e-3)


def test_isotropic_arm_of_three_links() -> None:
    """The three joints on an equilateral triangle about the tool: l1 = l2 = sqrt(3) l3, length l3 / sqrt(2)."""
    rho = 0.3
    T = np.eye(4)
    c, s = np.cos(2 * pi / 3), np.sin(2 * pi / 3)
    T[:2, :2], T[0, 3] = [[c, -s], [s, c]], rho
    tasks = TaskSet(T[None], characteristic_length=rho / sqrt(2))
    found = optimise(plane("l1", "l2", "l3"), tasks, ["condition"], population=16, generations=90, starts=20)
    (best,) = found.points
    assert best.proved
    assert best.measures["condition"] > 0.995
    assert best.values["l3"] == pytest.approx(rho, rel=0.01)
    assert best.values["l1"] / best.values["l3"] == pytest.approx(sqrt(3), rel=0.01)
    assert best.values["l2"] / best.values["l3"] == pytest.approx(sqrt(3), rel=0.01)


def test_front_with_limits_and_equal_seeds() -> None:
    tasks = TaskSet.of({"points": [[0.7, 0.2, 0.0], [0.3, -0.5, 0.0], [0.6, 0.3, 0.0]], "payload": 1.0})
    choice = {"goals": ["mass", "condition"], "limits": {"utilisation": 0.9}, "population": 12, "generations": 10}
    front = optimise(plane_arm(), tasks, points=4, **choice)
    again = optimise(plane_arm(), tasks, points=4, **choice)
    assert front.designs == again.designs
    assert 2 <= len(front) <= 4
    assert all(point.proved for point in front)
    f = np.array([[point.measures["mass"], -point.measures["condition"]] for point in front])
    assert is_undominated(f).all()
    assert (np.diff(f[:, 0]) > 0).all()
    for point in front:
        assert point.evaluation.measures["utilisation"] <= 0.9
        assert point.design.robot.n == 2
    # The lightest arm is the shortest that reaches: no length can be taken from it.
    lightest = front.points[0].values
    assert lightest["a"] + lightest["b"] == pytest.approx(np.hypot(0.7, 0.2), rel=0.02)
    none = optimise(plane_arm(), tasks, ["mass"], {"mass": 0.1}, population=8, generations=2)
    assert not none
    assert "none of" in none.explain()


def test_wrong_arguments() -> None:
    tasks = TaskSet.of({"points": [[0.5, 0.0, 0.0]]})
    for changes, word in (
        ({"goals": ["beauty"]}, "goals"), ({"goals": []}, "goals"), ({"goals": ["payload"]}, "goals"),
        ({"goals": ["mass"], "limits": {"beauty": 1.0}}, "goals"), ({"goals": ["mass"], "seed": -1}, "seed"),
        ({"goals": ["mass"], "limits": {"mass": float("nan")}}, "limits"),
        ({"goals": ["mass"], "population": 1}, "population"),
    ):  # fmt: skip
        with pytest.raises(mf.InputError, match=word):
            optimise(plane_arm(), tasks, **changes)  # type: ignore[arg-type]
    with pytest.raises(mf.InputError, match="period"):
        optimise(plane_arm(), tasks, ["mass"], {"energy": 3.0})
    with pytest.raises(mf.InputError, match="frequency"):
        optimise(plane("l1", "l2"), tasks, ["frequency"])
    screw = [{"kind": "H", "pitch": "l"}]
    arm = {"convention": "frames", "parameters": {"l": {"value": 0.1, "low": 0.0, "high": 0.2}}, "joint": screw}
    with pytest.raises(mf.InputError, match="pitch"):
        optimise(ParametricArm.of(arm), tasks, ["mass"])
    fixed = ParametricArm.of({"convention": "modified", "joint": [{}], "tool": {"xyz": [0.5, 0.0, 0.0]}})
    with pytest.raises(mf.InputError, match="range"):
        optimise(fixed, tasks, ["mass"])


def test_undominated_rows() -> None:
    rows = np.random.default_rng(0).uniform(size=(60, 3))
    keep = is_undominated(rows)
    for k, row in enumerate(rows):
        assert keep[k] == (not any((other <= row).all() and (other < row).any() for other in rows))
    assert is_undominated([[1.0, 1.0], [1.0, 1.0]]).tolist() == [True, False]
