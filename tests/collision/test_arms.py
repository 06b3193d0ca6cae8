"""Several arms in one scene: verdicts and distances are coal's, each arm alone is what it was, motions are proved."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.collision import ArmMount, Box, Checker, MultiArmCell, Obstacle, Scene, Sphere
from mafsil.collision.checker import PathStatus
from mafsil.errors import InputError, ModelError
from mafsil.model.placement import rotation_z
from tests.collision.arms import arm, scene
from tests.collision.peer import CoalChecker

TURNED = rotation_z(2.5)
TURNED[:3, 3] = (0.75, 0.1, 0.05)
FACING = rotation_z(np.pi)
FACING[0, 3] = 1.2
TABLE = Scene([Obstacle(Box((2.0, 2.0, 0.1)), (0.0, 0.0, -0.15), "table"), Obstacle(Sphere(0.15), (0.4, 0.6, 0.3))])


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return arm(tmp_path_factory.mktemp("arm"))


@pytest.fixture(scope="module")
def pair(robot):
    return MultiArmCell([ArmMount("left", robot), ArmMount("right", robot, TURNED)], TABLE)


@pytest.mark.capability("11-45")
def test_verdicts_and_distances_of_two_arms_are_those_of_coal(pair):
    peer, q = CoalChecker(pair), pair.random_configurations(300)
    coals, found, hit = np.array([peer.distance(each) for each in q]), pair.distance(q), pair.in_collision(q)
    assert 0.1 < hit.mean() < 0.95
    assert (hit == (coals <= 0.0)).all()
    apart = coals > 0.0
    np.testing.assert_allclose(found.distance[apart], coals[apart], atol=3e-6)


@pytest.mark.capability("11-45")
def test_arm_against_arm_alone_is_coal(robot):
    """Nothing but the other arm: every nearest pair is one body of each."""
    both = MultiArmCell(
        [ArmMount(name, robot, T, self_collision=False) for name, T in (("left", None), ("right", TURNED))]
    )
    assert len(both.arm.pairs) == len(both.between.pairs) == 49
    peer, q = CoalChecker(both), both.random_configurations(300)
    coals, found = np.array([peer.distance(each) for each in q]), both.distance(q)
    apart = coals > 0.0
    assert 0.1 < apart.mean() < 0.99
    assert (both.free(q) == apart).all()
    np.testing.assert_allclose(found.distance[apart], coals[apart], atol=3e-6)
    assert all({both.arm_of(each.first), both.arm_of(each.second)} == {"left", "right"} for each in found)


@pytest.mark.capability("11-45")
@given(seed=st.integers(0, 2**31))
@settings(max_examples=15, deadline=None)
def test_all_arms_are_each_arm_alone_and_the_arms_among_each_other(pair, seed):
    """The distance of all is the least of those of each arm alone and of bodies of different arms."""
    q = np.random.default_rng(seed).uniform(-2.8, 2.8, (40, 12))
    alone = [pair.alone(name).distance(part).distance for name, part in pair.split(q).items()]
    found, least = pair.distance(q), np.min(alone, axis=0)
    assert (found.distance <= least + 1e-8).all()
    for row, contact, single in zip(q, found, least, strict=True):
        names = {pair.arm_of(contact.first), pair.arm_of(contact.second)}
        if len(names - {""}) == 1:
            assert abs(contact.distance - single) < 1e-8
        assert bool(pair.free(row)) == (contact.distance > 0.0)


@pytest.mark.capability("11-45")
def test_an_arm_may_keep_less_from_itself_than_from_the_other_arm(pair):
    """Free is what keeps 60 mm from the scene and the other arm, and 1 mm from itself; so do verdicts and proofs."""
    cell = pair.with_clearance(0.06, own=0.001)
    q = cell.random_configurations(400)
    wanted = pair.met_by_each_other(pair.names).distance(q).distance > 0.06
    for name, rows in pair.split(q).items():
        alone = pair.alone(name)
        itself, around = alone.with_scene([]), Checker(alone.robot, alone.scene, self_collision=False)
        wanted &= (itself.distance(rows).distance > 0.001) & (around.distance(rows).distance > 0.06)
        assert cell.alone(name).self_clearance == 0.001
    assert 0.02 < wanted.mean() < 0.98
    assert (cell.free(q) == wanted).all()
    assert (cell.with_clearance(0.06, own=0.06).free(q) != wanted).any()
    assert [bool(cell.check(row)) for row in q[:40]] == wanted[:40].tolist()
    there = q[:60] + np.random.default_rng(1).normal(size=(60, 12)) * 0.05
    proved = cell.free_segment(q[:60], there)
    dense = np.linspace(q[:60], there, 30).reshape(-1, 12)
    assert (cell.free(dense).reshape(30, 60).all(axis=0) == proved).all()
    assert (
        MultiArmCell([ArmMount("one", pair.robots["left"])], clearance=0.02, self_clearance=0.0)
        .alone("one")
        .self_clearance
        == 0.0
    )


@pytest.mark.capability("11-45")
def test_gradients_are_those_of_differences(pair):
    q = pair.random_configurations(150)
    found, step = pair.distance(q), 1e-6
    up, down = (np.repeat(q[:, None], 12, axis=1) + sign * step * np.eye(12) for sign in (1.0, -1.0))
    numbers = (pair.distance(up).distance - pair.distance(down).distance) / (2 * step)
    off = np.abs(found.gradient - numbers).max(axis=1)[found.distance > 0.01]
    assert np.quantile(off, 0.9) < 1e-5


@pytest.mark.capability("11-45")
def test_motions_of_both_arms_are_proved(pair):
    """What is proved free is free in dense samples; two arms that pass through each other in between are not."""
    q = pair.random_configurations(3000)
    q = q[pair.free(q)][:100]
    rng = np.random.default_rng(3)
    a, b = q[:-1], q[:-1] + (q[1:] - q[:-1]) * rng.uniform(0.02, 0.6, (len(q) - 1, 1))
    free = pair.free_segment(a, b)
    assert 0.1 < free.mean() < 0.98
    for start, end, proved in zip(a, b, free, strict=True):
        states = start + np.linspace(0.0, 1.0, 400)[:, None] * (end - start)
        if proved:
            assert pair.free(states).all()
        else:
            assert pair.distance(pair.check_path(start, end).q).distance <= 2e-6


@pytest.mark.capability("11-45")
def test_arms_that_swing_through_each_other_are_caught_and_named(robot):
    """Both sweep the space between them; start and end are free."""
    both = MultiArmCell([ArmMount("left", robot), ArmMount("right", robot, FACING)])
    turns = np.array([0.0, 1.2, 0.3, 0.0, 0.0, 0.0]) + np.array([[-0.9], [0.9]]) * np.eye(6)[0]
    a, b = both.join({"left": turns, "right": turns})
    assert both.free(np.stack([a, b])).all()
    assert not both.free_segment(a, b)
    answer = both.check_path(a, b)
    assert answer.status is PathStatus.COLLIDING
    names = {both.arm_of(answer.contacts[0].first), both.arm_of(answer.contacts[0].second)}
    assert names == {"left", "right"}
    assert "left/" in answer.explain("en")
    assert "right/" in answer.explain("ar")


@pytest.mark.capability("11-45")
def test_bodies_stand_where_each_arm_puts_them(pair, robot):
    q = pair.random_configurations(20)
    poses = pair.robot.link_poses(q)
    names = pair.robot.mechanism.link_names
    for name, part in pair.split(q).items():
        T = np.eye(4) if name == "left" else TURNED
        for k, link in enumerate(robot.mechanism.link_names):
            np.testing.assert_allclose(
                poses[:, names.index(f"{name}/{link}")], T @ robot.link_poses(part)[:, k], atol=1e-12
            )
    np.testing.assert_array_equal(pair.join(pair.split(q)), q)


@pytest.mark.capability("11-45")
def test_three_different_arms_margins_and_scenes(robot):
    """Mimic joints and hands come along; another scene changes nothing of the arms."""
    others = [("b", "panda", (0.0, 1.0, 0.0)), ("c", "ur5", (-0.9, 0.0, 0.0))]
    mounted = [ArmMount(name, model, place, radius=0.05) for name, model, place in others]
    cell = MultiArmCell([ArmMount("a", robot), *mounted], scene(2), clearance=0.01)
    assert cell.robot.n == sum(each.n for each in cell.robots.values())
    q = cell.random_configurations(200)
    assert (cell.in_collision(q) == ~cell.distance(q).free).all()
    empty = cell.with_scene(())
    assert isinstance(empty, MultiArmCell)
    assert (empty.distance(q).distance >= cell.distance(q).distance - 1e-9).all()
    assert cell.alone("b").clearance == 0.01
    assert empty.alone("b").scene is empty.scene


@pytest.mark.capability("11-45")
def test_bases_that_stand_in_each_other_are_said(robot):
    both = MultiArmCell([ArmMount("left", robot), ArmMount("right", robot, (0.05, 0.0, 0.0))])
    found = both.check(np.zeros(12))
    assert any({c.first, c.second} == {"left/link0", "right/link0"} for c in found.contacts)
    assert not both.free(both.random_configurations(50)).any()


def test_what_is_refused(pair, robot):
    with pytest.raises(InputError, match="each with its own name"):
        MultiArmCell([ArmMount("a", robot), ArmMount("a", robot)])
    with pytest.raises(InputError, match="each with its own name"):
        MultiArmCell([])
    with pytest.raises(InputError, match="there is no arm 'up'"):
        pair.join({"left": np.zeros(6), "right": np.zeros(6), "up": np.zeros(6)})
    with pytest.raises(InputError, match="'right' are missing"):
        pair.join({"left": np.zeros(6)})
    with pytest.raises(InputError, match="there is no arm"):
        pair.alone("middle")
    with pytest.raises(InputError, match="right"):
        pair.join({"left": np.zeros(6), "right": [np.nan] * 6})
    with pytest.raises(ModelError, match="T_sb: not a pose"):
        MultiArmCell([ArmMount("a", robot, np.ones((4, 4)))])


@pytest.mark.capability("11-45")
@pytest.mark.parametrize("kept", [("right",), ("left",), ("right", "left")])
def test_motions_of_some_of_the_arms_are_proved_with_their_own_pairs(robot, kept):
    """What is laid out for pairs of bodies is laid out again where the pairs are others."""
    both = MultiArmCell([ArmMount("left", robot), ArmMount("right", robot, TURNED)]).with_passive([])
    both.free_segment(*both.random_configurations(2))
    some = both.among(kept)
    world = some.world()
    both_moved = world.motion.moves[:, world.arm.pairs[:, 0]] & world.motion.moves[:, world.arm.pairs[:, 1]]
    last = [max(np.flatnonzero(column), default=-1) for column in both_moved.T]
    assert world.motion.common.tolist() == last
    q = some.random_configurations(120).reshape(60, 2, -1)
    proved = some.free_segment(q[:, 0], q[:, 1])
    along = q[:, :1] + np.linspace(0.0, 1.0, 400)[:, None] * (q[:, 1:] - q[:, :1])
    dense = some.free(along).all(axis=1)
    assert 0.05 < dense.mean() < 0.95
    assert not (proved & ~dense).any()
    assert (proved == dense).mean() > 0.95
