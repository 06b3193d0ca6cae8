"""Payload maps: what an arm holds at every cell, against the same arm with that payload in its hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.design import ParametricArm, payload_map
from mafsil.design.payload_map import PayloadMapStatus
from mafsil.errors import InputError

DOWN = (np.pi, 0.0, 0.0)


def _arm(effort: float) -> ParametricArm:
    """Two links of 0.4 m that hang in the plane x-y."""
    joint = {"tube": {"outer": 0.06, "wall": 0.003, "material": "aluminium"}, "limits": {"effort": effort}}
    table = {"convention": "modified", "gravity": [0.0, -9.81, 0.0], "tool": {"xyz": [0.4, 0.0, 0.0]}}
    return ParametricArm.of(table | {"joint": [joint, joint | {"a": 0.4}]})


@pytest.mark.parametrize(
    ("name", "rpy"), [("puma560", [DOWN, (np.pi / 2, 0.0, 0.3)]), ("ur5e", [DOWN]), ("ur5e", None)]
)
def test_the_payload_brings_one_joint_to_its_limit_and_no_other_beyond(name: str, rpy: list | None) -> None:
    robot, centre = mf.load(name), (0.02, -0.01, 0.06)
    found = payload_map(robot, at=0.1, cell=0.25, rpy=rpy, centre=centre)
    held = np.argwhere(np.isfinite(found.payload) & (found.payload > 0.0))
    assert len(held) > 5
    for i, j, k in held[:: max(1, len(held) // 12)]:
        q, mass, joint = found.q[i, j, k], found.payload[i, j, k], found.limiting_joint[i, j, k]
        used = np.abs(robot.with_payload(mass, com=centre).gravity_torque(q)) / robot.limits.effort
        assert used.max() == pytest.approx(1.0, abs=1e-9)
        assert used.argmax() == joint
        T = robot.fk(q)
        assert T[:3, 3] == pytest.approx([found.x[i], 0.1, found.y[j]], abs=1e-7)
        if rpy is not None:
            assert T[:3, :3] == pytest.approx(mf.geometry.rotation.from_rpy(rpy[k]), abs=1e-7)


def test_no_other_solution_holds_more_and_cells_out_of_reach_are_empty() -> None:
    robot = mf.load("puma560")
    found = payload_map(robot, "xy", at=0.2, cell=0.3, rpy=[DOWN])
    for (i, j), mass in np.ndenumerate(found.payload[..., 0]):
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = mf.geometry.rotation.from_rpy(DOWN), (found.x[i], found.y[j], 0.2)
        others = mf.inverse_kinematics(robot, T)
        inside = others.q[others.within] if len(others.q) else []
        assert np.isnan(mass) == (not len(inside))
        for q in inside:
            assert not mf.performance.largest_payload(robot, q).largest > mass * (1 + 1e-9)
    assert 0.0 < found.reached < 1.0


def test_the_answer_says_where_the_arm_is_weakest() -> None:
    robot = mf.load("puma560")
    found = payload_map(robot, cell=0.2, rpy=[DOWN])
    assert found.status is PayloadMapStatus.HOLDS
    i, j = (int(np.abs(a - b).argmin()) for a, b in zip((found.x, found.y), found.least_at, strict=True))
    assert np.nanmin(found.payload[i, j]) == found.least == np.nanmin(found.payload)
    assert f"{found.least:.4g} kg" in str(found)
    weak = payload_map(_arm(effort=3.0).robot(), "xy", cell=0.2)
    assert weak.status is PayloadMapStatus.TOO_WEAK
    assert weak.least == 0.0 < weak.largest
    away = payload_map(robot, at=5.0, cell=0.3, rpy=[DOWN])
    assert away.status is PayloadMapStatus.NOT_REACHED
    assert not away
    assert np.isnan(away.least)


def test_what_has_no_map_is_refused() -> None:
    robot = mf.load("puma560")
    for named in ({"plane": "zx"}, {"cell": -1.0}, {"cell": 1e-4}, {"at": np.nan}, {"rpy": [[0.0, 1.0]]}):
        with pytest.raises(InputError):
            payload_map(robot, **named)
    with pytest.raises(InputError, match="gravity"):
        payload_map(robot.mechanism.with_gravity(np.zeros(3)), cell=0.3)
    with pytest.raises(InputError, match="limit"):
        payload_map(_arm(effort=np.inf).robot(), cell=0.3)


@pytest.mark.parametrize("language", ["en", "ar"])
def test_the_map_is_drawn(language: str, tmp_path: Path) -> None:
    found = payload_map("puma560", cell=0.4, rpy=[DOWN, (np.pi / 2, 0.0, 0.0)])
    path = tmp_path / "held.svg"
    mf.figures.plot_payload_map(found, path, language=language)
    assert path.stat().st_size > 5000
