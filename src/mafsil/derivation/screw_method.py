"""Forward kinematics and Jacobians by products of exponentials, helical joints too, derived step by step in letters.

A run of parallel axes is one turn by the sum of its angles, so that c12 and s123 appear at once:
P_i = E_1 ... E_i has the rotation R_i and the origin p_i = p_i-1 + R_i-1 r_i - R_i r_i + h_i theta_i R_i-1 w_i.

Reference: Lynch & Park, Modern Robotics, sec. 4.1 and 5.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypeAlias

import numpy as np

from mafsil.derivation.document import Derivation, Grid, Line, Name, Step
from mafsil.derivation.matrices import SymbolicPose, plus, product, transform, transpose
from mafsil.derivation.polynomial import symbol
from mafsil.derivation.screw_arm import ScrewArm, ScrewJudge, screw_arm
from mafsil.derivation.table_step import letter_line
from mafsil.derivation.verification import STATES
from mafsil.errors import InputError
from mafsil.model import Mechanism

Form: TypeAlias = Literal["dh", "screws"]
LONGEST = 1500
"""Factors and terms of a product on paper; longer ones stay products."""
_AXES = "xyz"


def wants_screws(form: str) -> bool:
    """Whether the method is that of screws.

    Raises:
        InputError: neither `dh` nor `screws`.
    """
    if form not in ("dh", "screws"):
        raise InputError("derivation.form", value=form, known="dh, screws")
    return form == "screws"


def fk_by_screws(mechanism: Mechanism) -> Derivation:
    """T_st = exp([S_1] q_1) ... exp([S_n] q_n) M, every line checked.

    Args:
        mechanism: its chain to the tip may have revolute, prismatic and helical joints.
    """
    arm = screw_arm(mechanism)
    judge = ScrewJudge(arm)
    found = arm.products(LONGEST)
    steps = [_table(arm, judge), _exponentials(arm, judge), _products(judge, found), _tip(arm, judge, found)]
    return Derivation("derivation.fk_title", mechanism.name, tuple(steps), STATES)


def jacobian_by_screws(mechanism: Mechanism) -> Derivation:
    """J_s,i = Ad(E_1 ... E_i-1) S_i, every line checked.

    Args:
        mechanism: its chain to the tip may have revolute, prismatic and helical joints.
    """
    arm = screw_arm(mechanism)
    judge = ScrewJudge(arm)
    found = arm.products(LONGEST)
    before = found[: arm.n]
    columns = [arm.moved_screw(i, pose) for i, pose in enumerate(before)]
    lines = [
        judge.line((Name("J", f"s,{i}"),), tuple((x,) for x in column), truth=judge.J_s[:, :, i - 1 : i])
        for i, column in enumerate(columns, start=1)
    ]
    steps = [_table(arm, judge), _exponentials(arm, judge), _products(judge, before)]
    steps.append(Step("derivation.screw_columns", {}, tuple(lines)))
    if len(columns) < arm.n:
        steps.append(Step("derivation.screw_columns_long", {"count": len(columns), "limit": LONGEST}))
    else:
        whole = judge.line((Name("J", "s"),), transpose(tuple(columns)), truth=judge.J_s)
        steps.append(Step("derivation.whole", {}, (whole,)))
    return Derivation("derivation.jacobian_title", mechanism.name, tuple(steps), STATES)


def _table(arm: ScrewArm, judge: ScrewJudge) -> Step:
    """Screws and home pose, and what the letters stand for."""
    head = (Name("i"), *(Name("ω", a) for a in _AXES), *(Name("v", a) for a in _AXES))
    rows = tuple((str(i), *arm.screw(i - 1)) for i in range(1, arm.n + 1))
    lines = [letter_line(name, value) for name, value in arm.letters.items()]
    for i, joint in enumerate(arm.joints, start=1):
        if joint.turns:
            lines.append(Line((Name(f"theta{i}"),), (symbol(f"q{i}"),)))
    lines.append(judge.line((Name("M"),), arm.home.entries, truth=judge.home))
    return Step("derivation.screw_table", {"robot": arm.mechanism.name}, tuple(lines), Grid(head, rows))


def _exponentials(arm: ScrewArm, judge: ScrewJudge) -> Step:
    lines = [
        judge.line((Name("E", str(i)),), arm.exponential(i - 1).entries, truth=judge.exponential(i))
        for i in range(1, arm.n + 1)
    ]
    return Step("derivation.screw_exponentials", {}, tuple(lines))


def _products(judge: ScrewJudge, found: Sequence[SymbolicPose]) -> Step:
    """P_2 and the later ones; P_1 is E_1."""
    lines: list[Line] = []
    for i, pose in enumerate(found[2:], start=2):
        sides = (Name("P" if i > 2 else "E", str(i - 1)), Name("E", str(i)))
        lines.append(judge.line((Name("P", str(i)),), sides, pose.entries, truth=judge.moved[i]))
    return Step("derivation.screw_products", {}, tuple(lines))


def _tip(arm: ScrewArm, judge: ScrewJudge, found: Sequence[SymbolicPose]) -> Step:
    """T_st in formulas, or as a product of what was written before."""
    last = len(found) - 1
    names = [Name("P" if last > 1 else "E", str(last))] if last else []
    names += [Name("E", str(i)) for i in range(last + 1, arm.n + 1)] + [Name("M")]
    if last < arm.n:
        T = judge.matrix(found[-1].entries)
        for i in range(last, arm.n):
            T = T @ judge.matrix(arm.exponential(i).entries)
        error = float(np.abs(T @ judge.matrix(arm.home.entries) - judge.tip).max())
        details = {"count": last, "limit": LONGEST, "tip": arm.mechanism.tip}
        return Step("derivation.screw_result_long", details, (Line((Name("T", "st"),), (tuple(names),), error),))
    R = product(found[-1].R, arm.home.R)
    p = plus(found[-1].p, transform(found[-1].R, arm.home.p))
    lines = [Line((Name("T", "st"),), (tuple(names),), 0.0)]
    for r in range(3):
        for c in range(3):
            lines.append(judge.line((Name("r", f"{r + 1}{c + 1}"),), R[r][c], truth=judge.tip[:, r, c]))
    for r, axis in enumerate(_AXES):
        lines.append(judge.line((Name("p", axis),), p[r], truth=judge.tip[:, r, 3]))
    return Step("derivation.screw_result", {"tip": arm.mechanism.tip}, tuple(lines))
