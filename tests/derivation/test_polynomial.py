"""Formulas of sines, cosines and lengths: every operation keeps the value."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.derivation.grouping import evaluate, factor_out
from mafsil.derivation.polynomial import angle_sum, constant, simplify, symbol, trig
from mafsil.derivation.text import formula

VALUES = {"theta1": 0.7, "theta2": -1.3, "theta3": 2.1, "alpha1": 0.4, "L1": 1.7, "a2": -0.6, "q4": 0.9}
THETA = {name: ((name, 1),) for name in ("theta1", "theta2", "theta3", "alpha1")}
atoms = st.one_of(
    st.sampled_from(["L1", "a2", "q4"]).map(symbol),
    st.builds(trig, st.booleans(), st.sampled_from(list(THETA.values())), st.integers(-4, 4)),
    st.builds(
        lambda sine, sign: trig(sine, angle_sum(THETA["theta1"], THETA["theta2"], sign)),
        st.booleans(),
        st.sampled_from([1, -1]),
    ),
    st.integers(-3, 3).map(lambda k: constant(float(k))),
)
formulas = st.recursive(
    atoms,
    lambda inner: st.tuples(inner, inner, st.sampled_from("+-*")).map(
        lambda t: t[0] + t[1] if t[2] == "+" else t[0] - t[1] if t[2] == "-" else t[0] * t[1]
    ),
    max_leaves=7,
)


@settings(deadline=None, max_examples=120)
@given(formulas)
def test_simplifying_and_factoring_keep_the_value(polynomial):
    shorter = simplify(polynomial)
    assert shorter.length <= polynomial.length
    wanted = polynomial.evaluate(VALUES)
    assert shorter.evaluate(VALUES) == pytest.approx(wanted, abs=1e-9)
    assert evaluate(factor_out(shorter), VALUES) == pytest.approx(wanted, abs=1e-9)


@settings(deadline=None, max_examples=60)
@given(formulas, st.sampled_from(["theta1", "theta2", "L1", "q4"]))
def test_derivatives_against_central_differences(polynomial, name):
    step = 1e-6
    ahead, behind = (polynomial.evaluate({**VALUES, name: VALUES[name] + s}) for s in (step, -step))
    assert polynomial.derivative(name).evaluate(VALUES) == pytest.approx((ahead - behind) / (2 * step), abs=1e-5)


@given(st.booleans(), st.integers(-9, 9), st.floats(-3, 3))
def test_quarter_turns_are_exact(sine, quarters, angle):
    value = trig(sine, THETA["theta1"], quarters).evaluate({"theta1": angle})
    wanted = (np.sin if sine else np.cos)(angle + quarters * pi / 2)
    assert value == pytest.approx(wanted, abs=1e-12)


def test_identities_are_found():
    c, s = (trig(sine, THETA["theta1"]) for sine in (False, True))
    assert formula(simplify(c * c + s * s)) == "1"
    t12 = angle_sum(THETA["theta1"], THETA["theta2"])
    difference = trig(True, t12) * c - trig(False, t12) * s
    assert formula(simplify(difference)) == "s2"
    assert formula(symbol("a2") * c * trig(False, THETA["theta2"]) + symbol("L1") * c) == "c1 (L1 + a2 c2)"
    assert formula(-(symbol("L1") * c)) == "−L1 c1"
    assert formula(trig(True, angle_sum(THETA["theta1"], THETA["theta2"], -1))) == "sin(θ1 − θ2)"
    assert formula(constant(0.0)) == "0"
