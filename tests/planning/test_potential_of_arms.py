"""Potential fields of whole arms, and pictures of fields with their minima marked."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil.collision import Box, Checker, Cylinder, Obstacle
from mafsil.collision.checker import each_distance
from mafsil.errors import InputError
from mafsil.figures import plot_potential
from mafsil.planning import PotentialField, disc_distance
from mafsil.planning.outcome import PlanningStatus

PIN = [Obstacle(Cylinder(0.1, 1.0), (1.2, 1.2, 0.0), "pin")]


@pytest.fixture(scope="module")
def arm():
    return Checker("planar2r", PIN, radius=0.05, self_collision=False)


@pytest.mark.capability("11-44")
def test_every_link_is_pushed_away(arm):
    """The force is minus the gradient of the potential; 1/rho of both links, each from segments in the plane."""
    field = PotentialField.of_arm(arm, [2.0, 0.4], eta=0.01, reach=0.5)
    q, step = np.array([0.35, 1.3]), 1e-6
    slope = [(field.potential(q + step * e) - field.potential(q - step * e)) / (2 * step) for e in np.eye(2)]
    np.testing.assert_allclose(field.force(q), -np.array(slope), rtol=1e-6)
    elbow = np.array([np.cos(q[0]), np.sin(q[0])])
    tip = elbow + np.array([np.cos(q.sum()), np.sin(q.sum())])
    expected = 0.5 * np.sum((q - [2.0, 0.4]) ** 2)
    for a, b in ((np.zeros(2), elbow), (elbow, tip)):
        share = np.clip((np.array([1.2, 1.2]) - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        rho = np.linalg.norm(a + share * (b - a) - 1.2) - 0.15
        assert rho > 0.0
        expected += 0.005 * (1.0 / rho - 2.0) ** 2 if rho < 0.5 else 0.0
    assert field.potential(q) == pytest.approx(expected, rel=1e-9)


@pytest.mark.capability("11-44")
def test_an_arm_arrives_or_is_stuck_and_meets_nothing(arm, tmp_path):
    field = PotentialField.of_arm(arm, [2.0, 0.4])
    there = field.path([1.9, -0.3], step=0.2)
    assert there
    assert arm.check_path(there.path)
    stuck = field.path([0.6, -0.4], step=0.2)
    assert stuck.status is PlanningStatus.LOCAL_MINIMUM
    np.testing.assert_array_equal(stuck.minima, stuck.path[-1:])
    assert "1 local min" in stuck.explain("en")
    assert arm.check_path(stuck.path)
    assert field.path([0.785, 0.0]).status is PlanningStatus.START_BLOCKED
    with pytest.raises(InputError, match="goal"):
        PotentialField.of_arm(arm, [1.0])
    plot_potential(field, tmp_path / "arm.png", [0.4, -0.6], [2.2, 0.6], way=stuck.path, cells=20, starts=1)
    assert (tmp_path / "arm.png").stat().st_size > 5000


@pytest.mark.capability("11-44")
def test_an_arm_is_pushed_away_from_itself_and_walks_out_of_minima():
    """Distances are the checker's, forces the slope of U; no path meets anything or leaves the limits."""
    boxes = [Obstacle(Box((0.5, 0.04, 0.45)), (0.6, 0.0, 0.225)), Obstacle(Box((0.4, 0.4, 0.03)), (0.5, 0.5, 0.5))]
    panda = Checker("panda", boxes, radius=0.05)
    q = panda.random_configurations(60)
    q = q[panda.distance(q).distance > 0.01]
    rho, _ = each_distance(panda, q, np.inf)
    np.testing.assert_allclose(rho.min(axis=-1), panda.distance(q).distance, atol=1e-9)
    alone = PotentialField.of_arm(panda.with_scene([]), q[0], eta=0.01, reach=0.5)
    near = alone.near(q).rho
    folded = q[((near < np.asarray(alone.reach)).any(axis=-1)) & (near.min(axis=-1) > 0.02)][0]
    assert np.abs(alone.repulsion(folded)).max() > 0.0
    slope = [(alone.potential(folded + 1e-6 * e) - alone.potential(folded - 1e-6 * e)) / 2e-6 for e in np.eye(7)]
    np.testing.assert_allclose(alone.force(folded), -np.array(slope), rtol=1e-4, atol=1e-5)
    arrived = 0
    for k in range(4):
        found = PotentialField.of_arm(panda, q[2 * k + 1]).path(q[2 * k], step=0.1, escapes=5, seed=k)
        arrived += bool(found)
        assert panda.check_path(found.path)
        assert (found.path >= panda.robot.limits.lower).all()
        assert (found.path <= panda.robot.limits.upper).all()
    assert arrived >= 3
    assert alone.path(q[1] + 9.0).status is PlanningStatus.START_OUTSIDE
    assert PotentialField.of_arm(panda, q[0] + 9.0).path(q[1]).status is PlanningStatus.GOAL_OUTSIDE


@pytest.mark.capability("11-44")
def test_a_pocket_is_a_minimum_and_is_marked(tmp_path):
    """Three discs around a place before the goal: descents end in one of two hollows of it, or at the goal."""
    field = PotentialField.of(
        [4.0, 0.0], [disc_distance(c, 0.5) for c in ([2.0, 0.9], [2.4, 0.0], [2.0, -0.9])], reach=0.5
    )
    found = field.minima([0.0, -2.0], [2.0, 2.0], starts=8)
    assert len(found) == 2
    np.testing.assert_allclose(found[0], found[1] * [1.0, -1.0], atol=1e-6)
    np.testing.assert_allclose(field.force(found), 0.0, atol=1e-6)
    around = found[:, None] + 1e-3 * np.stack([np.cos(np.arange(12)), np.sin(np.arange(12))], axis=-1)
    assert (field.potential(around) > field.potential(found)[:, None]).all()
    for language, ending in (("en", "svg"), ("ar", "pdf")):
        file = tmp_path / f"field.{ending}"
        plot_potential(field, file, [-1.0, -2.0], [5.0, 2.0], cells=30, starts=4, language=language)
        assert file.stat().st_size > 3000
    with pytest.raises(InputError, match="goal"):
        plot_potential(PotentialField.of([0.0, 0.0, 0.0], []), tmp_path / "a.png", [0, 0], [1, 1])
