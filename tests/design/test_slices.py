"""Slices: what an arm holds at every cell against the same arm with that payload in its hand; reach, closed forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.design import design
from mafsil.design import ParametricArm, TaskSet, evaluate, payload_map, reach_map
from mafsil.design.slices import PayloadMapStatus
from mafsil.errors import InputError
from mafsil.performance.velocity.scaling import ranges
from tests.design.test_published import PUMA

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


def _chain(*lengths: float, limits: dict | None = None) -> mf.Robot:
    """Links along x on parallel vertical axes; limits are those of the last joint."""
    joints = [{"a": length} for length in (0.0, *lengths[:-1])]
    joints[-1] |= {"limits": limits} if limits else {}
    table = {"convention": "modified", "joint": joints, "tool": {"xyz": [lengths[-1], 0.0, 0.0]}}
    return ParametricArm.of(table).robot()


@pytest.mark.parametrize(("lengths", "inner", "outer"), [((0.6, 0.2), 0.4, 0.8), ((0.7, 0.2, 0.1), 0.4, 1.0)])
def test_the_void_of_a_plane_arm_is_its_inner_circle(lengths: tuple, inner: float, outer: float) -> None:
    """Closed form: the longest link less the others; a void at the middle of just that radius."""
    found = reach_map(_chain(*lengths), "xy", cell=0.04)
    ((x, y, radius, area),) = found.voids[0]
    assert (x, y) == (0.0, 0.0)
    assert radius == pytest.approx(inner, rel=1e-6)
    assert area == pytest.approx(np.pi * inner**2, rel=0.05)
    assert found.area[0] == pytest.approx(np.pi * (outer**2 - inner**2), rel=0.05)
    judged = evaluate(_chain(*lengths), TaskSet.of({"points": [[0.5, 0.0, 0.0]]}))
    assert judged.measures["reach"] == pytest.approx(outer, rel=1e-9)
    assert judged.measures["void"] == pytest.approx(inner, rel=1e-6)


def test_an_elbow_with_limits_leaves_a_larger_void() -> None:
    """Law of cosines: at the largest bend of 120 degrees l^2 = a^2 + b^2 - a b."""
    robot = _chain(0.6, 0.2, limits={"lower": -2 * np.pi / 3, "upper": 2 * np.pi / 3})
    ((_, _, radius, _),) = reach_map(robot, "xy", cell=0.04).voids[0]
    assert radius == pytest.approx(np.sqrt(0.36 + 0.04 - 0.12), rel=1e-6)


def test_a_cylinder_about_the_first_axis_is_a_void_of_a_level_slice_and_open_upright() -> None:
    """The PUMA's wrist centre keeps its sideways offset from axis 1, at every height."""
    robot = ParametricArm.of(PUMA).robot()
    level = reach_map(robot, "xy", at=0.1, cell=0.05)
    ((x, y, radius, _),) = level.voids[0]
    assert (x, y) == (0.0, 0.0)
    assert radius == pytest.approx(0.15005, rel=1e-3)
    upright = reach_map(robot, "xz", cell=0.1)
    assert not any(upright.voids)
    assert (upright.distance[np.abs(upright.x) < 0.14] > 0.0).all()


@pytest.mark.parametrize(("name", "rpy"), [("puma560", None), ("ur5e", [DOWN, (0.0, np.pi / 2, 0.0)])])
def test_reached_cells_are_those_of_the_inverse_kinematics(name: str, rpy: list | None) -> None:
    robot = mf.load(name)
    found = reach_map(robot, at=0.05, cell=0.3, rpy=rpy)
    for i, j, k in np.ndindex(found.distance.shape):
        T = np.eye(4)
        T[:3, 3] = found.x[i], 0.05, found.y[j]
        if rpy is None:
            answer = mf.ik.solve_ik(robot, T, task="position")
            assert answer.solved == (found.distance[i, j, k] == 0.0) or found.distance[i, j, k] < 3e-3
        else:
            T[:3, :3] = mf.geometry.rotation.from_rpy(rpy[k])
            others = mf.inverse_kinematics(robot, T)
            assert bool(len(others.q) and others.within.any()) == (found.distance[i, j, k] == 0.0)


def test_distances_of_cells_out_of_reach_are_least() -> None:
    """No sample of the joints comes nearer than the map says; the nearest comes close."""
    robot = mf.load("stanford_arm")
    found = reach_map(robot, "xz", at=0.1, cell=0.4)
    tips = robot.fk(np.random.default_rng(1).uniform(*ranges(robot), (200_000, robot.n)))[:, :3, 3]
    for (i, j, _), distance in np.ndenumerate(found.distance):
        away = np.linalg.norm(tips - [found.x[i], 0.1, found.y[j]], axis=1).min()
        assert distance <= away + 1e-9


def test_what_has_no_reach_map_is_refused_and_far_slices_are_empty() -> None:
    for named in ({"plane": "zx"}, {"cell": 0.0}, {"at": np.inf}, {"rpy": [[0.0, 1.0]]}):
        with pytest.raises(InputError):
            reach_map("puma560", **named)
    away = reach_map("puma560", at=9.0, cell=0.4)
    assert not away
    assert not any(away.voids)


@pytest.mark.parametrize("language", ["en", "ar"])
def test_the_reach_map_is_drawn(language: str, tmp_path: Path) -> None:
    found = reach_map("ur5e", "xy", at=0.1, cell=0.2)
    mf.figures.plot_reach_map(found, tmp_path / "reach.svg", language=language)
    assert (tmp_path / "reach.svg").stat().st_size > 4000


def test_the_command_says_where_the_arm_gets(tmp_path: Path) -> None:
    file = Path(__file__).resolve().parents[2] / "examples/design/arm.toml"
    answer = design("reach", str(file), None, None, None, str(tmp_path / "reach.png"))
    assert (tmp_path / "reach.png").exists()
    assert answer.data["voids"] is not None
