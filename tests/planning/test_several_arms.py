"""Several arms: the coordination diagram with proved cells, planning in turn and together, deadlocks named."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from mafsil.collision import ArmMount, Box, MultiArmCell, Obstacle, Scene
from mafsil.errors import InputError
from mafsil.model.placement import rotation_z
from mafsil.planning import ArmPlan, coordinate_arms, plan_around_moving, plan_coupled, plan_prioritized, prioritized
from mafsil.planning.outcome import PlanningStatus
from mafsil.trajectory import MotionLimits
from tests.collision.arms import arm
from tests.collision.peer import CoalChecker

FACING = rotation_z(np.pi)
FACING[0, 3] = 1.4
OUT = np.array([0.0, 1.2, 0.3, 0.0, 0.0, 0.0])
TURN = np.eye(6)[0]
MET = OUT - 0.1 * TURN
SWEEP = OUT + np.array([[-0.9], [0.9]]) * TURN
BACK = np.array([-2.2, 0.2, 0.3, 0.0, 0.0, 0.0])
DIP = np.stack([BACK, OUT, BACK])
LIMITS = MotionLimits.of(12, velocity=2.0, acceleration=8.0)


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return arm(tmp_path_factory.mktemp("arm"))


@pytest.fixture(scope="module")
def cell(robot):
    table = Scene([Obstacle(Box((3.0, 2.0, 0.1)), (0.6, 0.0, -0.1), "table")])
    return MultiArmCell([ArmMount("left", robot), ArmMount("right", robot, FACING)], table)


def dense(at, duration, step=9e-4):
    """Configurations of a motion in time, no coordinate further apart than a step from one to the next."""
    t = np.linspace(0.0, duration, 400)
    way = np.abs(np.diff(at(t), axis=0)).max(axis=1)
    return at(
        np.concatenate([np.linspace(a, b, int(w / step) + 2) for (a, b), w in zip(pairwise(t), way, strict=True)])
    )


def largest_step(q):
    return np.abs(np.diff(q, axis=0)).max()


@pytest.mark.capability("11-45")
def test_a_built_deadlock_is_proved_and_named(cell):
    """Both sweep to the other's side: whoever goes first meets the other. Planned together they pass."""
    found = coordinate_arms(cell, {"left": SWEEP, "right": SWEEP})
    assert found.status is PlanningStatus.DEADLOCK
    assert [each.arm for each in found.waits] == ["left", "right"]
    for each in found.waits:
        assert 0.0 < each.share < 1.0
        assert {cell.arm_of(each.contact.first), cell.arm_of(each.contact.second)} == {"left", "right"}
        assert each.arm in found.explain("en")
        assert each.arm in found.explain("ar")
    shares = np.linspace(0.0, 1.0, 41)
    rows = SWEEP[0] + shares[:, None] * (SWEEP[1] - SWEEP[0])
    free = cell.free(cell.join({"left": rows[:, None], "right": rows[None]}))
    reached = np.zeros_like(free)
    for i, j in np.ndindex(free.shape):
        before = i == j == 0 or any(
            reached[a, b] for a, b in ((i - 1, j), (i, j - 1), (i - 1, j - 1)) if min(a, b) >= 0
        )
        reached[i, j] = free[i, j] and before
    assert not reached[-1, -1]
    ends = [{"left": row, "right": row} for row in SWEEP]
    assert plan_coupled(cell, *ends, seed=1)
    assert plan_prioritized(cell, *ends, LIMITS, seed=1)


@pytest.mark.capability("11-45")
def test_cells_are_what_they_are_proved_to_be(cell):
    found = coordinate_arms(cell, {"left": SWEEP, "right": SWEEP}, cells=50)
    assert set(np.unique(found.diagram)) >= {0, 3}
    rng = np.random.default_rng(2)
    spans = [found.shares[0], found.shares[1]]
    for code, free in ((0, True), (3, False)):
        for i, j in rng.permutation(np.argwhere(found.diagram == code))[:80]:
            s, t = (rng.uniform(span[k], span[k + 1], 25) for span, k in zip(spans, (i, j), strict=True))
            left = SWEEP[0] + s[:, None] * (SWEEP[1] - SWEEP[0])
            right = SWEEP[0] + t[:, None] * (SWEEP[1] - SWEEP[0])
            assert (cell.free(cell.join({"left": left, "right": right})) == free).all()


@pytest.mark.capability("11-45", "11-46")
def test_one_arm_waits_for_the_other_on_given_paths(cell):
    """Each keeps to its own path, the whole is proved, and nothing collides at 0.001 rad while it runs."""
    found = coordinate_arms(cell, {"left": SWEEP, "right": DIP})
    assert found, found.explain("en")
    assert cell.check_path(found.path)
    assert (np.diff(found.places, axis=0) >= 0.0).all()
    np.testing.assert_array_equal(found.places[[0, -1]], [[0, 0], [1, 1]])
    assert np.abs(found.places[:, 0] - found.places[:, 1]).max() > 0.1, "somebody has to wait"
    motion = found.time_optimal(LIMITS)
    q = dense(lambda t: motion.trajectory.at(t).u, motion.duration)
    assert largest_step(q) <= 1e-3
    assert cell.free(q).all()
    left = cell.split(q)["left"]
    assert np.abs(left[:, 1:] - OUT[1:]).max() < 1e-9, "on a straight path nothing is rounded away"
    alone = [(np.abs(np.diff(rows, axis=0)) / 2.0).max(axis=1).sum() for rows in (SWEEP, DIP)]
    assert motion.duration > max(alone)


@pytest.mark.capability("11-45")
def test_what_stands_in_the_way_of_coordination_is_said(cell):
    walled = cell.with_scene([Obstacle(Box((0.1, 0.1, 2.0)), (0.3, 0.3, 0.5), "post")])
    blocked = coordinate_arms(walled, {"left": SWEEP, "right": DIP})
    assert blocked.status is PlanningStatus.PATH_BLOCKED
    assert "post" in blocked.reason
    assert "hits" in blocked.explain("en")
    assert "hits" not in blocked.explain("ar")
    ends = coordinate_arms(cell, {"left": np.stack([SWEEP[0], MET]), "right": np.stack([BACK, MET])})
    assert ends.status is PlanningStatus.GOAL_BLOCKED
    assert {cell.arm_of(ends.ends[0].contacts[0].first), cell.arm_of(ends.ends[0].contacts[0].second)} == {
        "left",
        "right",
    }
    still = coordinate_arms(cell, {"left": SWEEP, "right": BACK[None]})
    assert still
    np.testing.assert_array_equal(cell.split(still.path)["right"], np.repeat(BACK[None], len(still.path), axis=0))
    with pytest.raises(InputError, match="'right' are missing"):
        coordinate_arms(cell, {"left": SWEEP})
    with pytest.raises(InputError, match="no arm 'middle'"):
        coordinate_arms(cell, {"left": SWEEP, "right": DIP, "middle": DIP})
    with pytest.raises(InputError):
        coordinate_arms(cell, {"left": SWEEP[:, :5], "right": DIP})


@pytest.mark.capability("11-45")
@pytest.mark.parametrize("seed", [1, 2])
def test_planned_together_nothing_meets_and_coal_agrees(cell, seed):
    start, goal = ({"left": row, "right": row} for row in SWEEP)
    found = plan_coupled(cell, start, goal, seed=seed)
    assert found
    motion = found.time_optimal(LIMITS)
    q = dense(lambda t: motion.trajectory.at(t).u, motion.duration)
    assert largest_step(q) <= 1e-3
    assert cell.free(q).all()
    peer = CoalChecker(cell)
    assert min(peer.distance(row) for row in q[:: max(len(q) // 150, 1)]) > 0.0
    np.testing.assert_array_equal(found.path, plan_coupled(cell, start, goal, seed=seed).path)


@pytest.mark.capability("11-45")
def test_an_arm_that_only_stands_there_makes_way(cell):
    """Right stands where left has to pass and is to stand there again: its goal is not named."""
    there = MET
    start, goal = {"left": SWEEP[0], "right": there}, {"left": SWEEP[1]}
    assert not cell.free_segment(cell.join(start), cell.join({**start, **goal}))
    for found in (plan_coupled(cell, start, goal, seed=3), plan_prioritized(cell, start, goal, LIMITS, seed=3)):
        assert found, found.explain("en")
    q = dense(found.at, found.duration)
    assert cell.free(q).all()
    np.testing.assert_allclose(cell.split(q[-1])["right"], there, atol=1e-12)


@pytest.mark.capability("11-45", "11-46")
def test_in_turn_the_first_is_not_slowed_and_the_second_waits(cell):
    start, goal = {"left": SWEEP[0], "right": BACK}, {"left": SWEEP[1], "right": OUT + 0.5 * TURN}
    found = plan_prioritized(cell, start, goal, LIMITS, order=("left", "right"))
    assert found, found.explain("en")
    alone = plan_prioritized(cell.among(["left"]), start, goal, LIMITS, order=("left", "right"))
    assert found.motions["left"].duration == pytest.approx(alone.motions["left"].duration)
    assert found.motions["left"].waiting == 0.0
    q = dense(found.at, found.duration)
    assert largest_step(q) <= 1e-3
    assert cell.free(q).all()
    np.testing.assert_allclose(q[[0, -1]], [cell.join(start), cell.join(goal)], atol=1e-9)
    t = np.linspace(0.0, found.duration, 4000)
    velocity = np.diff(found.at(t), axis=0) / np.diff(t)[:, None]
    assert np.abs(velocity).max() <= 2.0 + 1e-6
    assert np.abs(np.diff(velocity, axis=0) / np.diff(t)[1:, None]).max() <= 8.0 * (1.0 + 1e-3)
    assert found.explain("en") != found.explain("ar")
    assert found.to_dict()["arms"]["right"]["duration"] == found.motions["right"].duration


@pytest.mark.capability("11-45")
def test_three_arms_in_turn(robot):
    """Around a common middle; each goes to its neighbour's side."""
    mounted = []
    for k in range(3):
        T = rotation_z(2.0 * np.pi * k / 3.0)
        T[:3, 3] = -0.75 * T[:3, 0]
        mounted.append(ArmMount(f"arm {k}", robot, T))
    cell = MultiArmCell(mounted)
    start, goal = ({name: OUT * [1, 0.6, 1, 1, 1, 1] + side * TURN for name in cell.names} for side in (-0.9, 0.9))
    limits = MotionLimits.of(18, velocity=2.0, acceleration=8.0)
    found = plan_prioritized(cell, start, goal, limits, seed=1, seconds=60.0)
    assert found, found.explain("en")
    assert cell.free(dense(found.at, found.duration)).all()


@pytest.mark.capability("11-45")
def test_what_cannot_be_planned_in_turn_is_named(cell):
    meeting = plan_prioritized(cell, {"left": SWEEP[0], "right": BACK}, {"left": MET, "right": MET}, LIMITS)
    assert meeting.status is PlanningStatus.GOAL_BLOCKED
    assert "left/" in meeting.explain("en")
    started = plan_prioritized(cell, {"left": MET, "right": MET}, {}, LIMITS)
    assert started.status is PlanningStatus.START_BLOCKED
    none = plan_prioritized(
        cell, {"left": SWEEP[0], "right": SWEEP[0]}, {"left": SWEEP[1], "right": SWEEP[1]}, LIMITS, seconds=1e-6
    )
    assert none.status is PlanningStatus.NOT_FOUND
    assert none.duration == np.inf
    assert "no path was found" in none.explain("en")
    assert "no path was found" not in none.explain("ar")
    ends = {"left": SWEEP[0], "right": BACK}
    with pytest.raises(InputError, match="must be finite"):
        plan_prioritized(cell, ends, {}, MotionLimits.of(12, velocity=1.0))
    with pytest.raises(InputError, match="not an order of the arms"):
        plan_prioritized(cell, ends, {}, LIMITS, order=("left", "left"))
    with pytest.raises(InputError, match="no arm 'up'"):
        plan_prioritized(cell, ends, {"up": BACK}, LIMITS)


@pytest.mark.capability("11-45")
def test_searches_that_find_nothing_count_against_the_time(cell, monkeypatch):
    """Two seconds each: of five seconds three are left after the first, which waits for the compiler and is free."""
    asked = []

    def nothing(checker, scene, start, goal, *, seconds, **more):
        asked.append(seconds)
        return ArmPlan(PlanningStatus.NOT_FOUND, start[None], "rrt_connect", 1, 0, 1, seconds)

    monkeypatch.setattr(prioritized, "plan", nothing)
    found = plan_prioritized(cell, {"left": SWEEP[0], "right": SWEEP[0]}, {"left": SWEEP[1]}, LIMITS, seconds=5.0)
    assert found.status is PlanningStatus.NOT_FOUND
    assert asked == [2.0, 2.0, 2.0, 1.0]


@pytest.mark.capability("11-45", "11-46")
def test_one_arm_past_settled_motions_and_arms_that_are_only_met(cell):
    """Left's motion is settled and runs through a block; only right has to keep clear of everything."""
    low = Scene([Obstacle(Box((0.2, 0.2, 0.3)), (0.6, 0.1, 0.35), "block")])
    alone = cell.with_scene(()).among(["left"])
    left = plan_prioritized(alone, {"left": SWEEP[0], "right": BACK}, {"left": SWEEP[1]}, LIMITS).motions["left"]
    met = cell.with_scene(low).with_passive(["left"])
    start = {"left": SWEEP[0], "right": BACK}
    assert met.free(met.join({"left": OUT, "right": BACK}))
    assert not cell.with_scene(low).free(met.join({"left": OUT, "right": BACK}))
    found = plan_around_moving(met, "right", start, BACK + 2.0 * TURN, LIMITS, {"left": left})
    assert found, found.explain("en")
    assert met.free(dense(found.at, found.duration)).all()
    assert found.motions["left"] is left
    begun = left.later(0.5)
    np.testing.assert_array_equal(begun.at([0.0, 0.2, 9.0]), left.at([0.5, 0.7, 9.0]))
    twice = left.then(found.motions["right"])
    assert twice.duration == pytest.approx(left.duration + found.motions["right"].duration)
    into = plan_around_moving(met, "right", start, np.array([-0.9, 1.2, 0.3, 0.0, 0.0, 0.0]), LIMITS, {})
    assert into


def test_an_arm_that_is_always_near_itself_has_its_turn(tmp_path):
    """Two of its bodies stay 1 mm apart: what the moments keep on top of the clearance is asked of other arms only."""
    limits = '<limit lower="-2.5" upper="2.5" effort="1" velocity="1"/>'
    balls = {"l0": [(0.0, 0.05)], "l1": [], "l2": [(0.0, 0.149), (0.4, 0.03)]}
    links = [
        f'<link name="{name}">'
        + "".join(
            f'<collision><origin xyz="{x} 0 0"/><geometry><sphere radius="{r}"/></geometry></collision>' for x, r in row
        )
        + "</link>"
        for name, row in balls.items()
    ]
    joints = [
        f'<joint name="j{k}" type="revolute"><parent link="l{k - 1}"/><child link="l{k}"/><origin xyz="{x} 0 0"/>'
        f'<axis xyz="0 0 1"/>{limits}</joint>'
        for k, x in ((1, 0.0), (2, 0.2))
    ]
    file = tmp_path / "near.urdf"
    file.write_text(f'<robot name="near">{"".join(links + joints)}</robot>')
    cell = MultiArmCell([ArmMount("left", file), ArmMount("right", file, (1.0, 0.0, 0.0))])
    start = {"left": [1.0, 0.3], "right": [-2.0, 0.3]}
    assert 0.0 < float(cell.distance(cell.join(start)).distance) < 0.003
    goal = {"left": [-1.0, 0.3], "right": [2.0, -0.3]}
    found = plan_prioritized(cell, start, goal, MotionLimits.of(4, velocity=2.0, acceleration=5.0))
    assert found, found.explain()
    assert cell.free(found.at(np.linspace(0.0, found.duration, 2000))).all()
