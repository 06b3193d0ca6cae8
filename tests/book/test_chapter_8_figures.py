"""Figures of chapters 8 and 9: lengths of what is drawn, ranks and forms."""

import numpy as np
import pytest

import mafsil as mf
from tests.book.artists import artist_points


def length(points):
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


@pytest.mark.capability("12-87")
def test_figure_8_1() -> None:
    figure = mf.book.figure("8.1", height=1.3, turn=-0.4)
    legs = [artist_points(figure, "a", f"leg {k}") for k in range(1, 7)]
    assert [length(leg) for leg in legs] == pytest.approx(figure["lengths"])
    ends = np.array([leg[1] for leg in legs])
    assert np.linalg.norm(ends - [0.1, -0.2, 1.3], axis=1) == pytest.approx(1.0)
    assert np.linalg.norm([leg[0] for leg in legs], axis=1) == pytest.approx(2.0)
    assert figure["rank"] == 6


@pytest.mark.capability("12-88")
def test_figure_8_2() -> None:
    figure = mf.book.figure("8.2", q1=0.5, q2=-0.1, q3=0.3)
    for k, q in enumerate((0.5, -0.1, 0.3), start=1):
        hinge, elbow = artist_points(figure, "a", f"arm {k}")
        assert np.linalg.norm(elbow - hinge) == pytest.approx(0.5)
        assert elbow[2] == pytest.approx(-0.5 * np.sin(q))
        for side in (-1, 1):
            assert length(artist_points(figure, "a", f"rod {k} {side}")) == pytest.approx(1.0)
    assert figure["place"][2] < 0.0


@pytest.mark.capability("12-89")
def test_figure_8_3() -> None:
    figure = mf.book.figure("8.3", tilt=0.4)
    for k in range(1, 4):
        assert length(artist_points(figure, "a", f"rod {k}")) == pytest.approx(1.0)
        foot, top = artist_points(figure, "a", f"column {k}")
        assert np.hypot(*foot[:2]) == pytest.approx(1.0)
        assert (top - foot)[:2] == pytest.approx([0.0, 0.0])
    assert figure.status.name == "SCHEMATIC"


@pytest.mark.capability("12-90")
def test_figure_8_4() -> None:
    figure = mf.book.figure("8.4")
    assert figure["lengths"] == pytest.approx([1.928731305, 1.782230905, 1.639563681])
    assert figure["modes"] == 2
    assert [length(artist_points(figure, "a", f"leg {k}")) for k in (1, 2, 3)] == pytest.approx(figure["lengths"])


@pytest.mark.capability("12-91")
def test_figure_8_5() -> None:
    figure = mf.book.figure("8.5")
    assert (figure["mobility"], figure["gap"]) == (3, pytest.approx(0.0, abs=1e-9))
    driven = (0.1, -0.05, 0.15)
    for k, stroke in enumerate(driven, start=1):
        chain = artist_points(figure, "a", f"chain {k}")
        assert np.linalg.norm(chain[-1] - chain[0]) == pytest.approx(np.sqrt(1.25) + stroke)


@pytest.mark.capability("12-92")
def test_figure_8_6() -> None:
    figure = mf.book.figure("8.6", crank=2.0)
    assert (figure["printed_crossings"], figure["crossings"]) == (0, 1)
    assert figure["apart"] == pytest.approx(1.268, abs=1e-3)
    assert artist_points(figure, "c", "crossing")[0] == pytest.approx([np.pi, np.pi])
    for panel, (a, b, c, d) in (("b", (4, 4, 3, 2)), ("c", (4, 3, 3, 2))):
        points = np.vstack([artist_points(figure, panel, f"branch {k}") for k in (0, 1)])
        theta, phi = points[~np.isnan(points).any(axis=1)].T
        coupler = np.hypot(a * np.cos(theta) - d - c * np.cos(phi), a * np.sin(theta) - c * np.sin(phi))
        assert coupler == pytest.approx(b)


@pytest.mark.capability("12-93")
def test_figure_8_7() -> None:
    figure = mf.book.figure("8.7", alpha=1.7, beta=0.9)
    bars = artist_points(figure, "a", "bars")
    assert np.linalg.norm(np.diff(bars, axis=0), axis=1) == pytest.approx([2, 3, 3, 2])
    assert bars[-1] == pytest.approx([2.0, 0.0])
    assert bars[3] - bars[4] == pytest.approx([2 * np.cos(0.9), 2 * np.sin(0.9)])
    headings = np.arctan2(*np.diff(bars, axis=0).T[::-1])
    assert np.exp(1j * np.cumsum(figure["theta"])[:4]) == pytest.approx(np.exp(1j * headings))


@pytest.mark.capability("12-94")
def test_figure_8_8() -> None:
    figure = mf.book.figure("8.8")
    assert figure["rank"] == [2, 2, 2]
    for panel in "abc":
        bars = artist_points(figure, panel, "bars")
        assert bars[:, 1] == pytest.approx(0.0, abs=1e-12)
        assert bars[-1, 0] == pytest.approx(2.0)


@pytest.mark.capability("12-95")
def test_figure_8_9() -> None:
    figure = mf.book.figure("8.9")
    assert figure.objects["kinds"] == {"a": "NONDEGENERATE", "b": "DEGENERATE"}
    assert (abs(figure["form_a"]), figure["form_b"]) == (pytest.approx(0.2357, abs=1e-4), pytest.approx(0.0, abs=1e-12))
    stretched, folded = (artist_points(figure, panel, "bars") for panel in "ab")
    assert stretched[2] - stretched[1] == pytest.approx(stretched[3] - stretched[2])
    assert folded[1] == pytest.approx(folded[3])
    assert len(artist_points(figure, "a", "driven")) == 2


@pytest.mark.capability("12-96")
def test_figure_8_10() -> None:
    figure = mf.book.figure("8.10")
    along = np.radians(75.0)
    assert figure["blocked"] == pytest.approx([np.cos(along), np.sin(along)], abs=1e-6)
    first, last = artist_points(figure, "a", "blocked")
    bars = artist_points(figure, "a", "bars")
    assert (first + last) / 2 == pytest.approx(bars[2])
    assert np.linalg.det([last - first, bars[2] - bars[0]]) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.capability("12-97")
def test_figure_9_1() -> None:
    for elbow in (0.9, -1.4):
        figure = mf.book.figure("9.1", elbow=elbow)
        start, end = artist_points(figure, "a", "link")
        assert start == pytest.approx([np.cos(0.4), np.sin(0.4)])
        assert end - start == pytest.approx(0.8 * np.array([np.cos(0.4 + elbow), np.sin(0.4 + elbow)]))
        tail, tip = artist_points(figure, "a", "weight")
        assert tail == pytest.approx((start + end) / 2)
        assert (tip - tail)[0] == pytest.approx(0.0)
        assert (tip - tail)[1] < 0.0
