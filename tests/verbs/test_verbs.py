"""The verbs of a robot: each against the full function or an independent count."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import pickle
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil import verbs
from mafsil.errors import FileError, InputError, ModelError

ROBOTS = Path(__file__).parents[2] / "examples" / "robots"
SIX = ("puma560", "ur5e", "stanford_arm")


@pytest.fixture(scope="module", params=SIX)
def six(request):
    return mf.load(request.param)


def inside(robot, rng, count):
    lower = np.maximum(robot.limits.lower, -3.0)
    upper = np.minimum(robot.limits.upper, 3.0)
    return rng.uniform(lower, upper, (count, robot.n))


def test_the_stub_of_the_class_names_every_verb_of_the_table():
    stub = ast.parse(Path(mf.robot.__path__[0], "verbs.pyi").read_text("utf-8"))
    (kind,) = (node for node in stub.body if isinstance(node, ast.ClassDef))
    named = {ast.unparse(line) for line in kind.body}
    assert named == {f"{name} = verbs.{name}" for name in verbs.__all__}
    for name in verbs.__all__:
        assert getattr(mf.Robot, name) is getattr(verbs, name)
        assert name in dir(mf.load("planar2r"))
        assert getattr(verbs, name).__doc__


def test_degrees_are_of_angles_alone():
    scara = mf.load("scara_rrrp")
    q = np.array([0.3, -0.4, 0.5, 0.02])
    typed = scara.degrees(q)
    assert typed[3] == 0.02
    assert np.allclose(typed[:3], np.degrees(q[:3]), rtol=1e-15)
    assert np.allclose(scara.radians(typed), q, rtol=1e-15)
    assert np.allclose(scara.fk(typed, degrees=True), scara.forward_kinematics(q), atol=1e-15)
    assert np.allclose(scara.jacobian(typed, degrees=True), scara.jacobian_body(q), atol=1e-15)
    with pytest.raises(InputError, match="q"):
        scara.radians([1.0, 2.0])


ANGLES = frozenset({"q", "q0", "qd", "qdd", "q_preferred", "start"})
"""Arguments that hold joint coordinates or their time derivatives."""
KERNELS = frozenset({"fused_routine", "kernel", "routine", "compiled_routine", "radians", "degrees"})
"""What compiles, or converts itself."""


def takers():
    """Public methods and routines of a robot, and top-level functions, that are given joint coordinates."""
    owners = [(mf.Robot, name) for name in dir(mf.Robot)] + [(mf, name) for name in mf.__all__]
    for owner, name in owners:
        value = getattr(owner, name)
        if name.startswith("_") or name in KERNELS or not callable(value) or isinstance(value, type):
            continue
        names = tuple(inspect.signature(value).parameters)
        if ANGLES & set(names) or name == "ik_all":
            yield pytest.param(owner, name, names, id=f"{owner.__name__}.{name}")


def plain(answer):
    """What an answer holds in numbers, joint coordinates by name."""
    if isinstance(answer, np.ndarray | float):
        return {"": answer}
    if isinstance(answer, mf.performance.singularities.Singularity):
        return {"rank": answer.rank, "values": answer.singular_values}
    if isinstance(answer, mf.planning.ArmPlan):
        return {"path": answer.path}
    if hasattr(answer, "q"):
        return {"q": answer.q}
    numbers = {field.name: getattr(answer, field.name) for field in dataclasses.fields(answer)}
    return {name: value for name, value in numbers.items() if isinstance(value, np.ndarray | float | int)}


@pytest.mark.parametrize(("owner", "name", "names"), list(takers()))
def test_whatever_is_given_joint_coordinates_takes_them_in_degrees(owner, name, names):
    """One rule: what goes in is converted at the door, and coordinates of joints that come out are converted too."""
    assert "degrees" in names
    robot, rng = mf.load("puma560").with_payload(1.0), np.random.default_rng(4)
    angles = {key: rng.uniform(-0.3, 0.3, robot.n) for key in names if key in ANGLES}
    others = {
        "tau": np.ones(robot.n), "T_sd": robot.fk(rng.uniform(-0.3, 0.3, robot.n)), "scene": None,
        "goal": np.zeros(robot.n), "path": None, "trajectory": mf.trajectory.quintic(np.zeros(6), np.ones(6), 0.1),
    }  # fmt: skip
    rest = {key: others[key] for key in names if key in others and key != "path"}
    function = getattr(robot, name) if owner is mf.Robot else partial(getattr(mf, name), robot)
    if name == "plot":
        ours, theirs = function(**angles), function(robot.degrees(angles["q"]), degrees=True)
        spots = [[line.get_xydata() for axes in figure.axes for line in axes.lines] for figure in (ours, theirs)]
        assert all(np.allclose(a, b) for a, b in zip(*spots, strict=True))
        return
    ours = plain(function(**angles, **rest))
    typed = {key: robot.degrees(value) for key, value in angles.items()}
    given = plain(function(**typed, **rest, degrees=True))
    for key, value in ours.items():
        motion = name == "forward_dynamics" or (key == "q" and name != "simulate")
        assert np.allclose(given[key], robot.degrees(value) if motion else value, rtol=1e-9, atol=1e-9), key


def test_answers_in_degrees_take_and_give_degrees_in_all_their_parts():
    robot = mf.load("ur5e")
    typed = np.array([10.0, -90.0, 80.0, 5.0, 20.0, 30.0])
    T = robot.fk(np.stack([typed, typed + 1.0]), degrees=True)
    single, batch = robot.ik_all(T[0], degrees=True), mf.inverse_kinematics("ur5e", T, degrees=True)
    ours = robot.ik_all(T[0])
    assert len(single) == len(ours)
    assert single
    assert np.allclose(list(single), robot.degrees(ours.q))
    assert np.allclose(single.multi_turn_solutions(), robot.degrees(ours.multi_turn_solutions()))
    assert np.allclose(single.nearest(typed), typed)
    assert np.allclose(single.q_nearest, robot.degrees(ours.q_nearest))
    assert np.allclose(single.to_dict()["q"], single.q)
    assert single.status is ours.status
    assert single.explain("en") == ours.explain("en")
    assert np.allclose(batch.nearest(typed), [typed, typed + 1.0])
    assert np.allclose(batch[0].q, single.q)
    assert [len(one) for one in batch] == [len(single)] * 2


def test_degrees_pass_every_form_of_a_routine_call():
    """Frames, optional inputs, results to write into, batches, robots with loops and without inertia at a joint."""
    robot = mf.load("scara_rrrp").with_payload(1.0)
    q = np.array([[0.3, -0.4, 0.5, 0.02], [0.1, 0.2, 0.3, 0.05]])
    typed, wrench, out = robot.degrees(q), [0, 0, 0, 1.0, 2.0, 3.0], np.empty((2, 4))
    expected = robot.inverse_dynamics(q, q, q, wrench)
    for _ in range(2):
        assert np.allclose(robot.inverse_dynamics(typed, typed, typed, wrench, degrees=True), expected)
        assert np.allclose(robot.inverse_dynamics(typed, typed, qdd=typed, tip_wrench=wrench, degrees=True), expected)
    frame = robot.mechanism.link_names[1]
    assert np.allclose(robot.jacobian_body(typed, frame=frame, degrees=True), robot.jacobian_body(q, frame=frame))
    answer = robot.forward_dynamics(typed, typed, q, out=out, degrees=True)
    assert answer is out
    assert np.allclose(out, robot.degrees(robot.forward_dynamics(q, q, q)))
    assert np.allclose(robot.inverse_dynamics(typed, typed, out, degrees=True), q)
    with pytest.raises(InputError, match="takes q"):
        robot.mass_matrix(q, q, degrees=True)
    loops = mf.load(ROBOTS / "palletiser.xml")
    closed = np.zeros(loops.n)
    assert np.allclose(loops.fk(loops.degrees(closed), degrees=True), loops.fk(closed))


def test_ik_is_the_nearest_of_all_solutions_and_windings(six):
    rng = np.random.default_rng(5)
    for q, q0 in zip(inside(six, rng, 12), inside(six, rng, 12), strict=True):
        T = six.fk(q)
        answer = six.ik(T, q0)
        assert answer, answer.explain()
        every = six.ik_all(T).multi_turn_solutions()
        least = np.linalg.norm(every - q0, axis=1).min()
        assert np.linalg.norm(answer.q - q0) == pytest.approx(least, abs=1e-7)


def test_a_batch_gets_the_same_answers_as_single_poses(six):
    rng = np.random.default_rng(6)
    T, q0 = six.fk(inside(six, rng, 5)), inside(six, rng, 1)[0]
    together = six.ik(T, q0)
    alone = [six.ik(pose, q0).q for pose in T]
    assert np.allclose(together.q, alone, atol=1e-9)
    degrees = six.ik(T, six.degrees(q0), degrees=True)
    assert np.allclose(degrees.q, six.degrees(together.q), atol=1e-7)


def test_redundant_arms_stay_near_the_start():
    panda = mf.load("panda")
    rng = np.random.default_rng(7)
    q = inside(panda, rng, 20) * 0.5 + 0.25 * (panda.limits.lower + panda.limits.upper)
    start = q + rng.normal(scale=0.02, size=q.shape)
    answer = panda.ik(panda.fk(q), start)
    assert answer.all_solved
    assert (np.linalg.norm(answer.q - start, axis=1) <= np.linalg.norm(q - start, axis=1) + 1e-6).all()
    assert panda.ik(panda.fk(q[0]))


def test_joints_that_a_pose_leaves_free_stay_at_the_start():
    """The position of the tip of this arm does not depend on its last joint, which ends on the axis."""
    arm = mf.load("spatial3r")
    q = np.random.default_rng(3).uniform(-2.0, 2.0, (5, 3))
    T, q0 = arm.fk(q), q + np.array([0.02, -0.03, 0.04])
    alone = [arm.ik(pose, start, task="position").q for pose, start in zip(T, q0, strict=True)]
    for found in (np.array(alone), arm.ik(T, q0, task="position").q):
        assert (np.linalg.norm(found - q0, axis=1) <= np.linalg.norm(q - q0, axis=1) + 1e-9).all()


def test_ik_says_why_not_and_takes_tasks_and_frames(six):
    q = inside(six, np.random.default_rng(9), 1)[0]
    T = six.fk(q)
    far = T.copy()
    far[0, 3] += 50.0
    answer = six.ik(far)
    assert not answer
    assert "out of reach" in answer.explain(language="en")
    assert six.ik(T, task="position")
    assert six.ik(six.fk(q, six.tip), q, frame=six.tip).q == pytest.approx(q, abs=1e-8)
    with pytest.raises(InputError, match="task"):
        six.ik(T, task="nothing")


def test_the_jacobian_in_axes_of_the_base_is_the_rate_of_the_pose(six):
    q = inside(six, np.random.default_rng(8), 1)[0]
    J, h = six.jacobian(q, expressed_in="aligned"), 1e-6
    for k, step in enumerate(np.eye(6) * h):
        ahead, behind = six.fk(q + step), six.fk(q - step)
        turn = (ahead[:3, :3] - behind[:3, :3]) @ six.fk(q)[:3, :3].T / (2 * h)
        assert np.allclose(J[3:, k], (ahead[:3, 3] - behind[:3, 3]) / (2 * h), atol=1e-7)
        assert np.allclose(J[:3, k], [turn[2, 1], turn[0, 2], turn[1, 0]], atol=1e-7)
    assert np.array_equal(six.jacobian(q, expressed_in="space"), six.jacobian_space(q))
    assert np.array_equal(six.jacobian(q), six.jacobian_body(q))
    assert six.jacobian(np.zeros((4, 3, 6)), six.tip, expressed_in="aligned").shape == (4, 3, 6, 6)
    with pytest.raises(InputError, match="expressed_in"):
        six.jacobian(q, expressed_in="world")


def test_the_other_verbs_answer(tmp_path):
    robot = mf.load("planar2r")
    motion = mf.trajectory.quintic([0.0, 0.0], [0.5, 0.3], 0.5)
    run = robot.simulate(motion)
    assert np.abs(run.q[-1] - [0.5, 0.3]).max() < 1e-3
    free = robot.simulate(motion, mf.control.gravity_compensation(robot, 1.0, 0.1), q=[0.1, 0.0], duration=0.2)
    assert free.q[0] == pytest.approx([0.1, 0.0])
    assert free.t[-1] == pytest.approx(0.2)
    assert robot.singularity([0.3, 0.0]).explain("en") == mf.performance.singularity(robot, [0.3, 0.0]).explain("en")
    assert robot.verify()
    assert robot.workspace(2000, seed=1).explain() == mf.performance.workspace_map(robot, 2000, seed=1).explain()
    robot.plot([90, 0], tmp_path / "a.png", degrees=True)
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert "planar2r" in robot.show().html
    again = pickle.loads(pickle.dumps(robot))
    assert np.array_equal(again.fk([0.1, 0.2]), robot.fk([0.1, 0.2]))


@pytest.mark.parametrize("what", ["fk", "jacobian", "ik", "dynamics"])
def test_formulas_are_derived_by_name(what):
    assert mf.load("planar2r").derive(what).worst_error < 1e-9


def test_what_cannot_be_derived_is_said():
    with pytest.raises(InputError, match="dynamics"):
        mf.load("planar2r").derive("everything")


def test_a_plan_from_the_robot_is_the_plan():
    robot = mf.load("ur5e")
    start, goal = np.array([0, -1.5, 1.0, 0, 0, 0]), np.array([1.0, -1.2, 1.2, 0, 0, 0])
    found = robot.plan(None, start, goal, seed=1)
    assert found
    assert np.array_equal(found.path, mf.plan(robot, None, start, goal, seed=1).path)


@pytest.mark.parametrize(
    ("typed", "name"), [("Panda", "panda"), ("UR5e", "ur5e"), ("Puma 560", "puma560"), ("PLANAR-2R", "planar2r")]
)
def test_names_are_found_in_any_spelling(typed, name):
    assert mf.load(typed).name == mf.load(name).name
    assert name in mf.robots()
    assert mf.lint(typed).codes == mf.lint(name).codes


@pytest.mark.parametrize("typed", ["four-bar", "fourbar", "Four_Bar"])
def test_mechanisms_too(typed):
    assert mf.mobility(typed).explain("en") == mf.mobility("four_bar").explain("en")
    assert mf.mobility("stewart_gough").explain("en")
    with pytest.raises(InputError, match="four_bar"):
        mf.mobility("four bars")


URDF = """<robot name="gadget"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent link="a"/>
<child link="b"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""


@pytest.fixture
def descriptions(tmp_path, monkeypatch):
    """A package of that name with a robot that is there, and one that cannot be fetched."""
    package = tmp_path / "robot_descriptions"
    package.mkdir()
    (tmp_path / "gadget.urdf").write_text(URDF)
    (package / "__init__.py").write_text("")
    (package / "gadget_description.py").write_text(
        f"REPOSITORY_PATH = PACKAGE_PATH = {str(tmp_path)!r}\nURDF_PATH = {str(tmp_path / 'gadget.urdf')!r}\n"
    )
    (package / "absent_description.py").write_text("raise OSError('no network')\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield
    for name in [name for name in sys.modules if name.startswith("robot_descriptions")]:
        del sys.modules[name]


@pytest.mark.usefixtures("descriptions")
def test_robots_of_the_package_of_descriptions_load_by_name():
    for name in ("gadget", "gadget_description"):
        assert mf.load(name).joint_names == ("j",)
    with pytest.raises(FileError, match="no network"):
        mf.load("absent")
    with pytest.raises(FileError, match="unheard_of"):
        mf.load("unheard_of")


def test_robots_with_loops_get_no_numbers_of_their_tree():
    loops = mf.load(ROBOTS / "palletiser.xml")
    for verb in (loops.ik, loops.ik_all):
        with pytest.raises(ModelError, match="loops"):
            verb(np.eye(4))
    with pytest.raises(ModelError, match="loops"):
        loops.workspace(100)


def test_the_robot_may_be_given_by_name_of_its_argument():
    """Every function with degrees among its arguments takes its robot by keyword too, in both units."""
    robot, q = mf.load("ur5e"), [30.0, -60.0, 60.0, -90.0, -90.0, 0.0]
    T = robot.fk(q, degrees=True)
    assert mf.inverse_kinematics(robot=robot, T_sd=T)
    assert mf.inverse_kinematics(robot="ur5e", T_sd=T, q0=q, degrees=True)
    found = mf.solve_ik(robot=robot, T_sd=T, q0=q, degrees=True).q
    np.testing.assert_allclose(robot.fk(found, degrees=True), T, atol=1e-6)
    singularity = mf.performance.singularity
    assert singularity(robot=robot, q=q, degrees=True).explain() == singularity(robot, np.radians(q)).explain()


@pytest.mark.parametrize("language", ["en", "ar"])
def test_sentences_and_tables_in_degrees_have_degrees(language: str) -> None:
    """Every number of a joint in a sentence is the degrees of the one in radians; lengths stay."""
    puma, scara = mf.load("puma560"), mf.load("cobra600")
    T = puma.fk([170, 0, 10, 0, 20, 0], degrees=True)
    plain, typed = puma.ik_all(T), puma.ik_all(T, degrees=True)
    assert any(plain.violations(k) for k in range(len(plain)))
    for k in range(len(plain)):
        for rad, deg in zip(plain.violations(k), typed.violations(k), strict=True):
            assert (rad.unit, deg.unit) == ("rad", "deg")
            assert np.allclose([deg.value, deg.limit, deg.excess], np.degrees([rad.value, rad.limit, rad.excess]))
            assert " deg" in deg.explain(language)
            assert " rad" not in deg.explain(language)
    assert "q1 deg" in repr(typed)
    assert "q1 rad" in repr(plain)
    assert f"{typed.q[0, 0]:.3f}" in repr(typed)
    far = np.array(T)
    far[0, 3] += 3.0
    assert " deg" in puma.ik_all(far, degrees=True).explain(language)
    assert " rad" not in puma.ik_all(far, degrees=True).explain(language).replace("rad]", "")
    low = np.array(scara.forward_kinematics(np.zeros(scara.n)))
    low[2, 3] -= 1.0
    lowered = scara.ik_all(low, degrees=True)
    needs = [one for k in range(len(lowered)) for one in lowered.violations(k)]
    assert needs
    assert all(one.unit == "m" for one in needs)
