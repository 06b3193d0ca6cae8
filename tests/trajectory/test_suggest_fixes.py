"""Fixes of impossible motions: every remedy makes the motion possible, and no smaller one of its kind does."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.trajectory import MotionLimits, check, suggest_fixes
from mafsil.trajectory.feasibility import RemedyKind
from mafsil.trajectory.feasibility.diagnosis import GROWTH, RequestStatus, is_possible
from tests.sizes import few

LIMITS = MotionLimits.of(3, velocity=[1.5, 2.0, 1.0], acceleration=[8.0, 6.0, 9.0], jerk=400.0, position=2.5)


def broken_request(seed):
    rng = np.random.default_rng(seed)
    k = int(rng.integers(1, 6))
    points = np.cumsum(rng.uniform(-0.6, 0.6, (k + 1, 3)), axis=0).clip(-2.0, 2.0)
    return points, rng.uniform(0.02, 0.2, k), ("spline", "stops")[seed % 2]


@cache
def diagnosed(seed):
    points, durations, curve = broken_request(seed)
    return suggest_fixes(points, durations, LIMITS, curve=curve)


SEEDS = few(range(100), 6)


@pytest.mark.parametrize("seed", SEEDS)
def test_each_of_a_hundred_broken_requests_is_mended_by_the_least_change(seed):
    durations, diagnosis = broken_request(seed)[1], diagnosed(seed)
    assert not diagnosis
    assert diagnosis.status is RequestStatus.MENDABLE
    for remedy in diagnosis.remedies:
        assert check(remedy.request.trajectory(), LIMITS)
        if remedy.kind is RemedyKind.SLOWER:
            assert not is_possible(diagnosis.request.slower(remedy.factor * (1 - 1e-6)))
            np.testing.assert_allclose(remedy.request.durations, remedy.factor * durations)
        if remedy.kind is RemedyKind.SLOWER_LEG:
            leg = remedy.place - 1
            for smaller in (remedy.factor * (1 - 1e-6), 1 + (remedy.factor - 1) / 2):
                if smaller * GROWTH**2 > remedy.factor:
                    assert not is_possible(diagnosis.request.slower(smaller, leg))
    assert check(diagnosis.apply_fix(), LIMITS)


@pytest.mark.parametrize("seed", SEEDS[:6])
def test_every_obstruction_stands_on_the_leg_and_at_the_time_that_it_names(seed):
    durations, diagnosis = broken_request(seed)[1], diagnosed(seed)
    motion, ends = diagnosis.request.trajectory(), np.concatenate([[0.0], np.cumsum(durations)])
    orders = {"lower": 0, "upper": 0, "velocity": 1, "acceleration": 2}
    for obstruction in diagnosis:
        worst = obstruction.violation
        assert ends[obstruction.leg - 1] - 1e-9 <= worst.time <= ends[obstruction.leg] + 1e-9
        if worst.quantity in orders:
            here = motion.at(worst.time)[orders[worst.quantity]][int(worst.joint)]
            just_before = motion.at(np.nextafter(worst.time, 0.0))[orders[worst.quantity]][int(worst.joint)]
            assert min(abs(here - worst.value), abs(just_before - worst.value)) < 1e-9 * max(1.0, abs(worst.value))
        assert abs(worst.value) > abs(worst.limit)


def test_slowing_never_mends_a_spline_that_leaves_the_range_but_a_stop_does():
    points = [[0.0], [1.0], [2.0], [0.5]]
    diagnosis = suggest_fixes(points, [1.0, 1.0, 1.0], MotionLimits.of(1, position=2.001))
    assert {obstruction.violation.quantity for obstruction in diagnosis} == {"upper"}
    kinds = {remedy.kind for remedy in diagnosis.remedies}
    assert RemedyKind.SLOWER not in kinds
    assert RemedyKind.STOP in kinds
    assert check(diagnosis.apply_fix("stop"), diagnosis.request.limits)
    assert "stop at point" in diagnosis.explain("en")
    assert diagnosis.explain("ar") != diagnosis.explain("en")


def test_a_robots_own_limits_and_names():
    robot = mf.load("ur5e")
    diagnosis = suggest_fixes([[0.0] * 6, [1.0] * 6], [0.1], robot)
    assert robot.joint_names[0] in diagnosis.explain("en")
    assert [remedy.kind for remedy in diagnosis.remedies] == [RemedyKind.SLOWER]
    slower = diagnosis.apply_fix()
    assert check(slower, robot)
    assert slower.duration == pytest.approx(diagnosis.remedies[0].factor * 0.1)
    data = diagnosis.to_dict()
    assert data["status"] == "mendable"
    assert data["remedies"][0]["duration"] == slower.duration


def test_a_possible_request_is_true_and_mended_as_it_is():
    diagnosis = suggest_fixes([[0.0], [1.0]], [3.0], MotionLimits.of(1, velocity=1.0))
    assert diagnosis
    assert diagnosis.status is RequestStatus.POSSIBLE
    assert diagnosis.apply_fix().duration == 3.0


def test_what_no_time_allows_has_no_remedy():
    forbidden = suggest_fixes([[0.0], [1.0]], [3.0], MotionLimits.of(1, velocity=(0.0, 0.0)))
    assert forbidden.status is RequestStatus.NO_REMEDY
    one_way = suggest_fixes([[0.0], [1.0], [0.0]], [1.0, 1.0], MotionLimits.of(1, velocity=(0.0, 9.0)))
    assert RemedyKind.SLOWER not in {remedy.kind for remedy in one_way.remedies}
    with pytest.raises(InputError, match="no remedy"):
        forbidden.apply_fix()


@pytest.mark.parametrize(
    ("points", "durations", "says"),
    [
        ([[0.0], [np.nan]], [1.0], "points"),
        ([[0.0], [1.0]], [0.0], "leg 1"),
        ([[0.0], [1.0]], [1.0, 2.0], "durations"),
        ([[0.0]], [], "points"),
        ([0.0, 1.0], [1.0], "points"),
    ],
)
def test_requests_that_are_none_are_refused_by_name(points, durations, says):
    with pytest.raises(InputError, match=says):
        suggest_fixes(points, durations, MotionLimits.of(1))
    with pytest.raises(InputError, match="curve"):
        suggest_fixes([[0.0], [1.0]], [1.0], MotionLimits.of(1), curve="loop")
