"""What is touched, in pictures: the same bytes for the same numbers, words of both languages, curves that are exact."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil.control import Impedance, constraint_table
from mafsil.errors import InputError, MafsilError
from mafsil.figures import plot_constrained_task, plot_virtual_impedance
from mafsil.figures.touching import push_response
from mafsil.messages import say

NAMES = ("wx", "wy", "wz", "x", "y", "z")
TABLE = constraint_table((True, True, False, False, False, True), (0, 0, 0, 0.1, 0, -5), NAMES)
TOOL = Impedance.of(1, inertia=0.8, damping=6.0, stiffness=60.0)


@pytest.mark.capability("10-108", "10-71", "10-85")
@pytest.mark.parametrize("language", ["en", "ar"])
def test_pictures_are_reproducible_and_speak(language, tmp_path):
    for k in range(2):
        plot_constrained_task(np.eye(4), TABLE, tmp_path / f"task{k}.svg", language=language)
        plot_virtual_impedance(TOOL, tmp_path / f"felt{k}.svg", push=2.0, language=language)
    for name in ("task", "felt"):
        first, second = ((tmp_path / f"{name}{k}.svg").read_text("utf-8") for k in range(2))
        assert first == second
    assert f"<!-- {TABLE[5].artificial} -->" in (tmp_path / "task0.svg").read_text("utf-8")
    assert say("pictures.hand", language=language) in (tmp_path / "felt0.svg").read_text("utf-8")


@pytest.mark.parametrize(("m", "b", "k"), [(0.8, 6.0, 60.0), (1.0, 0.0, 4.0), (2.0, 3.0, 0.0), (1.0, 0.0, 0.0)])
def test_the_answer_to_a_push_solves_its_equation(m, b, k):
    """By differences of the curve, which know nothing of exponentials."""
    t, x = push_response(m, b, k, 3.0)
    h = t[1] - t[0]
    v, a = (x[2:] - x[:-2]) / (2 * h), (x[2:] - 2 * x[1:-1] + x[:-2]) / h**2
    assert np.abs(m * a + b * v + k * x[1:-1] - 3.0).max() < 2e-2
    assert x[0] == 0.0
    if b and k:
        assert x[-1] == pytest.approx(3.0 / k, rel=0.01)


def test_what_cannot_be_drawn_is_refused(tmp_path):
    with pytest.raises(InputError, match="impedance"):
        plot_virtual_impedance(Impedance.of(2, inertia=1.0), tmp_path / "a.svg")
    with pytest.raises(InputError, match="mass"):
        plot_virtual_impedance(Impedance.of(1, stiffness=1.0), tmp_path / "a.svg")
    with pytest.raises(InputError, match="push"):
        plot_virtual_impedance(TOOL, tmp_path / "a.svg", push=np.nan)
    with pytest.raises(MafsilError):
        plot_constrained_task(2.0 * np.eye(4), TABLE, tmp_path / "a.svg")
    with pytest.raises(InputError, match="constraints"):
        plot_constrained_task(np.eye(4), ["dx/dt = 0"], tmp_path / "a.svg")
    with pytest.raises(InputError, match="half_width"):
        plot_constrained_task(np.eye(4), TABLE, tmp_path / "a.svg", half_width=0.0)
