"""Typed Jacobians against other lengths than the robot's: letters exchanged or left out are found, ours are said."""

import pytest

from mafsil.derivation import Mistake, check_jacobian
from mafsil.model import mechanism_from_dh
from mafsil.model.denavit_hartenberg import DHRow

RIGHT = [["-L1*s1 - L2*s12", "-L2*s12"], ["L1*c1 + L2*c12", "L2*c12"]]


def review(*entries, **options):
    return check_jacobian([entries[:2], entries[2:]], "planar2r", kind="tip", **options)


def test_both_lengths_are_one_and_still_told_apart():
    assert review(*RIGHT[0], *RIGHT[1])
    exchanged = review("-L2*s1 - L1*s12", "-L1*s12", "L2*c1 + L1*c12", "L1*c12")
    assert [finding.mistake for finding in exchanged] == [Mistake.LETTER] * 4
    assert exchanged.findings[0].expected == "-L1 * s1 - L2 * s12"
    bare = review("-s1 - s12", "-s12", "c1 + c12", "c12")
    assert [finding.mistake for finding in bare] == [Mistake.LENGTHS] * 4
    assert [finding.expected for finding in bare][:2] == ["−L1 s1 − L2 s12", "L1 c1 + L2 c12"]


def test_lengths_typed_as_numbers_are_right():
    assert review("-1*s1 - 1*s12", "-1*s12", "1*c1 + 1*c12", "1*c12")


def test_own_letters_are_read_by_their_numbers():
    rows = ("-u*s1 - w*s12", "-w*s12", "u*c1 + w*c12", "w*c12")
    assert review(*rows, values={"u": 1.0, "w": 1.0})
    mixed = review("-u*s1 - w*s12", "-u*s12", "u*c1 + w*c12", "w*c12", values={"u": 1.0, "w": 1.0})
    assert [(f.mistake, f.row, f.column, f.expected) for f in mixed] == [(Mistake.LETTER, 1, 2, "-w * s12")]


@pytest.mark.parametrize(
    ("text", "mistake"),
    [
        ("L1*s1 - L2*s12", Mistake.TERM_SIGN),
        ("-L1*s1", Mistake.VALUE),
        ("-L1*c1 - L2*c12", Mistake.SINE_COSINE),
        ("-L1*c1 + L2*c12", Mistake.VALUE),
        ("L1*c12 + 3", Mistake.VALUE),
    ],
)
def test_the_right_formula_is_always_said(text, mistake):
    (finding,) = review(text, *RIGHT[0][1:], *RIGHT[1]).findings
    assert finding.mistake is mistake
    assert finding.expected
    for language in ("en", "ar"):
        sentence = finding.message(language)
        assert finding.expected in sentence
        assert "should be ;" not in sentence


def test_a_missing_column_in_six_rows_says_the_whole_column():
    arm = mechanism_from_dh([DHRow(), DHRow(a=0.5)], "modified", tool=None)
    rows = [["0", "0"], ["0", "0"], ["1", "1"], ["0", "0"], ["0", "0"], ["0", "0"]]
    (finding,) = check_jacobian(rows, arm).findings
    assert finding.mistake is Mistake.NO_MOMENT
    assert finding.expected == "(0, 0, 1, L1 s1, −L1 c1, 0)"
