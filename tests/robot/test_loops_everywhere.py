"""Whatever takes a robot gets one with loops: it answers for the closed chain, or refuses; never for the tree."""

from __future__ import annotations

import inspect
import pickle
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError, MafsilError, ModelError
from mafsil.geometry import pose
from mafsil.mechanics.catalogue import CATALOGUE
from mafsil.model.dh_from_axes import dh_from_mechanism
from mafsil.parallel import ClosedChain
from mafsil.robot.closed_states import STATES
from tests.public import faces

ROBOTS = Path(__file__).parents[2] / "examples" / "robots"
ROBOT_TYPE = re.compile(r"\b(RobotLike|Robot|Mechanism|Described)\b")
REFUSALS = ("robot.loops", "robot.loops_routine", "simulation.rigid_loops", "table.unwritable", "writing.refused")

CLOSED = {
    "mafsil.Scenario": "moved by ClosedPlant: tests/simulation/test_closed_loops.py",
    "mafsil.plan": "paths keep loops closed: tests/planning/test_closed_arms.py",
    "mafsil.save": "writes the loops: tests/model/mjcf/test_mjcf_loops.py",
    "mafsil.show": "cards of the closed chain: tests/page/test_pages_of_loops.py",
    "mafsil.verify": "checks the loops by a second method: tests/verification/test_closed_verification.py",
    "mafsil.page.Session": "moves the driven joints: tests/page/test_pages_of_loops.py",
    "mafsil.page.Page": "a record of show",
    "mafsil.studio.Studio": "the page's arm: tests/page/test_pages_of_loops.py",
    "mafsil.collision.Checker": "shapes at given coordinates; planning closes them: tests/planning/test_closed_arms.py",
    "mafsil.collision.ArmMount": "a record that a Checker takes",
    "mafsil.control.contact.tip_wrench_of": "a state's: test_the_wrench_of_an_environment_is_that_of_a_closed_state",
    "mafsil.figures.plot_mechanism": "drawn closed: test_pictures_are_of_closed_loops below",
    "mafsil.figures.plot_response": "draws recorded coordinates: tests/simulation/test_closed_loops.py records them",
    "mafsil.job.bench_laws": "drives jobs, which keep loops closed: tests/job/test_closed_mechanisms.py",
    "mafsil.job.driving.simulate_plan": "drives a planned job: tests/job/test_closed_mechanisms.py",
    "mafsil.mobility.linkage_of": "closes the loops: tests/mobility/test_mobility.py",
    "mafsil.model.with_loops": "adds loops to a description",
    "mafsil.model.with_skeleton": "adds shapes to a description",
    "mafsil.model.lint.findings": "reads a description",
    "mafsil.model.mjcf.write": "writes the loops: tests/model/mjcf/test_mjcf_loops.py",
    "mafsil.model.sdf.write": "writes the loops: tests/model/sdf/test_sdf_writer.py",
    "mafsil.parallel.ClosedChain": "the closed chain itself: tests/parallel/test_closed_dynamics.py",
    "mafsil.parallel.closed_inverse_kinematics": "tests/parallel/test_closed_poses.py",
    "mafsil.planning.loop_constraints": "what a path keeps: tests/planning/test_closed_arms.py",
    "mafsil.scene.Drawing": "shapes of a description",
    "mafsil.simulation.ClosedPlant": "tests/simulation/test_closed_loops.py",
    "mafsil.robot.OpenTree": "the tree, asked for by name",
    "mafsil.robot.as_open_tree": "the tree, asked for by name",
    "mafsil.robot.of_robot": "makes functions that refuse",
    "mafsil.trajectory.compare_profiles": "efforts by the robot's routines, which refuse: test_timing_refuses below",
    "mafsil.verbs.fk": "as forward_kinematics: test_routines_are_of_closed_states_or_refused below",
    "mafsil.verbs.plot": "as figures.plot_mechanism: test_pictures_are_of_closed_loops below",
    "mafsil.trajectory.time_optimal": "refused where it needs the robot: test_timing_refuses below",
}
"""Those that answer for a robot with loops, and where their answer is asserted, or why there is no number in it."""

CLOSED_VERBS = {"fk", "plan", "plot", "show", "verify"}
"""Methods of a robot that answer for the closed chain, see above."""
DESCRIPTION = {
    "degrees", "radians", "from_dh", "from_screws", "inertial_parameters", "joint_names", "knows_loops", "limits",
    "with_locked_joints", "mechanism", "n",
    "name", "save", "tip", "with_frame", "with_payload", "with_tip", "with_tool", "without_loops",
    "derived",  # what other packages keep with the description, such as layouts of its shapes
    "friction_torque", "friction_regressor",  # each joint's own law of its own rate, whatever the loops do
}  # fmt: skip
pytestmark = pytest.mark.filterwarnings("ignore::mafsil.errors.ModelWarning")


def takers() -> dict[str, tuple[Callable[..., Any], list[str]]]:
    """Every public callable that takes a robot by its annotation, and the names of those arguments."""
    found: dict[int, tuple[str, Callable[..., Any], list[str]]] = {}
    for face in faces():
        for name in face.__all__:
            each = getattr(face, name)
            if inspect.ismodule(each) or not callable(each):
                continue
            try:
                parameters = inspect.signature(each).parameters.values()
            except ValueError:
                continue
            robots = [p.name for p in parameters if ROBOT_TYPE.search(str(p.annotation))]
            if robots:
                found.setdefault(id(each), (f"{face.__name__}.{name}", each, robots))
    return {name: (each, robots) for name, each, robots in found.values()}


TAKERS = takers()


@pytest.fixture(scope="module")
def palletiser() -> mf.Robot:
    return mf.load(ROBOTS / "palletiser.xml")


def called(each: Callable[..., Any], robots: list[str], robot: mf.Robot) -> Any:
    """A call with the robot, and with nothing that could be meant as any other argument."""
    by_place, by_name = [], {}
    for p in inspect.signature(each).parameters.values():
        if p.name in robots:
            value: object = robot if "Robot" in str(p.annotation) else robot.mechanism
        elif p.default is p.empty and p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD):
            value = object()
        else:
            continue
        # Wrapped functions are called by the name of their wrapper's own first argument, or by place.
        if p.kind is p.POSITIONAL_ONLY or (not by_name and p.kind is p.POSITIONAL_OR_KEYWORD):
            by_place.append(value)
        else:
            by_name[p.name] = value
    return each(*by_place, **by_name)


def robots_in(record: object) -> list[mf.Robot]:
    slots = [getattr(record, name, None) for kind in type(record).__mro__ for name in getattr(kind, "__slots__", ())]
    return [each for each in (*slots, *getattr(record, "__dict__", {}).values()) if isinstance(each, mf.Robot)]


def test_the_list_finds_them() -> None:
    assert len(TAKERS) > 180
    assert set(CLOSED) <= set(TAKERS)
    assert {
        "mafsil.solve_ik",
        "mafsil.optimal_base_placement",
        "mafsil.export",
        "mafsil.performance.manipulability",
    } <= set(TAKERS)


@pytest.mark.parametrize("name", sorted(set(TAKERS) - set(CLOSED)))
def test_whatever_takes_a_robot_refuses_loops(name: str, palletiser: mf.Robot) -> None:
    each, robots = TAKERS[name]
    if not inspect.isclass(each):
        with pytest.raises(MafsilError) as refusal:
            called(each, robots, palletiser)
        assert refusal.value.key in REFUSALS, refusal.value
        assert all(refusal.value.message(language) for language in ("en", "ar"))
        return
    try:
        made = called(each, robots, palletiser)
    except MafsilError as error:
        if error.key not in REFUSALS:
            raise
        return
    # What remains are records and laws that keep a robot as it was given: its routines refuse.
    kept = [made] if isinstance(made, mf.Robot) else robots_in(made)
    assert kept
    for one in kept:
        with pytest.raises(ModelError) as refused:
            _ = one.mass_matrix
        assert refused.value.key == "robot.loops_routine"


def test_the_tree_is_an_answer_when_it_is_asked_for(palletiser: mf.Robot) -> None:
    tree, q = palletiser.without_loops(), np.array([0.2, 0.1, -0.1, 0.3])
    assert palletiser.mechanism.loops
    assert not tree.mechanism.loops
    assert tree.joint_names == palletiser.joint_names
    np.testing.assert_allclose(tree.mass_matrix(q), ClosedChain(palletiser).terms(q).M, atol=1e-12)
    assert mf.performance.manipulability(tree, q) is not None
    assert mf.verify(tree, states=1)
    for opened in (ClosedChain(palletiser).robot, ClosedChain(palletiser).robot.with_tool([0, 0, 0.1])):
        with pytest.raises(ModelError, match="closed loops"):
            mf.performance.manipulability(opened, q)


@pytest.mark.parametrize("name", sorted(CATALOGUE))
def test_routines_are_of_closed_states_or_refused(name: str, palletiser: mf.Robot) -> None:
    chain, rng, row = ClosedChain(palletiser), np.random.default_rng(4), CATALOGUE[name]
    q = chain.close_loops(rng.uniform(-0.3, 0.3, (5, 4))).q
    qd = chain.rates(q, rng.uniform(-1, 1, (5, 4)))
    qdd = chain.accelerations(q, qd, rng.uniform(-1, 1, (5, 2)))
    state = {"q": q, "qd": qd, "qdd": qdd}
    if name not in STATES:
        with pytest.raises(ModelError, match=rf"without_loops\(\)\.{name}"):
            getattr(palletiser, name)
        return
    routine, ours = getattr(palletiser, name), [state[key] for key in row.inputs]
    expected = getattr(palletiser.without_loops(), name)(*ours)
    np.testing.assert_array_equal(routine(*ours), expected)
    np.testing.assert_array_equal(routine(*(x[0] for x in ours)), expected[0])
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(palletiser)).routine(name)(*ours), expected)
    named = dict(zip(row.inputs, ours, strict=True))
    np.testing.assert_array_equal(routine(**named), expected)
    for key in row.inputs:
        spoilt = {**named, key: named[key].copy()}
        spoilt[key][3, 1] += 1e-3
        with pytest.raises(InputError, match=rf"^{key}\[3\].*closed loops"):
            routine(**spoilt)
        gone = {**named, key: named[key].copy()}
        gone[key][3, 1] = np.nan
        assert np.isnan(routine(**gone)[3]).any()


def test_a_robot_all_of_whose_joints_are_locked_is_closed_or_refused(palletiser: mf.Robot) -> None:
    q = ClosedChain(palletiser).close_loops(np.array([0.2, 0.0, -0.1, 0.0])).q
    names = palletiser.joint_names
    still = palletiser.with_locked_joints(dict(zip(names, q, strict=True)))
    np.testing.assert_allclose(still.forward_kinematics(np.zeros(0)), palletiser.forward_kinematics(q), atol=1e-12)
    torn = palletiser.with_locked_joints(dict(zip(names, q + 0.1, strict=True)))
    with pytest.raises(InputError, match=r"^q: palletiser has closed loops"):
        torn.forward_kinematics(np.zeros((3, 0)))


def test_every_other_name_of_a_robot_refuses_or_describes(palletiser: mf.Robot) -> None:
    one, calls = np.zeros(4), {
        "base_parameters": (), "compiled_routine": ("mass_matrix",), "mass_matrix_singularity": (np.zeros(4),),
        "export": ("mass_matrix",), "kernel": ("forward_kinematics",), "routine": ("jacobian_body",),
        "task_space": (np.zeros(4), np.zeros(4)), "fused_routine": ("forward_kinematics", "jacobian_body"),
        "torque_terms": (np.zeros(4), np.zeros(4), np.zeros(4)), "derive": (), "ik": (np.eye(4),), "workspace": (100,),
        "ik_all": (np.eye(4),), "jacobian": (np.zeros(4),), "singularity": (np.zeros(4),),
        "simulate": (mf.trajectory.profiles.rest(np.zeros(4), 0.1),),
    }  # fmt: skip
    names = {name for name in dir(palletiser) if not name.startswith("_")} - set(CATALOGUE)
    assert names == set(calls) | DESCRIPTION | CLOSED_VERBS
    for name, arguments in calls.items():
        with pytest.raises(ModelError, match="closed loops"):
            getattr(palletiser, name)(*arguments)
    assert not palletiser.friction_torque(one).any()


def test_there_is_no_table_and_no_code_of_the_tree(palletiser: mf.Robot, tmp_path: Path) -> None:
    for act in (
        lambda: dh_from_mechanism(palletiser, "classic"), lambda: mf.model.screws(palletiser),
        lambda: mf.export(palletiser, "forward_kinematics"), lambda: mf.export(palletiser, "closed_form"),
        lambda: mf.export(palletiser, "computed_torque"), lambda: mf.derivation.derive_fk(palletiser),
    ):  # fmt: skip
        with pytest.raises(ModelError, match="closed loops"):
            act()
    with pytest.raises(ModelError, match="loop"):
        palletiser.save(tmp_path / "palletiser.urdf")
    with pytest.raises(ModelError):
        palletiser.save(tmp_path / "palletiser.toml")


def test_timing_refuses(palletiser: mf.Robot) -> None:
    both = np.array([[-1.0], [1.0]]) * np.ones(4)
    limits = mf.trajectory.MotionLimits(9 * both, both, both, both, 50 * both)
    path = mf.trajectory.JointPath.through([np.zeros(4), np.full(4, 0.1)])
    with pytest.raises(ModelError, match="closed loops"):
        mf.trajectory.time_optimal(path, limits, robot=palletiser)
    assert np.isfinite(palletiser.limits.effort).any()
    with pytest.raises(ModelError, match="closed loops"):
        mf.trajectory.compare_profiles([np.zeros(4), np.full(4, 0.1)], limits, robot=palletiser)


@pytest.mark.parametrize("fused", [True, False])
def test_laws_made_without_their_functions_refuse_too(fused: bool, palletiser: mf.Robot) -> None:
    chain = ClosedChain(palletiser)
    q, gains = chain.close_loops(np.zeros(4)).q, mf.control.Gains.of(4, 100.0, 20.0)
    given = mf.Scenario(robot=palletiser, trajectory=mf.trajectory.quintic(q, q, 0.01), law=mf.control.pid(4, 0.0))
    for law in (
        mf.control.laws.ComputedTorque(palletiser, gains), mf.control.laws.JointFeedback(gains, palletiser),
        mf.control.laws.Feedforward(palletiser),
    ):  # fmt: skip
        if not fused:  # a law in Python that fails ends the run
            run = mf.simulate(replace(given, law=law), fused=False)
            assert not run
            assert "closed loops" in run.explain()
            continue
        with pytest.raises(ModelError, match="closed loops"):
            mf.simulate(replace(given, law=law), fused=True)


def test_pictures_are_of_closed_loops(palletiser: mf.Robot, tmp_path: Path) -> None:
    from mafsil.job.planning.resting import resting_configuration

    q = resting_configuration(palletiser.mechanism)
    assert ClosedChain(palletiser).error(q) < 1e-12
    mf.figures.plot_mechanism(palletiser, tmp_path / "arm.png")
    with pytest.raises(InputError, match="closed loops"):
        mf.figures.plot_mechanism(palletiser, tmp_path / "b.png", q + np.array([0, 0.2, 0, 0]))
    assert not (tmp_path / "b.png").exists()


def test_the_wrench_of_an_environment_is_that_of_a_closed_state(palletiser: mf.Robot) -> None:
    chain = ClosedChain(palletiser)
    q = chain.close_loops(np.zeros(4)).q
    qd = chain.rates(q, np.array([0.2, 0, 0.1, 0]))
    floor = mf.control.Wall(np.array([0, 0, 2.0]), np.array([0, 0, 1.0]), stiffness=100.0, damping=5.0)
    V = chain.jacobian_body(q) @ qd[chain.actuated]
    expected = floor.wrench(palletiser.forward_kinematics(q), V)
    np.testing.assert_allclose(mf.control.contact.tip_wrench_of(palletiser, floor, q, qd), expected, atol=1e-12)
    with pytest.raises(InputError, match=r"^qd: palletiser has closed loops"):
        mf.control.contact.tip_wrench_of(palletiser, floor, q, qd + np.array([0, 0.1, 0, 0]))


@pytest.mark.parametrize("file", ["palletiser.xml", "stewart.xml"])
def test_jacobians_of_closed_chains_are_slopes_of_positions(file: str) -> None:
    robot, h = mf.load(ROBOTS / file), 1e-5
    chain = ClosedChain(robot)
    q = chain.close_loops(0.02 * np.random.default_rng(1).normal(size=robot.n)).q
    body, space = chain.jacobian_body(q), chain.jacobian_space(q)
    middle = robot.mechanism.link_names[len(robot.mechanism.links) // 2]
    home, T = chain.robot.forward_kinematics(q), []
    for k, joint in enumerate(chain.actuated):
        T = []
        for way in (h, -h):
            moved = q.copy()
            moved[joint] += way
            found = chain.close_loops(moved, hold=chain.actuated, tries=1)
            assert found
            T.append(chain.robot.forward_kinematics(found.q))
        twist = pose.log(T[0] @ pose.inverse(T[1])) / (2 * h)
        np.testing.assert_allclose(space[:, k], twist, atol=1e-7)
    np.testing.assert_allclose(space, pose.adjoint(home) @ body, atol=1e-10)
    # the same power at the motors as at the tip
    F = np.random.default_rng(2).normal(size=6)
    np.testing.assert_allclose(chain.joint_torque(q, F), body.T @ F, atol=1e-10)
    rows = np.stack([q, q])
    np.testing.assert_allclose(chain.jacobian_body(rows), np.stack([body, body]), atol=1e-12)
    if file == "palletiser.xml":
        assert chain.jacobian_body(q, frame=middle).shape == (6, 2)
        with pytest.raises(InputError, match=r"^q\[1\]: palletiser has closed loops"):
            chain.jacobian_body(np.stack([q, q + 0.1]))


def test_dexterity_of_a_closed_chain(palletiser: mf.Robot) -> None:
    chain = ClosedChain(palletiser)
    q = chain.close_loops(np.random.default_rng(3).uniform(-0.3, 0.3, (4, 4))).q
    J = chain.jacobian_space(q)[:, [3, 5]]
    np.testing.assert_allclose(mf.performance.manipulability_of(J), np.abs(np.linalg.det(J)), rtol=1e-9)
    s = np.linalg.svd(J, compute_uv=False)
    np.testing.assert_allclose(mf.performance.manipulability_of(J[0], "inverse_condition"), s[0, 1] / s[0, 0])
    np.testing.assert_allclose(mf.performance.dexterity.ellipsoid_of(J).lengths, s)
    of_tree = mf.performance.dexterity.ellipsoid_of(palletiser.without_loops().jacobian_space(q)[:, [3, 5]])
    assert np.abs(of_tree.lengths - s).max() > 1e-3
    with pytest.raises(InputError, match="measure"):
        mf.performance.manipulability_of(J, "roundness")


def test_jacobians_of_too_few_and_too_many_motors_are_refused(palletiser: mf.Robot) -> None:
    q = ClosedChain(palletiser).close_loops(np.zeros(4)).q
    names = palletiser.joint_names
    with pytest.raises(InputError, match="do not decide"):
        ClosedChain(palletiser, (names[0],)).jacobian_body(q)
    with pytest.raises(InputError, match="independently"):
        ClosedChain(palletiser, names[:3]).jacobian_body(q)
