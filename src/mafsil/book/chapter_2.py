"""Figures of chapter 2: configurations, joints, linkages, their freedoms, the torus, task spaces."""

from __future__ import annotations

from math import pi

import numpy as np

from mafsil.book.drawing import add_linkage, sphere
from mafsil.book.entry import Fact, Slider
from mafsil.book.figure import Drawing, draws
from mafsil.figures.panel import ACCENT, BLUE, INK, SOFT, Panel
from mafsil.mobility import FourBar, SliderCrank, mobility, torus


@draws("2.5", crank=Slider(-pi, pi, 1.0))
def four_bar_and_slider_crank(crank: float) -> Drawing:
    """Four-bar and slider-crank at one angle of their cranks, counted."""
    four_bar = FourBar(2.0, 4.0, 3.5, 4.5).linkage(crank)
    slider = SliderCrank(1.0, 3.0).linkage(crank)
    counts = [mobility(each).count.mobility for each in (four_bar, slider)]
    panels = {"a": add_linkage(Panel(), four_bar), "b": add_linkage(Panel(), slider)}
    facts = Fact("four_bar", counts[0], 1), Fact("slider_crank", counts[1], 1)
    return Drawing(panels, {"four_bar": four_bar, "slider_crank": slider}, facts)


@draws("2.11", a=Slider(0.0, 2 * pi, 0.9), b=Slider(0.0, 2 * pi, 2.2))
def torus_of_two_joints(a: float, b: float) -> Drawing:
    """The square of two angles, whose opposite sides are one, and the torus that it closes to."""
    both = np.stack(np.meshgrid(np.linspace(0, 2 * pi, 49), np.linspace(0, 2 * pi, 25)), axis=-1)
    point = torus.embedded([a, b])
    square = Panel((r"$\theta_1$ [rad]", r"$\theta_2$ [rad]"), limits=(-0.6, 6.9, -0.6, 6.9))
    for k, colour in enumerate((ACCENT, BLUE)):
        for side in (0.0, 2 * pi):
            ends = np.array([[side, 0.0], [side, 2 * pi]])[:, :: 1 - 2 * k]
            square.line(ends, colour, width=2.4, name=f"side {k} {side:.0f}")
            square.arrow(ends[0], 0.55 * (ends[1] - ends[0]), colour=colour, width=2.4)
    square.dots([a, b], INK, width=8.0, name="point")
    solid = Panel(elevation=50.0).surface(torus.embedded(both), name="torus")
    turn = np.linspace(0, 2 * pi, 97)
    for axis, colour in ((1, ACCENT), (0, BLUE)):
        seam = np.zeros((97, 2))
        seam[:, axis] = turn
        solid.line(torus.embedded(seam), colour, width=2.4, name=f"seam {1 - axis}")
    solid.dots(point, INK, width=8.0, name="point")
    facts = (Fact("place", point, unit="m"), Fact("dimension", 2, 2))
    return Drawing({"a": square, "b": solid}, {"angles": np.array([a, b])}, facts)


@draws("2.1", door=Slider(0.0, 2.0, 0.8), heading=Slider(-pi, pi, 0.5))
def configurations_of_three_bodies(door: float, heading: float) -> Drawing:
    """A door by one number, a point of the plane by two, a coin on a table by three."""
    edge = np.array([np.cos(door), np.sin(door)])
    opened = Panel().line([[-0.5, 0], [0, 0]], SOFT, width=6.0).line([[0, 0], edge], BLUE, width=4.0, name="door")
    opened.dots([0, 0], name="hinge").arc([0, 0], 0.4, (0.0, door), r"$\theta$", name="angle")
    opened.line([[0, 0], [1.05, 0]], SOFT, "--")
    place = np.array([1.2, 0.8])
    flat = _corner(Panel(), 1.6).dots(place, ACCENT, width=8.0, name="point").label(place, "$(x, y)$", offset=(14, 14))
    flat.line([[place[0], 0], place, [0, place[1]]], SOFT, "--")
    coin = _corner(Panel(), 1.6).fill(place + 0.45 * sphere(1.0)[12, :-1, :2], BLUE, name="coin")
    coin.dots(place, name="centre").label(place, "$(x, y)$", offset=(0, -12))
    coin.arrow(place, 0.45 * np.array([np.cos(heading), np.sin(heading)]), r"$\varphi$", name="mark", reach=1.3)
    facts = [Fact(name, value, value) for name, value in (("door", 1), ("point", 2), ("coin", 3))]
    return Drawing({"a": opened, "b": flat, "c": coin}, {"door": door, "point": place, "heading": heading}, facts)


def _corner(panel: Panel, length: float) -> Panel:
    """Axes x and y of {s} from the origin."""
    return panel.frame(np.eye(3), length, "s")
