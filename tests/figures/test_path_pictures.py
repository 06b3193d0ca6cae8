"""The phase plane of a timed path and the difficulties of a diagnosed one: what is said stands in the picture."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil import Robot, figures
from mafsil.errors import InputError
from mafsil.figures import motion_over_time
from mafsil.model.library.textbook import planar2r
from mafsil.trajectory import JointPath, MotionLimits, diagnose_path, line_path, time_optimal

POINTS = np.array([[0.0, 0.0], [1.0, 0.5], [1.5, -0.5], [0.2, -0.8]])


def drawn(monkeypatch, module):
    """The figures that a module saves."""
    found = []
    monkeypatch.setattr(module, "save", lambda figure, path: found.append(figure))
    return found


@pytest.mark.parametrize(("jerk", "slack"), [(np.inf, 1e-6), (60.0, 1e-3)])
def test_the_phase_plane_shows_the_motion_below_the_limit_curve(monkeypatch, jerk, slack):
    timed = time_optimal(JointPath.through(POINTS), MotionLimits.of(2, velocity=1.5, acceleration=4.0, jerk=jerk))
    found = drawn(monkeypatch, motion_over_time)
    figures.plot_phase_plane(timed, "plane.png", language="en")
    (axes,) = found[0].axes
    limit, *parts = axes.lines
    assert len(parts) == len(timed.bindings)
    names = {line.get_label() for line in parts}
    assert names == {f"the {one.quantity} {one.joint}" for one in timed.bindings}
    s = np.concatenate([line.get_xdata() for line in parts])
    rate = np.concatenate([line.get_ydata() for line in parts])
    assert s[0] == pytest.approx(0.0)
    assert s[-1] == pytest.approx(timed.path.end)
    # Between places of the grid squares of rates are linear.
    above = rate**2 - np.interp(s, limit.get_xdata(), limit.get_ydata() ** 2)
    assert above.max() < slack * rate.max() ** 2


def test_difficulties_are_shaded_numbered_and_said(monkeypatch):
    T_0, T_1 = np.eye(4), np.eye(4)
    T_0[:2, 3], T_1[:2, 3] = (1, 0.3), (-1, 0.3)
    diagnosis = diagnose_path(Robot(planar2r((1.0, 0.5))), line_path(T_0, T_1), task="position")
    found = drawn(monkeypatch, motion_over_time)
    figures.plot_path_difficulties(diagnosis, "why.png", language="en")
    (figure,) = found
    assert len(figure.axes) == 2
    for axes in figure.axes:
        (shaded,) = axes.patches
        x = shaded.get_x(), shaded.get_x() + shaded.get_width()
        np.testing.assert_allclose(x, [0.3, 0.7], atol=1e-9)
    text = " ".join(figure._supxlabel.get_text().split())
    assert text.startswith("1. ")
    assert " ".join(diagnosis.difficulties[0].explain("en").split()) in text


def test_files_and_wrong_arguments(tmp_path):
    timed = time_optimal(JointPath.through(POINTS), MotionLimits.of(2, velocity=1.5, acceleration=4.0))
    figures.plot_phase_plane(timed, tmp_path / "plane.svg", language="ar")
    assert (tmp_path / "plane.svg").stat().st_size > 1000
    for save in (figures.plot_phase_plane, figures.plot_path_difficulties):
        with pytest.raises(InputError):
            save(3, tmp_path / "x.png")
        with pytest.raises(InputError):
            save(timed, tmp_path / "x.txt")
