"""Arms that never reach full rank, default tasks, canonical bases of what is lost and carried, sentences that agree."""

import re

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.geometry import screw
from mafsil.performance import (
    default_task,
    determinant_factors,
    generic_rank,
    is_singular,
    natural_task,
    rank,
    singular_values,
    singularity,
    workspace_map,
)
from mafsil.performance.singularities.screw_parameters import canonical_system
from mafsil.performance.statics import total_wrench

Z = [0.0, 0.0, 1.0]


def four_parallel():
    """Six joints, the first four parallel: rank five at every pose."""
    rng = np.random.default_rng(1)
    axes = [screw.from_axis(Z, rng.normal(size=3)) for _ in range(4)]
    axes += [screw.from_axis(rng.normal(size=3), rng.normal(size=3)) for _ in range(2)]
    return mf.Robot.from_screws(axes, np.eye(4))


@pytest.mark.capability("05-98", "05-70")
def test_an_arm_that_never_reaches_full_rank_is_singular_everywhere():
    arm = four_parallel()
    q = np.random.default_rng(2).normal(size=(20, 6))
    assert is_singular(arm, q).all()
    assert (rank(arm, q) == generic_rank(arm)).all()
    assert generic_rank(arm) == 5
    found = singularity(arm, q[0])
    assert found.singular
    assert found.deficient
    assert found.drop == 0
    assert (found.rank, found.generic_rank, found.full_rank) == (5, 5, 6)
    assert "at every configuration" in found.explain("en")
    assert "is singular here" not in found.explain("en"), "nothing is lost beyond what is always lost"
    (force,) = found.reciprocal_screws
    np.testing.assert_allclose(np.abs(force.direction), Z, atol=1e-9)
    np.testing.assert_allclose(found.wrenches @ arm.jacobian_space(q[0]), 0, atol=1e-8)
    assert [cause.case for cause in found.causes] == ["parallel"]
    assert found.explain("ar") != found.explain("en")


@pytest.mark.capability("05-98", "05-100")
@pytest.mark.parametrize(
    ("screws", "case"),
    [
        ([screw.from_axis(Z, [0, 0, 0]), screw.from_axis(Z, [1, 0, 0]), [0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 1, 0]],
         "planar_motion"),
        ([[0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 1, 0], [0, 0, 0, 0.6, 0.8, 0], screw.from_axis([1, 1, 0], [0, 0, 1])],
         "coplanar_prismatic"),
        ([screw.from_axis(Z, [k, k * k, 0]) for k in range(4)], "parallel"),
    ],
)  # fmt: skip
def test_what_depends_at_every_pose_has_its_cause(screws, case):
    arm = mf.Robot.from_screws(screws, np.eye(4), normalise=True)
    found = singularity(arm, [0.3, -0.2, 0.5, 0.1], task="pose")
    assert found.deficient
    assert case in {cause.case for cause in found.causes}


@pytest.mark.capability("05-107", "05-70")
@pytest.mark.parametrize("q2", [0.0, np.pi])
def test_the_planar_2r_is_singular_where_its_determinant_vanishes(q2):
    arm = mf.load("planar2r")
    assert default_task(arm) == determinant_factors(arm).task == "planar_position"
    q = [0.4, q2]
    assert abs(determinant_factors(arm).evaluate(q)) < 1e-12
    assert is_singular(arm, q)
    assert not is_singular(arm, [0.4, 1.0])
    found = singularity(arm, q)
    assert found.singular
    assert not found.deficient
    (lost,) = found.lost_screws
    np.testing.assert_allclose(np.abs(lost.direction), np.abs([np.cos(0.4), np.sin(0.4), 0]), atol=1e-9)
    assert np.isinf(lost.pitch)
    assert [cause.names for cause in found.causes] == [("joint1", "joint2")]
    assert "stretched or folded" in found.explain("en")
    assert found.explain("ar") != found.explain("en")
    assert not singularity(arm, q, task="pose").singular, "the whole pose asks only that the two twists differ"


@pytest.mark.parametrize(
    ("name", "task"), [("planar3r", "planar"), ("scara_rrrp", "schoenflies"), ("puma560", "pose"), ("panda", "pose")]
)
def test_default_tasks(name, task):
    assert default_task(mf.load(name)) == task


def test_default_tasks_of_arms_without_a_natural_one():
    wrist = mf.Robot.from_screws([[0, 0, 1, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0]], np.eye(4))
    assert default_task(wrist) == natural_task(wrist) == determinant_factors(wrist).task == "orientation"
    assert determinant_factors(wrist).evaluate([0.1, 0.5, 0.2]) == pytest.approx(-np.sin(0.5))
    assert is_singular(wrist, [0.1, 0, 0.2])
    assert not is_singular(wrist, [0.1, 0.5, 0.2])
    snake = mf.Robot.from_screws([screw.from_axis(Z, [k, 0, 0]) for k in range(5)], np.eye(4))
    assert default_task(snake) == "planar"
    assert not is_singular(snake, [0.1, 0.5, 0.2, 0.3, 0.1]), "redundant in its plane, not singular"
    assert is_singular(snake, np.zeros(5))
    assert singular_values(snake, np.zeros(5)).shape == (5,)


@pytest.mark.capability("05-79", "05-99")
def test_four_parallel_axes_of_a_ur_wrist():
    found = singularity(mf.load("ur5e"), [0.1, -1.0, 1.0, 0.4, 0.0, 0.2])
    (cause,) = found.causes
    assert cause.case == "parallel"
    assert cause.number == "III"
    assert cause.joints == (1, 2, 3, 5)
    assert "prismatic" not in found.explain("en")
    np.testing.assert_allclose(cause.rates[[0, 4]], 0, atol=1e-9)


@pytest.mark.capability("05-71")
def test_what_a_straight_planar_arm_carries():
    found = singularity(mf.load("planar3r"), np.zeros(3))
    couples = [s.direction.tolist() for s in found.reciprocal_screws if np.isinf(s.pitch)]
    forces = [s for s in found.reciprocal_screws if not np.isinf(s.pitch)]
    assert couples == [[1, 0, 0], [0, 1, 0]]
    assert [s.direction.tolist() for s in forces] == [[1, 0, 0], [0, 0, 1]]
    for force in forces:
        assert abs(force.pitch) < 1e-12
        assert np.abs(force.point).max() < 3.0, "the lines of action stay near the arm"


def test_canonical_basis_spans_the_system_and_does_not_depend_on_the_basis_given():
    rng = np.random.default_rng(0)
    for _ in range(60):
        k = int(rng.integers(1, 6))
        rows = rng.normal(size=(k, 6))
        if rng.uniform() < 0.5:
            rows[: min(k // 2 + 1, 3), :3] = 0.0
        rows = rng.normal(size=(k, k)) @ rows
        d, m = canonical_system(rows[:, :3], rows[:, 3:])
        both = np.concatenate([d, m], axis=1)
        assert np.linalg.matrix_rank(np.concatenate([both, rows]), tol=1e-8) == k == np.linalg.matrix_rank(both)
        again = np.concatenate(canonical_system(*np.hsplit(rng.normal(size=(k, k)) @ rows, 2)), axis=1)
        np.testing.assert_allclose(np.abs(again), np.abs(both), atol=1e-5)
        turning = d[np.abs(d).max(axis=1) > 0]
        np.testing.assert_allclose(turning @ turning.T, np.eye(len(turning)), atol=1e-9)


@pytest.mark.capability("05-71", "05-80")
@pytest.mark.parametrize(("name", "q"), [("puma560", [0.1, 0.4, 0.3, 0.5, 0, -0.2]), ("panda", [0.0] * 7)])
def test_sentences_say_what_the_numbers_say(name, q):
    """Lost motions are motions that fail, carried wrenches are wrenches without effort; neither word for the other."""
    arm = mf.load(name)
    found = singularity(arm, q)
    J = arm.jacobian_space(q)
    lines = found.explain("en").splitlines()
    lost = [line for line in lines if line.startswith("lost")]
    carried = [line for line in lines if line.startswith("carried")]
    assert len(lost) == found.generic_rank - found.rank == len(found.lost_twists)
    assert len(carried) == 6 - found.rank == len(found.wrenches)
    for line, V in zip(lost, found.lost_twists, strict=True):
        assert np.linalg.norm(V - J @ np.linalg.lstsq(J, V, rcond=1e-6)[0]) > 1e-3 * np.linalg.norm(V)
        assert not re.search("force|couple|wrench", line)
        np.testing.assert_allclose(np.cross(read(line), leading(V)), 0, atol=2e-3)
    for line, F in zip(carried, found.wrenches, strict=True):
        np.testing.assert_allclose(F @ J, 0, atol=1e-8)
        assert not re.search("rotation|translation|motion", line)
        np.testing.assert_allclose(np.cross(read(line), leading(np.roll(F, 3))), 0, atol=2e-3)


def read(line):
    """The direction that a sentence states last."""
    return np.array([float(x) for x in re.findall(r"\(([^()]*)\)", line)[-1].split(",")])


def leading(directed_first):
    """Unit direction of a twist (omega, v): of omega, or of v where nothing turns."""
    part = directed_first[:3] if np.linalg.norm(directed_first[:3]) > 1e-8 else directed_first[3:]
    return part / np.linalg.norm(part)


@pytest.mark.capability("05-59")
def test_a_total_wrench_is_about_its_point():
    forces, points = [[0, 0, 2.0], [1.0, 0, 0]], [[1.0, 0, 0], [0, 2.0, 0]]
    np.testing.assert_allclose(total_wrench(forces, points), [0, -2, -2, 1, 0, 2])
    about = np.array([1.0, 1.0, 0.0])
    moved = total_wrench(forces, points, about=about)
    np.testing.assert_allclose(moved, [-2, 0, -1, 1, 0, 2])
    np.testing.assert_allclose(moved[:3], total_wrench(forces, points)[:3] - np.cross(about, moved[3:]))
    for f, p in (([[1, 0, 0]], [[0, 0, 0], [1, 1, 1]]), ([[1, 0, 0]] * 2, [[0, 0, 0]]), ([[[1, 0, 0]]], [[0, 0, 0]])):
        with pytest.raises(InputError, match="one point"):
            total_wrench(f, p)


def test_the_range_of_an_unlimited_prismatic_joint_is_asked_for():
    arm = mf.load("scara_rrrp")
    with pytest.raises(InputError, match="prismatic joint4"):
        workspace_map(arm, 1000, view="xy")
    found = workspace_map(arm, 20_000, view="xz", ranges={"joint4": (0.1, 0.3)})
    assert found.given == {"joint4": (0.1, 0.3)}
    assert "joint4 [0.1, 0.3]" in found.explain("en")
    assert "joint4" in found.explain("ar")
    heights = found.centres(1)[found.reached.any(axis=0)]
    assert 0.15 < heights.max() - heights.min() < 0.25
    for wrong, words in (({"joint9": (0, 1)}, "joint9"), ({"joint4": (1, 0)}, "before it starts")):
        with pytest.raises(InputError, match=words):
            workspace_map(arm, 1000, ranges=wrong)
