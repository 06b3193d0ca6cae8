"""The check finds the joint, the time and the value; sampling and exact extremes agree."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil.errors import InputError
from mafsil.model import JointLimits
from mafsil.trajectory import Motion, check, cubic, export, prove, quintic, sequence, trapezoid
from mafsil.trajectory.profiles import rest


def bounds(n, **given):
    names = ("lower", "upper", "velocity", "acceleration", "jerk", "effort")
    return JointLimits(*(np.full(n, given.get(name, -np.inf if name == "lower" else np.inf)) for name in names))


@pytest.mark.capability("11-4")
def test_worst_place_is_named():
    motion = cubic([0.0, 0.0], [1.0, 3.0], 2.0)
    verdict = check(motion, bounds(2, velocity=2.0), ("shoulder", "elbow"))
    (violation,) = verdict.violations
    assert violation.joint == "elbow"
    assert violation.quantity == "velocity"
    assert violation.time == pytest.approx(1.0)
    assert violation.value == pytest.approx(1.5 * 3.0 / 2.0)
    assert "elbow" in verdict.explain("en")
    assert "2.25" in verdict.explain("ar")


@pytest.mark.parametrize("quantity", ["upper", "lower", "velocity", "acceleration", "jerk"])
def test_every_quantity(quantity):
    motion = quintic([0.0], [3.0], 1.0, start_velocity=-20.0)
    limit = -0.1 if quantity == "lower" else 0.5
    verdict = check(motion, bounds(1, **{quantity: limit}), ends=False)
    assert [v.quantity for v in verdict.violations] == [quantity]
    dense = np.linspace(0, 1, 200001)
    order = {"upper": 0, "lower": 0, "velocity": 1, "acceleration": 2, "jerk": 3}[quantity]
    values = (motion.jerk(dense) if order == 3 else motion.at(dense)[order])[:, 0]
    extreme = {"upper": values.max(), "lower": values.min()}.get(quantity, values[np.abs(values).argmax()])
    assert verdict.violations[0].value == pytest.approx(extreme, rel=1e-8)


def test_within_limits_says_so_and_names_what_no_limit_was_given_of(tmp_path):
    """A check that did not run never reads like one that passed."""
    motion, free = rest([0.0], 1.0), bounds(1)
    names = {"position": "upper", "velocity": "velocity", "acceleration": "acceleration", "jerk": "jerk"}
    for given in range(16):
        limited = [name for k, name in enumerate(names) if given >> k & 1]
        limits = bounds(1, **{names[name]: 1.0 for name in limited})
        lacks = [name for name in names if name not in limited]
        answers = (
            check(motion, limits),
            prove(motion, limits),
            export(motion, tmp_path / "a.csv", limits),
        )
        for answer in answers:
            assert answer
            for language, mark in (("en", "not checked, as no limit is given: "), ("ar", "لم يُفحص")):
                assert (mark in answer.explain(language)) == bool(lacks)
            rest_of_it = answer.explain("en").partition("given: ")[2]
            assert rest_of_it == ", ".join(f"the {name}" for name in lacks)
        assert answers[0].to_dict()["unchecked"] == answers[1].to_dict()["unchecked"] == lacks
    assert len(check(motion, free).unchecked) == 4


def test_sampled_agrees_with_exact():
    rng = np.random.default_rng(3)
    for _ in range(20):
        motion = quintic(*rng.normal(size=(2, 3)), 1.7, start_velocity=rng.normal(size=3))
        exact = check(motion, bounds(3, velocity=1e-3, acceleration=1e-3, jerk=1e-3, upper=-9.0))
        sampled = check(sequence(motion), bounds(3, velocity=1e-3, acceleration=1e-3, jerk=1e-3, upper=-9.0))
        assert len(exact.violations) == len(sampled.violations) == 12
        for a, b in zip(exact.violations, sampled.violations, strict=True):
            assert abs(b.value) == pytest.approx(abs(a.value), rel=1e-7)


def test_left_side_of_a_jump_counts():
    # The second blend decelerates at exactly the acceleration limit up to the very end, then rests.
    motion = sequence(trapezoid([0.0], [1.0], acceleration=1.0).value, rest([1.0], 1.0))
    assert check(motion, bounds(1, acceleration=1.0))
    assert not check(motion, bounds(1, acceleration=0.999))


def test_sequence_rests_between_parts():
    first, second = quintic([0.0], [1.0], 1.0), quintic([1.0], [-1.0], 2.0)
    motion = sequence(first, second, rests=0.5)
    assert motion.duration == 3.5
    assert motion.n == 1
    at = motion.at([0.5, 1.2, 1.5, 3.5, 9.0])
    np.testing.assert_allclose(at.u[:, 0], [first.at(0.5).u[0], 1.0, 1.0, -1.0, -1.0], atol=1e-12)
    np.testing.assert_allclose(at.v[[1, 2, 3, 4]], 0.0, atol=1e-12)
    np.testing.assert_allclose(motion.jerk(2.0), second.jerk(0.5), atol=1e-12)
    np.testing.assert_allclose(motion.at(2.5).a, second.at(1.0).a, atol=1e-12)


def test_sequence_refuses_gaps_and_nonsense():
    with pytest.raises(InputError, match="parts"):
        sequence(cubic([0.0], [1.0], 1.0), cubic([1.1], [2.0], 1.0))
    with pytest.raises(InputError, match="parts"):
        sequence(cubic([0.0], [1.0], 1.0), cubic([1.0, 1.0], [2.0, 2.0], 1.0))
    with pytest.raises(InputError, match="at least one"):
        sequence()
    with pytest.raises(InputError, match="rests"):
        sequence(cubic([0.0], [1.0], 1.0), cubic([1.0], [2.0], 1.0), rests=-1.0)


class Beat:
    """Five waves whose heights differ by a thousandth: the largest sample need not be next to the highest of them."""

    n, duration = 1, 1.0

    def __init__(self, phase):
        self.phase = phase

    def at(self, t):
        rows = [self.derivative(t, k) for k in range(3)]
        return Motion(*rows)

    def jerk(self, t):
        return self.derivative(t, 3)

    def breaks(self):
        return np.array([0.0, 1.0])

    def derivative(self, t, k):
        t = np.asarray(t, dtype=float)[..., None]
        parts = ((1.0, 10.0 * np.pi, 0.0), (2e-3, 1.7, self.phase))
        return sum(a * w**k * np.sin(w * t + p + k * np.pi / 2.0) for a, w, p in parts)


@pytest.mark.parametrize("phase", [0.3, 1.5, 4.0])
@pytest.mark.parametrize("order", [0, 1])
def test_the_highest_of_many_waves_is_found_to_nine_digits(phase, order):
    beat = Beat(phase)
    # Of a velocity both directions count; tops by Newton's method, from where they would be without the slow part.
    reached = [float(beat.derivative(end, order)[0]) for end in (0.0, 1.0)]
    for half_wave in range(22):
        t = ((0.5 if order == 0 else 0.0) + half_wave) / 10.0
        for _ in range(8):
            t = t - float(beat.derivative(t, order + 1)[0] / beat.derivative(t, order + 2)[0])
        if 0.0 <= t <= 1.0:
            reached.append(float(beat.derivative(t, order)[0]))
    highest = max(reached, key=lambda value: abs(value) if order else value)
    quantity = ("upper", "velocity")[order]
    found = check(beat, bounds(1, **{quantity: abs(highest) * (1.0 - 1e-3)}), tolerance=0.0)
    assert [v.value for v in found] == [pytest.approx(highest, rel=1e-9)]


def test_a_peak_anywhere_in_a_piece_is_seen():
    for place in np.linspace(0.15, 0.85, 25):
        motion = sequence(rest([0.0], 0.3), bump(place), rest([0.0], 0.2))
        found = check(motion, bounds(1, upper=0.5), tolerance=0.0)
        assert [v.value for v in found] == [pytest.approx(1.0, abs=1e-9)]
        assert found.violations[0].time == pytest.approx(0.3 + place, abs=1e-6)


def bump(place):
    """Nothing but a narrow hill in a piece of a second."""

    class Hill(Beat):
        def derivative(self, t, k):
            x = (np.asarray(t, dtype=float)[..., None] - place) / 0.02
            hill = np.exp(-(x**2))
            return (hill, -2.0 * x * hill / 0.02, (4.0 * x**2 - 2.0) * hill / 0.02**2, 0.0 * x)[k]

    return Hill(0.0)
