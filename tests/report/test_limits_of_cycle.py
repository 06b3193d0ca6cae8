"""What limits the cycle stands in the report and beside it, in both languages."""

from __future__ import annotations

import json

import numpy as np
import pytest

from mafsil.job import Run
from mafsil.job.judging.judgement import summary
from mafsil.job.planning.limiting import DECIDES
from mafsil.report import contents
from mafsil.report.results import as_data
from mafsil.report.run_tables import limit_plot


@pytest.mark.capability("11-47")
@pytest.mark.parametrize("language", ["en", "ar"])
def test_every_limit_has_its_row_and_what_it_would_save(small_run: Run, language: str) -> None:
    numbers = summary(small_run)
    page = contents.page(small_run, numbers, language)
    assert len(page.limit_table.rows) == len(small_run.limits) > 0
    best, row = small_run.limits[0], page.limit_table.rows[0]
    assert small_run.robot.joint_names[best.joint] in row[0]
    assert f"({100 * best.saved / numbers.cycle:.3g} %)" in row[2]
    other = contents.page(small_run, numbers, "ar" if language == "en" else "en")
    assert other.limit_table.head != page.limit_table.head


@pytest.mark.capability("11-47")
def test_the_plot_shows_which_limit_is_used_most(small_run: Run) -> None:
    t = np.linspace(0.0, small_run.plan.duration, 2001)
    (plot,) = limit_plot(small_run, t, "en")
    assert len(plot.names) == len(plot.keys) == plot.values.shape[1]
    assert plot.names[-1] == "other limits"
    assert np.nanmax(plot.values) <= 100.0 + 1e-3
    assert (np.nanmax(plot.values, axis=0)[:-1] >= 100.0 * DECIDES).all()
    # At every moment at most one curve goes on, and one more ends.
    assert np.isfinite(plot.values).sum(axis=1).max() <= 2


def test_results_hold_them_as_plain_data(small_run: Run) -> None:
    data = json.loads(json.dumps(as_data(small_run, summary(small_run)), allow_nan=False))["limits"]
    assert [one["quantity"] for one in data] == [one.quantity for one in small_run.limits]
    assert data[0]["joint"] in small_run.robot.joint_names
    assert data[0]["more"] == 0.1
