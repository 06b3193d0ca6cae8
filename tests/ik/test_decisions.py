"""What the compiled closed form decides, and that many poses together are answered as each of them alone."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.ik import SolutionBatch, SolutionSet, inverse_kinematics
from mafsil.ik.answers.candidate_table import CandidateTable, Decision
from mafsil.ik.answers.setting import Setting, setting
from mafsil.ik.refine import distinct, pose_errors, refine_rows, residuals
from mafsil.ik.refine_loops import unique_rows
from mafsil.ik.result import IKStatus
from mafsil.ik.tolerances import NO_BETTER, SINGULAR
from mafsil.mechanics.arm_pattern import CLEAR, INSIDE, LOOSE, MERGED
from mafsil.robot import Robot, load
from tests.budget import within

SIX = ("puma560", "ur5e", "ur10e", "elbow6r")
OTHERS = ("scara_rrrp", "planar3r", "planar2r", "rrrp", "stanford_arm", "generalized_puma")
BENDS = (0.0, 1e-12, 1e-10, 1e-9, 3e-9, 1e-8, 1e-6, 1e-4)


@cache
def arm(name: str) -> Robot:
    return load(name)


def together(robot: Robot, T: Floats, tolerance: float = 1e-9) -> SolutionBatch:
    answer = inverse_kinematics(robot, T, tolerance=tolerance)
    assert isinstance(answer, SolutionBatch)
    return answer


def alone(robot: Robot, T: Floats, tolerance: float = 1e-9) -> SolutionSet:
    answer = inverse_kinematics(robot, T, tolerance=tolerance)
    assert isinstance(answer, SolutionSet)
    return answer


def turned(a: Floats, b: Floats, turning: np.ndarray) -> Floats:
    """(k,) largest difference of joint vectors up to whole turns."""
    d = a - b
    return np.abs(np.where(turning, d - 2 * np.pi * np.round(d / (2 * np.pi)), d)).max(axis=-1)


def kinds(robot: Robot, seed: int, count: int = 6) -> Floats:
    """(k, 4, 4) poses: regular, beside every singular configuration, out of reach, beyond the limits."""
    rng = np.random.default_rng(seed)
    low, high = (np.clip(x, -np.pi, np.pi) for x in (robot.limits.lower, robot.limits.upper))
    q = rng.uniform(low, high, (count * (2 * len(BENDS) + 2), robot.n))
    for k, bend in enumerate(BENDS):
        q[2 * k * count : (2 * k + 1) * count, min(4, robot.n - 1)] = bend
        q[(2 * k + 1) * count : (2 * k + 2) * count, min(2, robot.n - 1)] = bend
    q[-count:] += rng.uniform(-2.0, 2.0, (count, robot.n))
    T = robot.forward_kinematics(q)
    far = T[-count:].copy()
    far[:, :3, 3] *= rng.uniform(1.5, 4.0, (count, 1))
    return np.concatenate([T, far])


def same(robot: Robot, batch: SolutionBatch, i: int, one: SolutionSet) -> None:
    """The rows of a pose in a batch are the solutions that it has alone, with their masks and names."""
    rows = np.flatnonzero(batch.valid[i])
    asked = setting(robot, None, "pose")
    moving = {family.solution for family in one.families}
    assert len(rows) == len(one), (i, len(rows), len(one))
    for row in rows:
        apart = turned(one.q, batch.q[i, row], asked.revolute)
        k = int(apart.argmin())
        assert apart[k] <= 1e-9
        assert bool(one.within[k]) == bool(batch.within[i, row])
        assert int(one.codes[k]) == int(batch.codes[i, row])
        assert (int(one.free[k]) != 0 or k in moving) == (int(batch.free[i, row]) != 0)
    assert batch.status[i] is one.status


@pytest.mark.capability("07-23")
@pytest.mark.parametrize("name", SIX)
def test_many_poses_are_answered_as_each_alone(name: str) -> None:
    robot = arm(name)
    T = kinds(robot, 3)
    batch = together(robot, T)
    for i, X in enumerate(T):
        same(robot, batch, i, alone(robot, X))


@pytest.mark.parametrize("name", OTHERS)
def test_other_arms_too(name: str) -> None:
    robot = arm(name)
    T = kinds(robot, 4, 1)
    batch = together(robot, T)
    for i, X in enumerate(T):
        same(robot, batch, i, alone(robot, X))


@given(
    seed=st.integers(0, 2**31), name=st.sampled_from(SIX), bend=st.sampled_from(BENDS), joint=st.sampled_from((2, 4))
)
@settings(max_examples=40, deadline=None)
def test_the_posture_that_made_the_pose_is_found_beside_every_fold(
    seed: int, name: str, bend: float, joint: int
) -> None:
    robot = arm(name)
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1.5, 1.5, (4, robot.n))
    q[:, joint] = bend
    T = robot.forward_kinematics(q)
    batch = together(robot, T)
    reached = robot.forward_kinematics(batch.q[batch.valid])
    owner = np.nonzero(batch.valid)[0]
    assert batch.valid.any(axis=1).all()
    assert np.abs(reached - T[owner]).max() <= 2e-9
    for i in range(len(T)):
        if not (batch.free[i] > 0).any():
            apart = turned(batch.q[i][batch.valid[i]], q[i], setting(robot, None, "pose").revolute)
            # Merged roots are known to the square root of the rounding, times what the arm makes of it.
            assert apart.min() <= 1e-5


def decided_by_rule(asked: Setting, details: CandidateTable, tolerance: float) -> np.ndarray:
    """(k,) whether a pose needs refinement or merging, by the rule that the kernel's decision sharpens."""
    good = details.residual <= tolerance
    free = details.free > 0
    odd = (details.residual <= max(asked.candidate, tolerance)) & (details.residual > CLEAR)
    odd |= good & (free | (details.margin <= MERGED))
    odd |= (np.fmin(details.residual, details.subproblem_residual) <= LOOSE) & ~good.any(axis=1, keepdims=True)
    odd |= asked.near_folds(details)
    lost = ~(good & (details.excess <= INSIDE)).any(axis=1) & free.any(axis=1)
    return np.asarray(odd.any(axis=1) | lost)


@pytest.mark.parametrize("name", SIX)
def test_decisions_keep_to_the_rule_in_numpy(name: str) -> None:
    robot = arm(name)
    asked = setting(robot, None, "pose")
    assert asked.kernel is not None
    T = np.concatenate([kinds(robot, 5), robot.forward_kinematics(np.random.default_rng(5).uniform(-3, 3, (500, 6)))])
    q, columns, decision = asked.kernel(T, asked.middle, asked.middle_turns, *asked.bounds, 1e-9)
    details, rule = CandidateTable.of(columns), decided_by_rule(asked, CandidateTable.of(columns), 1e-9)
    solved = details.residual <= 1e-9
    clear = decision > 0
    # A clear list is one that nothing speaks against; what the rule finds odd beside is a row that falls short.
    short = (details.subproblem_residual >= 0.1 * details.residual) & (details.residual > 1e-9)
    doubtful = rule & clear
    between = (details.residual > CLEAR) & ~short & (details.residual <= asked.candidate)
    assert not between[doubtful].any()
    assert (decision[~rule & solved.any(axis=1)] >= Decision.REPEATED).all()
    assert (decision[~rule & ~solved.any(axis=1)] == Decision.NONE).all()
    bits = (solved * 2.0 ** np.arange(solved.shape[1])).sum(axis=1)
    np.testing.assert_array_equal(decision[clear], bits[clear])
    # Where rows are short of a solution by more than rounding, refinement finds none either.
    for i in np.flatnonzero(doubtful)[:20]:
        assert len(inverse_kinematics(robot, T[i])) == solved[i].sum()
    kept = solved[clear]
    unique_rows(q[clear], kept, asked.revolute)
    assert kept.sum() == solved[clear].sum()


def test_rows_that_repeat_earlier_ones_are_left_out_as_one_by_one() -> None:
    rng = np.random.default_rng(0)
    turning = np.array([True, False, True])
    q = rng.integers(0, 2, (300, 6, 3)) + 2 * np.pi * turning * rng.integers(-1, 2, (300, 6, 3))
    good = rng.random((300, 6)) < 0.7
    kept = good.copy()
    unique_rows(q, kept, turning)
    for i in range(len(q)):
        rows = np.flatnonzero(good[i])
        np.testing.assert_array_equal(np.flatnonzero(kept[i]), rows[distinct(q[i, rows], turning)])


def test_reading_in_any_order_changes_nothing() -> None:
    robot = arm("ur5e")
    T = kinds(robot, 6)
    names = ("q", "valid", "within", "residual", "codes", "free", "status_codes")
    forwards, backwards = together(robot, T), together(robot, T)
    first = {name: np.array(getattr(forwards, name)) for name in names}
    for name in reversed(names):
        np.testing.assert_array_equal(np.array(getattr(backwards, name)), first[name])
    many = together(robot, np.tile(T, (4, 1, 1)))
    assert len(T) * 4 > 256 >= len(T)
    for name in names:
        np.testing.assert_array_equal(np.array(getattr(many, name))[: len(T)], first[name])


def test_a_pose_changed_afterwards_does_not_change_its_answer() -> None:
    robot = arm("puma560")
    for X in kinds(robot, 7, 2):
        mine = X.copy()
        answer, known = alone(robot, mine), alone(robot, X)
        mine[:] = np.eye(4)
        np.testing.assert_array_equal(answer.q, known.q)
        assert answer.status is known.status
        assert answer.explain() == known.explain()


@pytest.mark.parametrize("name", SIX)
def test_the_tolerance_decides_as_well(name: str) -> None:
    """Rows between an exact solution and a looser tolerance are found alike alone and together; so are tight ones."""
    robot = arm(name)
    T = kinds(robot, 8, 2)
    for tolerance in (1e-12, 1e-7):
        batch = together(robot, T, tolerance)
        assert (batch.residual[batch.valid] <= tolerance).all()
        for i, X in enumerate(T):
            assert int(batch.count[i]) == len(alone(robot, X, tolerance))


def test_matrices_that_are_no_poses() -> None:
    robot = arm("ur5e")
    good = robot.forward_kinematics(np.full((1, 6), 0.4))
    bad = np.stack([good[0] * np.nan, np.diag([1.0, 1.0, -1.0, 1.0]), 2 * good[0], good[0]])
    bad[3, 0, 3] = 1e101
    batch = together(robot, np.concatenate([good, bad]))
    assert [status is IKStatus.NOT_A_POSE for status in batch.status] == [False, True, True, True, True]
    assert batch.valid.any(axis=1).tolist() == [True, False, False, False, False]
    for X in bad:
        with pytest.raises(InputError):
            inverse_kinematics(robot, X)


def test_beyond_the_limits_whatever_the_wrist_does_is_proven() -> None:
    """Joints that stand while a straight wrist turns are beyond their limits: that is a no, not a search."""
    robot = arm("puma560")
    q = np.random.default_rng(1).uniform(-np.pi, np.pi, (200, 6))
    q[:, 4] = 0.0
    batch = together(robot, robot.forward_kinematics(q))
    beyond = np.flatnonzero([status is IKStatus.BEYOND_LIMITS for status in batch.status])
    assert len(beyond) > 20
    free = np.flatnonzero((batch.free[beyond] > 0).any(axis=1))
    assert len(free) > 20
    low, high = robot.limits.lower, robot.limits.upper
    for i in beyond:
        rows = batch.q[i][batch.valid[i]][:, [0, 1, 2, 4]]
        whole = batch.q[i][batch.valid[i]]
        out = ((rows < low[[0, 1, 2, 4]] - 1e-12) | (rows > high[[0, 1, 2, 4]] + 1e-12)).any(axis=1)
        out |= (batch.free[i][batch.valid[i]] == 0) & ((whole < low - 1e-12) | (whole > high + 1e-12)).any(axis=1)
        assert out.all()


def test_decisions_are_the_same_numbers_in_both_layers() -> None:
    pytest.importorskip("casadi")
    from mafsil.mechanics.closed_form import decision

    for member in Decision:
        assert getattr(decision, member.name) == float(member)
    assert all(a > b for a, b in pairwise(Decision))


@pytest.mark.parametrize("name", ["puma560", "panda", "scara_rrrp"])
@pytest.mark.parametrize("mask", [(1, 1, 1, 1, 1, 1), (1, 1, 0, 1, 1, 1), (0, 0, 0, 1, 1, 1)])
def test_refining_takes_the_steps_of_the_pseudoinverse(name: str, mask: tuple[int, ...]) -> None:
    """Also beside singular configurations, with joints locked, and where a half turn is missing."""
    rng, robot, counting = np.random.default_rng(4), arm(name), np.array(mask, dtype=bool)
    goal = rng.uniform(-2.0, 2.0, (120, robot.n))
    goal[::3, min(4, robot.n - 1)] = 0.0
    start = goal + rng.normal(size=goal.shape) * 10.0 ** rng.uniform(-8, 0, (120, 1))
    start[:10, -1] += np.pi
    locked, T = rng.random(goal.shape) < 0.1, robot.forward_kinematics(goal)
    q, residual = refine_rows(robot, start, T, counting, locked=locked)
    expected = start.copy()
    size = residuals(pose_errors(robot, expected, T, counting))
    for _ in range(8):
        J = robot.jacobian_body(expected) * counting[:, None] * ~locked[:, None]
        step = (np.linalg.pinv(J, rcond=SINGULAR) @ pose_errors(robot, expected, T, counting)[:, :, None])[:, :, 0]
        trial = expected + step * np.minimum(1.0, 0.5 / np.maximum(np.abs(step).max(axis=1), 1e-300))[:, None]
        left = residuals(pose_errors(robot, trial, T, counting))
        better = (left < size) & (size > NO_BETTER)
        expected[better], size[better] = trial[better], left[better]
    reached = size < 1e-9
    assert ((residual < 1e-9) == reached).all()
    np.testing.assert_allclose(q[reached], expected[reached], atol=1e-6)
    # Rounding over the least singular value that counts: EPS/SINGULAR.
    np.testing.assert_allclose(residual[~reached], size[~reached], atol=2e-9)
    assert (q[locked] == start[locked]).all()


@pytest.mark.parametrize("name", SIX)
def test_preferred_values_change_windings_alone_where_nothing_is_free(name: str) -> None:
    robot, rng = arm(name), np.random.default_rng(8)
    turning = setting(robot, None, "pose").revolute
    for q0 in rng.uniform(-2.0, 2.0, (20, robot.n)):
        T = robot.forward_kinematics(q0)
        near, plain = inverse_kinematics(robot, T, q0=q0), alone(robot, T)
        assert (len(near), near.status, near.complete) == (len(plain), plain.status, plain.complete)
        assert turned(near.q, plain.q, turning).max() < 1e-12
        listed = inverse_kinematics(robot, T, q0=list(q0))
        np.testing.assert_array_equal(near.q, listed.q)
    with pytest.raises(InputError, match="q0"):
        inverse_kinematics(robot, T, q0=np.full(robot.n, np.nan))
    with pytest.raises(InputError, match="q0"):
        inverse_kinematics(robot, T, q0=np.zeros(robot.n + 1))


@pytest.mark.parametrize("name", ["puma560", "ur5e"])
def test_a_wrist_that_is_hardly_bent_beyond_the_limits_needs_no_search(name: str) -> None:
    """Joints that stand while the wrist turns are beyond their limits in every solution: that is proven, and soon."""
    robot, rng = arm(name), np.random.default_rng(9)
    first, *rest = robot.mechanism.joints
    tight = replace(first, limits=replace(first.limits, lower=-0.2, upper=0.2))
    narrow = Robot(replace(robot.mechanism, joints=(tight, *rest)))
    q = rng.uniform(-1.0, 1.0, (60, robot.n))
    q[:, 0], q[:, 4] = rng.uniform(0.5, 1.0, 60), 10.0 ** rng.uniform(-11.0, -9.0, 60)
    T = robot.forward_kinematics(q)
    together(narrow, T)
    batch = within(0.5, lambda: together(narrow, T))
    assert {status.name for status in batch.status} <= {"BEYOND_LIMITS", "CONTINUUM", "SOLVED"}
    beyond = np.flatnonzero(~batch.solved)
    assert len(beyond) > 20
    for i in beyond[:10]:
        one = alone(narrow, T[i])
        assert one.status is IKStatus.BEYOND_LIMITS
        assert not one.within.any()


def test_the_number_of_threads_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Many chunks, in which poses need care, handed to one thread or to three."""
    robot, rng = arm("ur5e"), np.random.default_rng(10)
    q = rng.uniform(-3.0, 3.0, (5000, robot.n))
    q[::50, 4], q[::70, 4] = 0.0, 1e-10
    T = robot.forward_kinematics(q)
    T[::90, :3, 3] *= 4.0
    found: list[SolutionBatch] = []
    for threads in ("1", "3"):
        monkeypatch.setenv("MAFSIL_THREADS", threads)
        found.append(together(robot, T))
    for name in ("q", "valid", "within", "codes", "free", "status_codes"):
        np.testing.assert_array_equal(getattr(found[0], name), getattr(found[1], name))
