"""Time laws: rows of one table, whose peaks follow from their coefficients."""

from __future__ import annotations

from typing import cast, get_args

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.trajectory import cartesian_line, quintic
from mafsil.trajectory.profiles import PolynomialLaw
from mafsil.trajectory.profiles.laws import LAWS, QUINTIC, LawName, time_law

SEPTIC = PolynomialLaw((0, 0, 0, 0, 35, -84, 70, -20))
"""Rest, no acceleration and no jerk at both ends."""


def test_every_name_has_a_law_and_every_law_a_name() -> None:
    assert {*get_args(LawName), "exponential"} == set(LAWS)


@pytest.mark.parametrize(
    ("law", "peaks"),
    [
        (PolynomialLaw((0, 0, 3, -2)), (3 / 2, 6.0, 12.0)),
        (QUINTIC, (15 / 8, 10 / 3**0.5, 60.0)),
        (SEPTIC, (35 / 16, 84 / (5 * 5**0.5), 52.5)),
    ],
)
def test_the_peaks_follow_from_the_coefficients(law: PolynomialLaw, peaks: tuple[float, float, float]) -> None:
    np.testing.assert_allclose(law.peaks, peaks, rtol=2**-52)
    motion = law.unit().at(np.linspace(0.0, 1.0, 100_001))
    np.testing.assert_allclose([np.abs(motion.v).max(), np.abs(motion.a).max()], peaks[:2], rtol=1e-8)


def test_the_quintic_of_the_table_is_the_quintic_to_the_last_digit() -> None:
    start, goal = np.array([0.3, -1.0, 2.0]), np.array([1.1, -1.0, -0.7])
    ours, other = QUINTIC.between(start, goal, 0.7), quintic(start, goal, 0.7)
    np.testing.assert_array_equal(ours.coefficients, other.coefficients)
    np.testing.assert_array_equal(ours.knots, other.knots)


@pytest.mark.parametrize("law", list(LAWS.values()), ids=list(LAWS))
def test_the_fastest_motion_meets_a_limit_and_breaks_none(law: PolynomialLaw) -> None:
    velocity, acceleration = np.array([1.0, 0.5]), np.array([2.0, 40.0])
    start, goal = np.zeros(2), np.array([0.4, 0.9])
    motion = law.fastest(start, goal, velocity=velocity, acceleration=acceleration)
    at = motion.at(np.linspace(0.0, motion.duration, 20_001))
    share = max(float((np.abs(at.v) / velocity).max()), float((np.abs(at.a) / acceleration).max()))
    assert 1.0 - 1e-6 < share <= 1.0 + 1e-12
    np.testing.assert_allclose([at.u[0], at.u[-1]], [start, goal], atol=1e-14)


def test_a_further_law_is_one_row(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(cast("dict[str, object]", LAWS), "septic", SEPTIC)
    robot = mf.load("puma560")
    q = np.array([0.1, -0.6, 0.4, 0.2, 0.7, 0.3])
    goal = np.asarray(robot.forward_kinematics(q)).copy()
    goal[2, 3] += 0.05
    move = cartesian_line(robot, q, goal, duration=2.0, law=cast("LawName", "septic"))
    assert move.succeeded
    assert move.value is not None
    np.testing.assert_allclose(move.value.jerk([0.0, 2.0]), 0.0, atol=1e-9)


def test_an_unknown_law_is_refused_with_those_that_are_known() -> None:
    with pytest.raises(InputError, match="cubic, quintic"):
        time_law(cast("LawName", "fast"))
    with pytest.raises(InputError, match="from 0 to 1"):
        PolynomialLaw((0, 0, 3, -1))
