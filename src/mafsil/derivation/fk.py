"""Forward kinematics derived step by step from the Denavit-Hartenberg table."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mafsil.arrays import Floats
from mafsil.derivation.arm import SymbolicArm, compose, symbolic_arm
from mafsil.derivation.document import Derivation, Line, Name, Step, table_step
from mafsil.derivation.polynomial import ONE, ZERO, SymbolicPose, product, symbol, transform, transpose
from mafsil.derivation.screw_method import Form, fk_by_screws, wants_screws
from mafsil.derivation.verification import STATES, Judge
from mafsil.model import Mechanism
from mafsil.model.denavit_hartenberg import Convention
from mafsil.model.loading import of_mechanism

LONGEST = 2500
"""Factors and terms of a pose on paper; what is longer fills pages and teaches nothing."""


@of_mechanism
def derive_fk(mechanism: Mechanism, *, convention: Convention | str | None = None, form: Form = "dh") -> Derivation:
    """T_s,tip(q) as formulas, in numbered steps, every line compared with the compiled robot at random states.

    T_s,tip = T_s0 T_01 ... T_n-1,n T_n,tip, or exp([S_1] q_1) ... exp([S_n] q_n) M. What would be too long on paper is
    left as a product of shorter matrices.

    Args:
        mechanism: its chain to the tip may have revolute and prismatic joints, and helical ones with screws.
        convention: `modified` or `classic` table; that in which the robot was typed, else modified, if None.
        form: `dh` or `screws`, products of exponentials.

    Raises:
        InputError: an unknown form.
        ModelError: a helical joint (with a table) or a mimic joint, or none at all; an unknown convention.
        DerivationError: a line differs from the compiled robot; nothing is handed out then.
    """
    if wants_screws(form):
        return fk_by_screws(mechanism)
    arm = symbolic_arm(mechanism, convention)
    judge, frames = Judge(arm), arm.frames(LONGEST)
    steps = [table_step(arm), _links(arm, judge), *products(arm, judge, arm.shown(frames))]
    steps += [_result(arm, judge)] if len(frames) > arm.n else blocks(arm, judge, len(frames) - 1)
    return Derivation("derivation.fk_title", mechanism.name, tuple(steps), STATES)


def blocks(arm: SymbolicArm, judge: Judge, start: int) -> list[Step]:
    """The frames behind {start}, whose poses in {s} are too long: products of several links each, and their product.

    Args:
        arm: in letters.
        judge: of it.
        start: number of the last frame that was multiplied out.
    """
    s, lines, names, total = base_letter(arm), list[Line](), list[Name](), judge.shown_frames[start]
    names.append(Name("T", f"{s}{start}"))
    first = start
    while first < arm.n:
        last, pose = arm.block(first, LONGEST)
        if arm.classic is not None:
            pose = _between_ends(arm, first, last, pose)
        truth = _relative(judge, first, last)
        name = Name("T", f"{first},{last}")
        if last > first + 1:
            lines.append(judge.line((name,), pose.entries, truth=truth))
        names.append(name)
        total = total @ judge.matrix(pose.entries)
        first = last
    if not is_identity(arm.shown_tool):
        lines.append(_tool_line(arm, judge))
        names.append(Name("T", f"{arm.n}t"))
        total = total @ judge.matrix(arm.shown_tool.entries)
    lines.append(Line((Name("T", f"{s}t"),), (tuple(names),), float(np.abs(total - judge.tip).max())))
    return [Step("derivation.fk_blocks", {"frame": start, "limit": LONGEST, "tip": arm.mechanism.tip}, tuple(lines))]


def _between_ends(arm: SymbolicArm, first: int, last: int, pose: SymbolicPose) -> SymbolicPose:
    """The pose between frames of the classic table from that between those of the modified one."""
    assert arm.classic is not None
    ended = compose(pose, arm.classic.ends[last - 1])
    if first == 0:
        return ended
    end = arm.classic.ends[first - 1]
    back = transpose(end.R)
    return compose(SymbolicPose(back, tuple(-x for x in transform(back, end.p))), ended)


def base_letter(arm: SymbolicArm) -> str:
    """`0` if the table starts in the space frame, else `s`."""
    return "0" if is_identity(arm.base) else "s"


def is_identity(pose: SymbolicPose) -> bool:
    """Whether a constant pose is none."""
    flat = [x for row in pose.R for x in row]
    ones = (0, 4, 8)
    return all((x - (ONE if k in ones else ZERO)).is_zero for k, x in enumerate(flat)) and all(
        x.is_zero for x in pose.p
    )


def _relative(judge: Judge, first: int, last: int) -> Floats:
    """(states, 4, 4) T_first,last of the frames that are shown, in numbers."""
    return np.asarray(np.linalg.inv(judge.shown_frames[first]) @ judge.shown_frames[last], dtype=np.float64)


def _links(arm: SymbolicArm, judge: Judge) -> Step:
    """T_i-1,i of every row."""
    lines: list[Line] = []
    for i in range(1, arm.n + 1):
        truth = _relative(judge, i - 1, i)
        lines.append(judge.line((Name("T", f"{i - 1}{i}"),), arm.shown_link(i).entries, truth=truth))
    return Step("derivation.links" if arm.classic is None else "derivation.links_classic", {}, tuple(lines))


def products(arm: SymbolicArm, judge: Judge, poses: Sequence[SymbolicPose]) -> list[Step]:
    """One step for the base if there is one, and one for every further frame that is given."""
    s = base_letter(arm)
    steps: list[Step] = []
    if s == "s":
        line = judge.line((Name("T", "s0"),), poses[0].entries, truth=judge.shown_frames[0])
        steps.append(Step("derivation.base", {}, (line,)))
    for i in range(1 if s == "s" else 2, len(poses)):
        sides = (Name("T", f"{s}{i - 1}"), Name("T", f"{i - 1}{i}"))
        line = judge.line((Name("T", f"{s}{i}"),), sides, poses[i].entries, truth=judge.shown_frames[i])
        steps.append(Step(_reason(arm, i), {"i": i, "before": i - 1}, (line,)))
    return steps


def _reason(arm: SymbolicArm, i: int) -> str:
    """The sentence of a product: angles add up where neighbouring axes are parallel."""
    row = arm.rows[i - 1]
    turns = i > 1 and row.row.kind == "R" and arm.rows[i - 2].row.kind == "R"
    if row.alpha or row.alpha_quarters % 2 or not turns:
        return "derivation.product"
    return "derivation.product_opposite" if row.alpha_quarters % 4 == 2 else "derivation.product_parallel"


def _result(arm: SymbolicArm, judge: Judge) -> Step:
    """The tip: product with the tool, then every entry on its own line."""
    s, tip = base_letter(arm), arm.poses()[-1]
    names: list[Name] = [Name("T", f"{s}{arm.n}")]
    lines: list[Line] = []
    if not is_identity(arm.shown_tool):
        lines.append(_tool_line(arm, judge))
        names.append(Name("T", f"{arm.n}t"))
    lines.append(Line((Name("T", f"{s}t"),), (tuple(names),), 0.0))
    for r in range(3):
        for c in range(3):
            lines.append(judge.line((Name("r", f"{r + 1}{c + 1}"),), tip.R[r][c], truth=judge.tip[:, r, c]))
    for r, axis in enumerate("xyz"):
        lines.append(judge.line((Name("p", axis),), tip.p[r], truth=judge.tip[:, r, 3]))
    if _has_heading(arm):
        lines.append(_heading(arm, judge))
    return Step("derivation.result", {"tip": arm.mechanism.tip}, tuple(lines))


def _tool_line(arm: SymbolicArm, judge: Judge) -> Line:
    tool = np.broadcast_to(np.asarray(arm.shown_table.tool), (STATES, 4, 4))
    return judge.line((Name("T", f"{arm.n}t"),), arm.shown_tool.entries, truth=tool)


def _has_heading(arm: SymbolicArm) -> bool:
    """Whether the arm moves in the x-y plane and its tip's x axis makes the sum of all angles."""
    turned = product(arm.base.R, arm.tool.R)
    return "L1" in arm.letters and is_identity(SymbolicPose(turned, (ZERO, ZERO, ZERO))) and is_identity(arm.base)


def _heading(arm: SymbolicArm, judge: Judge) -> Line:
    """phi = theta1 + theta2 + ... of a planar arm, compared as a direction."""
    total = sum((symbol(f"theta{i}") for i in range(1, arm.n + 1)), start=ZERO)
    phi = judge.number(total)
    error = float(np.abs(judge.tip[:, :2, 0] - np.stack([np.cos(phi), np.sin(phi)], axis=-1)).max())
    return Line((Name("φ"),), (total,), error)
