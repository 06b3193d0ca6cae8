"""Classic tables as typed, products of exponentials with helical joints, and derivations that stay readable."""

import re

import numpy as np
import pytest

from mafsil.derivation import derive_fk, derive_jacobian, to_html, to_latex, to_text
from mafsil.derivation.arm import typed_classic
from mafsil.derivation.text import formula
from mafsil.errors import InputError, ModelError
from mafsil.messages.isolates import END, LEFT_TO_RIGHT
from mafsil.model import library, mechanism_from_screws
from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.placement import pose_from_xyz_rpy

CLASSIC = [
    DHRow(a=0.1, alpha=np.pi / 2, d=0.4),
    DHRow(a=0.5, d=0.03, theta=np.pi / 2),
    DHRow(alpha=-np.pi / 2, kind="P", d=0.2),
    DHRow(a=0.07, alpha=0.3, d=0.1, theta=0.2),
]


def lines(derivation, name):
    """Formulas of the lines with that name on the left."""
    return [
        side for line in derivation.lines if [n.letter + n.index for n in line.left] == [name] for side in line.sides
    ]


def test_a_classic_table_is_found_as_it_was_typed():
    arm = mechanism_from_dh(CLASSIC, "classic")
    found = typed_classic(arm)
    assert found is not None
    for row, other in zip(CLASSIC, found.rows, strict=True):
        assert row.kind == other.kind
        np.testing.assert_allclose([row.a, row.alpha, row.d, row.theta], [other.a, other.alpha, other.d, other.theta])
    assert typed_classic(mechanism_from_dh(CLASSIC, "modified")) is None
    assert typed_classic(library.load("panda")) is None


@pytest.mark.parametrize("derive", [derive_fk, derive_jacobian])
@pytest.mark.parametrize("tool", [None, pose_from_xyz_rpy((0.1, 0.2, 0.3), (0.4, 0.5, 0.6))])
def test_classic_arms_are_derived_in_their_own_table(derive, tool):
    arm = mechanism_from_dh(CLASSIC, "classic", tool=tool)
    derivation = derive(arm)
    assert derivation.worst_error < 1e-12
    text = to_text(derivation, "en")
    assert "classic Denavit-Hartenberg form" in text
    grid = derivation.steps[0].grid
    assert [
        formula(grid.rows[i][3]) if not isinstance(grid.rows[i][3], str) else grid.rows[i][3] for i in range(3)
    ] == [
        "a1",
        "a2",
        "0",
    ]
    assert grid.rows[1][1] == "theta2+90°"
    assert "modified Denavit-Hartenberg form" in to_text(derive(arm, convention="modified"), "en")
    assert to_text(derivation, "en") != to_text(derivation, "ar")


@pytest.mark.parametrize("name", ["planar3r", "panda", "rrprrr", "scara_rrrp"])
def test_any_arm_is_derived_in_the_classic_convention(name):
    for derive in (derive_fk, derive_jacobian):
        derivation = derive(name, convention="classic")
        assert derivation.worst_error < 1e-12
        assert derivation.steps[0].key == "derivation.table_classic"


@pytest.mark.parametrize("name", ["planar3r", "scara_rrrp", "puma560", "iiwa7", "stanford_arm"])
def test_products_of_exponentials(name):
    for derive in (derive_fk, derive_jacobian):
        assert derive(name, form="screws").worst_error < 1e-12
    if name == "planar3r":
        assert formula(lines(derive_fk(name, form="screws"), "px")[0]) == "L1 c1 + L2 c12 + L3 c123"


def test_helical_joints_are_derived_by_screws():
    """A screw of pitch 0.1 about z, a slanted one, a slide: against the compiled robot, and by hand."""
    slanted = np.array([0.6, 0.0, 0.8])
    S = [[0, 0, 1, 0, 0, 0.1], [*slanted, *(0.05 * slanted - np.cross(slanted, [0.3, 0, 0]))], [0, 0, 0, 1, 0, 0]]
    arm = mechanism_from_screws(S, pose_from_xyz_rpy((0.5, 0.2, 0.3), (0, 0, 0)))
    for derive in (derive_fk, derive_jacobian):
        derivation = derive(arm, form="screws")
        assert derivation.worst_error < 1e-13
        assert "h1 = 0.1 m/rad" in to_text(derivation, "en")
    single = mechanism_from_screws(S[:1], np.eye(4))
    assert formula(lines(derive_fk(single, form="screws"), "pz")[0]) == "h1 θ1"
    assert formula(lines(derive_jacobian(single, form="screws"), "Js")[0][5][0]) == "h1"
    with pytest.raises(ModelError, match="helical"):
        derive_fk(arm)
    with pytest.raises(InputError):
        derive_fk(arm, form="twists")


@pytest.mark.parametrize("convention", ["modified", "classic"])
def test_a_skew_arm_of_eight_joints_stays_readable(convention):
    """Multiplied out it took two minutes and 729,399 characters; now blocks whose product is the pose."""
    rng = np.random.default_rng(0)
    rows = [DHRow(a=x, alpha=y, d=z) for x, y, z in rng.uniform(0.2, 1.4, (8, 3))]
    arm = mechanism_from_dh(rows, convention)
    for derive in (derive_fk, derive_jacobian):
        for form in ("dh", "screws"):
            derivation = derive(arm, form=form)
            assert derivation.worst_error < 1e-9
            assert len(to_text(derivation, "en")) < 60_000
            keys = [step.key for step in derivation.steps]
            assert any(key.endswith(("blocks", "long")) for key in keys)
    pose = derive_fk(arm).steps[-1].lines[-1]
    assert [name.letter for name in pose.left] == ["T"]
    assert pose.error < 1e-12


@pytest.mark.parametrize("name", ["planar2r", "scara_rrrp"])
def test_nothing_foreign_stands_outside_an_isolate_on_arabic_pages(name):
    """Digits, minus signs, halves and powers outside of `bdi` are thrown about by the browser."""
    from mafsil.derivation import derive_dynamics

    derivation = derive_dynamics(name)
    page = to_html(derivation, "ar")
    body = re.sub(r"<math.*?</math>", "", page[page.index("<h1>") :])
    body = re.sub(r'<bdi dir="ltr">.*?</bdi>', "", body)
    assert not re.search(r"[0-9A-Za-zα-ωΑ-Ω½²−°ᵀ]", re.sub(r"<[^>]*>", "", body))
    latex = to_latex(derivation, "ar")
    for item in re.findall(r"\\item (.*)", latex):
        outside = item
        while (shorter := re.sub(r"\\LR\{(?:[^{}]|\{(?:[^{}]|\{[^{}]*\})*\})*\}", "", outside)) != outside:
            outside = shorter
        assert not re.search(r"[0-9A-Za-z$\\]", outside), item
    assert latex.count("{") == latex.count("}")
    assert latex.count("$") % 2 == 0
    for line in to_text(derivation, "ar").splitlines():
        if re.search(r"[A-Za-z]", line):
            assert line.count(LEFT_TO_RIGHT) == line.count(END) > 0


@pytest.mark.parametrize("language", ["en", "ar"])
def test_letters_with_dots_and_double_indices_are_set(language):
    from mafsil.derivation import derive_dynamics

    derivation = derive_dynamics("planar2r")
    page, latex = to_html(derivation, language), to_latex(derivation, language)
    assert "<msub><mi>T</mi><mtext>i,i-1</mtext></msub>" in page
    assert "<msub><mi>q̈</mi><mtext>j</mtext></msub>" in page
    assert "<msub><mi>Γ</mi><mtext>ijk</mtext></msub>" in page
    assert "<msub><mi>V̇</mi><mtext>i</mtext></msub>" in page
    for formula_text in (r"T_{i,i-1}", r"\ddot{q}_{j}", r"\Gamma_{ijk}", r"\dot{V}_{i}"):
        assert formula_text in latex
    assert not re.search(r"[\u0600-\u06ff][A-Za-z]\\_", latex)
    prose = re.sub(r"<math.*?</math>", "", page)
    assert not re.search(r"\w_\w", re.sub(r"<[^>]*>", "", prose[prose.index("<h1>") :]))


@pytest.mark.parametrize("write", [to_text, to_html, to_latex])
def test_other_languages_are_refused_with_the_known_ones(write):
    with pytest.raises(InputError, match="en, ar"):
        write(derive_fk("planar2r"), "fr")
