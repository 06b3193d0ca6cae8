"""Tables of students over many arms: right ones in any frames pass, every planted mistake is named, smallest first."""

import re
from dataclasses import replace
from math import degrees, pi

import numpy as np
import pytest

from mafsil.derivation import Mistake, check_dh, check_screws
from mafsil.model import library, screws
from mafsil.model.denavit_hartenberg import DHRow, mechanism_from_dh
from mafsil.model.dh_from_axes import Relation, dh_from_mechanism
from mafsil.model.placement import adjoint, pose_from_xyz_rpy

ARMS = ["puma560", "ur5e", "stanford_arm", "planar3r", "scara_rrrp", "panda", "rrprrr", "spatial3r"]
SHAPES = ["parallel", "sliding", "one", "general", "square", "almost parallel", "coaxial"]


def random_pose(rng, far=1.0):
    return pose_from_xyz_rpy(tuple(rng.uniform(-far, far, 3)), tuple(rng.uniform(-pi, pi, 3)))


def random_rows(rng, shape):
    """Rows of an arm of that shape."""
    n = 1 if shape == "one" else int(rng.integers(2, 7))
    rows = []
    for i in range(n):
        alpha = {"parallel": rng.choice([0.0, pi]), "square": pi / 2 * rng.integers(-1, 3), "coaxial": 0.0}.get(
            shape, rng.uniform(1e-6, 1e-4) if shape == "almost parallel" else rng.uniform(-pi, pi)
        )
        kind = "P" if shape == "sliding" or (shape != "one" and rng.random() < 0.2) else "R"
        a = 0.0 if shape == "coaxial" or rng.random() < 0.3 else rng.uniform(-1, 1)
        rows.append(DHRow(a, float(alpha) if i else 0.0, rng.uniform(-1, 1), rng.uniform(-pi, pi), kind))
    return rows


def in_other_frames(rng, rows):
    """The same arm in a modified table whose {0} and {n}, and frames on parallel axes, were chosen otherwise."""
    rows = list(rows)
    rows[0] = replace(rows[0], a=rng.uniform(-1, 1), alpha=rng.uniform(-pi, pi))
    rows[0] = replace(rows[0], theta=rng.uniform(-pi, pi), d=rng.uniform(-1, 1))
    if len(rows) > 1:
        turn, shift = rng.uniform(-pi, pi), rng.uniform(-1, 1)
        rows[-1] = replace(rows[-1], theta=rows[-1].theta + turn, d=rows[-1].d + shift)
    for i in range(1, len(rows)):
        side = np.cos(rows[i].alpha)
        if abs(abs(side) - 1) < 1e-15 and rng.random() < 0.7:
            shift = rng.uniform(-0.5, 0.5)
            rows[i - 1] = replace(rows[i - 1], d=rows[i - 1].d + shift)
            rows[i] = replace(rows[i], d=rows[i].d - side * shift)
    return rows


@pytest.mark.parametrize("shape", SHAPES)
def test_right_tables_pass_in_whatever_frames(shape):
    """Bases and tools turned by any angle, frames slid along parallel axes: 504 random arms."""
    rng = np.random.default_rng(SHAPES.index(shape))
    for _ in range(72):
        rows = random_rows(rng, shape)
        arm = mechanism_from_dh(rows, "modified", base=random_pose(rng, 3.0), tool=random_pose(rng))
        assert check_dh(in_other_frames(rng, rows), arm).correct, rows


def test_right_tables_with_given_constants_pass():
    """Base or tool given alone leave the other free; a single joint is an arm as well."""
    rng = np.random.default_rng(3)
    for shape in SHAPES:
        rows = random_rows(rng, shape)
        base, tool = random_pose(rng), random_pose(rng)
        arm = mechanism_from_dh(rows, "modified", base=base, tool=tool)
        for given in ({"base": base}, {"tool": tool}, {"base": base, "tool": tool}):
            assert check_dh(rows, arm, **given).correct, (shape, given)
        if shape != "one":
            assert not check_dh(rows, arm, base=base, tool=tool @ random_pose(rng)).correct


def test_the_straight_arm_seen_from_a_turned_base():
    """All axes parallel and x0 a quarter turn away: the turn about the axes has the right sense."""
    for name in ("planar2r", "planar3r", "scara_rrrp", "cobra600"):
        arm = library.load(name)
        rows = list(dh_from_mechanism(arm).rows)
        for angle in (pi / 2, -pi / 2, 0.3, 2.0, pi):
            assert check_dh([replace(rows[0], theta=angle), *rows[1:]], arm).correct, (name, angle)


@pytest.mark.parametrize("convention", ["modified", "classic"])
@pytest.mark.parametrize("name", ["puma560", "stanford_arm"])
def test_flipped_normals_pass(name, convention):
    arm = library.load(name)
    relations = dh_from_mechanism(arm).relations
    for i, relation in enumerate(relations, start=1):
        if relation is Relation.INTERSECTING:
            assert check_dh(dh_from_mechanism(arm, convention, flipped=[i]).rows, arm, convention).correct


def planted(rows):
    """Single mistakes: name, row from 1, and the table with it."""
    for i, row in enumerate(rows):
        changes = [(Mistake.SIGN, {f: -getattr(row, f)}) for f in ("alpha", "a", "d", "theta") if abs(getattr(row, f))]
        changes += [(Mistake.DEGREES, {f: degrees(getattr(row, f))}) for f in ("alpha", "theta") if getattr(row, f)]
        changes += [(Mistake.OFFSET, {"theta": row.theta + pi}), (Mistake.VALUE, {"a": row.a + 0.137})]
        if row.a != row.d:
            changes.append((Mistake.LENGTHS_SWAPPED, {"a": row.d, "d": row.a}))
        if row.alpha != row.theta:
            changes.append((Mistake.ANGLES_SWAPPED, {"alpha": row.theta, "theta": row.alpha}))
        for mistake, entries in changes:
            yield mistake, i + 1, [replace(r, **entries) if k == i else r for k, r in enumerate(rows)]
    for field in ("a", "alpha"):
        values = np.roll([getattr(row, field) for row in rows], 1)
        yield Mistake.ROW_SHIFTED, None, [replace(r, **{field: float(x)}) for r, x in zip(rows, values, strict=True)]


SHARE = 5
"""One slip in so many is tried on each arm."""


@pytest.mark.parametrize("name", ARMS)
def test_planted_slips_are_named(name):
    """At least 95 of 100; what is not a mistake because base or tool swallow it is right."""
    arm = library.load(name)
    rows = list(dh_from_mechanism(arm).rows)
    named, wrong = 0, []
    # Each arm gets another fifth of the slips; all of them take minutes.
    for mistake, row, table in list(planted(rows))[ARMS.index(name) % SHARE :: SHARE]:
        if table == rows:
            continue
        review = check_dh(table, arm)
        if review.correct:
            continue
        assert review.proven
        first = review.findings[0]
        # A column of lengths shifted by a row is just what the other convention does, and half a turn more than -90
        # degrees is 90.
        same = {Mistake.ROW_SHIFTED: Mistake.CONVENTION, Mistake.OFFSET: Mistake.SIGN}.get(mistake)
        if (first.mistake, first.row) == (mistake, row) or (first.mistake is same and first.row == row):
            named += 1
        else:
            wrong.append((mistake, row, first))
    assert named >= 0.95 * (named + len(wrong)), wrong
    assert named


@pytest.mark.parametrize("name", ["puma560", "ur5e", "stanford_arm"])
def test_the_smallest_repair_comes_first(name):
    """The twist of the last row, not a half turn in the row before."""
    arm = library.load(name)
    rows = list(dh_from_mechanism(arm).rows)
    rows[5] = replace(rows[5], alpha=-rows[5].alpha)
    assert [(f.mistake, f.row, f.entry) for f in check_dh(rows, arm).findings] == [(Mistake.SIGN, 6, "alpha")]


def test_any_wrong_value_is_named_with_the_right_one():
    arm = library.load("planar3r")
    rows = list(dh_from_mechanism(arm).rows)
    rows[1] = replace(rows[1], alpha=0.137)
    (finding,) = check_dh(rows, arm).findings
    assert (finding.mistake, finding.row, finding.entry, finding.expected) == (Mistake.VALUE, 2, "alpha", "0")
    puma = library.load("puma560")
    rows = list(dh_from_mechanism(puma).rows)
    rows[5] = replace(rows[5], a=0.137)
    (finding,) = check_dh(rows, puma).findings
    assert (finding.mistake, finding.row, finding.entry, finding.expected) == (Mistake.VALUE, 6, "a", "0")


def test_a_table_that_is_right_in_the_other_convention_is_told_so():
    arm = library.load("puma560")
    review = check_dh(dh_from_mechanism(arm, "classic").rows, arm)
    assert [finding.mistake for finding in review] == [Mistake.CONVENTION]
    assert "correct in the classic convention" in review.message("en")
    assert "classic" in review.message("ar")
    both = list(dh_from_mechanism(arm, "classic").rows)
    both[2] = replace(both[2], d=both[2].d + 0.05)
    assert [(f.mistake, f.row) for f in check_dh(both, arm)] == [(Mistake.CONVENTION, None), (Mistake.VALUE, 3)]


def test_plain_rows_and_degrees():
    table = dh_from_mechanism(library.load("ur5e"))
    rows = [[row.a, degrees(row.alpha), row.d, degrees(row.theta)] for row in table.rows]
    assert check_dh(rows, "ur5e", degrees=True).correct
    assert check_dh(rows, "ur5e").findings[0].mistake is Mistake.DEGREES
    rows[4][2] *= -1
    assert [(f.mistake, f.row) for f in check_dh(rows, "ur5e")] == [(Mistake.DEGREES, None), (Mistake.SIGN, 5)]


def test_answers_are_read_like_all_others():
    arm = library.load("planar3r")
    right = check_dh(dh_from_mechanism(arm).rows, arm)
    wrong = check_dh([replace(row, a=2 * row.a) for row in dh_from_mechanism(arm).rows], arm)
    assert right
    assert not wrong
    assert not wrong.proven or wrong.findings
    data = wrong.to_dict()
    assert data["correct"] is False
    assert [each["expected"] for each in data["findings"]] == [finding.expected for finding in wrong]
    assert wrong.explain("en") == wrong.message("en") != wrong.message("ar")
    assert not re.search(r"should be ;", wrong.message("en"))


def test_screws_written_in_another_frame():
    arm = library.load("puma560")
    S = screws(arm).S_s
    T = random_pose(np.random.default_rng(1))
    review = check_screws(S @ adjoint(T).T, "puma560")
    assert [finding.mistake for finding in review] == [Mistake.OTHER_BASE]
    assert review.message("en") != review.message("ar")
