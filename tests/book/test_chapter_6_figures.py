"""Figures of chapter 6: Jacobians against differences, ranks against singular values, lines drawn where axes are."""

import numpy as np
import pytest

import mafsil as mf
from tests.book.artists import artist_points, drawn


def by_differences(robot: mf.Robot, q: np.ndarray, step: float = 1e-6) -> np.ndarray:
    """(6, n) space Jacobian from differences of poses."""
    columns = []
    for unit in np.eye(len(q)):
        dT = (robot.fk(q + step * unit) - robot.fk(q - step * unit)) / (2 * step)
        V = dT @ np.linalg.inv(robot.fk(q))
        columns.append([V[2, 1], V[0, 2], V[1, 0], *V[:3, 3]])
    return np.array(columns).T


def least_singular_value(figure: mf.book.Figure) -> float:
    return float(np.linalg.svd(by_differences(figure.objects["robot"], np.array(figure.objects["q"])))[1][-1])


@pytest.mark.capability("12-68")
def test_figure_6_1() -> None:
    figure = mf.book.figure("6.1", angle=1.2, shift=0.6)
    T, S = figure.objects["T"], figure.objects["S"]
    points = drawn(figure)
    ends = points("b", "S")
    moved = points("b", "moved")
    direction = (moved[1] - moved[0]) / np.linalg.norm(moved[1] - moved[0])
    carried = (T @ np.column_stack([ends, [1, 1]]).T).T[:, :3]
    for end in carried:  # the carried line is the drawn one
        assert np.linalg.norm(np.cross(end - moved[0], direction)) < 1e-9
    assert figure["moved"][:3] == pytest.approx(T[:3, :3] @ S[:3])
    inverse = np.linalg.inv(T)
    seen = (inverse @ np.column_stack([points("a", "S"), [1, 1]]).T).T[:, :3]
    for end in seen:
        assert -np.cross(figure["S_b"][:3], end) == pytest.approx(figure["S_b"][3:])


@pytest.mark.capability("12-69")
def test_figure_6_2() -> None:
    figure = mf.book.figure("6.2", q1=0.3, q2=-1.0, q4=0.2)
    J = by_differences(figure.objects["robot"], np.array(figure.objects["q"]))
    assert figure.objects["J"] == pytest.approx(J, abs=1e-8)
    points = drawn(figure)
    for k in range(3):
        (q,) = points("arm", f"q{k + 1}")
        assert J[:, k] == pytest.approx([0, 0, 1, *-np.cross([0, 0, 1], q)], abs=1e-8)
        assert points("arm", f"axis {k + 1}")[:, :2] == pytest.approx(np.array([q[:2], q[:2]]))
    assert figure["gap"] < 1e-12
    assert figure["v4"] == pytest.approx([0, 0, -1])


@pytest.mark.capability("12-70")
def test_figure_6_3() -> None:
    figure = mf.book.figure("6.3", q1=-0.8, q2=0.6, q4=1.4)
    J = by_differences(figure.objects["robot"], np.array(figure.objects["q"]))
    assert figure["w5"] == pytest.approx(J[:3, 4], abs=1e-8)
    assert figure["gap"] < 1e-12
    (centre,) = artist_points(figure, "arm", "q_w")
    c1, s1, c2, s2 = np.cos(-0.8), np.sin(-0.8), np.cos(0.6), np.sin(0.6)
    assert centre == pytest.approx([-1.1 * s1 * c2, 1.1 * c1 * c2, 1 - 1.1 * s2])
    assert figure["rank"] == np.linalg.matrix_rank(J, tol=1e-6) == 6


@pytest.mark.capability("12-71")
def test_figure_6_4() -> None:
    figure = mf.book.figure("6.4", angle=-1.0, force=4.0)
    points = drawn(figure)
    r = points("wrench", "r")[1]
    along = np.diff(points("wrench", "f"), axis=0)[0]
    f = 4.0 * np.array([np.cos(-1.0), np.sin(-1.0), 0.6])
    assert np.cross(along, f) == pytest.approx(0.0, abs=1e-12)
    skew = np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
    assert figure["m"] == pytest.approx(skew @ f)
    assert np.cross(np.diff(points("wrench", "m"), axis=0)[0], skew @ f) == pytest.approx(0.0, abs=1e-12)
    assert points("wrench", "f")[0] == pytest.approx(r)


@pytest.mark.capability("12-72")
def test_figure_6_5() -> None:
    figure = mf.book.figure("6.5", yaw=-0.5, tilt=2.0)
    assert {figure[name] for name in ("space", "body", "base", "tool")} == {5}
    assert least_singular_value(figure) < 1e-7
    points = drawn(figure)
    assert points("arm", "s'.x")[0] == pytest.approx(figure.objects["base"][:3, 3])
    held = figure.objects["robot"].fk(figure.objects["q"]) @ figure.objects["tool"]
    assert points("arm", "b'.x")[0] == pytest.approx(held[:3, 3])


def red_lines(figure: mf.book.Figure, numbers: tuple[int, ...]) -> list[np.ndarray]:
    points = drawn(figure)
    return [points("arm", f"bold {k}") for k in numbers]


@pytest.mark.capability("12-73")
def test_figure_6_6() -> None:
    figure = mf.book.figure("6.6")
    first, last = red_lines(figure, (4, 6))
    for end in last:
        assert np.linalg.norm(np.cross(end - first[0], first[1] - first[0])) < 1e-9
    assert (figure["rank"], figure["of_columns"]) == (5, 1)
    assert least_singular_value(figure) < 1e-7
    regular = mf.book.figure("6.6", q5=0.6)
    assert regular["rank"] == 6
    assert least_singular_value(regular) > 1e-2


@pytest.mark.capability("12-74")
def test_figure_6_7() -> None:
    figure = mf.book.figure("6.7")
    axes = red_lines(figure, (2, 3, 5))
    along = axes[0][1] - axes[0][0]
    assert all(np.linalg.norm(np.cross(axis[1] - axis[0], along)) < 1e-9 for axis in axes)
    places = np.array([axis[0] - axes[0][0] for axis in axes[1:]] + [along])
    assert abs(np.linalg.det(places)) < 1e-9
    assert (figure["rank"], figure["of_columns"]) == (5, 2)
    assert least_singular_value(figure) < 1e-7
    assert mf.book.figure("6.7", q3=0.5)["rank"] == 6


@pytest.mark.capability("12-75")
def test_figure_6_8() -> None:
    for q2 in (0.5, 0.9):
        figure = mf.book.figure("6.8", q2=q2)
        (point,) = artist_points(figure, "arm", "meeting point")
        assert point == pytest.approx([0, 0, 2 * np.sin(q2)], abs=1e-9)
        for start, end in red_lines(figure, (1, 4, 5, 6)):
            assert np.linalg.norm(np.cross(point - start, end - start)) < 1e-9
        assert (figure["rank"], figure["of_columns"]) == (5, 3)
        assert least_singular_value(figure) < 1e-7
    assert mf.book.figure("6.8", error=0.3)["rank"] == 6


@pytest.mark.capability("12-76")
def test_figure_6_9() -> None:
    figure = mf.book.figure("6.9")
    golden = (1 + np.sqrt(5)) / 2
    assert figure["lengths"] == pytest.approx([golden, golden - 1])
    assert figure["area"] == pytest.approx(1.0)
    for L2 in (0.7, 1.0):
        figure = mf.book.figure("6.9", L2=L2)
        points = drawn(figure)
        for k, (shoulder, elbow) in enumerate(zip((-0.2, 0.25, 0.9, 1.6), figure.objects["elbows"], strict=True)):
            arm, ellipse = points("ellipses", f"arm {k}"), points("ellipses", f"ellipse {k}")
            assert arm[1] == pytest.approx([np.cos(shoulder), np.sin(shoulder)])
            second = L2 * np.array([np.cos(shoulder + elbow), np.sin(shoulder + elbow)])
            assert arm[2] - arm[1] == pytest.approx(second)
            J = np.column_stack([[-arm[2][1], arm[2][0]], [-second[1], second[0]]])
            rates = np.linalg.solve(J, (ellipse - arm[2]).T / 0.25)
            assert np.linalg.norm(rates, axis=0) == pytest.approx(
                1.0
            )  # every drawn point is the velocity of a unit rate
