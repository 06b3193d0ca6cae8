"""A robot as a table that fits a screen: joints with their kinds and limits, tip, masses; in notebooks too."""

from __future__ import annotations

from html import escape
from math import isfinite

from mafsil.messages import say
from mafsil.model import Joint, JointKind, Mechanism

MOST_JOINTS = 20
"""Rows of the table; with its head and what stands around it, it takes no more than 25 lines."""
LONGEST_NAME = 28
"""Letters of a name; with five numbers and their units beside it, a row takes no more than 100 columns."""


def overview(mechanism: Mechanism) -> str:
    """What `print(robot)` shows; the whole of it is shown by `mafsil show`.

    Args:
        mechanism: the robot's description.
    """
    rows = _rows(mechanism)
    widths = [max(len(row[k]) for row in rows if row[-1] or k != 1) for k in range(len(rows[0]))]
    lines = ["  " + "  ".join(_padded(row, widths)).rstrip() for row in rows if len(rows) > 1]
    return "\n".join([_title(mechanism), *lines, *_rest(mechanism)])


def overview_html(mechanism: Mechanism) -> str:
    """The same for notebooks.

    Args:
        mechanism: the robot's description.
    """
    head, *rows = _rows(mechanism)
    cells = ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows]
    table = "".join(f"<tr>{row}</tr>" for row in ("".join(f"<th>{escape(name)}</th>" for name in head), *cells))
    lines = "".join(f'<div dir="auto">{escape(line.strip())}</div>' for line in _rest(mechanism))
    return f'<div dir="auto">{escape(_title(mechanism))}</div>{f"<table>{table}</table>" if rows else ""}{lines}'


def _title(mechanism: Mechanism) -> str:
    return say("robot.overview", robot=mechanism.name, n=mechanism.n, tip=mechanism.tip)


def _rows(mechanism: Mechanism) -> list[list[str]]:
    """The table, its head first."""
    head = [say(f"robot.column_{name}") for name in ("joint", "kind", "lower", "upper", "speed", "effort")]
    shown = [joint for joint in mechanism.joints if joint.moves]
    return [head, *(_row(joint) for joint in shown[:MOST_JOINTS])]


def _rest(mechanism: Mechanism) -> list[str]:
    """What stands below the table."""
    bodies = [link.inertial for link in mechanism.links if link.inertial is not None and link.inertial.mass > 0.0]
    mass = sum(body.mass for body in bodies)
    more = sum(joint.moves for joint in mechanism.joints) - MOST_JOINTS
    return [
        *([say("robot.overview_more", count=more)] if more > 0 else []),
        say("robot.overview_mass", mass=mass, count=len(bodies)) if bodies else say("robot.overview_massless"),
    ]


def _row(joint: Joint) -> list[str]:
    length, force = ("m", "N") if joint.kind is JointKind.PRISMATIC else ("rad", "N m")
    kind = say(f"robot.kind_{joint.kind.value}")
    if joint.mimic is not None:
        follows = say("robot.follows", kind=kind, leader=_cut(joint.mimic.leader))
        return [_cut(joint.name), follows, "", "", "", ""]
    bounds = joint.limits
    pairs = ((bounds.lower, length), (bounds.upper, length), (bounds.velocity, f"{length}/s"), (bounds.effort, force))
    return [_cut(joint.name), kind, *(f"{value:.4g} {unit}" if isfinite(value) else "-" for value, unit in pairs)]


def _cut(name: str) -> str:
    return name if len(name) <= LONGEST_NAME else name[: LONGEST_NAME - 1] + "…"


def _padded(row: list[str], widths: list[int]) -> list[str]:
    sized = list(zip(row, widths, strict=True))
    return [cell.ljust(size) for cell, size in sized[:2]] + [cell.rjust(size) for cell, size in sized[2:]]
