"""Work of students: every usual mistake is planted and has to be named, place and kind; right work passes."""

from dataclasses import replace
from math import degrees, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.derivation import Mistake, check_dh, check_jacobian, check_screws
from mafsil.derivation.formula_text import evaluate, parse_formula
from mafsil.errors import InputError
from mafsil.model import library, screws
from mafsil.model.denavit_hartenberg import DHRow
from mafsil.model.dh_from_axes import dh_from_mechanism
from mafsil.model.library import textbook
from mafsil.robot import Robot

PUMA = library.load("puma560")
ROWS = dh_from_mechanism(PUMA).rows


def changed(rows, index, **entries):
    return [replace(row, **entries) if i == index else row for i, row in enumerate(rows)]


def named(review):
    return [(finding.mistake, finding.row, finding.entry) for finding in review.findings]


@pytest.mark.parametrize("convention", ["modified", "classic"])
@pytest.mark.parametrize("name", library.robots())
def test_right_tables_pass_whatever_frames_were_chosen(name, convention):
    robot = library.load(name)
    table = dh_from_mechanism(robot, convention)
    assert check_dh(table.rows, robot, convention).correct
    assert check_dh(table.rows, robot, convention, base=table.base, tool=table.tool).correct


@pytest.mark.parametrize(
    ("rows", "finding"),
    [
        (changed(ROWS, 2, a=-ROWS[2].a), (Mistake.SIGN, 3, "a")),
        (changed(ROWS, 2, d=-ROWS[2].d), (Mistake.SIGN, 3, "d")),
        (changed(ROWS, 3, alpha=-ROWS[3].alpha), (Mistake.SIGN, 4, "alpha")),
        (changed(ROWS, 3, a=ROWS[3].d, d=ROWS[3].a), (Mistake.LENGTHS_SWAPPED, 4, "a, d")),
        (changed(ROWS, 4, alpha=degrees(ROWS[4].alpha)), (Mistake.DEGREES, 5, "alpha")),
        (changed(ROWS, 4, kind="P"), (Mistake.KIND, 5, "kind")),
        (changed(ROWS, 2, a=0.4), (Mistake.VALUE, 3, "a")),
        ([replace(r, alpha=degrees(r.alpha)) for r in ROWS], (Mistake.DEGREES, None, "alpha")),
        (
            [replace(r, alpha=degrees(r.alpha), theta=degrees(r.theta)) for r in ROWS],
            (Mistake.DEGREES, None, "alpha, theta"),
        ),
        (
            [replace(r, a=a) for r, a in zip(ROWS, [*(r.a for r in ROWS[1:]), ROWS[0].a], strict=True)],
            (Mistake.ROW_SHIFTED, None, "a"),
        ),
        (dh_from_mechanism(PUMA, "classic").rows, (Mistake.CONVENTION, None, "")),
    ],
)
def test_slips_in_the_table_of_the_puma(rows, finding):
    review = check_dh(rows, PUMA)
    assert named(review) == [finding]
    assert review.message("en") != review.message("ar")


def test_exchanged_angles_and_missing_offsets():
    """In an arm whose frames are pinned by base and tool."""
    arm = textbook.spatial3r(1.0, 0.5)
    rows = [DHRow(), DHRow(alpha=pi / 2, a=1.0, theta=-pi / 2), DHRow(alpha=-pi / 2, a=0.5)]
    pinned = {"base": np.eye(4), "tool": np.eye(4)}
    assert check_dh(rows, arm, **pinned).correct
    swapped = changed(rows, 1, alpha=-pi / 2, theta=pi / 2)
    assert named(check_dh(swapped, arm, **pinned)) == [(Mistake.ANGLES_SWAPPED, 2, "alpha, theta")]
    missing = changed(rows, 1, theta=0.0)
    assert named(check_dh(missing, arm, **pinned)) == [(Mistake.OFFSET, 2, "theta")]


def test_two_slips_are_both_named():
    rows = changed(changed(ROWS, 2, d=-ROWS[2].d), 3, a=ROWS[3].d, d=ROWS[3].a)
    assert named(check_dh(rows, PUMA)) == [(Mistake.SIGN, 3, "d"), (Mistake.LENGTHS_SWAPPED, 4, "a, d")]


@settings(deadline=None, max_examples=12)
@given(st.sampled_from(library.robots()), st.integers(0, 6), st.sampled_from(["a", "d"]), st.floats(0.05, 0.4))
def test_a_wrong_length_never_passes_unless_it_is_free(name, index, field, by):
    robot = library.load(name)
    table = dh_from_mechanism(robot)
    rows = list(table.rows)
    index %= len(rows)
    rows[index] = replace(rows[index], **{field: getattr(rows[index], field) + by})
    review = check_dh(rows, robot, base=table.base, tool=table.tool)
    assert not review.correct


@pytest.mark.parametrize(
    ("arm", "rows", "mistake"),
    [(textbook.spatial3r(1.0, 0.5), [2], Mistake.CROSS_ORDER), (textbook.arm6r(0.6), [3, 4], Mistake.CROSS_ORDER)],
)
def test_the_printed_screws_of_the_book(arm, rows, mistake):
    """Errata 2 and 4: v printed with the other sign."""
    S = screws(arm).S_s.copy()
    S[rows, 3:] *= -1
    review = check_screws(S, arm)
    assert [(finding.row, finding.mistake) for finding in review.findings] == [(row + 1, mistake) for row in rows]
    assert review.proven
    assert check_screws(screws(arm).S_s, arm).correct
    assert check_screws(screws(arm).S_b, arm, "body").correct


def planted(mistake, S, i):
    S = S.copy()
    w, v = S[i, :3].copy(), S[i, 3:].copy()
    match mistake:
        case Mistake.REVERSED:
            S[i] *= -1
        case Mistake.NO_MOMENT:
            S[i, 3:] = 0
        case Mistake.PARTS_SWAPPED:
            S[i] = [*v, *w]
        case Mistake.POINT_AS_MOMENT:
            S[i, 3:] = np.cross(w, v)
        case Mistake.NOT_UNIT:
            S[i] *= 2.5
        case Mistake.KIND:
            S[i] = [0, 0, 0, *w]
        case Mistake.VALUE:
            S[i, 3:] += 0.123
    return S


@pytest.mark.parametrize(
    "mistake",
    [
        Mistake.REVERSED,
        Mistake.NO_MOMENT,
        Mistake.PARTS_SWAPPED,
        Mistake.POINT_AS_MOMENT,
        Mistake.NOT_UNIT,
        Mistake.KIND,
        Mistake.VALUE,
    ],
)
def test_slips_in_screws(mistake):
    arm = library.load("ur5e")
    review = check_screws(planted(mistake, screws(arm).S_s, 3), arm)
    assert [(finding.mistake, finding.row) for finding in review.findings] == [(mistake, 4)]
    assert review.message("en") != review.message("ar")


def test_whole_lists_of_screws():
    arm = textbook.arm6r(0.5)
    S = screws(arm).S_s
    assert check_screws(screws(arm).S_b, arm).findings[0].mistake is Mistake.FRAME
    assert check_screws(np.roll(S, 3, axis=1), arm).findings[0].mistake is Mistake.PARTS_SWAPPED


TWO = textbook.planar2r((1.0, 0.7))
RIGHT = [["-L1*s1 - L2*s12", "-L2*s12"], ["L1*c1 + L2*c12", "L2*c12"]]


def test_erratum_27_columns_are_position_vectors():
    printed = [["L1*c1", "L1*c1 + L2*c12"], ["L1*s1", "L1*s1 + L2*s12"]]
    review = check_jacobian(printed, TWO, kind="tip")
    assert [finding.mistake for finding in review.findings] == [Mistake.POSITION_VECTOR] * 2
    assert check_jacobian(RIGHT, TWO, kind="tip").correct


@pytest.mark.parametrize(
    ("row", "column", "text", "mistake"),
    [
        (0, 0, "-L1*s1 + L2*s12", Mistake.TERM_SIGN),
        (1, 0, "L1*c1 + L2*s12", Mistake.SINE_COSINE),
        (1, 0, "L1*c1 + L2*c2", Mistake.ANGLE),
        (0, 1, "L2*s12", Mistake.SIGN),
        (1, 1, "L2*cos(q1 - q2)", Mistake.TERM_SIGN),
        (1, 1, "L1*c12 + 3", Mistake.VALUE),
    ],
)
def test_slips_in_formulas(row, column, text, mistake):
    J = [list(line) for line in RIGHT]
    J[row][column] = text
    review = check_jacobian(J, TWO, kind="tip")
    assert [(f.mistake, f.row, f.column) for f in review.findings] == [(mistake, row + 1, column + 1)]
    assert review.message("en") != review.message("ar")


@pytest.mark.parametrize("name", ["puma560", "rrprrr_upright"])
@pytest.mark.parametrize("kind", ["space", "body", "tip"])
def test_slips_in_numbers(name, kind):
    robot = Robot(library.load(name))
    q = np.random.default_rng(2).uniform(-1, 1, robot.n)
    space, body = np.asarray(robot.jacobian_space(q)), np.asarray(robot.jacobian_body(q))
    tip = np.array(space)
    p = np.asarray(robot.forward_kinematics(q))[:3, 3]
    tip[3:] += np.cross(space[:3], p[:, None], axis=0)
    right = {"space": space, "body": body, "tip": tip}
    J = right[kind]
    assert check_jacobian(J, robot.mechanism, q, kind).correct
    other = "body" if kind != "body" else "space"
    assert check_jacobian(right[other], robot.mechanism, q, kind).findings[0].mistake is Mistake.FRAME
    assert check_jacobian(np.roll(J, 3, axis=0), robot.mechanism, q, kind).findings[0].mistake is Mistake.PARTS_SWAPPED
    assert check_jacobian(J.T, robot.mechanism, q, kind).findings[0].mistake is Mistake.TRANSPOSED
    wrong = J.copy()
    wrong[:, 4] *= -1
    assert [(f.mistake, f.column) for f in check_jacobian(wrong, robot.mechanism, q, kind).findings] == [
        (Mistake.REVERSED, 5)
    ]
    wrong = J.copy()
    wrong[3:] *= -1
    assert check_jacobian(wrong, robot.mechanism, q, kind).findings[0].mistake is Mistake.CROSS_ORDER
    wrong = J.copy()
    wrong[5, 5] += 0.2
    assert [(f.mistake, f.row, f.column) for f in check_jacobian(wrong, robot.mechanism, q, kind).findings] == [
        (Mistake.VALUE, 6, 6)
    ]


def test_screws_at_zero_and_degrees_in_numbers():
    robot = Robot(PUMA)
    q = np.array([0.2, -0.4, 0.6, 0.3, 0.9, -0.5])
    assert check_jacobian(screws(PUMA).S_s.T, PUMA, q).findings[0].mistake is Mistake.ZERO_CONFIGURATION
    assert check_jacobian(robot.jacobian_space(np.degrees(q)), PUMA, q).findings[0].mistake is Mistake.DEGREES


def test_formulas_of_an_own_alphabet():
    arm = textbook.scara_rrrp(0.2, 0.6, 0.4)
    rows = [["0"] * 4, ["0"] * 4, ["1", "1", "1", "0"]]
    rows += [["0", "l*s1", "l*s1 + m*s12", "0"], ["0", "-l*c1", "-l*c1 - m*c12", "0"], ["0", "0", "0", "-1"]]
    assert check_jacobian(rows, arm, values={"l": 0.6, "m": 0.4}).correct
    assert not check_jacobian(rows, arm, values={"l": 0.6, "m": 0.5}).correct


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')",
        "().__class__",
        "[1][0]",
        "lambda: 1",
        "q1 if q2 else 0",
        "exec('1')",
        "2**99999",
        "q1**q2",
        "'a'*3",
        "sin(q1, q2)",
        "sin(x=q1)",
        "1 +",
        "True",
        "9" * 400,
        "-" * 1500 + "1",
        "1" + "+1" * 900,
        "f(q1)",
        "q1; q2",
    ],
)
def test_hostile_and_broken_formulas_are_refused(text):
    with pytest.raises(InputError):
        evaluate(parse_formula(text), {"q1": 1.0, "q2": 2.0})


@given(st.text(max_size=60))
def test_any_text_is_a_formula_or_one_clear_error(text):
    try:
        value = evaluate(parse_formula(text), {"q1": 1.0})
    except InputError:
        return
    assert np.isreal(value)


@pytest.mark.parametrize(
    ("call", "key"),
    [
        (lambda: check_dh(ROWS[:3], PUMA), "derivation.rows"),
        (lambda: check_screws(np.zeros((6, 6)), PUMA, "tip"), "derivation.form"),
        (lambda: check_screws(np.zeros((5, 6)), PUMA), "input.shape"),
        (lambda: check_jacobian(np.zeros((6, 6)), PUMA), "derivation.q_missing"),
        (lambda: check_jacobian(np.zeros((5, 6)), PUMA, np.zeros(6)), "input.shape"),
        (lambda: check_jacobian(np.zeros((6, 6)), PUMA, np.zeros(6), "world"), "derivation.form"),
        (lambda: check_jacobian([["q1", "q1"], ["q1"]], TWO, kind="tip"), "derivation.ragged"),
        (lambda: check_jacobian([["x9", "0"], ["0", "0"]], TWO, kind="tip"), "derivation.formula_name"),
        (lambda: check_jacobian([["1" * 5000, "0"], ["0", "0"]], TWO, kind="tip"), "derivation.formula_long"),
        (lambda: check_jacobian([["q1(", "0"], ["0", "0"]], TWO, kind="tip"), "derivation.formula"),
    ],
)
def test_wrong_questions_are_refused_in_both_languages(call, key):
    with pytest.raises(InputError) as caught:
        call()
    assert caught.value.key == key
    assert caught.value.message("en") != caught.value.message("ar")
