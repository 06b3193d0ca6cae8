"""Rows R3 and V1 at the size of a pull request; `tests.reliability.derivatives` and `.slips` go on to any size."""

from __future__ import annotations

import pytest

from tests.reliability import derivatives, slips


@pytest.mark.capability("09-20", "09-56", "09-67")
@pytest.mark.row("R3")
@pytest.mark.parametrize("subject", [("planar3r", 0), ("stanford_arm", 0), ("tree", 3)], ids=lambda x: x[0])
def test_derivative_kernels_agree_with_the_complex_step_and_both_modes(subject: tuple[str, int]) -> None:
    count = derivatives.work(derivatives.subjects().index(subject), 20)
    assert count["cases"] == 20
    assert {name: value for name, value in count.items() if name.startswith("bad_") and value} == {}
    assert sum(name.startswith("bad_") for name in count) == 13


@pytest.mark.row("R3")
def test_a_wrong_derivative_is_seen() -> None:
    """The histogram counts what lies beyond the limit, and NaN."""
    assert derivatives.histogram("x", derivatives.np.array([1e-16, 1e-12, 2e-11, float("nan")]))["bad_x"] == 2
    assert derivatives.histogram("modes_of_x", derivatives.np.array([1e-13, 2e-12]))["bad_modes_of_x"] == 1


def test_no_slip_of_a_whole_arm_survives() -> None:
    """Every operation of every routine exchanged in turn, on the smallest arm; larger ones from the command line."""
    found = slips.work(slips.ARMS.index("planar2r_point_masses"), 1)
    assert found["mutants"] > 500
    assert found["bad_survivors"] == 0
