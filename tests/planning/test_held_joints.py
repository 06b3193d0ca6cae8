"""Which joints a plan moves, of robots with more of them than the question is about: arms, a head, wheels, fingers."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.collision import Box, Checker, Obstacle
from mafsil.planning.arm_limits import bounds_of, held_of, with_carriers

LIMITS = '<limit lower="-2.5" upper="2.5" effort="50" velocity="2"/>'
LEFT, RIGHT = (tuple(f"{side}{k}" for k in range(4)) for side in ("left", "right"))
WALL = [Obstacle(Box((0.6, 0.04, 0.5)), (0.6, 0.3, 1.2), "wall")]


def link(name, *balls):
    shapes = "".join(
        f'<collision><origin xyz="{x} 0 0"/><geometry><sphere radius="{r}"/></geometry></collision>' for x, r in balls
    )
    return f'<link name="{name}">{shapes}</link>'


def joint(name, parent, child, xyz, axis, kind="revolute", limits=LIMITS):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="{axis}"/>{limits}</joint>'
    )


def two_arms(folder, axes=("0 0 1", "0 1 0", "0 0 1", "0 1 0")):
    """A column that lifts two arms with two fingers each, and a head; the whole on wheels."""
    parts = [link("base", (0.0, 0.1)), link("torso", (0.0, 0.08)), link("head", (0.1, 0.05))]
    parts += [joint("lift", "base", "torso", "0 0 0.5", "0 0 1", "prismatic", LIMITS.replace("-2.5", "0"))]
    parts += [joint("pan", "torso", "head", "0 0 0.3", "0 0 1")]
    for side, y in (("left", 0.25), ("right", -0.25)):
        parts += [link(f"{side}_wheel", (0.0, 0.05))]
        parts += [joint(f"{side}_wheel", "base", f"{side}_wheel", f"0 {y} -0.2", "0 1 0", "continuous", "")]
        before, at = "torso", f"0 {y} 0.2"
        for k, axis in enumerate(axes):
            parts += [link(f"{side}_link{k}", (0.1, 0.04), (0.2, 0.04))]
            parts += [joint(f"{side}{k}", before, f"{side}_link{k}", at, axis)]
            before, at = f"{side}_link{k}", "0.27 0 0"
        for finger, off in (("a", 0.03), ("b", -0.03)):
            parts += [link(f"{side}_{finger}", (0.02, 0.01))]
            parts += [joint(f"{side}_{finger}", before, f"{side}_{finger}", f"0.27 {off} 0", "0 1 0", "prismatic")]
    file = folder / "two_arms.urdf"
    file.write_text(f'<robot name="two_arms">{"".join(parts)}</robot>')
    return mf.load(file, tip=f"right_link{len(axes) - 1}")


@pytest.fixture(scope="module")
def checker(tmp_path_factory):
    return Checker(two_arms(tmp_path_factory.mktemp("held")), WALL)


def names_of(checker):
    return [each.name for each in checker.robot.mechanism.coordinates]


def configuration(checker, **values):
    return np.array([values.get(name, 0.5 if name == "lift" else 0.0) for name in names_of(checker)])


def may_move(checker, *ends, moving=None):
    held = held_of(checker, np.stack(ends), moving)
    return {each.name for each, still in zip(checker.robot.mechanism.coordinates, held, strict=True) if not still}


@pytest.mark.capability("11-39", "11-45")
@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"left1": 1.0}, {*LEFT}),
        ({"right3": 1.0}, {*RIGHT}),
        ({"left0": 1.0, "right0": -1.0}, {*LEFT, *RIGHT}),
        ({"pan": 1.0}, {"pan"}),
        ({"lift": 1.0}, {"lift", *RIGHT}),
        ({"lift": 1.0, "left0": 1.0}, {"lift", *LEFT}),
        ({"left_wheel": 1.0}, {"left_wheel"}),
        ({"left_a": 0.02}, {"left_a"}),
        ({}, {"lift", *RIGHT}),
    ],
)
def test_a_limb_moves_and_the_rest_is_held(checker, changes, expected):
    a = configuration(checker)
    assert may_move(checker, a, configuration(checker, **changes)) == expected


@pytest.mark.capability("11-39")
def test_what_carries_a_limb_moves_where_nothing_is_found_without(tmp_path):
    """Arms of one hinge: the left one passes a post only when the column lifts it; a lower post does not move it."""
    checker = Checker(two_arms(tmp_path, ("0 0 1",)))
    a, b = (configuration(checker, left0=x, right0=-1.0) for x in (-0.5, 0.9))
    assert with_carriers(checker, np.stack([a, b])) == ("lift", "left0")
    assert with_carriers(checker, np.stack([a, configuration(checker, lift=0.6)])) is None
    for top, lifts in ((1.0, False), (1.3, True)):
        post = checker.with_scene([Obstacle(Box((0.05, 0.05, 1.0)), (0.2, 0.25, top - 0.5), "post")])
        found = mf.plan(post, None, a, b, max_nodes=4000)
        assert found, found.explain()
        assert bool(np.ptp(found.path[:, names_of(checker).index("lift")]) > 0.0) is lifts
        assert found.moving == (("lift", "left0") if lifts else None)
        alone = mf.plan(post, None, a, b, max_nodes=4000, active_joints=[])
        assert bool(alone) is not lifts
        for planner in ("lazy_prm_star", "prm"):
            found = mf.plan(post, None, a, b, planner=planner, max_nodes=1000, seconds=0.4)
            assert found, found.explain()
            assert found.moving == (("lift", "left0") if lifts else None)


def test_named_joints_move_in_place_of_the_rule(checker):
    a, b = configuration(checker), configuration(checker, left0=1.0)
    assert may_move(checker, a, b, moving=()) == {"left0"}
    assert may_move(checker, a, b, moving=("pan", "left2")) == {"left0", "left2", "pan"}


@pytest.mark.capability("11-39", "11-45")
@pytest.mark.parametrize("planner", ["rrt_connect", "lazy_prm_star", "prm"])
def test_the_other_arm_stays_where_it_is(checker, planner):
    """The tip is on the right arm, and the left one plans round a wall."""
    a, b = configuration(checker, left0=-0.3, right0=-0.8), configuration(checker, left0=0.9, right0=-0.8)
    assert not checker.free_segment(a, b)
    found = mf.plan(checker, None, a, b, planner=planner, seconds=0.3 if planner == "lazy_prm_star" else 10.0)
    assert found, found.explain()
    assert checker.check_path(found.path)
    moved = {
        e.name for e, way in zip(checker.robot.mechanism.coordinates, np.ptp(found.path, axis=0), strict=True) if way
    }
    assert moved <= {*LEFT}
    assert len(moved) > 1


def test_bounds_of_the_compiled_search_are_those_of_the_others(checker):
    """A start that ends at once shows the bounds: both write the same rule."""
    from mafsil.planning import arm_question_loops, arm_search

    a = configuration(checker, left0=-0.6)
    for changes in ({"left0": 0.5}, {"lift": 1.0}, {"pan": 0.3}, {"left_wheel": 9.0}, {"right_b": 0.1}):
        b = configuration(checker, **{"left0": -0.6} | changes)
        question = arm_search._question_for(checker, 1, None)
        bounds, near = np.empty((2, 2, checker.robot.n))
        arm_question_loops.bounds_around(question.value.limits, a, b[None], bounds, near)
        np.testing.assert_array_equal(bounds, bounds_of(checker, np.stack([a, b])))
        assert (bounds[0] <= near[0]).all()
        assert (near[0] <= np.minimum(a, b)).all()
        assert (np.maximum(a, b) <= near[1]).all()
        assert (near[1] <= bounds[1]).all()


def test_a_search_that_finds_nothing_says_what_it_held(checker):
    a, b = (configuration(checker, left0=x, right0=-0.8) for x in (-0.3, 0.9))
    found = mf.plan(checker, None, a, b, active_joints=[], max_nodes=50)
    assert found.status is mf.planning.outcome.PlanningStatus.NOT_FOUND
    assert "left1" in found.reason
    assert "left0" not in found.reason
    assert "active_joints=" in found.explain("ar")
    assert mf.plan(checker, None, a, b, active_joints=["lift"])
    with pytest.raises(mf.InputError, match="elbow"):
        mf.plan(checker, None, a, b, active_joints=["elbow"])
