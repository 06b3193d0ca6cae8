"""Boxes of configurations: paths through free ones, proofs that there is no path; patches of obstacles in pictures."""

from __future__ import annotations

import pickle
from collections import deque

import numpy as np
import pytest

import mafsil as mf
from mafsil.collision import Box, Checker, Cylinder, Obstacle, Plane, Sphere
from mafsil.errors import InputError
from mafsil.figures import plot_configuration_space
from mafsil.model import Limits
from mafsil.planning import configuration_space_obstacles
from mafsil.planning.outcome import PlanningStatus

CELLS = 60


def posts(*places, radius=0.1):
    return [Obstacle(Cylinder(radius, 1.0), (*place, 0.0), f"post {k}") for k, place in enumerate(places)]


def two_links(scene, **settings):
    return Checker("planar2r", scene, radius=0.05, self_collision=False, **settings)


@pytest.mark.capability("11-42")
def test_a_link_between_two_posts_does_not_get_out():
    """Whatever the second joint does, the first link meets a post on both sides; whole turns do not help."""
    caught = two_links(posts(*(0.6 * np.array([np.cos(a), np.sin(a)]) for a in (-0.6, 0.6))))
    for goal in ([np.pi, 0.0], [2 * np.pi, 0.0], [[2.0, 0.5], [-2.0, 0.0]]):
        found = mf.plan(caught, None, [0.0, 0.0], goal, planner="cell_decomposition")
        assert found.status is PlanningStatus.SEPARATED
        assert "boxes" in found.explain("en")
        assert found.reason in found.explain("en")
        assert "صناديق" in found.explain("ar")
        assert "turn" not in found.explain("ar"), "reasons are said again in the other language"
        assert pickle.loads(pickle.dumps(found.reason)).explain("ar") == found.reason.explain("ar")
    within = mf.plan(caught, None, [0.0, 0.0], [0.2, 2.0], planner="cell_decomposition")
    assert within
    assert caught.check_path(within.path)
    searched = mf.plan(caught, None, [0.0, 0.0], [np.pi, 0.0], seconds=0.5, max_nodes=2000)
    assert searched.status is PlanningStatus.SEPARATED
    assert searched.planner == "rrt_connect"


@pytest.mark.capability("11-42")
@pytest.mark.parametrize("seed", range(4))
def test_boxes_say_what_a_flood_over_proved_motions_says(seed):
    """On a grid of configurations, any number of turns wide: what proved motions join is not called separated."""
    rng = np.random.default_rng(seed)
    polar = [(rng.uniform(0.3, 1.8), rng.uniform(-np.pi, np.pi)) for _ in range(6)]
    scene = [
        Obstacle(shape, (d * np.cos(a), d * np.sin(a), 0.0))
        for (d, a), shape in zip(polar, (Sphere(0.15), Box((0.3, 0.2, 0.3)), Cylinder(0.1, 1.0)) * 2, strict=True)
    ]
    arm = two_links(scene, clearance=0.01 * seed)
    step = 2.0 * np.pi / CELLS
    axis = step * np.arange(CELLS)
    grid = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
    joined = [arm.free_segment(grid, grid + step * np.eye(2)[k]).reshape(CELLS, CELLS) for k in range(2)]
    open_places = np.argwhere(arm.free(grid).reshape(CELLS, CELLS))
    for i, j in open_places[rng.integers(len(open_places), size=(3, 2))]:
        known = _flooded(joined, tuple(i.tolist()), tuple(j.tolist()))
        found = mf.plan(arm, None, step * i, step * j, planner="cell_decomposition", shortcut_iterations=0)
        assert found.status is (PlanningStatus.FOUND if known else PlanningStatus.SEPARATED)
        assert not known or arm.check_path(found.path)


def _flooded(joined, start, goal):
    """Whether steps of the grid lead from a place to another one, which may be whole turns round in between."""
    seen, wave = {start}, deque([start])
    while wave:
        x, y = wave.popleft()
        if (x, y) == goal:
            return True
        i, j, k, m = x % CELLS, y % CELLS, (x - 1) % CELLS, (y - 1) % CELLS
        steps = (
            ((x + 1, y), joined[0][i, j]), ((x - 1, y), joined[0][k, j]),
            ((x, y + 1), joined[1][i, j]), ((x, y - 1), joined[1][i, m]),
        )  # fmt: skip
        for place, is_free in steps:
            if is_free and place not in seen and max(map(abs, place)) < 3 * CELLS:
                seen.add(place)
                wave.append(place)
    return False


@pytest.mark.capability("11-42")
def test_limits_separate_too_and_what_has_no_end_is_never_called_separated():
    """A plate across a slide: separated between limits; without limits nothing is proved. Six joints are too many."""
    for limited, status in ((True, PlanningStatus.SEPARATED), (False, PlanningStatus.NOT_FOUND)):
        slide = Checker(_sliding(limited), [Obstacle(Box((0.1, 9.0, 9.0)), (1.0, 0.0, 0.0), "plate")], radius=0.05)
        found = mf.plan(slide, None, [0.0, 0.0], [2.0, 0.0], planner="cell_decomposition")
        assert found.status is status
    arm = Checker("ur5", radius=0.05)
    with pytest.raises(InputError, match="6 move"):
        mf.plan(arm, None, np.full(6, -0.5), np.full(6, -1.0), planner="cell_decomposition")
    still = np.array([0.0, -1.0, 1.0, 0.0, 0.0, 0.0])
    assert mf.plan(arm, None, still, still + np.eye(6)[0], planner="cell_decomposition", active_joints=[])


def _sliding(limited):
    """A joint that slides along x, with a bar of 0.5 m, and one that turns behind it."""
    home = np.eye(4)
    home[0, 3] = 0.5
    limits = {"limits": [Limits(-1.0, 3.0), Limits(-3.0, 3.0)]} if limited else {}
    return mf.Robot.from_screws([[0, 0, 0, 1, 0, 0], [0, 0, 1, 0, 0, 0]], home, **limits)


@pytest.mark.capability("11-42")
def test_patches_of_an_arm_are_those_of_segments_in_the_plane():
    """Links are segments 50 mm thick, posts discs, the wall a line: each patch by itself, on 200 x 200 cells."""
    places = np.array([[1.2, 1.2], [-0.9, 0.4]])
    facing = np.array([[1, 0, 0, 0], [0, 0, 1, -1.5], [0, -1, 0, 0], [0, 0, 0, 1.0]])
    arm = two_links([*posts(*places), Obstacle(Plane(), facing, "wall")])
    axes, patches = configuration_space_obstacles(arm, 200)
    assert patches.shape == (4, 200, 200)
    a, b = np.meshgrid(*axes, indexing="ij")
    elbow = np.stack([np.cos(a), np.sin(a)], axis=-1)
    tip = elbow + np.stack([np.cos(a + b), np.sin(a + b)], axis=-1)
    gaps = [np.minimum(_apart(0 * elbow, elbow, p), _apart(elbow, tip, p)) - 0.15 for p in places]
    gaps.append(np.minimum(elbow[..., 1], tip[..., 1]) + 1.5 - 0.05)
    for patch, gap in zip(patches, gaps, strict=False):
        clear = np.abs(gap) > 1e-9
        assert (patch[clear] == (gap < 0.0)[clear]).all()
    assert not patches[3].any()


def _apart(a, b, p):
    way = b - a
    share = np.clip(((p - a) * way).sum(axis=-1) / np.maximum((way**2).sum(axis=-1), 1e-300), 0.0, 1.0)
    return np.linalg.norm(a + share[..., None] * way - p, axis=-1)


@pytest.mark.capability("11-42")
def test_pictures_of_two_and_three_joints_of_any_arm(tmp_path):
    arm = Checker("ur5", [Obstacle(Box((0.3, 0.3, 0.3)), (0.5, 0.2, 0.3), "box")], radius=0.05)
    names = [each.name for each in arm.robot.mechanism.coordinates]
    axes, patches = configuration_space_obstacles(arm, 12, joints=names[1:4], at=np.full(6, 0.3))
    assert patches.shape == (2, 12, 12, 12)
    q = np.array([0.3, axes[0][2], axes[1][7], axes[2][5], 0.3, 0.3])
    assert patches[:, 2, 7, 5].tolist() == arm.hits(q).tolist()
    for count, ending, language in ((2, "svg", "en"), (3, "png", "ar")):
        file = tmp_path / f"space.{ending}"
        plot_configuration_space(arm, file, cells=15, joints=names[:count], way=np.zeros((2, 6)), language=language)
        assert file.stat().st_size > 1000
    for wrong in ({}, {"joints": []}, {"joints": ["elbow"]}, {"joints": names[:1] * 2}):
        with pytest.raises(InputError, match="joints"):
            configuration_space_obstacles(arm, 5, **wrong)
