"""Inverse kinematics with all solutions: planted configurations are found, nothing is wrong, every no explained."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation
from mafsil.ik import closed_form, inverse_kinematics
from mafsil.ik.result import IKStatus
from mafsil.ik.structure.analysis import analysis
from mafsil.model.dh_from_axes import screws

ARMS = [
    "puma560", "elbow6r", "arm6r", "offset_puma", "generalized_puma", "stanford_arm", "offset_stanford", "rrprrr",
    "rrprrr_upright", "ur3e", "ur5e", "ur10e", "cobra600", "scara_rrrp", "planar2r", "planar3r",
]  # fmt: skip
POSES = int(os.environ.get("MAFSIL_IK_POSES", "1000"))
SHARD = int(os.environ.get("MAFSIL_IK_SHARD", "0"))
"""A larger campaign: MAFSIL_IK_POSES=100000 MAFSIL_IK_SHARD=3 pytest tests/ik/test_inverse.py -k planted"""


def turning(robot):
    return np.array([joint.kind.value == "revolute" for joint in robot.mechanism.coordinates])


def apart(robot, q, other):
    """Largest difference of coordinates, angles up to whole turns."""
    d = q - other
    return np.abs(np.where(turning(robot), (d + np.pi) % (2 * np.pi) - np.pi, d)).max(axis=-1)


def random_arm(rng, *, wrist=False, parallel=False, n=6):
    """Axes anywhere; the last three through one point, or axes 2 to 4 parallel and 5 meeting 6, if asked for."""
    w = rng.normal(size=(n, 3))
    r = 0.6 * rng.normal(size=(n, 3))
    if parallel:
        w[2:4] = w[1] * np.array([[1.0], [-1.0]])
        w[4] = np.cross(w[1], w[4])
        r[5] = r[4]
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    if wrist:
        w[2] = w[1]
        r[3:] = r[3]
        w[4] = np.cross(w[3], w[4])
        w[4] /= np.linalg.norm(w[4])
        w[5] = np.cross(w[4], w[5])
        w[5] /= np.linalg.norm(w[5])
    home = np.eye(4)
    home[:3, 3] = rng.normal(size=3)
    return mf.Robot.from_screws(np.concatenate([w, np.cross(r, w)], axis=1), home)


@pytest.mark.capability("07-2", "07-13", "07-30", "07-35")
@pytest.mark.parametrize("name", ARMS)
def test_planted_configurations_are_found_and_nothing_is_wrong(name):
    robot = mf.load(name)
    form = closed_form(robot)
    assert form is not None
    q = np.random.default_rng((7, SHARD)).uniform(-np.pi, np.pi, (POSES, robot.n))
    T = robot.forward_kinematics(q)
    answer = form.solve(T)
    found = answer.solves_pose()
    missed = np.where(found, apart(robot, answer.q, q[:, None]), np.inf).min(axis=1)
    values = np.linalg.svd(robot.jacobian_body(q), compute_uv=False)
    # Rounding of the pose moves it by about 1e-15 over the conditioning, twice where a root was taken before.
    assert (missed < np.maximum(1e-6, 1e-11 * values[:, 0] / values[:, min(6, robot.n) - 1])).all()
    reached = robot.forward_kinematics(answer.q[found])
    wanted = np.broadcast_to(T[:, None], (*found.shape, 4, 4))[found]
    assert np.abs(reached - wanted).max() < 1e-9
    twice = apart(robot, answer.q[:, :, None], answer.q[:, None]) < 1e-9
    twice &= found[:, :, None] & found[:, None] & ~np.eye(found.shape[1], dtype=bool)
    # Planar arms of two joints have one configuration per pose, listed by both roots.
    assert not twice.any() or name == "planar2r"


@pytest.mark.capability("07-19", "07-21", "07-4")
@pytest.mark.parametrize("name", ARMS)
def test_round_angles_lose_nothing(name):
    """Multiples of 45 degrees stand on every singular set at once."""
    robot = mf.load(name)
    q = np.random.default_rng(11).integers(-4, 5, (60, robot.n)) * (np.pi / 4)
    for planted, T in zip(q, robot.forward_kinematics(q), strict=True):
        answer = inverse_kinematics(robot, T)
        assert len(answer.q), f"{name}: {planted!r}"
        assert answer.residual.max() <= 1e-9
        assert np.abs(robot.forward_kinematics(answer.q) - T).max() < 1e-8
        assert apart(robot, answer.q, planted).min() < 1e-5 or answer.families, f"{name}: {planted!r}"


@pytest.mark.capability("07-19", "07-20")
@pytest.mark.parametrize("off", [0.0, 1e-16, 1e-14, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-4])
@pytest.mark.parametrize(("name", "joint"), [("puma560", 4), ("puma560", 2), ("ur5e", 4), ("ur5e", 2), ("elbow6r", 4)])
def test_beside_singular_sets_no_pose_is_wrong(name, joint, off):
    robot = mf.load(name)
    rng = np.random.default_rng(3)
    for _ in range(4):
        q = rng.uniform(-np.pi, np.pi, 6)
        q[joint] = off
        if (name, joint) == ("puma560", 2):
            q[joint] = off + np.arctan2(0.0203, 0.4318)
        T = robot.forward_kinematics(q)
        answer = inverse_kinematics(robot, T)
        assert len(answer.q)
        assert answer.residual.max() <= 1e-9
        # The planted configuration, or one merged with it, or a family through it.
        assert answer.families or apart(robot, answer.q, q).min() < 1e-3


@pytest.mark.capability("07-22", "07-27", "07-29")
@pytest.mark.parametrize("kind", ["wrist", "parallel", "reversed"])
def test_random_arms_of_the_families(kind):
    for seed in range(2):
        rng = np.random.default_rng((21, seed))
        robot = random_arm(rng, wrist=kind != "parallel", parallel=kind == "parallel")
        if kind == "reversed":
            T = pose.inverse(robot.forward_kinematics(np.zeros(6)))
            S, _, home = screws(robot.mechanism)
            Ad = pose.adjoint(T)
            robot = mf.Robot.from_screws(-(S @ Ad.T)[::-1], pose.inverse(home))
        assert analysis(robot.mechanism).exact, kind
        assert closed_form(robot).pattern.reversed == (kind == "reversed")
        q = rng.uniform(-np.pi, np.pi, (100, 6))
        answer = closed_form(robot).solve(robot.forward_kinematics(q))
        planted = answer.solves_pose() & (apart(robot, answer.q, q[:, None]) < 1e-5)
        assert planted.any(axis=1).all()


@pytest.mark.capability("07-44")
def test_general_arms_find_the_planted_configuration():
    rng = np.random.default_rng(31)
    for _ in range(6):
        robot = random_arm(rng)
        for q in rng.uniform(-np.pi, np.pi, (5, 6)):
            answer = inverse_kinematics(robot, robot.forward_kinematics(q))
            assert answer.method == "elimination"
            assert apart(robot, answer.q, q).min() < 1e-6
            assert len(answer.q) % 2 == 0
            assert answer.complete


@pytest.mark.capability("07-44")
def test_the_arm_with_sixteen_postures():
    """Six joints, all sixteen solutions real: Manocha and Canny, 1994, example 1 (after Wampler and Morgan)."""
    alpha, a, d = np.deg2rad([90, 1, 90, 1, 90, 1]), (0.3, 1, 0, 1.5, 0, 0), (0, 0, 0.2, 0, 0, 0)
    rows = [mf.DHRow(a=a[i], alpha=alpha[i], d=d[i], theta=0.0, kind="R") for i in range(6)]
    robot = mf.Robot.from_dh(rows, "classic")
    T = np.eye(4)
    printed = [[-0.760117, -0.641689, 0.102262], [0.133333, 0, 0.991071], [-0.635959, 0.766965, 0.085558]]
    T[:3, :3] = rotation.project(np.array(printed))
    T[0, 3] = -1.140175
    answer = inverse_kinematics(robot, T)
    assert len(answer.q) == 16
    assert answer.complete
    assert answer.residual.max() < 1e-10


@pytest.mark.capability("07-45", "07-4")
@pytest.mark.parametrize("name", ["panda", "fr3", "iiwa7"])
def test_seven_joints_by_a_held_one(name):
    robot = mf.load(name)
    form = closed_form(robot)
    q = np.random.default_rng(5).uniform(robot.limits.lower, robot.limits.upper, (500, 7))
    answer = form.solve(robot.forward_kinematics(q), q)
    assert (answer.solves_pose() & (apart(robot, answer.q, q[:, None]) < 1e-6)).any(axis=1).all()
    one = inverse_kinematics(robot, robot.forward_kinematics(q[0]), q0=q[0])
    assert apart(robot, one.q, q[0]).min() < 1e-6
    assert one.families
    assert not one.complete
    family = one.families[0]
    member = family.at(one.q[family.solution][robot.joint_names.index(family.joint)] + 0.02)
    assert np.abs(robot.forward_kinematics(member) - robot.forward_kinematics(q[0])).max() < 1e-8


@pytest.mark.capability("07-4", "07-19")
def test_families_can_be_walked():
    robot = mf.load("puma560")
    T = robot.forward_kinematics(np.array([0.3, 0.2, 0.4, 0.1, 0.0, 0.5]))
    answer = inverse_kinematics(robot, T)
    assert answer.status is IKStatus.CONTINUUM
    (family,) = answer.families
    assert family.joint == "joint4"
    assert family.moving == ("joint4", "joint6")
    for value in (-1.0, 0.4, 2.0):
        member = family.at(value)
        assert member[3] == pytest.approx(value)
        assert np.abs(robot.forward_kinematics(member) - T).max() < 1e-9
    assert "joint4" in answer.explain("en")
    assert "joint4" in answer.explain("ar")
    assert "joint6: -1" in family.relation()


@pytest.mark.capability("07-5")
def test_branches_have_different_labels():
    robot = mf.load("ur5e")
    q = np.array([0.3, -1.1, 1.4, -0.7, 0.9, 0.2])
    answer = inverse_kinematics(robot, robot.forward_kinematics(q))
    assert len(answer.q) == 8
    assert len({str(branch) for branch in answer.branches}) == 8
    assert {branch.elbow for branch in answer.branches} == {"up", "down"}
    assert {branch.shoulder for branch in answer.branches} == {"left", "right"}
    assert {branch.wrist for branch in answer.branches} == {"flip", "noflip"}
    assert answer.branches[0].label("en").startswith("shoulder")
    assert answer.branches[0].label("ar").startswith("الكتف")


@pytest.mark.capability("07-3")
def test_out_of_reach_says_by_how_much():
    robot = mf.load("elbow6r")
    T = robot.forward_kinematics(np.zeros(6)).copy()
    T[0, 3] += 0.25
    answer = inverse_kinematics(robot, T)
    assert answer.status is IKStatus.OUT_OF_REACH
    assert not answer
    assert answer.complete
    assert answer.details["error"] == pytest.approx(0.25, abs=1e-6)
    assert "out of reach by 250 mm" in answer.explain("en")
    assert answer.explain("ar")
    np.testing.assert_allclose(answer.T_nearest, robot.forward_kinematics(answer.q_nearest))


@pytest.mark.capability("07-3")
def test_limits_name_the_joint_and_the_value_it_needs():
    robot = mf.load("ur5e")
    joints = tuple(
        replace(joint, limits=replace(joint.limits, lower=-0.1, upper=0.1)) if joint.name == "elbow_joint" else joint
        for joint in robot.mechanism.joints
    )
    stiff = mf.Robot(replace(robot.mechanism, joints=joints))
    T = robot.forward_kinematics(np.array([0.3, -1.1, 1.4, -0.7, 0.9, 0.2]))
    answer = inverse_kinematics(stiff, T)
    assert answer.status is IKStatus.BEYOND_LIMITS
    assert answer.details["joint"] == "elbow_joint"
    assert abs(answer.details["value"]) > 0.1
    assert not answer.within.any()
    for language in ("en", "ar"):
        assert "elbow_joint" in answer.explain(language)


def test_windings_are_counted_apart():
    robot = mf.load("ur5e")  # limits of two turns
    answer = inverse_kinematics(robot, robot.forward_kinematics(np.array([0.3, -1.1, 1.4, -0.7, 0.9, 0.2])))
    windings = answer.multi_turn_solutions(limit=100000)
    assert len(windings) == 8 * 2**6
    assert np.abs(robot.forward_kinematics(windings) - robot.forward_kinematics(answer.q[:1])).max() < 1e-9
    far = np.array([-5.9, -1.1, 1.4, -0.7, 0.9, -6.0])
    assert apart(robot, answer.nearest(far), np.array([0.3, -1.1, 1.4, -0.7, 0.9, 0.2])) < 1e-9
    assert answer.nearest(far)[0] < -5.0


@pytest.mark.capability("07-11")
def test_position_of_a_redundant_arm_is_a_family():
    robot = mf.load("planar3r")
    T = robot.forward_kinematics(np.array([0.4, 0.5, -0.3]))
    answer = inverse_kinematics(robot, T, task="position")
    assert answer.status is IKStatus.CONTINUUM
    for q in answer.q:
        np.testing.assert_allclose(robot.forward_kinematics(q)[:3, 3], T[:3, 3], atol=1e-9)


def test_axis_task_of_a_six_joint_arm():
    robot = mf.load("puma560")
    T = robot.forward_kinematics(np.array([0.3, -0.5, 0.4, 0.6, 0.7, 0.5]))
    answer = inverse_kinematics(robot, T, task="axis")
    assert len(answer.q)
    reached = robot.forward_kinematics(answer.q)
    np.testing.assert_allclose(reached[:, :3, 2], np.broadcast_to(T[:3, 2], (len(reached), 3)), atol=1e-8)
    np.testing.assert_allclose(reached[:, :3, 3], np.broadcast_to(T[:3, 3], (len(reached), 3)), atol=1e-8)


def test_few_joints_say_that_the_orientation_is_not_theirs():
    robot = mf.load("cobra600")
    tilt = pose.exp(np.array([0.4, 0.0, 0.0, 0.0, 0.0, 0.0]))
    answer = inverse_kinematics(robot, robot.forward_kinematics(np.array([0.2, 0.5, 0.1, 0.3])) @ tilt)
    assert answer.status is IKStatus.NOT_OF_THIS_ARM
    assert "4 joints" in answer.explain("en")
    assert answer.explain("ar")


@pytest.mark.parametrize("n", [3, 4, 5])
def test_arms_of_few_joints_in_general_position(n):
    rng = np.random.default_rng(41 + n)
    robot = random_arm(rng, n=n)
    for q in rng.uniform(-2, 2, (3, n)):
        answer = inverse_kinematics(robot, robot.forward_kinematics(q))
        assert apart(robot, answer.q, q).min() < 1e-6


def test_what_is_no_pose_is_refused():
    robot = mf.load("puma560")
    with pytest.raises(InputError, match="not a pose"):
        inverse_kinematics(robot, np.diag([1.0, 1.0, 2.0, 1.0]))
    with pytest.raises(InputError):
        inverse_kinematics(robot, np.full((4, 4), np.nan))
    with pytest.raises(InputError):
        inverse_kinematics(robot, np.eye(3))
    with pytest.raises(InputError, match="task"):
        inverse_kinematics(robot, np.eye(4), task="planar")
    rows = closed_form(robot).solve(np.stack([np.full((4, 4), np.nan), robot.forward_kinematics(np.ones(6))]))
    assert not rows.solves_pose()[0].any()
    assert rows.solves_pose()[1].any()


@pytest.mark.parametrize("tolerance", [0.0, -1e-9, float("nan"), float("inf"), "small", True])
def test_a_tolerance_is_a_positive_number(tolerance):
    robot = mf.load("puma560")
    with pytest.raises(InputError, match="tolerance"):
        inverse_kinematics(robot, robot.forward_kinematics(np.full(6, 0.3)), tolerance=tolerance)


def test_a_task_that_is_no_word_is_refused():
    with pytest.raises(InputError, match="task"):
        inverse_kinematics(mf.load("puma560"), np.eye(4), task=["pose"])


def test_batches_print_a_line_for_each_pose():
    robot = mf.load("puma560")
    T = robot.forward_kinematics(np.full((2, 6), 0.3))
    first, _, *rows = repr(inverse_kinematics(robot, T)).split("\n")
    assert first == "2 of 2 poses solved"
    assert [row.split()[:2] for row in rows] == [["0", "8"], ["1", "8"]]


def test_a_search_shows_some_members_of_a_continuum_and_not_hundreds():
    robot = mf.load("cobra600")
    answer = inverse_kinematics(robot, robot.forward_kinematics(np.full(4, 0.1)), task="axis")
    assert answer.status is IKStatus.CONTINUUM
    assert not answer.complete
    assert 1 <= len(answer) <= 8


def test_eaik_finds_the_same_sets():
    eaik = pytest.importorskip("eaik.IK_HP")
    from mafsil.ik.chain import chain_of

    for name in ("elbow6r", "generalized_puma", "ur5e"):
        robot = mf.load(name)
        chain = chain_of(robot.mechanism)
        P = np.diff(np.concatenate([np.zeros((1, 3)), chain.points, chain.home[None, :3, 3]]), axis=0)
        other = eaik.HPRobot(chain.axes, P)
        tool = chain.home[:3, :3]
        for q in np.random.default_rng(2).uniform(-np.pi, np.pi, (40, 6)):
            T = robot.forward_kinematics(q)
            asked = T.copy()
            asked[:3, :3] = T[:3, :3] @ tool.T
            theirs = np.asarray(other.IK(asked).Q).reshape(-1, 6)
            theirs = theirs[np.abs(robot.forward_kinematics(theirs) - T).max(axis=(1, 2)) < 1e-6]
            mine = inverse_kinematics(robot, T).q
            for configuration in theirs:
                assert apart(robot, mine, configuration).min() < 1e-5
            distinct = [k for k in range(len(theirs)) if not any(apart(robot, theirs[:k], theirs[k]) < 1e-6)]
            assert len(mine) == len(distinct)
