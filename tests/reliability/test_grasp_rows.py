"""Rows R12 and R14 at the size of a pull request; any size by `python -m tests.reliability.grasps` and `.programs`."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil.grasp.contact_batch import wrench_closures
from mafsil.solvers.rational import Location, locate_origin
from tests.reliability import grasps, programs


@pytest.mark.row("R12")
@pytest.mark.capability("03-38", "03-48", "03-59")
def test_three_methods_agree_on_grasps_and_boundaries_are_marginal() -> None:
    count = grasps.work(1, 20_000)
    assert count["grasps"] == 20_000
    assert 1_000 < count["closed"] < 19_500
    assert not [name for name, value in count.items() if name.startswith("bad_") and value], count


@pytest.mark.row("R12")
def test_the_integer_method_is_exact() -> None:
    W = grasps.plane_grasps(np.random.default_rng(0), 300)
    exact = [locate_origin(A.T.tolist()).place is Location.INSIDE for A in W]
    assert grasps.exactly_closed(W).tolist() == exact


@pytest.mark.row("R14")
@pytest.mark.capability("03-48")
def test_programs_are_optimal_and_agree_with_highs() -> None:
    count = programs.work(1, 20_000)
    assert count["asked_of_highs"] >= 200
    assert not [name for name, value in count.items() if name.startswith("bad_") and value], count


@pytest.mark.row("R14")
def test_repeated_and_opposite_columns_do_not_confuse_the_program() -> None:
    W = programs.degenerate_programs(np.random.default_rng(4), 300)
    exact = [locate_origin(A.T.tolist()).place is Location.INSIDE for A in W]
    assert wrench_closures(W).force_closure.tolist() == exact
