"""Figures of chapter 3: closure, friction angles and cones by their own formulas, drawn where the contacts are."""

from itertools import pairwise
from math import atan, tan

import numpy as np
import pytest

import mafsil as mf
from mafsil.grasp import Grasp, NguyenCase
from mafsil.grasp.three_fingers import Section
from tests.book.artists import artist_points, drawn


def normals_pass_through(figure: mf.book.Figure, panel: str, grasp: Grasp) -> None:
    """Every drawn normal ends in its contact and points the way of its normal."""
    points = drawn(figure)
    for k, contact in enumerate(grasp.contacts):
        tail, tip = points(panel, f"normal {k}")
        assert tip == pytest.approx(contact.point)
        assert (tip - tail) / np.linalg.norm(tip - tail) == pytest.approx(contact.normal)


def closes(grasp: Grasp) -> bool:
    """The cone edges positively span: their null vector has one sign (n = m + 1), or by sampled directions."""
    A = grasp.matrix(8)
    directions = np.random.default_rng(3).normal(size=(4000, len(A)))
    return np.linalg.matrix_rank(A) == len(A) and bool((directions @ A).min(axis=1).max() < 0)


@pytest.mark.capability("12-31")
def test_figure_3_1() -> None:
    mu = 0.4
    figure = mf.book.figure("3.1", mu=mu)
    for name, grasp in figure.objects.items():
        normals_pass_through(figure, name, grasp)
    assert figure["epsilon_a"] == 0.0
    assert figure["epsilon_b"] == pytest.approx(1 / np.sqrt(4 + 1 / 0.5**2))
    assert figure["epsilon_c"] == pytest.approx(1 / np.sqrt(1 + 1 / mu**2 + 1 / mu**2))
    assert figure["free"] == 1
    assert [closes(figure.objects[name]) for name in "abc"] == [False, True, True]
    base, left, right = artist_points(figure, "c", "cone 0")[:3]
    edges = [(end - base)[1] / (end - base)[0] for end in (left, right)]
    assert np.abs(edges) == pytest.approx([mu, mu])


@pytest.mark.capability("12-32")
def test_figure_3_2() -> None:
    for mu, beta, stays in ((0.6, 0.35, True), (0.3, 0.5, False)):
        figure = mf.book.figure("3.2", mu=mu, beta=beta)
        points = drawn(figure)
        assert figure["alpha"] == pytest.approx(atan(mu))
        assert (figure["ratio"] < 1) == stays == (figure.objects["state"].name == "STICK")
        force = np.diff(points("contact", "force"), axis=0)[0]
        parts = [np.diff(points("contact", name), axis=0)[0] for name in ("normal part", "tangential part")]
        assert sum(parts) == pytest.approx(force)
        assert abs(parts[1][0] / parts[0][1]) == pytest.approx(tan(beta))
        _, *edges = points("contact", "cone")[:3]
        assert [abs(e[0] / e[1]) for e in edges] == pytest.approx([mu, mu])


@pytest.mark.capability("12-33")
def test_figure_3_3() -> None:
    figure = mf.book.figure("3.3", mu=0.8)
    assert figure["alpha"] == pytest.approx(atan(0.8))
    cone = figure.panels["cone"]["cone 0"].reshape(-1, 3)
    rim = cone[cone[:, 2] > 0.5]
    assert np.linalg.norm(rim[:, :2], axis=1) / rim[:, 2] == pytest.approx(0.8)
    normals_pass_through(figure, "cone", Grasp([figure.objects["contact"]]))


@pytest.mark.capability("12-34")
def test_figure_3_4() -> None:
    offset = 0.3
    figure = mf.book.figure("3.4", offset=offset)
    assert figure["epsilon_pinwheel"] == pytest.approx(1 / np.sqrt(4 + 1 / offset**2))
    assert figure["epsilon_printed"] == 0.0
    assert figure["moments"] == pytest.approx([-offset, offset, -offset, offset])
    (fact,) = [each for each in figure.facts if each.name == "moments"]
    assert not fact.agrees
    assert figure.erratum
    for name, grasp in figure.objects.items():
        normals_pass_through(figure, name, grasp)


@pytest.mark.capability("12-35")
def test_figure_3_5() -> None:
    figure = mf.book.figure("3.5")
    points = drawn(figure)
    vectors = np.array([points("a", f"a{k}")[1] for k in (1, 2, 3)])
    assert figure["shares"] @ vectors[1:] == pytest.approx([-1, 2])
    assert (figure["shares"] >= 0).all()
    sector = np.degrees(np.arctan2(*points("a", "sector")[1:, ::-1].T))
    assert (sector.min(), sector.max()) == pytest.approx((0.0, 135.0))
    below = points("a", "unreachable")[1]
    assert (vectors @ [0, 1] >= 0).all()
    assert below @ [0, 1] < 0  # y = (0, 1) certifies it
    other = np.array([points("b", f"a{k}")[1] for k in (1, 2, 3)])
    assert figure["null"] @ other == pytest.approx([0, 0])
    assert (figure["null"] > 0).all()


@pytest.mark.capability("12-36")
def test_figure_3_6() -> None:
    for seed in (1, 7):
        figure = mf.book.figure("3.6", seed=seed)
        points = drawn(figure)
        for name in "abc":
            cloud, hull = points(name, "points"), points(name, "hull")
            assert hull[0] == pytest.approx(hull[-1])
            for a, b in pairwise(hull):
                sides = [float(np.linalg.det([b - a, p - a])) for p in cloud]
                assert min(sides) > -1e-9 or max(sides) < 1e-9
        assert figure["corners"] == len(points("c", "hull")) - 1


@pytest.mark.capability("12-37")
def test_figure_3_7() -> None:
    for L in (0.5, 1.2):
        figure = mf.book.figure("3.7", L=L)
        grasp = figure.objects["grasp"]
        assert figure["S"] == pytest.approx([-1, -1, -1])
        assert figure["epsilon"] == pytest.approx(1 / np.sqrt(10 + 4 / L**2))
        normals_pass_through(figure, "body", grasp)
        corners = artist_points(figure, "body", "body")
        assert np.linalg.norm(corners - grasp.contacts[0].point, axis=1).min() == 0.0  # in the inner corner
        assert grasp.matrix(order="fm")[0] == pytest.approx([-1, 0, 1, 0])


@pytest.mark.capability("12-38")
def test_figure_3_8() -> None:
    figure = mf.book.figure("3.8", mu=0.5, height=0.0)
    points = drawn(figure)
    forces = [np.diff(points("b", f"force {k}"), axis=0)[0] / 0.06 for k in (0, 1)]
    assert sum(forces) == pytest.approx([0.0, 9.81])
    assert abs(forces[0][0]) == pytest.approx(9.81 / (2 * 0.5))
    for mu, height in ((0.5, 0.9), (0.3, 0.7), (0.3, 0.5)):
        figure = mf.book.figure("3.8", mu=mu, height=height)
        assert bool(figure["closed"]) == (mu > height / 2)
        assert figure["least"] == pytest.approx(height / 2)
        normals_pass_through(figure, "a", figure.objects["grasp"])


@pytest.mark.capability("12-39")
def test_figure_3_9() -> None:
    for mu, shift in ((0.5, 0.3), (0.2, 0.3), (0.2, 0.5)):
        figure = mf.book.figure("3.9", mu=mu, shift=shift)
        assert figure["delta"] == pytest.approx(atan(shift / 2))
        assert bool(figure["inside"]) == (figure["delta"] < atan(mu)) == closes(figure.objects["inside"])
        assert not figure["beside"]
        line = artist_points(figure, "inside", "line")
        assert line == pytest.approx(np.array([each.point for each in figure.objects["inside"].contacts]))


@pytest.mark.capability("12-40")
def test_figure_3_10() -> None:
    figure = mf.book.figure("3.10")
    expected = (NguyenCase.FACING, NguyenCase.ONE_CONE, NguyenCase.OPPOSITE_SIDES, NguyenCase.SAME_SIDE)
    points = drawn(figure)
    inside = []
    for name, case in zip(figure.panels, expected, strict=True):
        assert figure.objects["verdicts"][name].status is case
        assert closes(figure.objects[name]) == bool(figure[name])
        count = 0
        for k, way in ((0, 1.0), (1, -1.0)):
            apex, one, other = points(name, f"cone {k}")[:3]
            sides = [np.linalg.det([end - apex, [0.0, way]]) for end in (one, other)]
            count += sides[0] * sides[1] < 0
        inside.append(count)
    assert inside == [2, 1, 0, 0]


@pytest.mark.capability("12-41")
def test_figure_3_11() -> None:
    for tilt in (0.2, 0.4, 0.6):
        figure = mf.book.figure("3.11", tilt=tilt)
        assert bool(figure["closed"]) == (tilt < atan(0.5))
        assert figure["tilt"] == pytest.approx(tilt)
        grasp = figure.objects["grasp"]
        normals_pass_through(figure, "grasp", grasp)
        assert artist_points(figure, "grasp", "triangle")[:, 2] == pytest.approx(0.0)
        assert [np.arcsin(abs(c.normal[2])) for c in grasp.contacts] == pytest.approx([tilt] * 3)


@pytest.mark.capability("12-42")
def test_figure_3_12() -> None:
    mu = 0.7
    figure = mf.book.figure("3.12", mu=mu)
    alpha = atan(mu)
    kinds = [figure.objects["sections"][name].kind for name in ("cone", "line", "point")]
    assert kinds == [Section.CONE, Section.LINE, Section.POINT]
    assert figure["half_angle"] == pytest.approx(np.arccos(np.cos(alpha) / np.cos(alpha / 2)))
    axis = np.diff(artist_points(figure, "cone", "normal"), axis=0)[0]
    edge = artist_points(figure, "cone", "section")[1]
    assert edge[2] == 0.0
    assert edge @ axis / np.linalg.norm(edge) / np.linalg.norm(axis) == pytest.approx(np.cos(alpha))
    ray = artist_points(figure, "line", "section")
    axis = np.diff(artist_points(figure, "line", "normal"), axis=0)[0]
    assert (ray[1] - ray[0]) @ axis == pytest.approx(np.cos(alpha))
    assert "section" not in figure.panels["point"].names
