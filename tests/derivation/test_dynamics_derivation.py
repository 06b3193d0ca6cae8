"""`derive dynamics`: closed forms a teacher accepts, by two methods, equal to the compiled robot, in three formats."""

from __future__ import annotations

import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.derivation import DerivationError, derive_dynamics, to_html, to_latex, to_text
from mafsil.derivation.arm import symbolic_arm
from mafsil.derivation.dynamics import DynamicsJudge, newton_euler, same
from mafsil.derivation.lagrange_method import lagrange, operations, symbolic_bodies
from mafsil.derivation.polynomial import ZERO
from mafsil.derivation.text import formula
from mafsil.errors import ModelError
from mafsil.model import Actuator, Inertial, Joint, JointKind, Link, Mechanism, library

ARMS = ("planar2r", "planar2r_point_masses", "planar3r", "spatial3r")


def lines_of(derivation) -> dict[str, str]:
    text = to_text(derivation, "en")
    found: dict[str, str] = {}
    for left, right in re.findall(r"^   (\S.*?) = (?!\S* = )(.*)$", text, re.M):
        found.setdefault(left, right)
    return found


def slider() -> Mechanism:
    """Revolute, revolute about a crossing axis, prismatic: the r r p arm of the books, with a geared motor."""
    body = Inertial(2.0, np.array([0.1, 0.0, 0.2]), np.diag([0.03, 0.04, 0.05]))
    turned = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0.3], [0, 0, 0, 1]])
    motor = Actuator(rotor_inertia=1e-4, gear_ratio=50)
    joints = [
        Joint("one", JointKind.REVOLUTE, "base", "a", actuator=motor),
        Joint("two", JointKind.REVOLUTE, "a", "b", T_pj=turned),
        Joint("three", JointKind.PRISMATIC, "b", "c", axis=np.array([1.0, 0, 0])),
    ]
    return Mechanism.assemble("rrp", [Link("base"), *(Link(name, body) for name in "abc")], joints)


def two_joints(name: str, first: JointKind, axis: tuple, second: JointKind, then: tuple, com: tuple) -> Mechanism:
    bodies = [Inertial(5.0, np.zeros(3), np.eye(3) * 0.1), Inertial(2.0, np.array(com), np.diag([0.02, 0.03, 0.04]))]
    joints = [
        Joint("one", first, "base", "a", axis=np.array(axis, float)),
        Joint("two", second, "a", "b", axis=np.array(then, float)),
    ]
    return Mechanism.assemble(name, [Link("base"), Link("a", bodies[0]), Link("b", bodies[1])], joints)


SLIDE, TURN = JointKind.PRISMATIC, JointKind.REVOLUTE
BUILT = {
    "rrp": slider,
    "cartpole": lambda: two_joints("cartpole", SLIDE, (1, 0, 0), TURN, (0, 1, 0), (0, 0, 0.5)),
    "rp": lambda: two_joints("rp", TURN, (0, 1, 0), SLIDE, (1, 0, 0), (0, 0, 0)),
}


def arm_named(name: str) -> Mechanism:
    return BUILT[name]() if name in BUILT else library.load(name)


@pytest.mark.capability("09-13", "09-17", "09-19", "09-20")
def test_a_pole_on_a_cart() -> None:
    """The textbook's equations, the pole upright at zero: F on the cart, the moment at the pivot."""
    found = lines_of(derive_dynamics(arm_named("cartpole")))
    assert found["M_11"] == "m1 + m2"
    assert found["M_12"] == "m2 r2 c2"
    assert found["Γ_122"] == "−m2 r2 s2"
    assert found["τ_1"] == "(m1 + m2) q̈1 + m2 r2 c2 θ̈2 − m2 r2 s2 θ̇2²"
    assert found["τ_2"] == "m2 r2 c2 q̈1 + (I2zz + m2 r2²) θ̈2 − m2 g r2 s2"


@pytest.mark.capability("09-13", "09-17", "09-19", "09-20")
def test_a_slide_on_a_turning_joint() -> None:
    """Centrifugal and Coriolis terms of polar coordinates."""
    found = lines_of(derive_dynamics(arm_named("rp")))
    assert found["det M"] == "m2 (I1zz + I2yy + m2 q2²)"
    assert found["Γ_211"] == "−m2 q2"
    assert found["τ_1"] == "(I1zz + I2yy + m2 q2²) θ̈1 + 2 m2 q2 θ̇1 q̇2 − m2 g q2 c1"
    assert found["τ_2"] == "m2 q̈2 − m2 q2 θ̇1² − m2 g s1"


@pytest.mark.capability("09-15", "09-16", "09-18", "09-20", "09-21")
def test_point_masses_at_the_ends_of_the_links() -> None:
    """The closed form of the books, with their four misprints set right."""
    found = lines_of(derive_dynamics(library.load("planar2r_point_masses")))
    assert found["M_11"] == "(m1 + m2) L1² + m2 L2 (L2 + 2 L1 c2)"
    assert found["M_12"] == "m2 L2 (L2 + L1 c2)"
    assert found["M_22"] == "m2 L2²"
    assert found["det M"] == "m2 L1² L2² (m1 + m2 s2²)"
    assert found["Γ_211"] == "m2 L1 L2 s2"
    assert found["Γ_122"] == "−m2 L1 L2 s2"
    assert found["c_1"] == "−m2 L1 L2 s2 (2 θ̇1 θ̇2 + θ̇2²)"
    assert found["g_1"] == "(m1 + m2) g L1 c1 + m2 g L2 c12"
    assert found["τ_1"] == (
        "((m1 + m2) L1² + m2 L2 (L2 + 2 L1 c2)) θ̈1 + m2 L2 (L2 + L1 c2) θ̈2 "
        "− m2 L1 L2 s2 (2 θ̇1 θ̇2 + θ̇2²) + (m1 + m2) g L1 c1 + m2 g L2 c12"
    )
    assert found["τ_2"] == "m2 L2 (L2 + L1 c2) θ̈1 + m2 L2² θ̈2 + m2 L1 L2 s2 θ̇1² + m2 g L2 c12"
    assert found["P_2"] == "m2 g (L1 s1 + L2 s12)"
    assert found["K_1"] == "½ m1 L1² θ̇1²"


@pytest.mark.capability("09-9", "09-10", "09-13", "09-19", "09-59")
@pytest.mark.parametrize("name", [*ARMS, *BUILT, "rrrp", "scara_rrrp"])
def test_two_roads_and_the_compiled_robot_agree(name: str) -> None:
    """Term by term in letters, and every line in numbers."""
    mechanism = arm_named(name)
    arm = symbolic_arm(mechanism)
    bodies = symbolic_bodies(arm)
    one, two = lagrange(arm, bodies), newton_euler(arm, bodies)
    for a, b in zip(one.tau, two.tau, strict=True):
        assert same(a, b)
        assert not same(a, b + b)
    derivation = derive_dynamics(mechanism)
    assert derivation.worst_error < 1e-11
    assert all(line.error is not None for line in derivation.lines if line.left[0].letter in ("M", "τ", "K", "P", "c"))


def test_mass_matrix_is_symmetric_and_c_is_its_slope_in_letters() -> None:
    arm = symbolic_arm(library.load("planar3r"))
    method = lagrange(arm, symbolic_bodies(arm))
    for i in range(3):
        for j in range(3):
            assert same(method.M[i][j], method.M[j][i])
            slopes = (method.M[i][j].derivative(f"theta{k + 1}") * method.rates[k] for k in range(3))
            assert same(sum(slopes, start=ZERO), method.C[i][j] + method.C[j][i])


@pytest.mark.capability("09-10")
def test_formulas_grow_and_the_growth_is_counted() -> None:
    terms = []
    for name in ("planar2r", "planar3r"):
        arm = symbolic_arm(library.load(name))
        terms.append(operations(*lagrange(arm, symbolic_bodies(arm)).tau)[0])
    assert terms[1] > 3 * terms[0]
    arm = symbolic_arm(library.load("planar2r_point_masses"))
    second = lagrange(arm, symbolic_bodies(arm)).tau[1]
    counted, _, _, sines_and_cosines = operations(second)
    assert (counted, sines_and_cosines) == (5, 3)  # m2 (L2² θ̈1 + L1 L2 c2 θ̈1 + L2² θ̈2 + L1 L2 s2 θ̇1² + g L2 c12)
    text = to_text(derive_dynamics(library.load("panda")), "en")
    assert "7 joints" in text
    assert "inverse_dynamics" in text
    assert "compared" not in text


@pytest.mark.parametrize("language", ["en", "ar"])
@pytest.mark.parametrize("name", ["planar2r", "rrp"])
def test_formats_parse(name: str, language: str) -> None:
    mathtext = pytest.importorskip("matplotlib.mathtext")
    derivation = derive_dynamics(arm_named(name))
    latex = to_latex(derivation, language)
    displays = re.findall(r"\\\[ (.*?) \\\]", latex, re.S)
    assert len(displays) > 20
    parser = mathtext.MathTextParser("path")
    for display in displays:
        if "bmatrix" in display:
            rows = re.sub(r"\\(begin|end)\{bmatrix\}", "", display)
            for cell in re.split(r"&|\\\\", rows):
                parser.parse(f"${cell.strip() or '0'}$")
        else:
            shown = display.replace(r"\bigl", "").replace(r"\bigr", "").replace(r"\tfrac", r"\frac")
            parser.parse(f"${shown}$")
    assert all(ord(c) < 128 for display in displays for c in display), "only commands inside formulas"
    page = to_html(derivation, language)
    for formula_ in re.findall(r"<math.*?</math>", page, re.S):
        ElementTree.fromstring(formula_)
    assert ('dir="rtl"' in page) == (language == "ar")


def test_what_has_no_equations_says_why() -> None:
    bare = Mechanism.assemble("bare", [Link("a"), Link("b")], [Joint("j", JointKind.REVOLUTE, "a", "b")])
    with pytest.raises(ModelError, match="no mass"):
        derive_dynamics(bare)
    body = Inertial(1.0, np.array([0.1, 0, 0]), np.eye(3) * 0.01)
    joints = [Joint(f"j{x}", JointKind.REVOLUTE, "a", x) for x in "bc"]
    fork = Mechanism.assemble("fork", [Link("a"), Link("b", body), Link("c", body)], joints, tip="b")
    with pytest.raises(ModelError, match="link c") as caught:
        derive_dynamics(fork)
    assert "للوصلة c" in caught.value.message("ar")


def test_a_wrong_line_is_never_handed_out(monkeypatch: pytest.MonkeyPatch) -> None:
    import mafsil.derivation.dynamics as module

    true = module.newton_euler
    monkeypatch.setattr(module, "newton_euler", lambda arm, bodies: _spoilt(true(arm, bodies)))
    with pytest.raises(DerivationError, match="different efforts of joint 1"):
        derive_dynamics(library.load("planar2r"))
    monkeypatch.undo()
    right = module.lagrange
    monkeypatch.setattr(module, "lagrange", lambda arm, bodies: _spoilt(right(arm, bodies)))
    with pytest.raises(DerivationError):
        derive_dynamics(library.load("planar2r"))


def _spoilt(method):
    from dataclasses import replace

    return replace(method, tau=(-method.tau[0], *method.tau[1:]))


def test_numbers_of_the_letters_are_those_of_the_robot() -> None:
    arm = symbolic_arm(slider())
    judge = DynamicsJudge(arm, symbolic_bodies(arm))
    assert judge.bodies.letters["I_1m"] == pytest.approx(0.25)
    assert judge.bodies.letters["m3"] == 2.0
    assert formula(judge.bodies.links[0].mass) == "m1"


def test_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["derive", "dynamics", "planar2r", "--lang", "ar"]) == 0
    out = capsys.readouterr().out
    assert "كريستوفل" in out
    assert "θ̈1" in out
    assert main(["derive", "dynamics", "planar2r", "--json"]) == 0
    steps = json.loads(capsys.readouterr().out)["steps"]
    assert any(line["left"] == ["τ_2"] for step in steps for line in step["lines"])
    assert main(["derive", "dynamics", "panda"]) == 0
    assert mf.derivation.derive_dynamics is derive_dynamics
