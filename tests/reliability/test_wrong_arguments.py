"""Row F3 at the size of a pull request: one wrong argument in valid calls of public functions."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil import control, trajectory
from mafsil.errors import InputError
from mafsil.trajectory import JointPath, MotionLimits
from tests.reliability import wrong_arguments
from tests.sizes import size

OPEN = ("=a class): ", "grasp.eliminate(A=ragged)")
"""A class can be called, too; rows of unequal length are found by NumPy."""


@pytest.mark.row("F3")
def test_a_wrong_argument_is_said_in_our_words():
    counts, foreign = wrong_arguments.work(wrong_arguments.CALLS[:: size(8, 1)])
    late = [each for each in foreign if each.endswith(": late")]
    assert [each for each in foreign if each not in late and not any(words in each for words in OPEN)] == []
    assert counts["ours"] > 10 * counts["answered"]
    assert len(late) < 0.01 * counts["ours"]


LIMITS = MotionLimits.of(1, velocity=1.0, acceleration=1.0, jerk=1.0)
SENTENCES = {
    "minimum_duration: expected a number, got None": lambda: trajectory.jerk_limited(
        [0], [1], LIMITS, minimum_duration=None
    ),
    "trajectory: expected Trajectory, got str 'x'": lambda: trajectory.check("x", LIMITS),
    "MotionLimits: argument position, acceleration, jerk, effort is missing": lambda: MotionLimits(velocity=1),
    "JointPath.through: argument point is not known": lambda: JointPath.through(point=3),
    "Gains.of: argument kq is not known": lambda: control.Gains.of(1, kq=1),
    "plan: argument scene, start, goal is missing": lambda: mf.plan("ur5e"),
    "jerk_limited: argument goal, limits is missing": lambda: trajectory.jerk_limited(1),
    "f: expected a function of 1 argument, got": lambda: mf.ik.find_root(lambda: 0, [1.0]),
}


@pytest.mark.parametrize("words", SENTENCES)
def test_the_gate_names_the_argument_what_it_should_be_and_what_it_is(words):
    with pytest.raises(InputError) as caught:
        SENTENCES[words]()
    assert str(caught.value).startswith(words)
    assert caught.value.message("ar") != caught.value.message("en")


def test_what_fits_is_not_to_blame():
    """An error that a user's own function raises goes on as it is, and so does one that no argument explains."""

    def broken(x):
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        mf.ik.find_root(broken, np.ones(2))


def test_public_functions_are_themselves_wherever_they_are_found():
    from mafsil.trajectory.jerk.state_to_state import jerk_limited

    assert trajectory.jerk_limited is jerk_limited
    assert trajectory.jerk.jerk_limited is jerk_limited
