"""The tangent construction of Newton's method in one dimension."""

import numpy as np
import pytest

from mafsil.errors import InputError
from mafsil.figures import plot_newton_tangents
from mafsil.figures.ik_constructions import _drawn
from mafsil.ik import find_root


def cubic(x):
    return x**3 - 2 * x - 5


@pytest.mark.capability("07-37")
def test_every_tangent_goes_from_the_graph_to_the_next_iterate(tmp_path):
    record = plot_newton_tangents(cubic, 3.5, tmp_path / "tangents.png", lambda x: np.array([[3 * x[0] ** 2 - 2]]))
    assert (tmp_path / "tangents.png").stat().st_size > 5000
    assert record.iterations == 4
    lines = [line.get_xydata() for line in _drawn(cubic, record).axes[0].lines]
    tangents = [line for line in lines if len(line) == 2 and line[1, 1] == 0.0 and line[0, 1] != 0.0]
    assert len(tangents) == 4
    x = 3.5
    for (a, height), (b, _) in tangents:
        assert a == pytest.approx(x, abs=1e-12)
        assert height == pytest.approx(a**3 - 2 * a - 5, abs=1e-9)
        x = a - (a**3 - 2 * a - 5) / (3 * a**2 - 2)
        assert b == pytest.approx(x, abs=1e-12)


def test_a_level_tangent_is_refused(tmp_path):
    with pytest.raises(InputError, match="level"):
        plot_newton_tangents(lambda x: x**2 + 1, 0.0, tmp_path / "a.png", lambda x: np.array([[2 * x[0]]]))


def test_the_iteration_is_that_of_find_root(tmp_path):
    record = plot_newton_tangents(cubic, 3.0, tmp_path / "a.svg", steps=3)
    np.testing.assert_array_equal(record.iterates, find_root(cubic, [3.0], max_steps=3).iterates)
