"""Jacobians derived step by step: axes and points by inspection, columns, tip velocity, determinant and its zeros.

Their entries as text serve the sentence that says what should stand in a student's Jacobian.
"""

from __future__ import annotations

import logging
from collections.abc import Collection, Sequence

import numpy as np

from mafsil.arrays import Floats
from mafsil.derivation.arm import SymbolicArm, symbolic_arm
from mafsil.derivation.determinant import Determinant, determinant
from mafsil.derivation.document import Derivation, Factors, Line, Name, Side, Step, table_step
from mafsil.derivation.fk import base_letter, blocks, products
from mafsil.derivation.polynomial import (
    ZERO,
    Entries,
    Polynomial,
    Row,
    SymbolicPose,
    Trig,
    cross,
    plus,
    simplify,
    transform,
    transpose,
)
from mafsil.derivation.polynomial import cross as moment
from mafsil.derivation.screw_method import Form, jacobian_by_screws, wants_screws
from mafsil.derivation.text import formula
from mafsil.derivation.verification import STATES, Judge
from mafsil.errors import ModelError
from mafsil.messages import say
from mafsil.model import Mechanism
from mafsil.model.denavit_hartenberg import Convention
from mafsil.model.exponentials import chain_to_tip
from mafsil.model.loading import of_mechanism

LONGEST_FRAME = 1200
"""Factors and terms of the longest pose whose axes are multiplied out: their moments are products of its entries."""
MOST_JOINTS = 6
"""Chains with more joints have no square Jacobian."""


@of_mechanism
def derive_jacobian(
    mechanism: Mechanism, *, convention: Convention | str | None = None, form: Form = "dh"
) -> Derivation:
    """J_s(q), the tip's velocity Jacobian and, where it is square, its determinant, every line checked.

    J_s,i = (z_i, p_i x z_i) for a revolute joint with axis z_i through p_i, (0, z_i) for a sliding one; by screws,
    J_s,i = Ad(exp([S_1] q_1) ... exp([S_i-1] q_i-1)) S_i. What would be too long on paper is left as a product.

    Args:
        mechanism: its chain to the tip may have revolute and prismatic joints, and helical ones with screws.
        convention: `modified` or `classic` table; that in which the robot was typed, else modified, if None.
        form: `dh` or `screws`.

    Raises:
        InputError: an unknown form.
        ModelError: a helical joint (with a table) or a mimic joint, or none at all; an unknown convention.
        DerivationError: a line differs from the compiled robot; nothing is handed out then.
    """
    joints = sum(joint.moves for joint in chain_to_tip(mechanism))
    if joints > MOST_JOINTS:
        logging.getLogger("mafsil").info(say("derivation.slow", robot=mechanism.name, joints=joints))
    if wants_screws(form):
        return jacobian_by_screws(mechanism)
    arm = symbolic_arm(mechanism, convention)
    judge, frames = Judge(arm), arm.frames(LONGEST_FRAME)
    if len(frames) <= arm.n:
        steps = [table_step(arm), *products(arm, judge, arm.shown(frames)), *blocks(arm, judge, len(frames) - 1)]
        steps += [_axes(arm, judge, frames), _columns(arm, judge, frames), Step("derivation.jacobian_blocks", {})]
        return Derivation("derivation.jacobian_title", mechanism.name, tuple(steps), STATES)
    poses = arm.poses()
    steps = [table_step(arm), _axes(arm, judge, frames), _columns(arm, judge, frames), *_matrices(arm, judge, poses)]
    if arm.n <= MOST_JOINTS:
        steps += _determinant(arm, judge)
    return Derivation("derivation.jacobian_title", mechanism.name, tuple(steps), STATES)


def space_columns(arm: SymbolicArm) -> Entries:
    """(n, 6) columns of J_s as formulas.

    Args:
        arm: in letters.
    """
    return tuple(_column(arm, i, pose) for i, pose in enumerate(arm.poses()[1:-1]))


def tip_columns(arm: SymbolicArm) -> Entries:
    """(n, 3) partial derivatives of the tip's position in {s} as formulas.

    Args:
        arm: in letters.
    """
    p = arm.poses()[-1].p
    names = [f"theta{i}" if row.row.kind == "R" else f"q{i}" for i, row in enumerate(arm.rows, start=1)]
    return tuple(tuple(simplify(x.derivative(name)) for x in p) for name in names)


def _column(arm: SymbolicArm, index: int, pose: SymbolicPose) -> Row:
    if arm.rows[index].row.kind == "P":
        return (ZERO, ZERO, ZERO, *pose.z)
    return (*pose.z, *cross(pose.p, pose.z))


def _upright(vector: Row) -> Entries:
    return tuple((x,) for x in vector)


def _axes(arm: SymbolicArm, judge: Judge, frames: Sequence[SymbolicPose]) -> Step:
    """Direction and a point of every axis: third and fourth column of T_si, of T_s,i-1 in a classic table."""
    lines: list[Line] = []
    shift = 0 if arm.classic is None else 1
    for i, pose in enumerate(arm.shown(frames)[1 - shift : len(frames) - shift], start=1 - shift):
        frame = judge.shown_frames[i]
        lines.append(judge.line((Name("z", str(i)),), _upright(pose.z), truth=frame[:, :3, 2:3]))
        if arm.rows[i - 1 + shift].row.kind == "R":
            lines.append(judge.line((Name("p", str(i)),), _upright(pose.p), truth=frame[:, :3, 3:4]))
    key = "derivation.axes" if arm.classic is None else "derivation.axes_classic"
    return Step(key, {"s": base_letter(arm)}, tuple(lines))


def _columns(arm: SymbolicArm, judge: Judge, frames: Sequence[SymbolicPose]) -> Step:
    lines: list[Line] = []
    shift = 0 if arm.classic is None else 1
    for i, pose in enumerate(frames[1:], start=1):
        formula = "(z, p × z)" if arm.rows[i - 1].row.kind == "R" else "(0, z)"
        column = _upright(_column(arm, i - 1, pose))
        truth = judge.J_s[:, :, i - 1 : i]
        lines.append(judge.line((Name("J", f"s,{i}"),), _index(formula, i - shift), column, truth=truth))
    return Step("derivation.columns", {}, tuple(lines))


def _index(formula: str, i: int) -> Side:
    parts = {"(z, p × z)": ("(", "z", ", ", "p", " × ", "z", ")"), "(0, z)": ("(0, ", "z", ")")}[formula]
    return tuple(Name(part, str(i)) if part in ("z", "p") else Name(part) for part in parts)


def _matrices(arm: SymbolicArm, judge: Judge, poses: tuple[SymbolicPose, ...]) -> list[Step]:
    """The whole J_s, and the tip's velocity by differentiating its position."""
    whole = judge.line((Name("J", "s"),), transpose(space_columns(arm)), truth=judge.J_s)
    tip = poses[-1].p
    positions = [judge.line((Name("p", a),), tip[r], truth=judge.tip[:, r, 3]) for r, a in enumerate("xyz")]
    truth = judge.J_s[:, 3:] + np.cross(judge.J_s[:, :3], judge.tip[:, :3, 3, None], axisa=1, axisb=1, axisc=1)
    moved = judge.line((Name("J", "p"),), transpose(tip_columns(arm)), truth=truth)
    return [Step("derivation.whole", {}, (whole,)), Step("derivation.tip", {}, (*positions, moved))]


def _determinant(arm: SymbolicArm, judge: Judge) -> list[Step]:
    found = determinant(arm)
    if found is None or any(factor.is_zero for factor in found.factors):
        return []
    truth = _seen(arm, judge, found)
    J = judge.line((Name("J"),), found.columns, truth=truth)
    value = judge.line((Name("det J"),), Factors(found.factors), truth=np.linalg.det(truth))
    details = {"frame": found.frame, "point": found.point if found.point <= arm.n else "t"}
    zeros = tuple(Line((), (zero, "0")) for zero in _zeros(found.factors))
    key = "derivation.determinant" if arm.classic is None else "derivation.determinant_classic"
    steps = [Step(key, details, (J, value))]
    return [*steps, Step("derivation.singular", {}, zeros)] if zeros else steps


def _zeros(factors: tuple[Polynomial, ...]) -> list[Polynomial]:
    """What may vanish: every sine or cosine of the monomial in front, and every bracket."""
    zeros: list[Polynomial] = []
    for factor in factors:
        if len(factor.terms) > 1:
            zeros.append(factor)
            continue
        (monomial,) = factor.terms
        moving = dict.fromkeys(f for f in monomial if isinstance(f, Trig) or f.joint)
        zeros += [Polynomial({(f,): 1.0}) for f in moving if not (isinstance(f, Trig) and _is_constant(f))]
    return zeros


def _is_constant(factor: Trig) -> bool:
    return all(name.startswith("alpha") or name.endswith("_") for name, _ in factor.angle)


def _seen(arm: SymbolicArm, judge: Judge, found: Determinant) -> Floats:
    """(states, rows, n) the Jacobian of the compiled robot, in {frame}, its linear part at the point."""
    R = judge.frames[found.frame][:, :3, :3]
    point = (judge.tip if found.point > arm.n else judge.frames[found.point])[:, :3, 3]
    omega, v = judge.J_s[:, :3], judge.J_s[:, 3:]
    v = v + np.cross(omega, point[:, :, None], axisa=1, axisb=1, axisc=1)
    both = np.concatenate([R.transpose(0, 2, 1) @ omega, R.transpose(0, 2, 1) @ v], axis=1)
    return both[:, list(found.rows)]


MOST_JOINTS_OF_FORMULAS = 7
"""Formulas of longer chains are longer than what a sentence holds."""
LONGEST = 400
"""Characters of one entry."""


def expected_formulas(
    mechanism: Mechanism, kind: str, rows: int, columns: Collection[int]
) -> dict[int, tuple[str, ...]]:
    """The entries of some columns; nothing where they are too long or the arm has no letters.

    Args:
        mechanism: the robot.
        kind: `space`, `body` or `tip`.
        rows: 6, or 3 or 2 of the tip's velocity.
        columns: numbers from 1, in the order of q.
    """
    try:
        arm = symbolic_arm(mechanism, None)
    except ModelError:
        return {}
    if arm.n > MOST_JOINTS_OF_FORMULAS:
        return {}
    found = {arm.coordinates[i] + 1: column for i, column in enumerate(_formula_columns(arm, kind, rows))}
    zero = ("0",) * rows
    texts = {c: tuple(formula(x) for x in found[c]) if c in found else zero for c in set(columns)}
    return {c: text for c, text in texts.items() if max(map(len, text)) <= LONGEST}


def _formula_columns(arm: SymbolicArm, kind: str, rows: int) -> tuple[Row, ...]:
    space = space_columns(arm)
    if kind == "space":
        return space
    if kind == "tip":
        moved = tip_columns(arm)
        return tuple((*column[:3], *p) if rows == 6 else p[:rows] for column, p in zip(space, moved, strict=True))
    tip = arm.poses()[-1]
    turned = transpose(tip.R)
    return tuple(
        (*transform(turned, column[:3]), *transform(turned, plus(column[3:], moment(column[:3], tip.p))))
        for column in space
    )
