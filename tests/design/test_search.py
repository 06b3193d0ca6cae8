"""Search among arms and platforms: published optima, fronts, equal seeds; platforms as designs by their own numbers."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from math import pi, sqrt
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

import mafsil as mf
from mafsil.cli.design import design as answer_of_command
from mafsil.design import ParametricArm, ParametricPlatform, TaskSet, evaluate, measure_designs, optimise
from mafsil.design.platform import platform_motion
from mafsil.design.search import hypervolume, is_undominated
from mafsil.parallel import DeltaRobot, StewartPlatform
from mafsil.parallel.legs.rod_indices import rod_indices
from mafsil.simulation.many_runs import cluster_executor
from tests.budget import within
from tests.design.test_arm import TABLE
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


DELTA = {
    "kind": "rotary_delta",
    "parameters": {"arm": {"value": 0.524, "low": 0.3, "high": 0.8}},
    "geometry": {"base": 0.164, "platform": 0.044, "arms": "arm", "forearms": 1.244},
    "masses": {"platform": 0.5, "arms": "2 * arm", "rods": 0.3},
    "motors": {"effort": 60.0, "stiffness": 2e4, "rod_stiffness": 5e6},
}  # fmt: skip
BASE, PLATFORM = [0.1, 1.9, 2.2, 4.0, 4.3, 6.1], [0.9, 1.2, 3.0, 3.3, 5.1, 5.4]
STEWART = {
    "kind": "stewart",
    "geometry": {"base": 0.4, "platform": 0.2, "base_angles": BASE, "platform_angles": PLATFORM},
    "masses": {"platform": 5.0},
    "motors": {"lower": 0.3, "upper": 0.9, "effort": 500.0, "stiffness": 1e7},
}
FIVE_BAR = {
    "kind": "five_bar", "gravity": [0.0, -9.81, 0.0],
    "geometry": {"base": [[-0.1, 0.0], [0.1, 0.0]], "arms": 0.2, "rods": 0.3},
    "masses": {"platform": 0.2}, "motors": {"effort": 5.0, "stiffness": 1e3},
}  # fmt: skip
POINTS = [[0.3, 0.0, -1.1], [-0.2, 0.3, -1.1], [0.0, 0.0, -0.95]]


def test_efforts_of_a_delta_without_rods_masses_are_those_of_its_transpose() -> None:
    table = DELTA | {"masses": {"platform": 0.5}}
    found = evaluate(ParametricPlatform.of(table).at(), TaskSet.of({"points": POINTS, "payload": 1.5}))
    delta = DeltaRobot(0.164, 0.044, 0.524, 1.244)
    q = delta.inverse_kinematics(POINTS).q[..., 0]
    assert found
    np.testing.assert_allclose(found.q, q, atol=1e-12)
    np.testing.assert_allclose(found.torque, delta.torques(q, POINTS, [0.0, 0.0, 2.0 * 9.81]), rtol=1e-9)
    values = np.linalg.svd(delta.jacobian(q, POINTS), compute_uv=False)
    np.testing.assert_allclose(found.gains, values[:, [-1, 0]], rtol=1e-9)
    # What it holds brings one motor to its limit and none beyond.
    for k, mass in enumerate(found.payload):
        torque = delta.torques(q[k], POINTS[k], [0.0, 0.0, (0.5 + mass) * 9.81])
        assert np.abs(torque).max() == pytest.approx(60.0, rel=1e-9)


@pytest.mark.parametrize("table", [DELTA, FIVE_BAR])
def test_deflection_and_frequency_by_the_stiffness_of_the_platform(table: dict) -> None:
    """Second road: K and M about the platform, K V = load and K v = omega^2 M v."""
    points = POINTS if table is DELTA else [[0.0, 0.3, 0.0], [0.1, 0.35, 0.0]]
    design, tasks = ParametricPlatform.of(table).at(), TaskSet.of({"points": points, "payload": 1.0})
    found = evaluate(design, tasks)
    motors = design.motors
    rods = None if np.isinf(motors.rod_stiffness) else motors.rod_stiffness
    K = rod_indices(design.robot, tasks.poses, found.q, motor_stiffness=motors.stiffness, rod_stiffness=rods).stiffness
    loaded = design.loaded(1.0, (0.0, 0.0, 0.0))
    M = loaded.mass_matrix(tasks.poses, found.q)
    J = design.robot.jacobian(tasks.poses, found.q)
    for k in range(len(points)):
        load = np.linalg.solve(J[k].T, found.torque[k])
        assert found.deflection[k] == pytest.approx(np.linalg.norm(np.linalg.solve(K[k], load)), rel=1e-8)
        assert found.frequency[k] == pytest.approx(
            np.sqrt(eigh(K[k], M[k], eigvals_only=True)[0]) / 2 / np.pi, rel=1e-8
        )


def test_a_stewart_platform_carries_its_load_by_its_legs() -> None:
    tasks = TaskSet.of({
        "poses": [[0, 0, 0.6, 0, 0, 0], [0.05, 0, 0.6, 0, 0.1, 0.05]], "payload": 5.0, "centre": [0.0, 0.05, 0.1],
        "period": 2.0, "characteristic_length": 0.2,
    })  # fmt: skip
    found = evaluate(ParametricPlatform.of(STEWART).at(), tasks)
    robot = StewartPlatform.on_circles(0.4, 0.2, BASE, PLATFORM)
    assert found
    np.testing.assert_allclose(found.q, robot.lengths(tasks.poses), atol=1e-12)
    for T, torque in zip(tasks.poses, found.torque, strict=True):
        at, weight = T @ [0.0, 0.05, 0.1, 1.0], np.array([0.0, 0.0, -5.0 * 9.81])
        load = np.concatenate([np.cross(at[:3], weight) + np.cross(T[:3, 3], weight), 2 * weight])
        # Legs balance the load: the platform exerts it, in space axes about the origin.
        np.testing.assert_allclose(np.abs(torque), np.abs(robot.leg_forces(T, load)), rtol=1e-8)
    assert found.measures["peak_torque"] > found.measures["static_torque"]
    far = evaluate(ParametricPlatform.of(STEWART).at(), TaskSet.of({"poses": [[0, 0, 1.6, 0, 0, 0]]}))
    assert far.status.name == "NOT_FOUND"


def test_motion_between_poses_by_differences() -> None:
    poses = TaskSet.of(
        {"poses": [[0, 0, 0.6, 0, 0, 0], [0.1, 0.2, 0.5, 0.3, -0.2, 0.4], [0, 0.1, 0.7, 0, 0.5, 0]]}
    ).poses
    T, V, Vd = (part.reshape(3, 25, *part.shape[1:]) for part in platform_motion(poses, 3.0))
    step = 1.0 / 25
    for leg in range(3):
        for k in range(1, 24):
            rate = (T[leg, k + 1] - T[leg, k - 1]) / (2 * step) @ np.linalg.inv(T[leg, k])
            seen = np.array([rate[2, 1], rate[0, 2], rate[1, 0], *rate[:3, 3]])
            np.testing.assert_allclose(V[leg, k], seen, atol=0.02)
            np.testing.assert_allclose(Vd[leg, k], (V[leg, k + 1] - V[leg, k - 1]) / (2 * step), atol=0.15)


def test_a_slow_cycle_takes_the_static_efforts_and_work_is_that_of_the_speed() -> None:
    design = ParametricPlatform.of(DELTA).at()
    slow = evaluate(design, TaskSet.of({"points": POINTS, "period": 1e5}))
    fast = evaluate(design, TaskSet.of({"points": POINTS, "period": 0.5}))
    twice = evaluate(design, TaskSet.of({"points": POINTS, "period": 0.25}))
    assert np.isfinite(slow.peak).all()
    assert twice.measures["speed"] == pytest.approx(2 * fast.measures["speed"], rel=1e-9)
    assert (twice.peak > 2 * fast.peak).all()
    away = TaskSet.of({"points": [[0.9, 0.0, -1.1], [-0.9, 0.0, -1.1]], "period": 1.0})
    blocked = ParametricPlatform.of(DELTA | {"motors": {"lower": -2.0, "upper": 0.2}}).at()
    assert np.isnan(evaluate(blocked, away).peak).all()


@pytest.mark.parametrize(
    ("table", "inner", "pose"),
    [(DELTA, False, np.array([0.0, 0.0, -0.9])), (FIVE_BAR, [True, False], np.array([0.0, 0.3]))],
)
def test_elbows_are_outside_as_such_robots_are_built_or_as_the_table_says(
    table: dict, inner: object, pose: np.ndarray
) -> None:
    away = list[np.ndarray]()
    for motors in ({}, {"second": inner}):
        robot = ParametricPlatform.of(table | {"motors": motors}).at()
        found = evaluate(robot, TaskSet.of({"points": [[*pose, 0.0][:3]]}))
        away.append(np.linalg.norm(robot.robot.carriers(found.q[0])[:, : len(pose) - 1], axis=-1))
    assert (away[0] > away[1]).all()


def test_many_platforms_are_as_each_one() -> None:
    family, tasks = ParametricPlatform.of(DELTA), TaskSet.of({"points": POINTS, "payload": 1.0, "period": 2.0})
    designs = [family.at(arm=value) for value in (0.4, 0.5, 0.6)]
    names = ("condition", "peak_torque", "mass", "payload", "reached", "deflection")
    measured, q = measure_designs(designs, tasks, names)
    for k, design in enumerate(designs):
        alone = evaluate(design, tasks)
        np.testing.assert_array_equal(q[k], alone.q)
        assert [measured[name][k] for name in names] == [alone.measures[name] for name in names]


def _orthoglide(edge: float) -> tuple[ParametricPlatform, TaskSet]:
    """Three linear motors at right angles through a point that stands off the middle of a cube; the cube's corners."""
    table = {
        "kind": "linear_delta",
        "parameters": {
            "rod": {"value": 0.4, "low": 0.25, "high": 0.6}, "off": {"value": 0.0, "low": -0.05, "high": 0.05},
        },
        "geometry": {
            "towers": [["off", "off", "off"]] * 3, "rods": "rod", "platform": np.zeros((3, 3)).tolist(),
            "rails": np.eye(3).tolist(),
        },
        "masses": {"rods": "rod"},
    }  # fmt: skip
    corners = edge / 2 * (2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1.0)
    return ParametricPlatform.of(table), TaskSet.of({"points": corners.tolist()})


def test_the_published_optimum_of_the_orthoglide_is_found() -> None:
    """Wenger & Chablat 2000: the shortest rods whose velocity amplification stays between 1/2 and 2 over a cube.

    At the corner (p, p, p) from the isotropic point it is 1 / (1 + 2 t) with t = p / sqrt(L^2 - 2 p^2): a half and two
    where p = L / sqrt(6) and - L / sqrt(18), so that the cube of 200 mm needs rods of 310.6 mm.
    """
    family, tasks = _orthoglide(0.2)
    limits = {"amplification": 2.0, "singular_distance": 0.5}
    found = optimise(family, tasks, ["mass"], limits, population=16, generations=60, seed=1)
    (best,) = found.points
    assert best.proved
    assert best.values["rod"] == pytest.approx(0.2 / (1 / np.sqrt(6) + 1 / np.sqrt(18)), rel=2e-3)
    assert best.values["rod"] == pytest.approx(0.3106, rel=2e-3)


def test_an_isotropic_delta_has_rods_at_right_angles() -> None:
    """J is isotropic in the middle where W W' = E l^2: the three rods are normal to each other."""
    table = DELTA | {"parameters": {"arm": {"value": 0.5, "low": 0.3, "high": 1.4}}}
    found = optimise(
        ParametricPlatform.of(table), TaskSet.of({"points": [[0.0, 0.0, -1.0]]}), ["condition"], population=12,
        generations=40,
    )  # fmt: skip
    (best,) = found.points
    assert best.proved
    design = best.design
    rods = design.robot.ends([0.0, 0.0, -1.0]) - design.robot.carriers(best.evaluation.q[0])
    assert best.measures["condition"] > 0.999
    np.testing.assert_allclose(rods @ rods.T / 1.244**2, np.eye(3), atol=2e-3)


def test_wrong_platforms_are_refused(tmp_path: Path) -> None:
    for change, word in (
        ({"kind": "octopod"}, "octopod"), ({"wheels": 4}, "wheels"), ({"geometry": {"base": 0.1}}, "platform"),
        ({"masses": {"soul": 1.0}}, "soul"), ({"motors": {"colour": 1.0}}, "colour"),
        ({"motors": {"effort": -1.0}}, "effort"),
        ({"motors": {"lower": 1.0, "upper": 0.0}}, "lower"),
        ({"motors": {"upper": float("nan")}}, "lower"),
        ({"gravity": [0.0, float("inf"), 0.0]}, "gravity"), ({"geometry": DELTA["geometry"] | {"arms": "leg"}}, "leg"),
        ({"geometry": DELTA["geometry"] | {"arms": -0.1}}, "arms"), ({"masses": {"platform": -1.0}}, "platform"),
    ):  # fmt: skip
        with pytest.raises(mf.MafsilError, match=word):
            ParametricPlatform.of(DELTA | change)
    family, tasks = ParametricPlatform.of(DELTA), TaskSet.of({"points": POINTS})
    with pytest.raises(mf.InputError, match="goals"):
        optimise(family, tasks, ["reach"])
    with pytest.raises(mf.InputError, match="scene"):
        evaluate(family.at(), TaskSet(tasks.poses, task="position", scene=mf.collision.Scene()))


def test_the_command_answers_for_a_platform(tmp_path: Path) -> None:
    page = (Path(__file__).resolve().parents[2] / "docs/design.md").read_text(encoding="utf-8")
    (tmp_path / "delta.toml").write_text(page.split("```toml\n")[1].split("```")[0], encoding="utf-8")
    file = str(tmp_path / "delta.toml")
    assert answer_of_command("tasks", file, ["arm=0.4"], None, None, None).data["measures"]["mass"] == pytest.approx(
        2.92
    )
    found = answer_of_command("search", file, None, None, None, None)
    assert len(found.data["designs"]) >= 2
    for what, out in (("accuracy", None), ("reach", None), ("tasks", str(tmp_path / "delta.urdf"))):
        with pytest.raises(mf.InputError, match="only arms"):
            answer_of_command(what, file, None, None, None, out)


def _front(**options: object) -> mf.design.Front:
    tasks = TaskSet.of({"points": [[0.7, 0.2, 0.0], [0.3, -0.5, 0.0]], "payload": 1.0})
    return optimise(
        plane_arm(),
        tasks,
        ["mass", "condition"],
        {"utilisation": 0.9},
        points=3,
        population=10,
        generations=4,
        **options,
    )  # type: ignore[arg-type]


def test_a_search_that_was_stopped_ends_as_one_that_was_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole, file, looked = _front(), tmp_path / "kept.npz", []
    measure = mf.design.search.measure_designs

    def stop_soon(designs: list, *args: object, **named: object) -> object:
        looked.extend(designs)
        if len(looked) > 70:
            raise KeyboardInterrupt
        return measure(designs, *args, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(mf.design.search, "measure_designs", stop_soon)
    with pytest.raises(KeyboardInterrupt):
        _front(resume=file)
    kept = len(np.load(file)["x"])
    assert 0 < kept < 70
    looked.clear()
    monkeypatch.setattr(
        mf.design.search,
        "measure_designs",
        lambda designs, *a, **n: looked.extend(designs) or measure(designs, *a, **n),
    )
    again = _front(resume=file)
    assert again.designs == whole.designs
    assert len(looked) <= whole.count - kept + len(again)
    looked.clear()
    assert _front(resume=file).designs == whole.designs
    assert len(looked) == len(again)
    with pytest.raises(mf.FileError, match="another search"):
        _front(resume=file, seed=1)
    file.write_bytes(file.read_bytes()[:200])
    with pytest.raises(mf.FileError):
        _front(resume=file)


def test_designs_measured_elsewhere_are_the_same_to_the_last_bit() -> None:
    alone = _front()
    with ThreadPoolExecutor(3) as threads:
        assert _front(executor=threads).designs == alone.designs
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as processes:
        assert _front(executor=processes).designs == alone.designs
    with cluster_executor("2") as client:
        assert _front(executor=client).designs == alone.designs


def test_hypervolume_of_boxes_and_of_a_known_front() -> None:
    assert hypervolume([[1.0, 2.0], [2.0, 1.0]], [3.0, 3.0]) == 3.0
    assert hypervolume([[1.0, 1.0, 1.0], [0.0, 2.0, 2.0], [5.0, 0.0, 0.0]], [3.0, 3.0, 3.0]) == pytest.approx(9.0)
    assert hypervolume(np.zeros((0, 2)), [1.0, 1.0]) == 0.0
    rng = np.random.default_rng(0)
    rows, points = rng.uniform(size=(12, 3)), rng.uniform(size=(40_000, 3))
    share = (points[:, None] >= rows).all(axis=2).any(axis=1).mean()
    assert hypervolume(rows, [1.0, 1.0, 1.0]) == pytest.approx(share, abs=0.01)
    # Mass and reach are both as long as the arm is: the front is a line from (0.2, 0.2) to (2, 2), halved by steps.
    tube = {"outer": 0.05, "wall": 0.004}
    lengths = {name: {"value": 0.5, "low": 0.1, "high": 1.0} for name in ("a", "b")}
    joints = [{"tube": tube}, {"a": "a", "tube": tube}]
    arm = ParametricArm.of({
        "convention": "modified", "parameters": lengths, "joint": joints, "tool": {"xyz": ["b", 0.0, 0.0]}
    })  # fmt: skip
    tasks = TaskSet.of({"points": [[0.15, 0.0, 0.0]]})
    front = optimise(arm, tasks, ["mass", "reach"], points=4, population=8, generations=8)
    line = 2700 * pi * 0.004 * 0.046
    f = np.array([[point.measures["mass"] / line, -point.measures["reach"]] for point in front])
    np.testing.assert_allclose(f[:, 0], -f[:, 1], rtol=1e-6)
    steps = len(front) - 1
    best = 1.8**2 / 2 * (1 - 1 / steps)
    assert hypervolume(f, [2.0, -0.2]) > 0.9 * best


def test_hundreds_of_designs_take_seconds() -> None:
    """200 six-axis arms of lengths of all the range on 100 poses, built and measured: a second, and room."""
    arm = ParametricArm.of(TABLE)
    poses = arm.robot(upper=0.4).fk(np.random.default_rng(0).uniform(-1, 1, (100, 6)))
    tasks, names = TaskSet(poses, payload=2.0), ("reached", "condition", "utilisation", "mass")
    measure_designs([arm.at()], tasks, names)
    within(5.0, lambda: measure_designs([arm.at(upper=float(u)) for u in np.linspace(0.2, 0.6, 200)], tasks, names))
