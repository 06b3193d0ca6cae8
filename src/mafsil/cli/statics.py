"""`mafsil statics`: efforts for a wrench at the tip, or back, with reactions; `mafsil singularity`: what is lost."""

from __future__ import annotations

from typing import Any, Literal, cast

import numpy as np

from mafsil.arrays import Floats, JointVector, Vector6
from mafsil.cli.answer import Answer
from mafsil.cli.state import degrees_remarks, effort_unit, efforts, joint_values, require_open_chain
from mafsil.cli.state import number as typed
from mafsil.cli.table import brief, number, table
from mafsil.errors import InputError
from mafsil.geometry import wrench as wrenches
from mafsil.messages import say
from mafsil.performance import joint_reactions, joint_torque, singularity, tip_wrench
from mafsil.performance.statics import TipWrench
from mafsil.performance.statics.reactions import JointReactions
from mafsil.robot import Robot, load

_COMPONENTS = ("mx", "my", "mz", "fx", "fy", "fz")
_Given = Literal["body", "space", "tip"]


def statics(
    robot: str,
    q: list[str],
    wrench: list[str] | None,
    tau: list[str] | None,
    given_in: str | None,
    tip: str | None,
    degrees: bool,
) -> Answer:
    """The arm at rest: efforts tau = J' F, or the wrench F that efforts balance, and the reactions of all joints.

    Args:
        robot: name or file.
        q: (n) coordinates as typed.
        wrench: six numbers (m, f) that the tip exerts on the world.
        tau: (n) efforts besides those that hold gravity.
        given_in: axes and origin of the wrench: `body` (the tip frame), `space`, or `tip` (there, axes of {s}).
        tip: another tip link.
        degrees: whether bare angles are degrees.

    Raises:
        MafsilError: no such robot, not one number per joint, not six numbers, both a wrench and efforts.
    """
    if wrench is not None and tau is not None:
        raise InputError("cli.statics_one")
    arm = load(robot, tip=tip)
    require_open_chain(arm.mechanism, "statics")
    values = joint_values("q", q, arm.mechanism, degrees=degrees)
    data: dict[str, Any] = {"robot": arm.name, "q": values, "joints": list(arm.joint_names)}
    lines = [say("cli.statics_title", robot=arm.name)]
    refusal = None
    if tau is not None:
        found = tip_wrench(arm, values, efforts("tau", tau, arm.mechanism))
        data |= {"tip_wrench": found.F, "status": found.status.name.lower(), "carried": found.carried}
        lines += _wrench_lines(found)
        refusal = found.explain().splitlines()[0] if np.any(found.unbalanced) else None
    F = np.zeros(6) if wrench is None else _six(wrench)
    given = cast("_Given", given_in or "body")
    reactions = joint_reactions(arm, values, _in_tip_frame(arm, values, F, given))
    data |= {"hold": reactions.torque, "reactions": dict(zip(reactions.joints, reactions.at_joint, strict=True))}
    if wrench is not None:
        data |= {"wrench": F, "given_in": given, "tau": joint_torque(arm, values, F, given_in=given)}
        lines += _effort_lines(arm, data["tau"], reactions.torque)
    lines += [*_reaction_lines(reactions), *degrees_remarks(q, arm.mechanism, degrees=degrees)]
    return Answer(data, tuple(lines), refusal)


def _six(words: list[str]) -> Vector6:
    if len(words) != 6:
        raise InputError("cli.statics_wrench_count", got=len(words))
    values = [typed(f"wrench[{name}]", word) for name, word in zip(_COMPONENTS, words, strict=True)]
    for name, value in zip(_COMPONENTS, values, strict=True):
        if not np.isfinite(value):
            raise InputError("input.finite", name="wrench", value=value, index=name)
    return np.array(values)


def _in_tip_frame(arm: Robot, q: JointVector, F: Vector6, given_in: _Given) -> Vector6:
    """The wrench in the axes and about the origin of the tip frame."""
    if given_in == "body":
        return F
    T = np.asarray(arm.forward_kinematics(q))
    if given_in == "space":
        return np.asarray(wrenches.transform(T, F))
    R = T[:3, :3]
    return np.concatenate([R.T @ F[:3], R.T @ F[3:]])


def _wrench_lines(found: TipWrench) -> list[str]:
    rows = [["", *(number(float(x)) for x in found.F)]]
    head = ["", *(f"{name} [{'N m' if name[0] == 'm' else 'N'}]" for name in _COMPONENTS)]
    return [say("cli.statics_title_wrench"), *table(head, rows), *found.explain().splitlines()]


def _effort_lines(arm: Robot, tau: Floats, hold: Floats) -> list[str]:
    head = [say(f"cli.{key}") for key in ("joint", "statics_effort", "statics_held", "unit")]
    rows = [
        [joint.name, number(float(a)), number(float(b)), effort_unit(joint.kind)]
        for joint, a, b in zip(arm.mechanism.coordinates, tau, hold, strict=True)
    ]
    return [say("cli.statics_title_tau"), *table(head, rows)]


def _reaction_lines(found: JointReactions) -> list[str]:
    head = [say("cli.joint"), *(f"{name} [{'N m' if name[0] == 'm' else 'N'}]" for name in _COMPONENTS)]
    rows = [[name, *(number(float(x), 3) for x in row)] for name, row in zip(found.joints, found.at_joint, strict=True)]
    return ["", say("cli.statics_reactions"), *table(head, rows)]


def find_singularity(robot: str, q: list[str], task: str | None, tip: str | None, degrees: bool) -> Answer:
    """Rank, singular values, causes, lost twists and carried wrenches of one configuration.

    Args:
        robot: name or file.
        q: (n) coordinates as typed.
        task: rows of the Jacobian that count; the arm's natural task if None.
        tip: another tip link.
        degrees: whether bare angles are degrees.

    Raises:
        MafsilError: no such robot or task, not one number per joint.
    """
    arm = load(robot, tip=tip)
    require_open_chain(arm.mechanism, "singularity")
    values = joint_values("q", q, arm.mechanism, degrees=degrees)
    found = singularity(arm, values, task=task)
    product = float(np.prod(found.singular_values)) if found.singular_values.size else 0.0
    data = {**found.to_dict(), "manipulability": product}
    size, length = brief(product), brief(found.length)
    lines = found.explain().splitlines()
    lines.append(say("cli.singularity_rank", rank=found.rank, full=found.full_rank, manipulability=size, length=length))
    head = [say("cli.singularity_values"), *(f"σ{k}" for k in range(1, found.singular_values.size + 1))]
    lines += table(head, [["", *(brief(float(s)) for s in found.singular_values)]])
    return Answer(data, (*lines, *degrees_remarks(q, arm.mechanism, degrees=degrees)))
