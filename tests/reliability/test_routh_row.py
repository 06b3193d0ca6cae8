"""Row R22, Routh's array against the roots, at the size of a pull request."""

from __future__ import annotations

import pytest

from tests.reliability import routh_roots


@pytest.mark.row("R22")
@pytest.mark.capability("10-23")
def test_routh_against_the_roots():
    found = routh_roots.work(0, 20_000)
    assert not any(value for name, value in found.items() if name.startswith("bad_"))
    assert found["polynomials"] == 20_000
    assert found["stable"] > 2_500
    assert found["unclear"] < 200
