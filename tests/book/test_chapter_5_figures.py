"""Figures of chapter 5: tables, screws and poses recomputed from matrices; arms drawn through them."""

import numpy as np
import pytest
from scipy.linalg import expm

import mafsil as mf
from tests.book.artists import artist_points, drawn


def about(axis: str, angle: float) -> np.ndarray:
    k = "xyz".index(axis)
    i, j = (k + 1) % 3, (k + 2) % 3
    T = np.eye(4)
    T[[i, i, j, j], [i, j, i, j]] = np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)
    return T


def shift(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


def exponential(S: np.ndarray, angle: float) -> np.ndarray:
    w, v = S[:3], S[3:]
    xi = np.array([[0, -w[2], w[1], v[0]], [w[2], 0, -w[0], v[1]], [-w[1], w[0], 0, v[2]], [0, 0, 0, 0]])
    return expm(angle * xi)


def table(rows: list[tuple[float, float, float, float]]) -> np.ndarray:
    """Product of modified link transforms (alpha, a, d, theta)."""
    T = np.eye(4)
    for alpha, a, d, theta in rows:
        T = T @ about("x", alpha) @ shift(a) @ about("z", theta) @ shift(z=d)
    return T


def axes_are_drawn(figure: mf.book.Figure, S: np.ndarray) -> None:
    """Every drawn axis is the line of its screw."""
    points = drawn(figure)
    for k, screw in enumerate(S):
        start, end = points("arm", f"axis {k + 1}")
        direction = (end - start) / np.linalg.norm(end - start)
        omega = screw[:3] if screw[:3].any() else screw[3:]
        assert direction == pytest.approx(omega, abs=1e-9)
        if screw[:3].any():
            assert -np.cross(omega, start) == pytest.approx(screw[3:], abs=1e-9)


@pytest.mark.capability("12-58")
def test_figure_5_1() -> None:
    q = np.array([0.3, -0.8, 1.1])
    figure = mf.book.figure("5.1", q1=q[0], q2=q[1], q3=q[2])
    sums, lengths = np.cumsum(q), np.array([1.0, 0.8, 0.5])
    corners = np.vstack([[0, 0], np.cumsum(lengths[:, None] * np.column_stack([np.cos(sums), np.sin(sums)]), axis=0)])
    points = drawn(figure)
    for k, corner in enumerate(corners[:3]):
        tail, tip = points("arm", f"{k + 1}.x")
        assert tail == pytest.approx(corner)
        assert np.arctan2(*(tip - tail)[::-1]) == pytest.approx(sums[k])
    assert points("arm", "arm")[-1] == pytest.approx(corners[3])
    assert figure["tip"] == pytest.approx(corners[3])
    assert figure["angle"] == pytest.approx(q.sum())


@pytest.mark.capability("12-59")
def test_figure_5_2() -> None:
    row = (0.7, 1.1, -0.4, 1.3)
    figure = mf.book.figure("5.2", **dict(zip(("alpha", "a", "d", "theta"), row, strict=True)))
    T = table([row])
    assert figure.objects["T"] == pytest.approx(T)
    assert figure["parameters"] == pytest.approx(row)
    points = drawn(figure)
    (start, foot), (low, high) = points("link", "a"), points("link", "d")
    assert np.linalg.norm(foot - start) == pytest.approx(1.1)
    assert (high - low) @ T[:3, 2] == pytest.approx(-0.4)
    assert foot == pytest.approx(low)
    assert high == pytest.approx(T[:3, 3])
    twist = points("link", r"$\alpha_{i-1}$") - foot
    assert twist[0] / 0.75 == pytest.approx([0, 0, 1])
    assert twist[-1] / 0.75 == pytest.approx(T[:3, 2])
    angle = points("link", r"$\theta_i$") - T[:3, 3]
    assert angle[-1] / 0.38 == pytest.approx(T[:3, 0])
    assert angle[0] / 0.38 == pytest.approx([1, 0, 0])  # from the direction of x_(i-1)
    for name in ("axis i-1", "axis i"):  # the common normal is across both axes
        assert np.diff(points("link", name), axis=0)[0] @ (foot - start) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.capability("12-60")
def test_figure_5_3() -> None:
    figure = mf.book.figure("5.3", alpha=-0.5, a=0.6, d=0.9, theta=0.4)
    T = table([(-0.5, 0.6, 0.9, 0.4)])
    assert figure.objects["T"] == pytest.approx(T)
    assert figure["parameters"] == pytest.approx([-0.5, 0.6, 0.9, 0.4])
    assert figure.objects["row"].kind == "P"
    longer = mf.book.figure("5.3", alpha=-0.5, a=0.6, d=1.1, theta=0.4)
    assert longer.objects["T"][:3, 3] - T[:3, 3] == pytest.approx(0.2 * T[:3, 2])
    assert artist_points(figure, "link", "d")[1] == pytest.approx(T[:3, 3])


@pytest.mark.capability("12-61")
def test_figure_5_4() -> None:
    figure = mf.book.figure("5.4", shift=0.5, tilt=0.9)
    for name, T in (("ab", shift(y=0.5)), ("ac", shift(0.9) @ about("y", 0.9))):
        assert figure.objects[f"T_{name}"] == pytest.approx(T)
        assert figure[name] == 0
        x, z = np.eye(3)[0], T[:3, 2]  # x_(i-1) has to meet z_i at a right angle
        assert abs(x @ z) > 1e-3 or abs(np.cross(x, z) @ T[:3, 3]) > 1e-3
        assert artist_points(figure, "frames", name)[1] == pytest.approx(T[:3, 3])
    assert not figure.objects["fits"]["ab"]
    assert mf.model.dh_frames.link_fit(table([(0.3, 0.5, 0.2, 1.0)]))


@pytest.mark.capability("12-62")
def test_figure_5_5() -> None:
    q = (0.4, -0.6, 0.9)
    figure = mf.book.figure("5.5", q1=q[0], q2=q[1], q3=q[2])
    half = np.pi / 2
    T = table([(0, 0, 0, q[0]), (half, 1.0, 0, q[1] - half), (-half, 0.8, 0, q[2])])
    assert artist_points(figure, "arm", "arm")[-1] == pytest.approx(T[:3, 3])
    assert figure["S3"] == pytest.approx([1, 0, 0, 0, -0.8, 0])
    assert not figure.facts[0].agrees
    S = np.array([[0, 0, 1, 0, 0, 0], [0, -1, 0, 0, 0, -1.0], [1, 0, 0, 0, -0.8, 0]])
    axes_are_drawn(mf.book.figure("5.5"), S)
    M = figure.objects["robot"].fk(np.zeros(3))
    product = exponential(S[0], q[0]) @ exponential(S[1], q[1]) @ exponential(S[2], q[2]) @ M
    assert product == pytest.approx(T)
    printed = exponential(S[0], q[0]) @ exponential(S[1], q[1]) @ exponential(S[2] * [1, 1, 1, 1, -1, 1], q[2]) @ M
    assert np.abs(printed - T).max() > 0.1  # the counterexample


@pytest.mark.capability("12-63")
def test_figure_5_6() -> None:
    figure = mf.book.figure("5.6", q3=0.8, q4=0.7)
    half = np.pi / 2
    T = table([(0, 0, 0, 0), (half, 0, 0, 0), (0, 1.0, 0, 0.8 + half), (half, 0, 0.7, 0)])
    assert artist_points(figure, "arm", "arm")[-1] == pytest.approx(T[:3, 3])
    assert figure["S3"] == pytest.approx([0, -1, 0, 0, 0, -1])
    S = np.array([[0, 0, 1, 0, 0, 0], [0, -1, 0, 0, 0, 0], [0, -1, 0, 0, 0, -1], [0, 0, 0, 1, 0, 0.0]])
    axes_are_drawn(mf.book.figure("5.6", q4=0.0), S)


@pytest.mark.capability("12-64")
def test_figure_5_7() -> None:
    zero = mf.book.figure("5.7")
    assert zero["rank"] == 4
    assert zero["wrist"] == pytest.approx([1.9, 0, 0])
    S = np.array([[0, 0, 1, 0, 0, 0], [0, -1, 0, 0, 0, 0], [0, -1, 0, 0, 0, -1], [1, 0, 0, 0, 0, 0],
                  [0, -1, 0, 0, 0, -1.9], [1, 0, 0, 0, 0, 0.0]])  # fmt: skip
    axes_are_drawn(zero, S)
    bent = mf.book.figure("5.7", q2=0.5, q3=-1.2, q5=0.6)
    wrist = [np.cos(0.5) + 0.9 * np.cos(0.7), 0, np.sin(0.5) - 0.9 * np.sin(0.7)]
    assert bent["wrist"] == pytest.approx(wrist)
    assert bent["rank"] == 6
    assert artist_points(bent, "arm", "arm")[-1] == pytest.approx(wrist)


@pytest.mark.capability("12-65")
def test_figure_5_8() -> None:
    q = (0.5, -0.7, 1.2)
    figure = mf.book.figure("5.8", q1=q[0], q2=q[1], q3=q[2])
    S = np.array([[0, 0, 1, 0, 0, 0], [0, -1, 0, 0, 0, -1.0], [1, 0, 0, 0, -0.8, 0]])
    T = figure.objects["robot"].fk(np.zeros(3))
    points = drawn(figure)
    for k in range(4):
        assert points(f"step_{k}", "arm")[-1] == pytest.approx(T[:3, 3])
        if k < 3:
            T = exponential(S[2 - k], q[2 - k]) @ T
            assert points(f"step_{k}", "axis 1")[0][:2] == pytest.approx([0, 0])
    assert figure["gap"] < 1e-12
    assert figure.objects["T"] == pytest.approx(T)


@pytest.mark.capability("12-66")
def test_figure_5_9() -> None:
    L = 0.8
    figure = mf.book.figure("5.9", L=L)
    S = np.array([[0, 0, 1, 0, 0, 0], [0, 1, 0, 0, 0, 0], [-1, 0, 0, 0, 0, 0], [-1, 0, 0, 0, 0, L],
                  [-1, 0, 0, 0, 0, 2 * L], [0, 1, 0, 0, 0, 0.0]])  # fmt: skip
    axes_are_drawn(figure, S)
    assert (figure["v4"][2], figure["v5"][2]) == (pytest.approx(L), pytest.approx(2 * L))
    assert figure["rank"] == np.linalg.matrix_rank(S) == 4
    assert [fact.agrees for fact in figure.facts[:2]] == [False, False]
    turned = mf.book.figure("5.9", L=L, q4=np.pi / 2)
    assert artist_points(turned, "arm", "arm")[-1] == pytest.approx([0, L, -2 * L], abs=1e-12)
    wrong = exponential(S[3] * [1, 1, 1, 1, 1, -1], np.pi / 2) @ shift(y=3 * L)
    assert wrong[:3, 3] == pytest.approx([0, -L, -4 * L])  # what the printed sign gives


@pytest.mark.capability("12-67")
def test_figure_5_10() -> None:
    figure = mf.book.figure("5.10")
    S = np.array([[0, 0, 1, 0, 0, 0], [1, 0, 0, 0, 0, 0], [0, 0, 0, 0, 1, 0], [0, 1, 0, 0, 0, 0],
                  [1, 0, 0, 0, 0, -1.0], [0, 1, 0, 0, 0, 0]])  # fmt: skip
    axes_are_drawn(figure, S)
    assert figure["rank"] == np.linalg.matrix_rank(S) == 5
    moved = mf.book.figure("5.10", q2=0.6, q3=0.4)
    T = exponential(S[1], 0.6) @ exponential(S[2], 0.4) @ shift(y=1.6)
    assert artist_points(moved, "arm", "arm")[-1] == pytest.approx(T[:3, 3])
