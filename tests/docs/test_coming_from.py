"""The tables of docs/coming-from.md: every call of mafsil runs, and peers that are installed give the same numbers."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "coming-from.md").read_text("utf-8")
SECTIONS = dict(re.findall(r"^## ([^\n]+)\n(.*?)(?=^## |\Z)", PAGE, re.M | re.S))
ROWS = {
    library: {theirs: ours.strip("`") for theirs, ours in re.findall(r"^\| (`.+?) \| (`[^|]+`) \|", text, re.M)}
    for library, text in SECTIONS.items()
}
LINEAR_FIRST = [3, 4, 5, 0, 1, 2]
"""Rows of ours in the order of libraries whose twists are (v, omega)."""

Ours = Callable[[str], Any]


@pytest.fixture(scope="module")
def values() -> dict[str, Any]:
    """The names that the page defines before its tables."""
    names: dict[str, Any] = {}
    exec(re.search(r"```python\n(.*?)```", PAGE, re.S)[1], names)  # type: ignore[index]
    return names


@pytest.fixture
def ours(request: pytest.FixtureRequest, values: dict[str, Any]) -> Ours:
    """The value of our call in the one row of the test's library whose other call contains a text."""

    def value(theirs: str) -> Any:
        (call,) = [call for cell, call in ROWS[request.param].items() if theirs in cell]
        return eval(call, values)

    return value


def test_all_seven_are_there() -> None:
    assert len(ROWS) == 7
    for library, rows in ROWS.items():
        lines = re.findall(r"^\| `", SECTIONS[library], re.M)
        assert len(lines) == len(rows) >= 9, library


@pytest.mark.parametrize("call", sorted({call for rows in ROWS.values() for call in rows.values()}))
def test_call_answers(call: str, values: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    answer = eval(call, values)
    assert answer is not None
    assert not hasattr(answer, "status") or answer, "an answer that is no"


@pytest.mark.parametrize("ours", ["Modern Robotics"], indirect=True)
def test_modern_robotics(ours: Ours, values: dict[str, Any]) -> None:
    mr = pytest.importorskip("modern_robotics")
    robot, q, T, V, F = (values[name] for name in ("robot", "q", "T", "V", "F"))
    M = robot.fk(0 * q)
    S = robot.jacobian(0 * q, expressed_in="space")
    B = robot.jacobian(0 * q)
    same(ours("FKinSpace"), mr.FKinSpace(M, S, q))
    same(ours("JacobianSpace"), mr.JacobianSpace(S, q))
    same(ours("JacobianBody"), mr.JacobianBody(B, q))
    same(ours("MatrixExp6"), mr.MatrixExp6(mr.VecTose3(V)))
    same(ours("MatrixLog6"), mr.se3ToVec(mr.MatrixLog6(T)))
    same(ours("Adjoint"), mr.Adjoint(T))
    same(ours("EndEffectorForces"), mr.JacobianBody(B, q).T @ F)
    middle = mr.JointTrajectory(q, values["goal"], 1.0, 3, 5)[1]
    same(ours("JointTrajectory").at(0.5).u, middle)


@pytest.mark.parametrize("ours", ["Pinocchio"], indirect=True)
def test_pinocchio(ours: Ours, values: dict[str, Any], tmp_path: Path) -> None:
    pin = pytest.importorskip("pinocchio")
    q, qd, qdd, tau, T = (values[name] for name in ("q", "qd", "qdd", "tau", "T"))
    model = pin.buildModelFromUrdf(urdf(values, tmp_path))
    data, link = model.createData(), model.getFrameId("link7")
    pin.framesForwardKinematics(model, data, q)
    same(ours("data.oMf[i]"), data.oMf[link].homogeneous)
    for reference in ("LOCAL", "WORLD", "LOCAL_WORLD_ALIGNED"):
        J = pin.computeFrameJacobian(model, data, q, link, getattr(pin, reference))
        same(ours(f"pin.{reference})")[LINEAR_FIRST], J)
    same(ours("pin.rnea"), pin.rnea(model, data, q, qd, qdd))
    same(np.triu(ours("pin.crba")), np.triu(pin.crba(model, data, q)))
    same(ours("nonLinearEffects"), pin.nonLinearEffects(model, data, q, qd))
    same(ours("GeneralizedGravity"), pin.computeGeneralizedGravity(model, data, q))
    same(ours("CoriolisMatrix"), pin.computeCoriolisMatrix(model, data, q, qd))
    same(ours("pin.aba"), pin.aba(model, data, q, qd, tau))
    same(ours("centerOfMass"), pin.centerOfMass(model, data, q))
    same(ours("pin.ccrba")[LINEAR_FIRST], pin.ccrba(model, data, q, qd))
    same(ours("pin.log6")[LINEAR_FIRST], pin.log6(pin.SE3(T)).vector)
    x, y, z, w = pin.Quaternion(T[:3, :3].copy()).coeffs()
    same_rotation(ours("Quaternion"), [w, x, y, z])


@pytest.mark.parametrize("ours", ["Drake"], indirect=True)
def test_drake(ours: Ours, values: dict[str, Any], tmp_path: Path) -> None:
    tree = pytest.importorskip("pydrake.multibody.tree")
    parsing = pytest.importorskip("pydrake.multibody.parsing")
    plants = pytest.importorskip("pydrake.multibody.plant")
    q, qd, qdd = (values[name] for name in ("q", "qd", "qdd"))
    plant = plants.MultibodyPlant(0.0)
    parsing.Parser(plant).AddModels(urdf(values, tmp_path))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(values["robot"].mechanism.link_names[0]))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, np.concatenate([q, qd]))
    world, link = plant.world_frame(), plant.GetFrameByName("link7")
    same(ours("CalcRelativeTransform"), plant.CalcRelativeTransform(context, world, link).GetAsMatrix4())
    velocity = tree.JacobianWrtVariable.kV
    same(
        ours("JacobianSpatialVelocity"),
        plant.CalcJacobianSpatialVelocity(context, velocity, link, np.zeros(3), world, world),
    )
    same(ours("CalcMassMatrix"), plant.CalcMassMatrix(context))
    same(ours("CalcBiasTerm"), plant.CalcBiasTerm(context))
    same(ours("CalcGravity"), -plant.CalcGravityGeneralizedForces(context))
    forces = tree.MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)
    same(ours("CalcInverseDynamics"), plant.CalcInverseDynamics(context, qdd, forces))
    same(ours("CenterOfMass"), plant.CalcCenterOfMassPositionInWorld(context))


@pytest.mark.parametrize("ours", ["MuJoCo"], indirect=True)
def test_mujoco(ours: Ours, values: dict[str, Any], tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    q, qd, qdd, tau, T = (values[name] for name in ("q", "qd", "qdd", "tau", "T"))
    model = mujoco.MjModel.from_xml_path(saved(values, tmp_path / "arm.xml"))
    model.dof_damping[:] = model.dof_frictionloss[:] = 0
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.qfrc_applied[:] = q, qd, tau
    mujoco.mj_forward(model, data)
    body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "link7")
    linear, angular, M = np.zeros((3, model.nv)), np.zeros((3, model.nv)), np.zeros((model.nv, model.nv))
    mujoco.mj_jacBody(model, data, linear, angular, body)
    same(ours("mj_jacBody"), np.vstack([angular, linear]))
    same(ours("data.xpos")[:3, 3], data.xpos[body])
    same(ours("qfrc_bias"), data.qfrc_bias)
    same(ours("data.qacc"), data.qacc)
    mujoco.mj_fullM(model, data, M)
    same(ours("mj_fullM"), M)
    data.qacc[:] = qdd
    mujoco.mj_inverse(model, data)
    same(ours("qfrc_inverse"), data.qfrc_inverse)
    w = np.zeros(4)
    mujoco.mju_mat2Quat(w, T[:3, :3].flatten())
    same_rotation(ours("mat2Quat"), w)


@pytest.mark.parametrize("ours", ["MoveIt, OMPL, Ruckig and TOPP-RA"], indirect=True)
def test_ruckig(ours: Ours, values: dict[str, Any]) -> None:
    ruckig = pytest.importorskip("ruckig")
    start, goal, n = values["q"], values["goal"], 7
    request, answer = ruckig.InputParameter(n), ruckig.Trajectory(n)
    request.current_position, request.target_position = list(start), list(goal)
    request.max_velocity, request.max_acceleration, request.max_jerk = [2.0] * n, [5.0] * n, [100.0] * n
    assert ruckig.Ruckig(n).calculate(request, answer) == ruckig.Result.Working
    assert ours("Ruckig(n)").duration == pytest.approx(answer.duration, rel=1e-9)


def urdf(values: dict[str, Any], folder: Path) -> str:
    return saved(values, folder / "arm.urdf")


def saved(values: dict[str, Any], path: Path) -> str:
    """The page's arm in a file for another library."""
    values["robot"].save(path)
    return str(path)


def same(value: Any, other: Any) -> None:
    np.testing.assert_allclose(np.asarray(value), np.asarray(other), rtol=1e-7, atol=1e-8)


def same_rotation(quaternion: Any, other: Any) -> None:
    """Both signs of a quaternion are one rotation."""
    assert abs(np.dot(quaternion, other)) == pytest.approx(1.0, abs=1e-12)
