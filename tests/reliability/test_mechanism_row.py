"""Row R9 at the size of a pull request; any size by `python -m tests.reliability.mechanisms`."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil import mobility as mo
from tests.reliability.over_constrained import BUILDERS, composed

pytest.importorskip("pinocchio")
mechanisms = pytest.importorskip("tests.reliability.mechanisms")


@pytest.mark.row("R9")
@pytest.mark.capability("02-47", "02-51", "02-59")
def test_ranks_are_those_of_pinocchio() -> None:
    count = mechanisms.work(7, 100)
    assert count["configurations"] > 150
    assert count["over_constrained"] == 10
    assert not [name for name, value in count.items() if name.startswith("bad_") and value], count


@pytest.mark.row("R9")
@pytest.mark.capability("02-51")
@pytest.mark.parametrize("name", BUILDERS)
def test_finite_mobility_of_mechanisms_that_a_theorem_knows(name: str) -> None:
    for seed in range(3):
        linkage, expected = composed(np.random.default_rng([11, seed]), [name])
        assert mo.finite_mobility(linkage).mobility == expected, seed


@pytest.mark.row("R9")
def test_mechanisms_hung_on_each_other_add_their_mobilities() -> None:
    for seed in range(4):
        linkage, expected = composed(np.random.default_rng([12, seed]), ["bennett", "sarrus", "parallel_cranks"])
        assert mo.mobility(linkage).mobility == expected, seed
