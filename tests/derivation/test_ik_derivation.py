"""Inverse kinematics on paper: every line held against the solver, in both languages and all formats."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.derivation import DerivationError, derive_ik, to_html, to_latex, to_text
from mafsil.derivation.expression import function, name_expression, number, plus_minus
from mafsil.derivation.verification import between
from mafsil.errors import ModelError
from mafsil.geometry import pose
from mafsil.ik import closed_form

ARMS = {
    "puma560": ("spherical_wrist", 8),
    "ur5e": ("three_parallel", 8),
    "stanford_arm": ("spherical_wrist", 8),
    "generalized_puma": ("spherical_wrist", 8),
    "arm6r": ("three_parallel", 8),
    "scara_rrrp": ("planar", 2),
    "cobra600": ("planar", 2),
    "planar2r": ("planar", 2),
    "planar3r": ("planar", 2),
}


def derived(name, spoil=0.0):
    robot = mf.load(name)
    form = closed_form(robot)

    def solutions(T):
        rows = form.solve(T)
        return rows.q[rows.solves_pose()] + spoil

    return derive_ik(robot.mechanism, form.pattern, solutions)


@pytest.mark.capability("07-14", "07-16", "07-17", "07-21")
@pytest.mark.parametrize("name", ARMS)
def test_every_line_agrees_with_the_solver(name):
    derivation = derived(name)
    assert derivation.worst_error < 1e-9
    family, most = ARMS[name]
    keys = [step.key for step in derivation.steps]
    assert keys[0].startswith(f"derivation.ik_{family}")
    branches = next(step for step in derivation.steps if step.key == "derivation.ik_branches")
    assert branches.details["most"] == most
    # Every joint of the arm has its own line.
    solved = {line.left[0].letter for line in derivation.lines if line.left and line.error is not None}
    robot = mf.load(name)
    assert {int(re.sub(r"\D", "", letter)) for letter in solved if re.fullmatch(r"(theta|d)\d", letter)} == set(
        range(1, robot.n + 1)
    )


@pytest.mark.parametrize("name", ["puma560", "ur5e", "planar3r"])
@pytest.mark.parametrize("language", ["en", "ar"])
def test_all_formats_in_both_languages(name, language):
    derivation = derived(name)
    text, latex, html = (write(derivation, language) for write in (to_text, to_latex, to_html))
    assert "atan2" in text
    assert latex.count("{") == latex.count("}")
    assert r"\operatorname{atan2}" in latex
    assert not re.search(r"\\mathrm\{[^}]*,", latex)
    assert "<msqrt>" in html
    for math in re.findall(r"<math.*?</math>", html, re.S):
        ET.fromstring(math)
    if language == "ar":
        assert 'dir="rtl"' in html
        assert not re.search(r"Structure|Joint ", text)


def test_wrong_solutions_are_never_printed():
    with pytest.raises(DerivationError, match="differs"):
        derived("puma560", spoil=np.array([0.0, 0.0, 1e-3, 0.0, 0.0, 0.0]))


def test_arms_without_a_short_road_are_refused():
    panda = mf.load("panda")
    with pytest.raises(ModelError, match="panda"):
        derive_ik(panda.mechanism, closed_form(panda).pattern, lambda _T: np.zeros((0, 7)))
    with pytest.raises(ModelError, match="rrrp"):
        derive_ik(mf.load("rrrp").mechanism, None, lambda _T: np.zeros((0, 4)))


def test_expressions_evaluate_and_print_the_same_formula():
    rng = np.random.default_rng(2)
    u, w = rng.normal(size=(2, 5, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    a = rng.normal(size=5)
    values = {"u": u, "w_1": w, "theta1": a}
    turned = (function("Rot", name_expression("w_1"), name_expression("theta1")) * name_expression("u")).evaluate(
        values
    )
    expected = u * np.cos(a)[:, None] + np.cross(w, u) * np.sin(a)[:, None]
    expected += w * ((w * u).sum(axis=1) * (1 - np.cos(a)))[:, None]
    np.testing.assert_allclose(turned, expected, atol=1e-14)
    both = plus_minus(number(1.0), function("sqrt", function("square", name_expression("theta1"))))
    np.testing.assert_allclose(both.evaluate(values, -1.0), 1 - np.abs(a))
    assert both.text() == "1 ± √(θ1²)"
    tree = name_expression("a") - (name_expression("b") - name_expression("c"))
    assert tree.text() == "a − (b − c)"
    assert r"\left(b - c\right)" in tree.latex()
    assert (-(name_expression("a") + name_expression("b"))).text() == "−(a + b)"
    assert (
        name_expression("u").cross(name_expression("v")).dot(name_expression("w_1"))
    ).text() == "(u × v)·w1" or "u × v" in (
        name_expression("u").cross(name_expression("v")).dot(name_expression("w_1"))
    ).text()


@pytest.mark.capability("07-26")
def test_turns_are_signed_angles_between_projected_vectors():
    rng = np.random.default_rng(4)
    w, u, lift = (rng.normal(size=(200, 3)) for _ in range(3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    a = rng.uniform(-np.pi, np.pi, 200)
    turned = pose.act(pose.exp(np.concatenate([w * a[:, None], np.zeros((200, 3))], axis=1)), u)
    # What lies along the axis does not count.
    v = turned + (w * lift).sum(axis=1, keepdims=True) * w
    formula = between(name_expression("w"), name_expression("u"), name_expression("v"))
    np.testing.assert_allclose(formula.evaluate({"w": w, "u": u, "v": v}), a, atol=1e-12)


@pytest.mark.capability("07-24")
def test_the_wrist_leaves_its_centre_where_it_is():
    robot = mf.load("puma560")
    m = closed_form(robot).pattern.centre
    bent = np.zeros((50, 6))
    bent[:, 3:] = np.random.default_rng(5).uniform(-3, 3, (50, 3))
    moved = robot.forward_kinematics(bent) @ np.linalg.inv(robot.forward_kinematics(np.zeros(6)))
    np.testing.assert_allclose(pose.act(moved, m), np.broadcast_to(m, (50, 3)), atol=1e-14)


def test_the_command_derives(capsys):
    assert main(["derive", "ik", "puma560"]) == 0
    assert "θ5" in capsys.readouterr().out
    assert main(["derive", "ik", "panda"]) != 0
