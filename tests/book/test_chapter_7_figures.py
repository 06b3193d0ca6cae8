"""Figures of chapter 7: angles against plain trigonometry, and where they are drawn."""

import numpy as np
import pytest

import mafsil as mf
from tests.book.artists import artist_points

CENTRE = np.array([0.4, 0.3, 0.9])


def wrist(q, offset=0.0):
    """Wrist centre of an arm with h 0.6, a1 0.5, a2 0.4 by the formulas of the plane."""
    rho = 0.5 * np.cos(q[1]) + 0.4 * np.cos(q[1] + q[2])
    rise = 0.5 * np.sin(q[1]) + 0.4 * np.sin(q[1] + q[2])
    c, s = np.cos(q[0]), np.sin(q[0])
    return np.array([rho * c - offset * s, rho * s + offset * c, 0.6 + rise])


@pytest.mark.capability("12-77")
def test_figure_7_1() -> None:
    for x, y in ((2.0, 1.0), (-1.0, 1.6)):
        figure = mf.book.figure("7.1", x=x, y=y)
        for name, sign in (("down", 1), ("up", -1)):
            q = figure[name]
            assert np.sign(q[1]) == sign
            tip = [2 * np.cos(q[0]) + 1.5 * np.cos(q.sum()), 2 * np.sin(q[0]) + 1.5 * np.sin(q.sum())]
            assert tip == pytest.approx([x, y])
            assert artist_points(figure, "a", name)[-1] == pytest.approx([x, y])
        radii = [np.linalg.norm(artist_points(figure, "a", name), axis=1) for name in ("inner", "outer")]
        assert np.ptp(radii, axis=1) == pytest.approx(0.0, abs=1e-12)
        assert [each[0] for each in radii] == pytest.approx([0.5, 3.5])
    printed = next(fact for fact in mf.book.figure("7.1").facts if fact.name == "cosine")
    assert printed.printed == pytest.approx(1.2578, abs=1e-4)
    assert not printed.agrees


@pytest.mark.capability("12-78")
def test_figure_7_2() -> None:
    for branch in range(4):
        figure = mf.book.figure("7.2", branch=branch)
        assert artist_points(figure, "a", "arm")[-1] == pytest.approx(CENTRE)
        assert abs(np.sin(figure["theta_1"] - np.arctan2(0.3, 0.4))) < 1e-9
        assert artist_points(figure, "a", "projection")[1] == pytest.approx([0.4, 0.3, 0.0])
    assert figure["solutions"] == 4
    assert all(wrist(q) == pytest.approx(CENTRE) for q in figure.objects["solutions"])


@pytest.mark.capability("12-79")
def test_figure_7_3() -> None:
    for offset in (0.15, 0.3):
        figure = mf.book.figure("7.3", offset=offset)
        reach = np.sqrt(0.25 - offset**2)
        for name, side in (("left", 1), ("right", -1)):
            assert figure[name] == pytest.approx(np.arctan2(0.3, 0.4) - np.arctan2(offset, side * reach))
            assert artist_points(figure, "b", name)[-1] == pytest.approx([0.4, 0.3])
    assert "phi - alpha" in figure.erratum


@pytest.mark.capability("12-80")
def test_figure_7_4() -> None:
    figure = mf.book.figure("7.4", free=1.3)
    assert figure["families"] == 2
    assert figure["elbow"] == pytest.approx(1.696124, abs=1e-6)
    for k in range(3):
        assert artist_points(figure, "a", f"arm {k}")[-1] == pytest.approx([0.0, 0.0, 1.2])


@pytest.mark.capability("12-81")
def test_figure_7_5() -> None:
    figure = mf.book.figure("7.5")
    postures = [figure[f"posture_{k}"] for k in range(4)]
    assert len({tuple(np.round(q, 6)) for q in postures}) == 4
    for panel, q in zip("abcd", postures, strict=True):
        assert wrist(q, 0.15) == pytest.approx(CENTRE)
        assert artist_points(figure, panel, "arm")[-1] == pytest.approx(CENTRE)
        assert ("left" in figure.words(panel, "en")) == (abs(q[0]) < np.pi / 2)
        elbow = artist_points(figure, panel, "arm")[3]
        assert ("elbow up" in figure.words(panel, "en")) == (elbow[2] > 0.75)


@pytest.mark.capability("12-82")
def test_figure_7_6() -> None:
    figure = mf.book.figure("7.6")
    directions = [np.diff(artist_points(figure, "a", f"axis {k}"), axis=0)[0] for k in range(1, 7)]
    assert directions[0] @ directions[1] == pytest.approx(0.0, abs=1e-12)
    assert directions[3] @ directions[4] == pytest.approx(0.0, abs=1e-12)
    for k in (4, 5, 6):
        assert artist_points(figure, "a", f"axis {k}").mean(axis=0) == pytest.approx(figure["wrist"])


@pytest.mark.capability("12-83")
def test_figure_7_7() -> None:
    for distance, count in ((0.9, 2), (1.4, 2), (2.6, 0)):
        figure = mf.book.figure("7.7", distance=distance)
        assert figure["count"] == count
        for k in range(count):
            (z,) = artist_points(figure, "a", f"reached {k}")
            assert np.hypot(*z) == pytest.approx(distance)
            assert np.linalg.norm(z - [1.0, 0.4]) == pytest.approx(1.0)


@pytest.mark.capability("12-84")
def test_figure_7_8() -> None:
    figure = mf.book.figure("7.8", turn_1=0.7, turn_2=-0.4)
    assert figure["count"] == 2
    assert np.abs(figure["turns"] - [0.7, -0.4]).max(axis=1).min() < 1e-9
    p1, p2 = (artist_points(figure, "a", f"p w_{k}")[0] for k in (1, 2))
    for k in range(2):
        (z,) = artist_points(figure, "a", f"z {k}")
        assert (np.linalg.norm(z), z[2], z[1]) == pytest.approx((1.0, p1[2], p2[1]))


@pytest.mark.capability("12-85")
def test_figure_7_9() -> None:
    figure = mf.book.figure("7.9")
    assert figure["stroke"] == pytest.approx(np.sqrt(0.4**2 + 0.3**2 + 0.3**2) - 0.5)
    assert figure["joints"] == pytest.approx([np.arctan2(0.3, 0.4), np.arctan2(0.3, 0.5), figure["stroke"]])
    assert artist_points(figure, "a", "rod")[-1] == pytest.approx(CENTRE)


@pytest.mark.capability("12-86")
def test_figure_7_10() -> None:
    figure = mf.book.figure("7.10", start=3.2)
    assert figure["root"] == pytest.approx(np.sqrt(2))
    x = 3.2
    for k in range(3):
        top, foot = artist_points(figure, "a", f"tangent {k}")
        assert top == pytest.approx([x, x**2 - 2])
        x = x - (x**2 - 2) / (2 * x)
        assert foot == pytest.approx([x, 0.0], abs=1e-12)
