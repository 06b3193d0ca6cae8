"""What stands beside the solutions: branch names, limits, windings, continua, reasons, and whole batches of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.ik import SolutionBatch, inverse_kinematics
from mafsil.ik.result import IKStatus
from mafsil.ik.structure.subproblems import linked_circles, three_axes

NAMES = ["puma560", "ur5e", "stanford_arm", "generalized_puma", "offset_puma"]


def apart(q, other):
    return np.abs((q - other + np.pi) % (2 * np.pi) - np.pi).max(axis=-1)


@pytest.mark.capability("07-5", "07-18")
@pytest.mark.parametrize("name", NAMES)
def test_labels_stay_along_a_path_without_singular_postures(name):
    robot = mf.load(name)
    rng = np.random.default_rng(17)
    kept = 0
    for _ in range(6):
        q = rng.uniform(-2, 2, 6)
        way = q + np.linspace(0, 1, 60)[:, None] * rng.uniform(-1.5, 1.5, 6)
        det = np.linalg.det(robot.jacobian_body(way))
        # Between two samples it cannot vanish where it is larger than its changes, not even twice at once, as where the
        # Stanford arm's stroke passes zero and shoulder and elbow change names together.
        change = np.abs(np.diff(det))
        clear = np.abs(det) > np.maximum(np.append(change, 0.0), np.append(0.0, change))
        until = len(way) if clear.all() else int((~clear).argmax())
        batch = inverse_kinematics(robot, robot.forward_kinematics(way))
        distance = np.where(batch.valid, apart(batch.q, way[:, None]), np.inf)
        assert distance.min(axis=1).max() < 1e-6
        words = batch.labels[np.arange(len(way)), distance.argmin(axis=1)]
        # The determinant is the product of the marks: where it does not vanish, no mark does.
        assert len(set(words[: max(until, 1)])) == 1
        kept += max(until, 1)
    assert kept > 20


@pytest.mark.capability("07-5")
def test_labels_mean_what_they_say():
    """Read off the configuration: heights and sides, not the formulas of the labels."""
    robot = mf.load("puma560")
    q = np.array([0.3, 0.4, -0.5, 0.6, 0.8, 0.2])
    answer = inverse_kinematics(robot, robot.forward_kinematics(q))
    for k, branch in enumerate(answer.branches):
        raised = answer.q[k] + np.array([0, 1e-6, 0, 0, 0, 0])
        turned = answer.q[k] + np.array([0, 0, 0, 0.7, 0, 0])
        start, lifted, same = (robot.forward_kinematics(x, frame="wrist_1") for x in (answer.q[k], raised, turned))
        np.testing.assert_allclose(start[:3, 3], same[:3, 3], atol=1e-12)  # the wrist's centre
        centre = start[2, 3], lifted[2, 3]
        assert (branch.shoulder == "right") == (centre[1] > centre[0])
        assert (branch.wrist == "noflip") == (np.sin(answer.q[k, 4]) > 0) or name_of_flip(answer, k)
    assert len(set(answer.branches)) == 8


def name_of_flip(answer, k):
    """The sign of joint 5 and the name agree for all solutions or for none."""
    same = [(b.wrist == "noflip") == (np.sin(q[4]) > 0) for b, q in zip(answer.branches, answer.q, strict=True)]
    return not any(same)


@pytest.mark.capability("07-5")
def test_labels_in_words():
    robot = mf.load("ur5e")
    answer = inverse_kinematics(robot, robot.forward_kinematics(np.array([0.3, -1.1, 1.4, -0.7, 0.9, 0.2])))
    assert len({b.label("en") for b in answer.branches}) == len({b.label("ar") for b in answer.branches}) == 8
    planar = mf.load("planar2r")
    only = inverse_kinematics(planar, planar.forward_kinematics(np.array([0.3, 0.7])), task="position")
    assert {b.label("en") for b in only.branches} == {"elbow up", "elbow down"}
    # Elbow up is the configuration whose second angle is negative.
    assert {b.elbow: bool(q[1] < 0) for b, q in zip(only.branches, only.q, strict=True)} == {"up": True, "down": False}


def test_the_branches_of_an_arm_without_names_are_signs_and_letters():
    rng = np.random.default_rng(3)
    w = rng.normal(size=(6, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    r = rng.normal(size=(6, 3))
    r[3:] = r[3]
    robot = mf.Robot.from_screws(np.concatenate([w, np.cross(r, w)], axis=1), np.eye(4))
    answer = inverse_kinematics(robot, robot.forward_kinematics(rng.uniform(-3, 3, 6)))
    assert answer.method == "closed form"
    assert len(set(answer.branches)) == len(answer.q) >= 2
    assert all(b.root and b.elbow in "+-" and b.label("en") and b.label("ar") for b in answer.branches)


@pytest.mark.capability("07-1", "07-30")
@pytest.mark.parametrize("name", [*NAMES, "cobra600", "planar3r"])
def test_batches_are_the_single_answers(name):
    robot = mf.load(name)
    rng = np.random.default_rng(8)
    q = rng.uniform(-np.pi, np.pi, (40, robot.n))
    q[::4] = np.round(q[::4] / (np.pi / 2)) * (np.pi / 2)
    T = robot.forward_kinematics(q)
    T[5, :3, 3] += 50.0
    T[6] = np.nan
    batch = inverse_kinematics(robot, T.reshape(4, 10, 4, 4))
    assert isinstance(batch, SolutionBatch)
    assert batch.q.shape[:2] == (4, 10)
    for i, X in enumerate(T):
        index = divmod(i, 10)
        if i == 6:
            assert batch.status[index] is IKStatus.NOT_A_POSE
            assert batch.count[index] == 0
            with pytest.raises(InputError, match="not a finite number"):
                batch[index]
            continue
        one = inverse_kinematics(robot, X)
        rows = batch.q[index][batch.valid[index]]
        assert len(rows) == len(one) == batch.count[index]
        assert all(apart(one.q, row).min() < 1e-6 for row in rows) or one.families
        assert batch.status[index] is one.status
        assert batch.solved[index] == one.within.any()
        assert len(batch[index]) == len(one)
        for k in np.flatnonzero(batch.valid[index]):
            assert str(batch.branch(*index, k)) == batch.labels[(*index, k)] != ""
    near = batch.nearest(np.zeros(robot.n))
    assert np.isnan(near[0, 5]).all() == (batch.count[0, 5] == 0)
    assert np.abs(robot.forward_kinematics(near[0, 0]) - T[0]).max() < 1e-8


def test_empty_batches_and_batches_of_general_arms():
    robot = mf.load("puma560")
    assert len(inverse_kinematics(robot, np.zeros((0, 4, 4)))) == 0
    rng = np.random.default_rng(5)
    S = rng.normal(size=(6, 6))
    S[:, :3] /= np.linalg.norm(S[:, :3], axis=1, keepdims=True)
    S[:, 3:] = np.cross(rng.normal(size=(6, 3)), S[:, :3])
    general = mf.Robot.from_screws(S, np.eye(4))
    q = rng.uniform(-3, 3, (3, 6))
    batch = inverse_kinematics(general, general.forward_kinematics(q))
    assert (np.where(batch.valid, apart(batch.q, q[:, None]), np.inf).min(axis=1) < 1e-6).all()


@pytest.mark.capability("07-3", "07-20")
def test_limits_per_branch():
    robot = mf.load("puma560")
    answer = inverse_kinematics(robot, robot.forward_kinematics(np.array([2.7, 0.4, -0.5, 0.6, 0.8, 0.2])))
    outside = [k for k in range(len(answer)) if not answer.within[k]]
    assert outside
    for k in range(len(answer)):
        found = answer.violations(k)
        assert bool(found) == (k in outside)
        for one in found:
            j = robot.joint_names.index(one.joint)
            assert one.value == answer.q[k, j]
            assert one.limit in (robot.limits.lower[j], robot.limits.upper[j])
            assert one.excess == pytest.approx(abs(one.value - one.limit))
            assert one.joint in one.explain("en")
            assert one.joint in one.explain("ar")


@pytest.mark.capability("07-4", "07-19", "07-21")
@pytest.mark.parametrize(
    ("q", "joints"),
    [
        ((0.3, 0.2, 0.4, 0.1, 0.0, 0.5), {"joint4"}),
        ("shoulder", {"joint1"}),
        ("both", {"joint1", "joint4"}),
    ],
)
def test_families_by_their_free_joints(q, joints):
    robot = mf.load("elbow6r")
    if isinstance(q, str):
        # The wrist's centre on axis 1: equal links, folded to the height of the shoulder.
        start = np.array([0.3, 0.5, 2.0, 0.4, 0.7, 0.2])
        start[1:3] = _over_the_shoulder(robot)
        if q == "both":
            start[4] = 0.0
        q = start
    T = robot.forward_kinematics(np.asarray(q))
    answer = inverse_kinematics(robot, T)
    assert answer.status is IKStatus.CONTINUUM
    assert {name for family in answer.families for name in family.joints} >= joints
    for family in answer.families:
        j = robot.joint_names.index(family.joint)
        reached = 0
        for value in np.linspace(-1.0, 1.0, 5):
            member = family.at(value)
            if np.isfinite(member).all():
                reached += 1
                assert member[j] == pytest.approx(value)
                assert np.abs(robot.forward_kinematics(member) - T).max() < 1e-8
        assert reached
        assert family.sample(np.zeros(2)).shape == (2, 6)
    assert any(answer.dependent(k) for k in range(len(answer)))
    assert "depend on each other" in answer.explain("en")
    assert answer.explain("ar")


def _over_the_shoulder(robot):
    """Joints 2 and 3 that bring the wrist's centre onto axis 1, by search."""
    best, grid = None, np.linspace(-np.pi, np.pi, 61)
    for third in np.linspace(0.5, 2.5, 5):
        q = np.zeros((len(grid), 6))
        q[:, 1], q[:, 2] = grid, third
        for _ in range(30):
            step = 1e-6
            x = _off_axis(robot, q)
            raised = q.copy()
            raised[:, 1] += step
            slope = (_off_axis(robot, raised) - x) / step
            q[:, 1] -= np.clip(x / np.where(np.abs(slope) < 1e-9, 1.0, slope), -0.2, 0.2)
        k = int(np.abs(_off_axis(robot, q)).argmin())
        if abs(_off_axis(robot, q[k : k + 1])[0]) < 1e-13:
            best = q[k, 1:3]
            break
    assert best is not None
    return best


def _off_axis(robot, q):
    """Signed distance of the wrist's centre from axis 1 in the plane of the arm."""
    from mafsil.ik.chain import chain_of, common_point

    chain = chain_of(robot.mechanism)
    centre, _ = common_point(chain.axes[3:], chain.points[3:])
    E = np.eye(4)
    for k in (0, 1, 2):
        E = E @ pose.exp(chain.screws[k] * q[:, k, None])
    place = E[..., :3, :3] @ centre + E[..., :3, 3] - chain.points[0]
    w1, w2 = chain.axes[:2]
    return place @ np.cross(w1, w2)


@pytest.mark.capability("07-3", "07-7")
def test_reasons_of_a_planar_arm():
    robot = mf.load("planar2r")
    base = robot.forward_kinematics(np.zeros(2))
    reach = base[0, 3]

    def at(x):
        T = np.eye(4)
        T[0, 3] = x
        T[2, 3] = base[2, 3]
        return inverse_kinematics(robot, T, task="position")

    far = at(reach + 0.3)
    assert far.status is IKStatus.OUT_OF_REACH
    assert far.complete
    assert far.details["error"] == pytest.approx(0.3, abs=1e-9)
    assert "too far away" in far.explain("en")
    inner = np.linalg.norm(robot.forward_kinematics(np.array([0.0, np.pi]))[:2, 3])
    if inner > 1e-3:
        near = at(inner / 2)
        assert near.details["error"] == pytest.approx(inner / 2, abs=1e-9)
        assert "too near" in near.explain("en")
        assert near.explain("ar")


@pytest.mark.capability("07-3", "07-19")
def test_the_nearest_pose_keeps_the_orientation_and_nothing_is_nearer():
    robot = mf.load("offset_puma")
    rng = np.random.default_rng(2)
    for scale in (3.0, 0.02):
        T = robot.forward_kinematics(rng.uniform(-2, 2, 6))
        T[:3, 3] *= scale
        answer = inverse_kinematics(robot, T)
        if len(answer):
            continue
        assert answer.status is IKStatus.OUT_OF_REACH
        assert answer.complete
        np.testing.assert_allclose(answer.T_nearest[:3, :3], T[:3, :3], atol=1e-8)
        distance = np.linalg.norm(answer.T_nearest[:3, 3] - T[:3, 3])
        assert answer.details["error"] == pytest.approx(distance, rel=1e-6)
        # No pose of the same orientation nearer than that is reachable.
        for _ in range(200):
            other = T.copy()
            d = rng.normal(size=3)
            other[:3, 3] += d / np.linalg.norm(d) * distance * (1 - 1e-6) * rng.random()
            assert not len(inverse_kinematics(robot, other))


@pytest.mark.capability("07-1")
def test_five_joints_reach_what_they_can_and_say_why_not_the_rest():
    rng = np.random.default_rng(12)
    w = np.array([[0, 0, 1], [0, 1, 0], [0, 1, 0], [0, 1, 0], [1.0, 0, 0]])
    r = np.array([[0, 0, 0], [0, 0, 0.3], [0.4, 0, 0.3], [0.7, 0, 0.3], [0.8, 0, 0.3]])
    home = np.eye(4)
    home[:3, 3] = [0.9, 0.0, 0.3]
    robot = mf.Robot.from_screws(np.concatenate([w, np.cross(r, w)], axis=1), home)
    for q in rng.uniform(-2, 2, (5, 5)):
        T = robot.forward_kinematics(q)
        answer = inverse_kinematics(robot, T)
        assert apart(answer.q, q).min() < 1e-6
        assert answer.complete
        no = inverse_kinematics(robot, T @ pose.exp(np.array([0.0, 0.0, 0.3, 0.0, 0.0, 0.0])))
        assert no.status is IKStatus.NOT_OF_THIS_ARM
        assert "5 joints" in no.explain("en")
        aimed = inverse_kinematics(robot, T, task="axis")
        assert aimed.status is not IKStatus.NOT_FOUND


@pytest.mark.capability("07-1")
def test_no_joints_are_no_crash():
    robot = mf.Robot.from_screws(np.array([[0, 0, 1.0, 0, 0, 0]]), np.eye(4))
    answer = inverse_kinematics(robot, robot.forward_kinematics(np.array([0.4])))
    np.testing.assert_allclose(answer.q, [[0.4]], atol=1e-9)
    fixed = replace(robot.mechanism, tip=robot.mechanism.links[0].name)
    none = inverse_kinematics(mf.Robot(fixed), np.eye(4))
    assert none.explain("en")


def test_subproblem_five_has_up_to_four_roots():
    rng = np.random.default_rng(1)
    counts = set()
    for _ in range(200):
        k = rng.normal(size=(3, 3))
        k /= np.linalg.norm(k, axis=1, keepdims=True)
        p0, p2, p3 = rng.normal(size=(3, 3))
        q = rng.uniform(-np.pi, np.pi, 3)
        turn = [pose.exp(np.concatenate([w * x, np.zeros(3)]))[:3, :3] for w, x in zip(k, q, strict=True)]
        p1 = turn[0].T @ (turn[1] @ (p2 + turn[2] @ p3) - p0)
        found = three_axes(*k, p0, p1, p2, p3).solutions(1e-8)
        assert apart(found, q).min() < 1e-6
        counts.add(len(found))
    assert counts == {2, 4}


def test_subproblem_six_has_up_to_four_roots():
    rng = np.random.default_rng(1)
    counts = set()
    for _ in range(300):
        A, B = rng.normal(size=(2, 2, 2))
        q = rng.uniform(-np.pi, np.pi, 2)
        x = np.stack([np.cos(q), np.sin(q)])
        found = linked_circles(A, B, A @ x[:, 0] + B @ x[:, 1]).solutions(1e-8)
        assert apart(found, q).min() < 1e-6
        counts.add(len(found))
    assert counts == {2, 4}


@pytest.mark.capability("07-2", "07-24")
def test_nothing_is_listed_twice_where_the_equation_of_fourth_degree_is_of_lower_degree():
    x, y, z = np.eye(3)
    axes = [z, y, -x, -y, -x, y]
    places = [0.5 * x, 0.25 * (x - z), 0 * x, 0.5 * x - 0.25 * z, -0.25 * (y + z), 0.5 * x - 0.25 * z]
    home = np.array([[1, 0, 0, 0.25], [0, 0, -1, -0.25], [0, 1, 0, 0.5], [0, 0, 0, 1.0]])
    robot = mf.Robot.from_screws(
        np.array([np.concatenate([w, np.cross(r, w)]) for w, r in zip(axes, places, strict=True)]), home
    )
    q = np.array([-1.153739, 2.03747303, np.pi, 0.0, -2.48902858, np.pi])
    T = robot.forward_kinematics(q)
    one, many = inverse_kinematics(robot, T), inverse_kinematics(robot, T[None])
    for found in (one.q, many.q[0][many.valid[0]]):
        assert apart(found, q).min() < 1e-9
        assert (apart(found[:, None], found[None]) + 9 * np.eye(len(found))).min() > 1e-6
