"""Answers of designs for their tasks: against the robot's own numbers, closed forms, and many designs against each."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.design import design as answer_of_command
from mafsil.collision import Box, Obstacle, Scene
from mafsil.design import FlexibleArm, ParametricArm, TaskSet, Tolerances, accuracy, evaluate, measure_designs
from mafsil.design.tasks import MEASURES
from mafsil.errors import InputError
from mafsil.job import solve_file, task_set
from mafsil.model.dh_from_axes import dh_from_mechanism
from mafsil.report.design_report import write_design
from mafsil.toml_source import read_toml
from tests.design.test_arm import TABLE

ROOT = Path(__file__).resolve().parents[2]
FILE = ROOT / "examples/design/arm.toml"


def plane_arm(a: float = 0.5, b: float = 0.4) -> ParametricArm:
    return ParametricArm.of({
        "convention": "modified", "gravity": [0.0, -9.81, 0.0],
        "parameters": {"a": {"value": a, "low": 0.1, "high": 1.0}, "b": {"value": b, "low": 0.1, "high": 1.0}},
        "joint": [
            {"tube": {"outer": 0.06, "wall": 0.003}, "limits": {"effort": 60.0}},
            {"a": "a", "tube": {"outer": 0.06, "wall": 0.003}, "drive": {"mass": 2.0}, "limits": {"effort": 30.0}},
        ],
        "tool": {"xyz": ["b", 0.0, 0.0]},
    })  # fmt: skip


def test_plane_arm_by_hand() -> None:
    design = plane_arm().at()
    found = evaluate(design, TaskSet.of({"points": [[0.9, 0.0, 0.0]], "payload": 1.5}))
    line = 2700 * np.pi * 0.003 * 0.057
    assert found
    torque = 9.81 * (0.25 * 0.5 * line + 0.5 * 2.0 + 0.7 * 0.4 * line + 0.9 * 1.5)
    # Stretched out, where no step of Newton converges fast: the pose is reached to its square root.
    assert found.measures["static_torque"] == pytest.approx(torque, rel=1e-4)
    assert found.measures["utilisation"] == pytest.approx(torque / 60, rel=1e-4)
    assert found.measures["condition"] < 1e-3
    assert found.measures["payload"] == pytest.approx((60 / 9.81 - (torque / 9.81 - 0.9 * 1.5)) / 0.9, rel=1e-4)
    flexible = FlexibleArm(design, payload=1.5)
    assert found.measures["deflection"] == pytest.approx(np.linalg.norm(flexible.deflection(found.q[0])[3:]))
    assert not evaluate(design, TaskSet.of({"points": [[0.9, 0.0, 0.0]], "payload": 9.0}))
    far = evaluate(design, TaskSet.of({"points": [[0.5, 0.1, 0.0], [1.2, 0.0, 0.0]]}))
    assert not far
    assert far.status.name == "NOT_FOUND"
    assert far.measures["reached"] == 0.5
    assert "1 of 2" in far.explain()


def test_cycle_of_a_mass_moved_without_gravity() -> None:
    """One link on a vertical axis from rest to rest and back: tau = m l^2 qdd."""
    table = {"convention": "modified", "joint": [{}], "tool": {"xyz": [0.5, 0.0, 0.0]}}  # no masses but the payload
    robot = ParametricArm.of(table).robot()
    ends = robot.fk([[0.0], [1.2]])
    found = evaluate(robot, TaskSet(ends, payload=2.0, period=4.0))
    inertia, T = 2.0 * 0.25, 2.0
    assert found.speed[0] == pytest.approx(15 / 8 * 1.2 / T, rel=2e-3)
    assert found.peak[0] == pytest.approx(inertia * 10 / np.sqrt(3) * 1.2 / T**2, rel=2e-2)
    # Mean square of 60 u - 180 u^2 + 120 u^3 is 120 / 7.
    assert found.rms[0] == pytest.approx(inertia * 1.2 / T**2 * np.sqrt(120 / 7), rel=2e-3)
    assert found.energy == pytest.approx(2 * 0.5 * inertia * (15 / 8 * 1.2 / T) ** 2, rel=2e-2)


def test_obstacles() -> None:
    scene = Scene([Obstacle(Box((0.2, 0.2, 0.2)), _at(0.3), name="box")])
    found = evaluate(plane_arm().at(), TaskSet(_at(0.6)[None], task="position", scene=scene))
    assert found.status.name in ("COLLIDES", "SERVES")
    blocked = evaluate(plane_arm().at(), TaskSet(_at(0.89)[None], task="position", scene=scene))
    assert blocked.status.name == "COLLIDES"
    assert "collision" in blocked.explain()


def _at(x: float) -> np.ndarray:
    T = np.eye(4)
    T[0, 3] = x
    return T


def test_many_designs_are_as_each_one() -> None:
    arm, rng = ParametricArm.of(TABLE), np.random.default_rng(0)
    poses = arm.robot(upper=0.4).fk(rng.uniform(-1, 1, (8, 6)))
    tasks = TaskSet(poses, payload=2.0, centre=(0.0, 0.01, 0.05), period=16.0, characteristic_length=0.3)
    designs = [arm.at(upper=value) for value in (0.4, 0.41, 0.45)]
    names = [name for name in MEASURES if name != "payload"]
    measured, q = measure_designs(designs, tasks, names)
    again, _ = measure_designs(designs, tasks, names)
    for k, design in enumerate(designs):
        alone = evaluate(design, tasks, q0=q[k])
        np.testing.assert_allclose(alone.q, q[k], atol=1e-7)
        for name in names:
            assert measured[name][k] == pytest.approx(alone.measures[name], rel=1e-6, nan_ok=True), name
            assert measured[name][k] == pytest.approx(again[name][k], nan_ok=True, rel=0, abs=0)


@pytest.mark.parametrize("name", ["panda", "ur5e", "puma560", "iiwa7"])
def test_robots_of_the_library_are_rigid_designs(name: str) -> None:
    robot = mf.load(name)
    arm = robot.locked({j.name: 0.0 for j in robot.mechanism.coordinates[7:]}) if robot.n > 7 else robot
    q = np.clip([0.2, -0.5, 0.4, -1.2, 0.3, 1.0, 0.2][: arm.n], arm.limits.lower, arm.limits.upper)
    found = evaluate(arm, TaskSet(arm.fk(q)[None], payload=1.0), q0=q[None])
    np.testing.assert_allclose(found.torque[0], arm.with_payload(1.0, com=(0, 0, 0)).gravity_torque(q), atol=1e-6)
    assert found.measures["deflection"] == 0.0
    error = mf.design.accuracy(arm, q, mf.design.Tolerances(zero=1e-4, temperature=5.0, expansion=1e-5), samples=2000)
    assert error
    row = {"name": "a", "peak_torque": 9.0, "continuous_torque": 5.0, "speed": 500.0, "rotor_inertia": 1e-5}
    one = mf.design.Catalogue.of([{**row, "ratio": 100.0, "efficiency": 0.8, "mass": 0.0}])
    still = mf.design.pick_drives(arm, one, q, 0 * q, 0 * q, payload=1.0)
    assert still
    np.testing.assert_allclose(still.peak * 9.0, np.abs(found.torque[0]) / 100 / 0.8, atol=1e-7)


def test_wrong_arguments() -> None:
    for table, word in (
        ({}, "points"), ({"points": [[0, 0, 0]], "poses": []}, "points"), ({"points": [[0, 0]]}, "points"),
        ({"points": [[0, 0, 0]], "load": 3}, "load"), ({"points": [[0, 0, 0]], "payload": -1}, "payload"),
        ({"points": [[0, 0, 0]], "period": 0}, "period"), ({"points": [[0, 0, float("nan")]]}, "points"),
    ):  # fmt: skip
        with pytest.raises(mf.MafsilError, match=word):
            TaskSet.of(table)
    with pytest.raises(mf.InputError, match="task"):
        TaskSet(np.eye(4)[None], task="axis")  # type: ignore[arg-type]
    with pytest.raises(mf.InputError, match="measure"):
        measure_designs([plane_arm().at()], TaskSet.of({"points": [[0.3, 0, 0]]}), ["beauty"])


JOB = """
robot = "panda"

[[move]]
pose = { position = [0.45, 0.25, 0.3], rpy = [3.14159265, 0.0, 0.0] }

[[move]]
pick = { name = "part", mass = 0.7, offset = [0.0, 0.0, 0.05], com = [0.0, 0.0, 0.02] }

[[move]]
pose = { position = [0.45, -0.25, 0.3], rpy = [3.14159265, 0.0, 0.0] }

[[move]]
place = true

[[move]]
pose = { position = [0.45, 0.0, 0.5], rpy = [3.14159265, 0.0, 0.0] }

[[obstacle]]
name = "post"
box = [0.1, 0.1, 0.4]
position = [0.0, 0.7, 0.2]
"""


def test_a_job_gives_its_poses_its_heaviest_part_its_cycle_and_its_obstacles(tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text(JOB)
    tasks = task_set(tmp_path / "cell.toml")
    assert tasks.poses[:, :3, 3] == pytest.approx(np.array([[0.45, 0.25, 0.3], [0.45, -0.25, 0.3], [0.45, 0.0, 0.5]]))
    assert (tasks.payload, tuple(tasks.centre)) == (0.7, pytest.approx((0.0, 0.0, 0.07)))
    assert tasks.scene is not None
    assert [thing.name for thing in tasks.scene] == ["post"]
    run = solve_file(tmp_path / "cell.toml", plant="kinematic")
    assert tasks.period == pytest.approx(run.plan.cycle)
    found = evaluate("panda", tasks)
    assert found
    for q, T in zip(found.q, tasks.poses, strict=True):
        assert mf.load("panda").fk(q) == pytest.approx(T, abs=1e-8)


def test_a_job_that_cannot_be_planned_gives_no_tasks(tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text(JOB.replace("0.45, -0.25", "1.45, -0.25"))
    with pytest.raises(InputError, match="cannot be planned"):
        task_set(tmp_path / "cell.toml")


def test_the_command_takes_tasks_from_a_job(tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text(JOB)
    table = (FILE).read_text().split("[tasks]")[0]
    (tmp_path / "arm.toml").write_text(f'{table}[tasks]\njob = "cell.toml"\n')
    given = answer_of_command("tasks", str(tmp_path / "arm.toml"), None, None, None, None)
    assert len(given.data["q"]) == 3
    assert np.isfinite(given.data["measures"]["peak_torque"])


def test_the_page_has_every_measure_and_the_arm_again(tmp_path: Path) -> None:
    tables = read_toml(FILE)
    tasks, arm = TaskSet.of(tables["tasks"]), ParametricArm.of(tables["arm"]).at()
    tolerances, judged = Tolerances(**tables["tolerances"]), evaluate(arm, tasks)
    errors = [accuracy(arm, q, tolerances, payload=tasks.payload) for q in judged.q]
    text = write_design(judged, tasks, tmp_path / "design.html", tolerances=tolerances, errors=errors).read_text()
    for name in ("mass", "peak_torque", "deflection", "frequency", "payload"):
        assert f">{judged.measures[name]:.4g} <small>" in text
    assert f"{max(error.rms for error in errors) * 1e3:.4g} mm rms" in text
    for sentence in ("Design of study", "تصميم"):
        assert sentence in text
    # The sheet alone makes the same arm again, up to the digits that are printed.
    cells = [re.sub("<[^>]+>", "", row) for row in re.findall(r"<td[^>]*>(.*?)</td>", text)]
    lengths = [cell for cell in cells if "± 0.05 mm" in cell]
    rows = dh_from_mechanism(arm.robot).rows
    wanted = [f"{1e3 * value:.6g} ± 0.05 mm" for row in rows for value in (row.a, row.d)]
    assert lengths[: len(wanted)] == wanted


def test_the_command_writes_the_page_and_says_what_it_needs(tmp_path: Path) -> None:
    answer = answer_of_command("report", str(FILE), None, None, None, str(tmp_path / "design.html"))
    assert answer.data["page"] == str(tmp_path / "design.html")
    with pytest.raises(InputError, match="--out"):
        answer_of_command("report", str(FILE), None, None, None, None)
    data = json.loads(json.dumps(answer.data, default=lambda value: np.asarray(value).tolist()))
    assert data["measures"]["reached"] == 1.0
