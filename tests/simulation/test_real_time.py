"""Against the clock: late ticks are counted, the worst lateness is said, a law that is too slow is named."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter, sleep

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import add_delay, computed_torque
from mafsil.errors import InputError
from mafsil.job import Run, parse_job, solve
from mafsil.simulation import Deadlines, Recording, Scenario, simulate
from mafsil.simulation.clock import RealTime
from mafsil.trajectory import quintic

ARM = mf.load("planar2r")
PATH = quintic([0, 0], [0.3, 0.2], 0.1)


class Slow:
    """A law that sleeps at some ticks."""

    def __init__(self, period, ticks):
        self.inner, self.length, self.late = computed_torque(ARM), 2.5 * period, ticks
        self.period = period

    def __call__(self, t, q, qd, reference):
        if round(t / self.period) in self.late:
            sleep(self.length)
        return self.inner(t, q, qd, reference)

    def session(self, period):
        return self


@pytest.mark.capability("10-2")
def test_what_a_slow_law_misses_is_counted_and_said(tmp_path):
    period = 0.02
    run = simulate(Scenario(robot=ARM, trajectory=PATH, law=Slow(period, (1, 3)), step=period), clock="real")
    found = Deadlines.of(run.metadata)
    assert run
    assert found is not None
    assert found.law == "Slow"
    assert 2 <= found.missed <= found.ticks == len(run.t)
    assert found.worst_lateness >= 1.5 * period
    assert f"{found.missed} of {found.ticks} deadlines" in run.explain("en")
    assert not found.law_is_slow or "slower than its period" in run.explain("en")
    run.save(tmp_path / "timed")
    assert Recording.load(tmp_path / "timed").explain("ar") == run.explain("ar")
    free = simulate(Scenario(robot=ARM, trajectory=PATH, law=Slow(period, ()), step=period))
    assert np.array_equal(free.q, run.q)
    assert "clock" not in free.metadata


def test_a_law_slower_than_its_period_is_named():
    law = add_delay(Slow(0.01, range(100)), 0.01)
    run = simulate(Scenario(robot=ARM, trajectory=PATH, law=law, step=0.01), clock="real")
    assert "The control law Slow is slower than its period" in run.explain("en")


def test_a_run_takes_as_long_as_the_motion_and_fusing_it_is_refused():
    scenario = Scenario(robot=ARM, trajectory=PATH, law=computed_torque(ARM))
    began = perf_counter()
    assert simulate(scenario, clock="real")
    assert perf_counter() - began > 0.1
    for options in ({"clock": "real", "fused": True}, {"clock": "fast"}):
        with pytest.raises(InputError):
            simulate(scenario, **options)


def test_counting_is_exact_on_a_clock_of_our_own():
    time = [0.0]
    clock = RealTime("law", 1.0, lambda: time[0], lambda left: time.__setitem__(0, time[0] + left + 5e-4))
    for law, work in ((0.2, 0.5), (1.5, 2.25), (0.1, 0.3)):
        clock.begin()
        start = time[0]
        time[0] = start + law
        clock.end_law()
        time[0] = start + work
        clock.end()
    found = clock.deadlines()
    assert (found.ticks, found.missed) == (3, 1)
    assert found.worst_lateness == pytest.approx(1.25)
    assert (found.law_mean, found.law_worst) == (pytest.approx(0.6), pytest.approx(1.5))
    both = Deadlines.of_all([found, found])
    assert (both.ticks, both.missed, both.law_mean) == (6, 2, pytest.approx(0.6))


def test_jobs_against_the_clock_say_what_they_missed():
    text = """
robot = "planar2r"
[simulation]
real_time = true
step = 0.01
settle = 0
[[move]]
joints = [0.2, 0.1]
duration = 0.6
"""
    run = solve(parse_job(text), text, Path())
    assert isinstance(run, Run)
    found = Deadlines.of(run.recording.metadata)
    assert found is not None
    assert any(remark.key == "job.deadlines" for remark in run.remarks)
    assert found.explain("en") in run.explain("en")
