"""Equations of motion from typed energies: known systems, other methods, and what is refused."""

from __future__ import annotations

import re
from itertools import product

import numpy as np
import pytest

import mafsil as mf
from mafsil.derivation import derive_lagrange, to_html, to_latex, to_text
from mafsil.derivation.document import Derivation
from mafsil.derivation.formula_text import evaluate, parse_formula
from mafsil.errors import InputError

ARM = (
    "m1*l1**2*dt1**2/2 + m2/2*(l1**2*dt1**2 + 2*l1*l2*cos(t2)*(dt1**2 + dt1*dt2) + l2**2*(dt1 + dt2)**2)",
    "(m1 + m2)*g*l1*sin(t1) + m2*g*l2*sin(t1 + t2)",
)


def numbers(derivation: Derivation, letter: str, values: dict[str, float]) -> list[float]:
    """Values of the lines of one letter, in order."""
    return [float(line.sides[0].evaluate(values)) for line in derivation.lines if line.left[0].letter == letter]


@pytest.mark.capability("09-11", "09-12", "09-13", "09-14")
def test_particle_by_newton_and_lagrange():
    """f = m xdd + m g by both, a force in newtons, the motion without force: xdd = -g."""
    found = derive_lagrange("m*dx**2/2", "m*g*x", {"x": "m"}, newton={"x": "m*ddx + m*g"}, name="particle")
    values = {"m": 2.5, "g": 9.81, "x": 0.7, "dx": -0.3, "ddx": 1.7}
    by_lagrange, by_newton = numbers(found, "f", values)
    assert by_lagrange == by_newton == pytest.approx(2.5 * (1.7 + 9.81))
    assert numbers(found, "f", {**values, "ddx": -9.81}) == pytest.approx([0.0, 0.0])
    text = to_text(found, "en")
    assert re.search(r"x +m +N", text)
    assert text.count("f_x = m (g + ẍ)") == 2
    assert found.worst_error < 1e-9
    for wrong in ("m*ddx - m*g", "m*ddx", "2*m*ddx + m*g"):
        with pytest.raises(InputError, match="difference is not zero"):
            derive_lagrange("m*dx**2/2", "m*g*x", "x", newton={"x": wrong})


@pytest.mark.capability("09-11", "09-12", "09-13", "09-16")
def test_planar_2r_equals_the_compiled_robot():
    L, m = (0.8, 0.5), (2.0, 1.5)
    robot = mf.Robot(mf.model.library.textbook.planar2r_point_masses(L, m).with_gravity(np.array([0, -9.81, 0])))
    found = derive_lagrange(*ARM, ["t1", "t2"])
    rng = np.random.default_rng(4)
    for q, qd, qdd in rng.normal(size=(5, 3, 2)):
        letters = {"m1": m[0], "m2": m[1], "l1": L[0], "l2": L[1], "g": 9.81}
        state = {f"{d}t{i + 1}": x[i] for d, x in (("", q), ("d", qd), ("dd", qdd)) for i in range(2)}
        values = letters | state
        np.testing.assert_allclose(numbers(found, "f", values), robot.inverse_dynamics(q, qd, qdd), rtol=1e-12)
        np.testing.assert_allclose(numbers(found, "M", values), robot.mass_matrix(q)[np.triu_indices(2)], rtol=1e-12)
        np.testing.assert_allclose(numbers(found, "p", values), robot.mass_matrix(q) @ qd, rtol=1e-11)


@pytest.mark.capability("09-11")
def test_units_of_the_forces_follow_the_coordinates():
    """A cart with a pendulum: newtons for the slide, newton metres for the angle, power f . qd either way."""
    found = derive_lagrange(
        "(M + m)*dx**2/2 + m*l*dx*dtheta*cos(theta) + m*l**2*dtheta**2/2", "m*g*l*cos(theta)", ["x", "theta"]
    )
    text = to_text(found, "en")
    assert re.search(r"x +m +N\b", text)
    assert re.search(r"θ +rad +N m", text)
    values = {"M": 3.0, "m": 0.5, "l": 0.7, "g": 9.81, "x": 0.1, "theta": 0.6, "dx": 0.4, "dtheta": -1.1}
    values |= {"ddx": 0.9, "ddtheta": 2.0}
    x, angle = numbers(found, "f", values)
    c, s = np.cos(0.6), np.sin(0.6)
    assert x == pytest.approx(3.5 * 0.9 + 0.35 * c * 2.0 - 0.35 * s * 1.21)
    assert angle == pytest.approx(0.245 * 2.0 + 0.35 * c * 0.9 - 0.35 * 9.81 * s)


def test_a_spring_in_an_angle_and_a_lagrangian_with_rates_in_m():
    """Angles may stand bare as well; a kinetic energy of fourth order has no mass matrix, and none is printed."""
    found = derive_lagrange("J*dphi**2/2", "k*phi**2/2 + m*g*l*sin(2*phi)", {"phi": "rad"})
    values = {"J": 1.5, "k": 3.0, "m": 1.0, "g": 9.81, "l": 0.5, "phi": 0.3, "dphi": 0.0, "ddphi": 2.0}
    assert numbers(found, "f", values) == pytest.approx([3.0 + 0.9 + 2 * 9.81 * 0.5 * np.cos(0.6)])
    assert numbers(derive_lagrange("dx**4", "x", "x"), "M", {}) == []


@pytest.mark.parametrize("language", ["en", "ar"])
def test_written_in_both_languages_and_all_forms(language):
    found = derive_lagrange("(M + m)*dx**2/2 + m*l*dx*dtheta*cos(theta)", "m*g*l*cos(theta)", ["x", "theta"])
    assert "f_θ" in to_text(found, language)
    latex = to_latex(found, language)
    assert r"\ddot{x}" in latex
    assert r"\partial L/\partial \theta" in latex
    assert not set("ẍẋθ∂̇") & set(re.sub(r"\\section.*", "", latex))
    assert "robot" not in to_text(found, "en").split("Every line")[1]
    assert "<math" in to_html(found, language)


def test_typed_formulas_keep_their_values():
    from mafsil.derivation.lagrange import polynomial_of

    values = {"a": 1.3, "b": -0.4, "t": 0.7, "u": 2.1}
    pieces = ["a", "-b**3", "sin(t - 2*u)", "cos(u)/4", "(a + b)**2", "3"]
    for one, two, operation in product(pieces, pieces, "+-*"):
        text = f"({one}) {operation} ({two})"
        expected = float(np.real(evaluate(parse_formula(text), values)))
        assert polynomial_of(text).evaluate(values) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("kinetic", "potential", "coordinates", "match"),
    [
        ("dx**2/m", "x", "x", "multiply out"),
        ("dx**2*sqrt(2)", "x", "x", "multiply out"),
        ("dx**2", "sin(x*y)", "x", "multiply out"),
        ("dx**2", "sin(x/2)", "x", "multiply out"),
        ("dx**2", "x", "y", "not a coordinate"),
        ("dx**2", "x", ["x", "x"], "twice"),
        ("dx**2", "x", {"x": "mm"}, "choose one of: m, rad"),
        ("dx**2", "x", [], "not a coordinate"),
        ("import os", "x", "x", "cannot be parsed as a formula"),
    ],
)
def test_what_is_refused(kinetic, potential, coordinates, match):
    with pytest.raises(InputError, match=match):
        derive_lagrange(kinetic, potential, coordinates)
