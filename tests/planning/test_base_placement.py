"""Base placement: what is found reaches and is free, what is missed is missed for the reason that is said."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.collision import ArmMount, Box, Checker, MovableArm, MultiArmCell, Obstacle, Scene
from mafsil.errors import InputError, MafsilError
from mafsil.figures import plot_placement
from mafsil.geometry import rotation
from mafsil.planning import PlacementFailure, base_placement
from mafsil.planning.base_placement import base_poses
from mafsil.planning.placement_answer import PlacementStatus
from tests.collision.arms import arm, scene
from tests.sizes import size

POST = Obstacle(Box((0.1, 0.1, 0.6)), (0.2, 0.1, 0.3), "post")
TABLE = Scene([Obstacle(Box((1.6, 0.8, 0.05)), (0.0, 0.0, -0.03), "table"), POST])
TARGETS = np.tile(np.eye(4), (4, 1, 1))
TARGETS[:, :3, :3] = rotation.from_rpy(np.array([np.pi, 0, 0]))
TARGETS[:, :3, 3] = [[-0.3, -0.2, 0.2], [0.3, -0.2, 0.2], [-0.3, 0.2, 0.2], [0.35, 0.2, 0.2]]
REGION = ((-0.8, 0.8), (-0.4, 0.4))


@pytest.fixture(scope="module")
def ur5():
    return Checker("ur5", radius=0.04, clearance=0.005)


@pytest.fixture(scope="module")
def found(ur5):
    return mf.optimal_base_placement(ur5, TARGETS, scene=TABLE, region=REGION, stands_on=["table"])


def test_the_best_base_reaches_every_target_free_and_within_limits(found, ur5):
    assert found.status is PlacementStatus.FOUND
    robot = mf.load("ur5")
    reached = found.T_sb @ np.linalg.inv(robot.mechanism.T_sb) @ robot.forward_kinematics(found.configurations)
    np.testing.assert_allclose(reached, TARGETS, atol=1e-8)
    limits = robot.limits
    assert ((found.configurations >= limits.lower) & (found.configurations <= limits.upper)).all()
    there = MultiArmCell([ArmMount("arm", "ur5", found.T_sb, radius=0.04)], TABLE, clearance=0.005)
    assert there.free(found.configurations).all(), "the same arm mounted there, by the ordinary checker"
    shares = found.quality[found.best]
    distance = there.distance(found.configurations).distance
    np.testing.assert_allclose(shares[:, 2], np.clip((distance - 0.005) / 0.1, 0, 1), atol=1e-7)
    assert found.score[found.best] == pytest.approx(shares.min())
    assert found.score[found.best] == found.score.max()


def test_verdicts_of_all_bases_are_those_of_each_pose_solved_alone(found, ur5):
    """For some bases every target by its own call and the arm mounted there."""
    rng = np.random.default_rng(3)
    reached = found.reached
    for k in rng.choice(found.grid, size(4, 8), replace=False):
        T = base_poses(found.bases[k])
        there = MultiArmCell([ArmMount("arm", "ur5", T, radius=0.04)], TABLE, clearance=0.005)
        base_free = found.misses[k, 0] != PlacementFailure.BASE
        for j, target in enumerate(TARGETS):
            answer = mf.inverse_kinematics(there.robots["arm"], target)
            rows = np.asarray(answer.q)[np.asarray(answer.within, dtype=bool)]
            free = base_free and len(rows) > 0 and bool(there.free(rows).any())
            assert reached[k, j] == free
            if base_free and not free:
                assert (found.misses[k, j] == PlacementFailure.COLLISION) == (len(rows) > 0)


def test_the_base_stands_in_nothing(tmp_path):
    """A base is refused exactly where its shapes meet what it does not stand on."""
    checker = Checker(arm(tmp_path))
    movable = MovableArm(checker, TABLE)
    rng = np.random.default_rng(1)
    bases = np.column_stack([rng.uniform(-1, 1, (200, 2)), rng.uniform(-0.2, 0.3, 200), rng.uniform(-3, 3, 200)])
    free, touching = movable.base_is_free(bases, ["table"]), movable.base_is_free(bases)
    assert 0.5 < free.mean() < 1.0
    assert (free | ~touching).all()
    column = movable.bodies[0].shapes[0]
    for base, verdict in zip(bases[:60], touching[:60], strict=True):
        T = base_poses(base)
        gaps = [mf.collision.distance(Obstacle(column[0], T @ column[1]), each).distance for each in TABLE]
        if not verdict:
            assert min(gaps) <= 0.0 or not movable.free(movable.join(base, np.zeros(6)))
        else:
            assert min(gaps) > 0.0
    with pytest.raises(InputError, match="no obstacle 'desk'"):
        movable.base_is_free(bases, ["desk"])


@pytest.mark.capability("11-39")
def test_a_movable_arm_is_the_arm_mounted_there(tmp_path):
    robot = arm(tmp_path)
    around = scene(4)
    movable = MovableArm(Checker(robot), around)
    rng = np.random.default_rng(2)
    for _ in range(5):
        base = np.array([*rng.uniform(-0.4, 0.4, 3), rng.uniform(-3, 3)])
        there = MultiArmCell([ArmMount("arm", robot, base_poses(base))], around)
        q = rng.uniform(-2.5, 2.5, (50, 6))
        full = movable.join(base, q)
        assert (movable.free(full) == there.free(q)).all()
        np.testing.assert_allclose(movable.distance(full).distance, there.distance(q).distance, atol=1e-9)


def test_what_is_missed_is_named(ur5):
    far = mf.optimal_base_placement(ur5, TARGETS, scene=TABLE, region=((1.1, 1.3), (-0.1, 0.1)), stands_on=["table"])
    assert far.status is PlacementStatus.NOT_FOUND
    assert "target 0 is not reached: 1." in far.explain("en")
    assert far.explain("ar") != far.explain("en")
    inside = TARGETS.copy()
    inside[0, :3, 3] = [0.2, 0.1, 0.3]
    blocked = mf.optimal_base_placement(ur5, inside, scene=TABLE, region=REGION, stands_on=["table"], spacing=0.2)
    assert not blocked
    assert not blocked.reached[:, 0].any()
    assert blocked.misses[blocked.best, 0] == PlacementFailure.COLLISION
    assert "post" in blocked.explain("en")
    assert blocked.reached[blocked.best, 1:].sum() == blocked.reached.sum(axis=1).max()
    nowhere = mf.optimal_base_placement(
        ur5, TARGETS, scene=TABLE, region=((0.2, 0.2), (0.1, 0.1)), stands_on=["table"], refinements=0
    )
    assert (nowhere.misses == PlacementFailure.BASE).all()
    assert "base would be in collision" in nowhere.explain("en")


def test_refinement_never_loses_and_redundant_arms_take_samples(ur5, found):
    coarse = mf.optimal_base_placement(ur5, TARGETS, scene=TABLE, region=REGION, stands_on=["table"], refinements=0)
    assert found.score.max() >= coarse.score.max()
    grid = {"region": ((-0.4, 0.4), (0.3, 0.5)), "spacing": 0.2, "yaws": 2, "refinements": 0}
    few, many = (mf.optimal_base_placement("panda", TARGETS[:2], samples=k, **grid) for k in (1, 4))
    assert (many.reached | ~few.reached).all()
    gained = many.quality.min(axis=2) - few.quality.min(axis=2)
    assert gained.min() >= 0.0
    assert gained.max() > 0.0


def test_pictures_and_plain_data(found, tmp_path):
    for ending in ("png", "svg"):
        plot_placement(found, tmp_path / f"map.{ending}", scene=TABLE, language="en")
        assert (tmp_path / f"map.{ending}").stat().st_size > 5000
    x, y, share, score = found.score_map()
    assert share.shape == score.shape == (len(x), len(y))
    assert share.max() == 1.0
    plain = found.to_dict()
    assert plain["status"] == "found"
    assert plain["targets"] == ["none"] * 4


def test_what_is_refused(ur5):
    for words, wrong in (
        ("targets", {"targets": np.eye(3)}),
        ("targets", {"targets": np.zeros((0, 4, 4))}),
        ("region", {"region": ((1.0, 0.0), (0.0, 1.0))}),
        ("spacing", {"spacing": 0.0}),
        ("base poses", {"spacing": 1e-4}),
        ("heights", {"heights": [np.nan]}),
        ("no obstacle", {"stands_on": ["desk"]}),
        ("no obstacle 'desk'", {"stands_on": "desk"}),
        ("region: expected shape", {"region": 5.0}),
    ):
        with pytest.raises(InputError, match=words):
            mf.optimal_base_placement(ur5, **{"targets": TARGETS, "scene": TABLE, **wrong})
    with pytest.raises(MafsilError, match=r"targets\[0\]: not a pose"):
        mf.optimal_base_placement(ur5, 2.0 * np.asarray(TARGETS), scene=TABLE)


@pytest.mark.parametrize("when", [0, 3, 10_000])
def test_what_was_looked_at_is_kept_at_an_interruption(found, ur5, monkeypatch, when):
    """In the first part of the grid, in a later one, and while the grid is made finer."""
    solve, calls = base_placement._Search._solve, list[int]()

    def until(self, bases, *rest):
        calls.append(len(bases))
        if len(calls) > when or len(bases) < found.grid:
            raise KeyboardInterrupt
        solve(self, bases, *rest)

    monkeypatch.setattr(base_placement, "CHUNK", 300)
    monkeypatch.setattr(base_placement._Search, "_solve", until)
    if not when:
        with pytest.raises(KeyboardInterrupt):
            mf.optimal_base_placement(ur5, TARGETS, scene=TABLE, region=REGION, stands_on=["table"])
        return
    some = mf.optimal_base_placement(ur5, TARGETS, scene=TABLE, region=REGION, stands_on=["table"])
    assert some.interrupted
    assert "interrupted" in some.explain("en")
    count = len(some.bases)
    assert count == found.grid if when > 3 else 0 < count < found.grid
    np.testing.assert_array_equal(some.misses, found.misses[:count])
    np.testing.assert_array_equal(some.q, found.q[:count])
