"""Derivations of the library: true at states of their own, in the forms that books print, in three formats."""

import re
from html.parser import HTMLParser

import numpy as np
import pytest

from mafsil import messages
from mafsil.derivation import DerivationError, derive_fk, derive_jacobian, to_html, to_latex, to_text
from mafsil.derivation.arm import symbolic_arm
from mafsil.derivation.determinant import determinant, product_of_blocks
from mafsil.derivation.document import Factors, is_matrix
from mafsil.derivation.jacobian import space_columns, tip_columns
from mafsil.derivation.polynomial import Polynomial, constant, evaluate, numbers, transpose
from mafsil.derivation.text import formula, side_text
from mafsil.derivation.verification import Judge
from mafsil.errors import ModelError
from mafsil.model import library, mechanism_from_screws
from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.library import textbook
from mafsil.robot import Robot


def found(derivation, *left):
    """Formulas of the line with these names on the left."""
    names = ["_".join(filter(None, (name.letter, name.index))) for line in derivation.lines for name in line.left]
    assert left[0] in names, names
    return [
        side
        for line in derivation.lines
        if ["_".join(filter(None, (name.letter, name.index))) for name in line.left] == list(left)
        for side in line.sides
    ]


@pytest.mark.capability("05-10", "05-26", "05-46")
@pytest.mark.parametrize("name", library.robots())
def test_formulas_of_the_library_at_fresh_states(name):
    """Symbols against compiled machine code at 50 states that the derivation has not seen."""
    mechanism = library.load(name)
    arm, robot = symbolic_arm(mechanism), Robot(mechanism)
    q = np.random.default_rng(99).uniform(-3, 3, (50, robot.n))
    values = arm.values(q)
    T = evaluate(arm.poses()[-1].entries, values, 50)
    np.testing.assert_allclose(T, robot.forward_kinematics(q), atol=1e-12)
    J = evaluate(transpose(space_columns(arm)), values, 50)
    np.testing.assert_allclose(J, robot.jacobian_space(q), atol=1e-11)
    J_p = evaluate(transpose(tip_columns(arm)), values, 50)
    step = 1e-6
    for i in range(robot.n):
        ahead, behind = q.copy(), q.copy()
        ahead[:, i] += step
        behind[:, i] -= step
        slope = (robot.forward_kinematics(ahead) - robot.forward_kinematics(behind))[:, :3, 3] / (2 * step)
        np.testing.assert_allclose(J_p[:, :, i], slope, atol=1e-7)


@pytest.mark.parametrize(
    "name", ["planar2r", "planar3r", "scara_rrrp", "spatial3r", "rrrp", "elbow6r", "puma560", "ur5e"]
)
def test_every_line_that_says_something_was_checked(name):
    for derive in (derive_fk, derive_jacobian):
        derivation = derive(library.load(name))
        assert derivation.worst_error < 1e-12
        for line in derivation.lines[len(derivation.steps[0].lines) :]:
            if any(is_matrix(side) or isinstance(side, Polynomial | Factors) for side in line.sides) and line.left:
                assert line.error is not None


@pytest.mark.capability("05-2")
def test_the_planar_arms_in_the_teachers_form():
    fk = derive_fk(textbook.planar3r())
    assert [formula(side) for side in found(fk, "p_x")] == ["L1 c1 + L2 c12 + L3 c123"]
    assert [formula(side) for side in found(fk, "p_y")] == ["L1 s1 + L2 s12 + L3 s123"]
    assert [formula(side) for side in found(fk, "φ")] == ["θ1 + θ2 + θ3"]
    J = found(derive_jacobian(textbook.planar2r()), "J_p")[0]
    assert [[formula(x) for x in row] for row in J[:2]] == [
        ["−L1 s1 − L2 s12", "−L2 s12"],
        ["L1 c1 + L2 c12", "L2 c12"],
    ]


def test_puma_in_the_teachers_form():
    fk = derive_fk(library.load("puma560"))
    assert [formula(side) for side in found(fk, "p_x")] == ["c1 (a2 c2 + a3 c23 − d4 s23) + d3 s1"]
    assert [formula(side) for side in found(fk, "p_z")] == ["a2 s2 + d4 c23 + a3 s23"]
    assert formula(found(fk, "r_33")[0]) == "c23 c5 − s23 c4 s5"


@pytest.mark.parametrize(
    ("arm", "text"),
    [
        (textbook.elbow6r(0.5, 0.4), "−a2 d4 s3 s5 (a2 c2 + d4 c23)"),
        (textbook.arm6r(0.4), "a3 a4 c2 s4 (a3 s45 + a4 s5)"),
        (textbook.rrprrr(0.5, 0.3), "c2 s5 (d4 + q3) (d4 + q3)"),
        (textbook.rrprrr_upright(0.5, 0.3), "−c2 c5 (d3 + q3) (d3 + q3)"),
        (textbook.scara_rrrp(0.2, 0.6, 0.4), "−a1 a2 s2"),
        (textbook.rrrp(0.7), "a2 c3"),
        (textbook.planar2r(), "L1 L2 s2"),
        (library.load("puma560"), "−a2 s5 (a2 c2 + a3 c23 − d4 s23) (d4 c3 + a3 s3)"),
    ],
)
def test_closed_form_determinants(arm, text):
    """The products of the reference (its L are our a and d), recovered without being given them."""
    shown = determinant(symbolic_arm(arm))
    assert shown is not None
    assert side_text(Factors(shown.factors)) == text


@pytest.mark.parametrize("name", ["elbow6r", "arm6r", "rrprrr", "puma560", "ur5e", "stanford_arm", "generalized_puma"])
def test_determinants_are_those_of_the_compiled_jacobian(name):
    arm = symbolic_arm(library.load(name))
    judge, shown = Judge(arm, seed=77), determinant(arm)
    assert shown is not None
    product = np.prod([judge.number(factor) for factor in shown.factors], axis=0)
    np.testing.assert_allclose(product, np.linalg.det(judge.J_s), atol=1e-12)


def test_blocks_give_the_determinant_of_numbers():
    rng = np.random.default_rng(8)
    for _ in range(20):
        A = rng.integers(-3, 4, (5, 5)) * (rng.random((5, 5)) < 0.5)
        factors = product_of_blocks(numbers(A.astype(float)))
        assert factors is not None
        value = np.prod([factor.evaluate({}) for factor in factors])
        assert value == pytest.approx(np.linalg.det(A), abs=1e-9)


def test_a_wrong_line_is_never_printed():
    arm = symbolic_arm(textbook.planar2r())
    judge = Judge(arm)
    with pytest.raises(DerivationError) as caught:
        judge.line((), constant(0.5), truth=judge.tip[:, 0, 3])
    assert caught.value.message("en") != caught.value.message("ar")


def test_odd_angles_and_offsets_get_letters():
    rows = [DHRow(), DHRow(alpha=0.3, a=0.4, theta=0.2), DHRow(alpha=-0.5, d=0.1, kind="P"), DHRow(alpha=1.0, a=0.2)]
    mechanism = mechanism_from_dh(rows, "modified")
    for derive in (derive_fk, derive_jacobian):
        derivation = derive(mechanism)
        assert derivation.worst_error < 1e-12
        assert "α1 =" in to_text(derivation)
    turned = mechanism_from_screws([[0, 0, 1, 0, 0, 0], [0, 0, 1, 0, -1, 0]], np.diag([1.0, -1, -1, 1]))
    assert derive_fk(turned).worst_error < 1e-12


def test_arms_without_a_table_are_refused():
    with pytest.raises(ModelError, match="helical"):
        derive_fk(mechanism_from_screws([[0, 0, 1, 0, 0, 0.1]], np.eye(4)))


class _Page(HTMLParser):
    def __init__(self):
        super().__init__()
        self.open, self.links, self.maths = [], [], []

    def handle_starttag(self, tag, attrs):
        if tag != "meta":
            self.open.append(tag)
        self.links += [value for name, value in attrs if name in ("src", "href")]
        if tag == "math":
            self.maths.append(dict(attrs))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


@pytest.mark.parametrize("language", messages.LANGUAGES)
@pytest.mark.parametrize("derive", [derive_fk, derive_jacobian])
def test_pages_are_whole_and_formulas_run_from_left_to_right(derive, language):
    text = to_html(derive(library.load("scara_rrrp")), language)
    page = _Page()
    page.feed(text)
    assert page.open == []
    assert page.links == []
    assert "http" not in text
    assert f'<html lang="{language}" dir="{messages.direction(language)}">' in text
    assert page.maths
    assert all(attributes.get("dir") == "ltr" for attributes in page.maths)
    assert bool(re.search(r"[\u0600-\u06ff]", text)) == (language == "ar")


@pytest.mark.parametrize("language", messages.LANGUAGES)
def test_latex_is_balanced_and_plain(language):
    text = to_latex(derive_jacobian(library.load("rrrp")), language)
    assert text.count("{") == text.count("}")
    for name in set(re.findall(r"\\begin\{(\w+)\}", text)):
        assert text.count(rf"\begin{{{name}}}") == text.count(rf"\end{{{name}}}")
    assert not re.search(r"[−θα×°]", text)
    assert text.count("$") % 2 == 0


@pytest.mark.parametrize("language", messages.LANGUAGES)
def test_text_has_numbered_steps(language):
    derivation = derive_fk(library.load("spatial3r"))
    text = to_text(derivation, language)
    for k in range(1, len(derivation.steps) + 1):
        assert f"\n{k}. " in text
    assert bool(re.search(r"[\u0600-\u06ff]", text)) == (language == "ar")
