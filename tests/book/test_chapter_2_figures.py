"""Figures of chapter 2: counts, places and what is drawn there."""

import numpy as np
import pytest

import mafsil as mf
from tests.book.artists import artist_points


@pytest.mark.capability("12-15")
def test_figure_2_1() -> None:
    door, heading = 0.7, -2.0
    figure = mf.book.figure("2.1", door=door, heading=heading)
    assert [figure[name] for name in ("door", "point", "coin")] == [1, 2, 3]
    assert artist_points(figure, "a", "door")[1] == pytest.approx([np.cos(door), np.sin(door)])
    tail, tip = artist_points(figure, "c", "mark")
    assert np.arctan2(*(tip - tail)[::-1]) == pytest.approx(heading)
    rim = artist_points(figure, "c", "coin")
    assert np.linalg.norm(rim - tail, axis=1) == pytest.approx(np.linalg.norm(tip - tail))


@pytest.mark.capability("12-19")
def test_figure_2_5() -> None:
    for crank in (-2.0, 0.4, 1.0):
        figure = mf.book.figure("2.5", crank=crank)
        lengths = {"crank": 2.0, "coupler": 4.0, "rocker": 3.5}
        for name, length in lengths.items():
            assert np.linalg.norm(np.diff(artist_points(figure, "a", name), axis=0)) == pytest.approx(length)
        for name in "ABCD":
            (pin,) = artist_points(figure, "a", f"joint {name}")
            ends = [artist_points(figure, "a", body) for body in lengths]
            assert min(np.linalg.norm(points - pin, axis=1).min() for points in ends) < 1e-9
        assert artist_points(figure, "a", "joint B")[0] == pytest.approx(2 * np.array([np.cos(crank), np.sin(crank)]))
        (block,) = artist_points(figure, "b", "joint C")
        assert block == pytest.approx([np.cos(crank) + np.sqrt(9 - np.sin(crank) ** 2), 0.0])
    assert (figure["four_bar"], figure["slider_crank"]) == (3 * (4 - 1 - 4) + 4,) * 2


@pytest.mark.capability("12-25")
def test_figure_2_11() -> None:
    a, b = 5.0, 1.2
    figure = mf.book.figure("2.11", a=a, b=b)
    (point,) = artist_points(figure, "b", "point")
    out = 2.0 + 0.7 * np.cos(b)
    assert point == pytest.approx([out * np.cos(a), out * np.sin(a), 0.7 * np.sin(b)])
    assert figure["place"] == pytest.approx(point)
    for k in (0, 1):
        first, second = (artist_points(figure, "a", f"side {k} {side}") for side in (0, 6))
        glued = [[mf.mobility.torus.embedded(end) for end in side] for side in (first, second)]
        assert glued[0] == pytest.approx(np.array(glued[1]))
        seam = artist_points(figure, "b", f"seam {k}")
        assert seam[0] == pytest.approx(glued[0][0])
        assert seam[0] == pytest.approx(seam[-1])
