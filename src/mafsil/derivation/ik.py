"""Inverse kinematics derived as a person would: the structure of the arm, then joint after joint by geometry.

What the arm was recognised as decides the method, not its name: the same few elementary equations, each with its
meaning, in the arm's own numbers.
"""

from __future__ import annotations

from collections.abc import Callable

from mafsil.arrays import Floats, PoseMatrix
from mafsil.derivation.document import Derivation, Grid, Line, Name, Step
from mafsil.derivation.expression import Expression, function, name_expression, number, plus_minus
from mafsil.derivation.verification import AngleJudge, vector_text
from mafsil.errors import ModelError
from mafsil.mechanics.arm_pattern import ArmPattern, Family, PositioningMethod
from mafsil.model import Mechanism
from mafsil.model.exponentials import chain_to_tip
from mafsil.model.loading import of_mechanism

Solve = Callable[[PoseMatrix], Floats]
"""(4, 4) pose to (k, n) all its solutions: the solver that the lines are checked against."""


@of_mechanism
def derive_ik(mechanism: Mechanism, pattern: ArmPattern | None, solve: Solve) -> Derivation:
    """All solutions for a pose as a chain of formulas, every line compared with the solver's answers.

    Args:
        mechanism: the arm.
        pattern: what it was recognised as (`mafsil.ik.closed_form(robot).pattern`), or None.
        solve: its solutions for a pose.

    Raises:
        ModelError: an arm without such a closed form: more than six joints, or none of the families derived here.
        DerivationError: a line differs from the solver; nothing is handed out then.

    Reference: Pieper, The kinematics of manipulators under computer control, 1968; Paden and Kahan's subproblems.
    """
    if pattern is None or pattern.locked or pattern.shifted or pattern.positioning_reversed or pattern.prismatic[0]:
        raise ModelError("derivation.ik_no_form", robot=mechanism.name)
    methods = {Family.SPHERICAL_WRIST: _wrist_arm, Family.THREE_PARALLEL: _parallel_arm, Family.PLANAR: _planar_arm}
    build = methods.get(pattern.family)
    if build is None or pattern.positioning not in (PositioningMethod.PARALLEL, PositioningMethod.MEET):
        raise ModelError("derivation.ik_no_form", robot=mechanism.name)
    judge = AngleJudge(mechanism, pattern, solve)
    steps = [_structure(mechanism, pattern, judge), _displacement(judge), *build(judge)]
    steps += _end(judge)
    return Derivation("derivation.ik_title", mechanism.name, tuple(steps), judge.poses)


def _structure(mechanism: Mechanism, pattern: ArmPattern, judge: AngleJudge) -> Step:
    """What was found, and the axes it was found from."""
    head = (Name("i"), Name("w", "i"), Name("r", "i"))
    rows = tuple(
        (
            str(judge.index(k)),
            vector_text(judge.axes[k]),
            vector_text(judge.points[k]) if not pattern.prismatic[k] else "—",
        )
        for k in range(len(pattern.axes))
        if pattern.joints[k] >= 0
    )
    names = [joint.name for joint in chain_to_tip(mechanism) if joint.moves]
    details = {
        "robot": mechanism.name,
        "count": len(names),
        "a": judge.index(0),
        "b": judge.index(1),
        "c": judge.index(2),
        "last": ", ".join(str(judge.index(k)) for k in range(3, len(pattern.axes))),
        "parallel": ", ".join(str(judge.index(k)) for k in (1, 2, 3)),
        "meeting": ", ".join(str(judge.index(k)) for k in range(4, len(pattern.axes))),
    }
    kind = pattern.family.value
    if pattern.family is Family.SPHERICAL_WRIST:
        kind += "_" + pattern.positioning.value + ("_prismatic" if pattern.prismatic[2] else "")
    lines = [Line((Name("m"),), (vector_text(pattern.centre) + " m",))] if pattern.family is not Family.PLANAR else []
    if pattern.positioning is PositioningMethod.MEET and pattern.family is Family.SPHERICAL_WRIST:
        lines.append(Line((Name("o"),), (vector_text(pattern.meeting) + " m",)))
    return Step(f"derivation.ik_{kind}", details, tuple(lines), Grid(head, rows))


def _displacement(judge: AngleJudge) -> Step:
    """The motion from the zero pose, and where it takes the point that the first joints place."""
    if judge.pattern.family is Family.PLANAR:
        return Step("derivation.ik_displacement_plane")
    key = "ik_displacement_reversed" if judge.pattern.reversed else "ik_displacement"
    lines = (judge.define("p", name_expression("R") * name_expression("m") + name_expression("t")),)
    return Step(f"derivation.{key}", {}, lines)


def _wrist_arm(judge: AngleJudge) -> list[Step]:
    """Three joints place the wrist's centre, three turn about it."""
    method = (
        _parallel_method(judge) if judge.pattern.positioning is PositioningMethod.PARALLEL else _meeting_method(judge)
    )
    w4, w5, w6 = (judge.w(k) for k in (3, 4, 5))
    turns = [function("Rot", judge.w(k), -judge.angle(k)) for k in (2, 1, 0) if not judge.pattern.prismatic[k]]
    product = turns[0]
    for turn in turns[1:]:
        product = product * turn
    lines = [judge.define("Q", product * name_expression("R"))]
    beside = (w4.dot(w5), w5.dot(w6))
    lines += judge.elementary(
        4,
        judge.less(w4.dot(w6), *beside),
        w4.dot(w5.cross(w6)),
        judge.less(w4.dot(name_expression("Q") * w6), *beside),
    )
    middle = Step("derivation.ik_wrist_middle", judge.details(3, 4, 5), tuple(lines))
    first = judge.turn(3, function("Rot", w5, judge.angle(4)) * w6, name_expression("Q") * w6)
    back = function("Rot", w5, -judge.angle(4)) * w4
    last = judge.turn(5, function("transpose", name_expression("Q")) * w4, back)
    outer = Step("derivation.ik_wrist_outer", judge.details(3, 4, 5), (*first, *last))
    return [*method, middle, outer]


def _first_by_height(judge: AngleJudge) -> Step:
    """The height along the next axes does not change when they turn: one equation for the first joint."""
    w1, w2, v = judge.w(0), judge.w(1), name_expression(judge.letter("v", 0))
    beside = (w1.dot(w2), w1.dot(v))
    lines = [judge.define(judge.letter("v", 0), name_expression("p") - judge.r(0))]
    lines += judge.elementary(
        0,
        judge.less(w2.dot(v), *beside),
        w1.dot(w2.cross(v)),
        judge.less(w2.dot(name_expression("m") - judge.r(0)), *beside),
    )
    return Step("derivation.ik_height", judge.details(0, 1, 2), tuple(lines))


def _parallel_method(judge: AngleJudge) -> list[Step]:
    """Height, distance, turn."""
    s = judge.define(
        "s", judge.r(0) + function("Rot", judge.w(0), -judge.angle(0)) * (name_expression("p") - judge.r(0))
    )
    third = _distance(judge, 2, judge.r(1), name_expression("m"), name_expression("s"), (s,))
    second = judge.turn(1, name_expression("g") - judge.r(1), name_expression("s") - judge.r(1))
    return [_first_by_height(judge), third, Step("derivation.ik_turn", judge.details(1, 2), tuple(second))]


def _meeting_method(judge: AngleJudge) -> list[Step]:
    """Distance from the meeting point, then both axes through it."""
    o, w1, w2 = name_expression("o"), judge.w(0), judge.w(1)
    third = _distance(judge, 2, o, name_expression("m"), name_expression("p"), ())
    u, v = judge.letter("u", 1), judge.letter("v", 1)
    lines = [judge.define(u, name_expression("g") - o), judge.define(v, name_expression("p") - o)]
    beside = (w1.dot(w2), w2.dot(name_expression(u)))
    lines += judge.elementary(
        1,
        judge.less(w1.dot(name_expression(u)), *beside),
        w1.dot(w2.cross(name_expression(u))),
        judge.less(w1.dot(name_expression(v)), *beside),
    )
    second = Step("derivation.ik_two_axes", judge.details(0, 1), tuple(lines))
    first = judge.turn(0, function("Rot", w2, judge.angle(1)) * name_expression(u), name_expression(v))
    return [third, second, Step("derivation.ik_turn", judge.details(0, 1), tuple(first))]


def _distance(
    judge: AngleJudge, k: int, centre: Expression, moved: Expression, goal: Expression, before: tuple[Line, ...]
) -> Step:
    """Joint k sets how far a point is from a centre that the joints before it do not move: the law of cosines."""
    x, y, reach = judge.letter("x", k), judge.letter("y", k), function("square", goal - centre)
    lines = list(before)
    if judge.pattern.prismatic[k]:
        lines.append(judge.define(x, moved - centre))
        along = judge.w(k).dot(name_expression(x))
        root = function("sqrt", function("square", along) - function("square", name_expression(x)) + reach)
        lines.append(judge.judge_joint(k, plus_minus(-along, root)))
        lines.append(judge.define("g", moved + judge.angle(k) * judge.w(k)))
        return Step("derivation.ik_prismatic", judge.details(k, k - 1), tuple(lines))
    lines += [judge.define(x, moved - judge.r(k)), judge.define(y, judge.r(k) - centre)]
    along = (judge.w(k).dot(name_expression(x)), judge.w(k).dot(name_expression(y)))
    lines += judge.elementary(
        k,
        judge.less(name_expression(x).dot(name_expression(y)), *along),
        name_expression(y).dot(judge.w(k).cross(name_expression(x))),
        judge.less(
            (reach - function("square", name_expression(x)) - function("square", name_expression(y))) / number(2.0),
            *along,
        ),
    )
    lines.append(judge.define("g", judge.r(k) + function("Rot", judge.w(k), judge.angle(k)) * name_expression(x)))
    return Step("derivation.ik_distance", judge.details(k, k - 1), tuple(lines))


def _parallel_arm(judge: AngleJudge) -> list[Step]:
    """One joint, three parallel axes, two that meet."""
    w2, w5, w6 = judge.w(1), judge.w(4), judge.w(5)
    beside = (w2.dot(w5), w5.dot(w6))
    fifth = [judge.define("Q", function("Rot", judge.w(0), -judge.angle(0)) * name_expression("R"))]
    fifth += judge.elementary(
        4,
        judge.less(w2.dot(w6), *beside),
        w2.dot(w5.cross(w6)),
        judge.less(w2.dot(name_expression("Q") * w6), *beside),
    )
    sixth = judge.turn(5, function("transpose", name_expression("Q")) * w2, function("Rot", w5, -judge.angle(4)) * w2)
    total = judge.total((1, 2, 3), function("Rot", w5, judge.angle(4)) * w6, name_expression("Q") * w6)
    k = judge.letter("k", 3)
    back = judge.r(5) + function("Rot", w6, -judge.angle(5)) * (
        judge.r(4) + function("Rot", w5, -judge.angle(4)) * (judge.r(3) - judge.r(4)) - judge.r(5)
    )
    carried = name_expression("R") * name_expression(k) + name_expression("t") - judge.r(0)
    place = (
        judge.define(k, back),
        judge.define("s", judge.r(0) + function("Rot", judge.w(0), -judge.angle(0)) * carried),
    )
    third = _distance(judge, 2, judge.r(1), judge.r(3), name_expression("s"), place)
    second = judge.turn(1, name_expression("g") - judge.r(1), name_expression("s") - judge.r(1))
    return [
        _first_by_height(judge),
        Step("derivation.ik_fifth", {**judge.details(1, 4, 5), "first": judge.index(0)}, tuple(fifth)),
        Step("derivation.ik_sixth", judge.details(5, 4), tuple(sixth)),
        Step("derivation.ik_sum", judge.details(1, 2, 3), tuple(total)),
        third,
        Step("derivation.ik_turn", judge.details(1, 2), tuple(second)),
        Step("derivation.ik_rest", judge.details(3), (judge.remaining(3, (1, 2)),)),
    ]


def _planar_arm(judge: AngleJudge) -> list[Step]:
    """Three parallel axes, and perhaps a slide along them."""
    w = judge.w(0)
    steps: list[Step] = []
    lines = [judge.define("k", name_expression("R") * judge.r(2) + name_expression("t"))]
    if judge.pattern.joints[3] >= 0:
        rise = judge.w(3).dot(name_expression("k") - judge.r(2))
        steps.append(Step("derivation.ik_rise", judge.details(3), (lines.pop(), judge.judge_joint(3, rise))))
    lines.append(judge.define("s", name_expression("k") - (w.dot(name_expression("k") - judge.r(2))) * w))
    steps.append(_distance(judge, 1, judge.r(0), judge.r(2), name_expression("s"), tuple(lines)))
    first = judge.turn(0, name_expression("g") - judge.r(0), name_expression("s") - judge.r(0))
    steps.append(Step("derivation.ik_turn", judge.details(0, 1), tuple(first)))
    if judge.pattern.joints[2] >= 0:
        judge.constant("n", judge.across(0))
        total = judge.total((0, 1, 2), name_expression("n"), name_expression("R") * name_expression("n"))
        steps.append(Step("derivation.ik_sum", judge.details(0, 1, 2), tuple(total)))
        steps.append(Step("derivation.ik_rest", judge.details(2), (judge.remaining(2, (0, 1)),)))
    return steps


def _end(judge: AngleJudge) -> list[Step]:
    """How many solutions there are, and where the method breaks down."""
    most = 2 ** len(judge.signed)
    steps = [Step("derivation.ik_branches", {"joints": ", ".join(sorted(judge.signed)), "most": most})]
    steps.append(Step("derivation.ik_limits", {}))
    steps += [Step(f"derivation.ik_singular_{case}", details) for case, details in judge.singular()]
    return steps
