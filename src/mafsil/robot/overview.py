"""A robot as a table that fits a screen: joints with their kinds and limits, tip, masses."""

from __future__ import annotations

from math import isfinite

from mafsil.messages import say
from mafsil.model import Joint, JointKind, Mechanism

_MOST_JOINTS = 40
_LONGEST_NAME = 28


def overview(mechanism: Mechanism) -> str:
    """What `print(robot)` shows; the whole of it is shown by `mafsil show`.

    Args:
        mechanism: the robot's description.
    """
    bodies = [link.inertial for link in mechanism.links if link.inertial is not None and link.inertial.mass > 0.0]
    mass = sum(body.mass for body in bodies)
    head = [say(f"robot.column_{name}") for name in ("joint", "kind", "lower", "upper", "speed", "effort")]
    shown = [joint for joint in mechanism.joints if joint.moves]
    rows = [head, *(_row(joint) for joint in shown[:_MOST_JOINTS])]
    widths = [max(len(row[k]) for row in rows if row[-1] or k != 1) for k in range(len(head))]
    lines = [
        say("robot.overview", robot=mechanism.name, n=mechanism.n, tip=mechanism.tip),
        *("  " + "  ".join(_padded(row, widths)).rstrip() for row in rows if shown),
    ]
    if len(shown) > _MOST_JOINTS:
        lines.append(say("robot.overview_more", count=len(shown) - _MOST_JOINTS))
    lines.append(say("robot.overview_mass", mass=mass, count=len(bodies)) if bodies else say("robot.overview_massless"))
    return "\n".join(lines)


def _row(joint: Joint) -> list[str]:
    slides = joint.kind is JointKind.PRISMATIC
    length, force = ("m", "N") if slides else ("rad", "N m")
    kind = say(f"robot.kind_{joint.kind.value}")
    if joint.mimic is not None:
        return [_cut(joint.name), say("robot.follows", kind=kind, leader=joint.mimic.leader), "", "", "", ""]
    bounds = joint.limits
    pairs = ((bounds.lower, length), (bounds.upper, length), (bounds.velocity, f"{length}/s"), (bounds.effort, force))
    return [_cut(joint.name), kind, *(f"{value:.4g} {unit}" if isfinite(value) else "-" for value, unit in pairs)]


def _cut(name: str) -> str:
    return name if len(name) <= _LONGEST_NAME else name[: _LONGEST_NAME - 1] + "…"


def _padded(row: list[str], widths: list[int]) -> list[str]:
    sized = list(zip(row, widths, strict=True))
    return [cell.ljust(size) for cell, size in sized[:2]] + [cell.rjust(size) for cell, size in sized[2:]]
