"""Tasks that ask for less than a pose, preferences for what is free, time limits, and honest refusals."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from time import perf_counter

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import mafsil as mf
from mafsil.errors import InputError, ModelError
from mafsil.ik import solve_ik
from mafsil.ik.numerical.fast_search import BLOCK
from mafsil.ik.numerical.problem import problem_of
from mafsil.ik.result import CODES, IKStatus
from mafsil.model import Joint, JointKind, Limits, Link, Mechanism, Mimic
from tests.budget import within


@pytest.fixture(scope="module")
def panda():
    return mf.load("panda")


def poses(robot, count, seed=1):
    lower = np.where(np.isfinite(robot.limits.lower), robot.limits.lower, -np.pi)
    upper = np.where(np.isfinite(robot.limits.upper), robot.limits.upper, np.pi)
    return robot.forward_kinematics(np.random.default_rng(seed).uniform(lower, upper, (count, robot.n)))


@pytest.mark.capability("07-1", "07-11")
@pytest.mark.parametrize("name", ["panda", "puma560", "planar3r", "spatial3r"])
def test_position_alone(name):
    robot = mf.load(name)
    T = poses(robot, 100)
    answer = solve_ik(robot, T, task="position")
    assert answer.all_solved
    reached = robot.forward_kinematics(answer.q)
    assert np.linalg.norm(reached[:, :3, 3] - T[:, :3, 3], axis=1).max() <= 1e-10
    assert np.abs(reached[:, :3, :3] - T[:, :3, :3]).max() > 0.1
    assert answer.rotation_error.max() == 0.0


@pytest.mark.parametrize("axis", [(0, 0, 1), (1.0, 2.0, -2.0)])
def test_position_and_direction_of_one_axis(panda, axis):
    T = poses(panda, 100)
    answer = solve_ik(panda, T, task="axis", axis=axis)
    assert answer.all_solved
    reached = panda.forward_kinematics(answer.q)
    a = np.array(axis) / np.linalg.norm(axis)
    assert np.abs(reached[:, :3, :3] @ a - T[:, :3, :3] @ a).max() <= 2e-10
    assert np.abs(reached[:, :3, 3] - T[:, :3, 3]).max() <= 1e-10


def test_direction_and_orientation_leave_the_place_free(panda):
    T = poses(panda, 50)
    T[:, :3, 3] += 100.0
    for task in ("orientation", "direction"):
        answer = solve_ik(panda, T, task=task)
        assert answer.all_solved
        R = panda.forward_kinematics(answer.q)[:, :3, :3]
        wanted = T[:, :3, :3]
        gap = R - wanted if task == "orientation" else R[:, :, 2] - wanted[:, :, 2]
        assert np.abs(gap).max() <= 2e-10


def test_opposite_axes_are_no_solution_and_not_a_trap(panda):
    q = np.array([0.0, 0.3, 0.0, -2.0, 0.0, 2.0, 0.0])
    T = panda.forward_kinematics(q)
    T[:3, :3] = T[:3, :3] @ np.diag([1.0, -1.0, -1.0])
    answer = solve_ik(panda, T, q, task="direction")
    assert answer.solved
    assert np.abs(panda.forward_kinematics(answer.q)[:3, 2] - T[:3, 2]).max() <= 2e-10


def test_weights_of_zero_set_components_free(panda):
    T = poses(panda, 50)
    answer = solve_ik(panda, T, weights=(1, 1, 1, 1, 1, 0))
    assert answer.all_solved
    reached = panda.forward_kinematics(answer.q)
    local = np.einsum("kji,kj->ki", reached[:, :3, :3], T[:, :3, 3] - reached[:, :3, 3])
    assert np.abs(local[:, :2]).max() <= 1e-10
    assert np.abs(local[:, 2]).max() > 1e-3


@pytest.mark.parametrize(("weights", "task"), [((1, 1, 1, 1, 1, 0), "pose"), ((1, 0, 1, 0, 2, 1), "pose"),
                                               ((1, 1, 1, 0, 1, 1), "axis"), ((0, 0, 1, 1, 0, 0), "pose")])  # fmt: skip
def test_weights_along_the_axes_of_the_base(panda, weights, task):
    """A placed robot: {s} is the frame of the weights, for one pose and for many."""
    T_sb = mf.geometry.pose.exp(np.array([0.4, -0.8, 0.3, 1.0, -2.0, 0.5]))
    robot = mf.Robot(replace(panda.mechanism, T_sb=T_sb))
    T = poses(robot, 40)
    answer = solve_ik(robot, T, task=task, weights=weights, expressed_in="aligned")
    assert answer.all_solved
    reached = robot.forward_kinematics(answer.q)
    apart = T[:, :3, 3] - reached[:, :3, 3]
    turn = np.stack([Rotation.from_matrix(R).as_rotvec() for R in T[:, :3, :3] @ reached[:, :3, :3].mT])
    if task == "axis":
        turn = np.cross(reached[:, :3, 2], T[:, :3, 2])
    counts = np.array(weights) > 0
    left = np.concatenate([turn, apart], axis=1)
    assert np.abs(left[:, counts]).max() <= 2e-10
    assert (np.abs(left[:, ~counts]).max(axis=0) > 1e-3).all()
    for k in range(5):
        alone = solve_ik(robot, T[k], task=task, weights=weights, expressed_in="aligned")
        np.testing.assert_allclose(alone.q, answer.q[k], atol=1e-9)


def test_weights_along_the_axes_of_the_base_balance_as_a_general_solver():
    """A place out of reach: errors along x and y come out as SciPy's, which minimises the weighted sum of squares."""
    robot = mf.load("spatial3r")
    place = np.array([1.5, 2.0, 0.4])
    T = np.eye(4)
    T[:3, 3] = place
    starts = np.random.default_rng(0).uniform(-3, 3, (12, 3))
    for weights in ((1, 1, 0), (1, 4, 0), (4, 1, 0), (1, 1, 4)):
        gap = partial(_weighted_gap, robot, place, np.array(weights))
        least = min((least_squares(gap, q) for q in starts), key=lambda found: found.cost)
        answer = solve_ik(robot, T, weights=(0, 0, 0, *weights), expressed_in="aligned", limits=False)
        assert not answer
        assert np.linalg.norm(gap(answer.nearest)) <= 1.02 * np.linalg.norm(least.fun)


def _weighted_gap(robot, place, weights, q):
    return weights * (place - robot.forward_kinematics(q)[:3, 3])


def test_weights_balance_what_cannot_vanish():
    robot = mf.load("spatial3r")
    T = poses(mf.load("spatial3r"), 1)[0]
    T[:3, :3] = T[:3, :3] @ np.diag([1.0, -1.0, -1.0])
    heavy = solve_ik(robot, T, weights=(1, 1, 1, 100, 100, 100), restarts=7)
    light = solve_ik(robot, T, weights=(100, 100, 100, 1, 1, 1), restarts=7)
    assert heavy.status is not IKStatus.SOLVED
    assert heavy.position_error < light.position_error
    assert light.rotation_error < heavy.rotation_error


def test_tolerances_apart(panda):
    T = poses(panda, 50)
    answer = solve_ik(panda, T, tolerance=1e-3, rotation_tolerance=1e-1)
    assert answer.all_solved
    assert answer.position_error.max() <= 1e-3
    assert answer.iterations.mean() < solve_ik(panda, T).iterations.mean()


@pytest.mark.capability("07-45", "07-48")
def test_postures_are_approached_in_the_self_motion(panda):
    T = poses(panda, 60)
    middle = problem_of(panda, None, True).middle
    plain, wished = solve_ik(panda, T), solve_ik(panda, T, q_preferred=middle)
    assert wished.all_solved
    before = ((plain.q - middle) ** 2).sum(axis=1)
    after = ((wished.q - middle) ** 2).sum(axis=1)
    assert (after <= before + 1e-9).all()
    assert (after < before - 1e-3).mean() > 0.5
    # At rest: the preferred motion has no part along the self-motion, unless a joint is at its limit.
    free = ((wished.q > panda.limits.lower + 1e-6) & (wished.q < panda.limits.upper - 1e-6)).all(axis=1)
    J = panda.jacobian_body(wished.q[free])
    z = middle - wished.q[free]
    along = z - np.einsum("kij,kj->ki", np.linalg.pinv(J) @ J, z)
    assert np.quantile(np.linalg.norm(along, axis=1), 0.9) < 1e-3


def test_preferred_weights_choose_the_joints(panda):
    T = poses(panda, 30)
    configuration = np.array([0.0, 0, 0, -1.5, 0, 1.5, 0])
    first = solve_ik(panda, T, q_preferred=configuration, preferred_weights=[1, 0, 0, 0, 0, 0, 0])
    plain = solve_ik(panda, T)
    assert np.abs(first.q[:, 0]).sum() < np.abs(plain.q[:, 0]).sum()


@pytest.mark.row("T1")
def test_time_limits_are_kept_and_nothing_is_said_unchecked(panda):
    T = poses(panda, 1)[0]
    T[:3, 3] = [0.0, 0.0, 0.9]
    T[:3, :3] = np.diag([1.0, 1.0, 1.0])
    solve_ik(panda, T, seconds=1.0, restarts=3)
    for seconds in (1e-4, 1e-3, 1e-2):
        search = partial(solve_ik, panda, T, seconds=seconds, restarts=1_000_000)
        answer = within(seconds + 0.05, search, clock=perf_counter)
        assert answer.status in (IKStatus.TIME_SPENT, IKStatus.SOLVED)
        if answer.status is IKStatus.SOLVED:
            assert answer.residual <= 1e-10
    for language in ("en", "ar"):
        assert answer.explain(language=language)


def test_poses_that_nobody_began_in_time_say_so_with_a_configuration(panda):
    answer = solve_ik(panda, poses(panda, 5 * BLOCK), seconds=1e-3)
    late = answer.codes == CODES[IKStatus.TIME_SPENT]
    assert late.any()
    assert np.isfinite(answer.q).all()
    assert np.isfinite(answer.residual).all()


def arm_of(*joints):
    """Links in a row: (kind, axis, offset, limits)."""
    links = [Link("l0"), *(Link(f"l{k + 1}") for k in range(len(joints)))]
    rows = []
    for k, (kind, axis, offset, limits, *mimic) in enumerate(joints):
        T = np.eye(4)
        T[:3, 3] = offset
        follows = mimic[0] if mimic else None
        rows.append(Joint(f"j{k + 1}", kind, f"l{k}", f"l{k + 1}", T, axis, limits=Limits(*limits), mimic=follows))
    return mf.Robot(Mechanism.assemble("row", links, rows))


X, Y, Z = np.eye(3)
TURN, SLIDE = JointKind.REVOLUTE, JointKind.PRISMATIC
WRIST = [(TURN, Z, (0, 0, 0.1), (-3, 3)), (TURN, Y, (0, 0, 0.1), (-3, 3)), (TURN, X, (0.1, 0, 0), (-3, 3))]


@pytest.mark.parametrize("stroke", [1e-3, 1.0, 1e3, 1e6, np.inf])
def test_strokes_of_any_length(stroke):
    robot = arm_of(*((SLIDE, axis, (0, 0, 0), (-stroke, stroke)) for axis in (X, Y, Z)), *WRIST)
    span = stroke if np.isfinite(stroke) else 1e3
    q = np.random.default_rng(3).uniform(-1, 1, (100, 6)) * [span, span, span, 3, 3, 3]
    answer = solve_ik(robot, robot.forward_kinematics(q))
    assert answer.all_solved
    assert answer.residual.max() <= 1e-10


def test_limits_narrower_than_the_tolerance():
    for width in (0.0, 1e-12):
        robot = arm_of(*((TURN, Z, (0.3, 0, 0), (0.3, 0.3 + width)) for _ in range(3)), *WRIST)
        q = np.array([0.3, 0.3, 0.3, 0.5, -0.4, 0.2])
        assert solve_ik(robot, robot.forward_kinematics(q)).solved
        q[0] += 0.2
        beyond = solve_ik(robot, robot.forward_kinematics(q))
        assert beyond.status is IKStatus.BEYOND_LIMITS


def test_joints_that_follow_others():
    robot = arm_of(
        (TURN, Z, (0, 0, 0.1), (-3, 3)),
        (TURN, Z, (0.3, 0, 0), (-2, 2)),
        (TURN, Z, (0.3, 0, 0), (-1.1, 1.1), Mimic("j2", -0.5, 0.1)),
        (SLIDE, X, (0.1, 0, 0), (-0.3, 0.3), Mimic("j1", 0.1)),
    )
    q = np.random.default_rng(0).uniform(robot.limits.lower, robot.limits.upper, (200, 2))
    answer = solve_ik(robot, robot.forward_kinematics(q))
    assert answer.all_solved
    np.testing.assert_allclose(answer.q, q, atol=1e-8)


@pytest.mark.capability("07-3")
def test_five_joints_asked_for_six_conditions():
    five = arm_of(WRIST[0], (TURN, Y, (0, 0, 0.3), (-3, 3)), (TURN, Y, (0.4, 0, 0), (-3, 3)), *WRIST[1:])
    reachable = poses(five, 100)
    assert solve_ik(five, reachable).all_solved
    T = poses(mf.load("panda"), 20)
    answer = solve_ik(five, T)
    assert {answer.status[k] for k in range(20)} <= {IKStatus.FEW_JOINTS, IKStatus.OUT_OF_REACH}
    missed = int(np.flatnonzero(answer.codes == CODES[IKStatus.FEW_JOINTS])[0])
    for language in ("en", "ar"):
        assert "'axis'" in answer.explain(missed, language=language)


def test_poses_too_far_for_numbers(panda):
    T = np.eye(4)
    T[0, 3] = 1e300
    with pytest.raises(InputError, match=r"beyond 1e\+100"):
        solve_ik(panda, T)
    assert solve_ik(panda, T[None])[0].status is IKStatus.NOT_A_POSE


def test_blocks_do_not_change_results(panda):
    T = poses(panda, BLOCK + 37)
    whole = solve_ik(panda, T)
    np.testing.assert_array_equal(whole.q[BLOCK:], solve_ik(panda, T[BLOCK:]).q)
    assert whole.all_solved


def test_robots_without_joints_are_refused_by_name():
    T = np.eye(4)
    T[0, 3] = 0.5
    weld = Joint("weld", JointKind.FIXED, "base", "tip", T_pj=T)
    post = mf.Robot(Mechanism.assemble("post", [Link("base"), Link("tip")], [weld]))
    with pytest.raises(ModelError, match="post"):
        solve_ik(post, T)


@pytest.mark.capability("07-3")
def test_too_few_joints_say_how_near_they_come():
    robot = mf.load("planar2r")
    T = np.eye(4)
    T[:3, 3] = [0.3, 0.2, 0.4]
    answer = solve_ik(robot, T, restarts=15)
    assert answer.status is IKStatus.FEW_JOINTS
    assert answer.residual > 1e-3
    assert np.isfinite(answer.q).all()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"task": "nose"}, "task"),
        ({"task": "axis", "axis": (0, 0, 0)}, "axis"),
        ({"weights": (0, 0, 0, 0, 0, 0)}, "weights"),
        ({"weights": (1, 1, 1, 1, 1, -1)}, "weight"),
        ({"expressed_in": "base"}, "expressed_in"),
        ({"expressed_in": None}, "expressed_in"),
        ({"task": "position", "weights": (1, 1, 1, 0, 0, 0)}, "position"),
        ({"rotation_tolerance": -1.0}, "rotation_tolerance"),
        ({"tolerance": "tight"}, "tolerance"),
        ({"tolerance": None}, "tolerance"),
        ({"seconds": 0.0}, "seconds"),
        ({"restarts": 1.5}, "restarts"),
        ({"restarts": np.nan}, "restarts"),
        ({"restarts": 10**30}, "restarts"),
        ({"seed": "a"}, "seed"),
        ({"seed": np.random.default_rng(0)}, "seed"),
        ({"frame": ["link5"]}, "frame"),
        ({"task": ["pose"]}, "task"),
        ({"axis": "z"}, "axis"),
        ({"weights": "w"}, "weights"),
        ({"q_preferred": np.zeros(3)}, "q_preferred"),
        ({"q_preferred": np.zeros(7), "preferred_weights": np.zeros(7)}, "preferred_weights"),
    ],
)
def test_wrong_settings_are_named(panda, given, words):
    T = panda.forward_kinematics(np.array([0.0, 0.3, 0.0, -2.0, 0.0, 2.0, 0.0]))
    with pytest.raises(InputError, match=words):
        solve_ik(panda, T, **given)
