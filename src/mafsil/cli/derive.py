"""`mafsil derive`: forward and inverse kinematics, Jacobians and equations of motion as formulas, in numbered steps.

`mafsil dh`: the Denavit-Hartenberg table of any arm, in both conventions.
"""

from __future__ import annotations

from math import degrees as to_degrees
from pathlib import Path
from typing import Any, cast

import numpy as np

from mafsil.cli.answer import PLAIN, Answer, draw_picture, require_kind
from mafsil.cli.state import require_open_chain
from mafsil.cli.table import brief, matrix, table
from mafsil.cli.tolerances import ROUNDOFF
from mafsil.derivation import Derivation, derive_fk, derive_jacobian, to_html, to_latex, to_text
from mafsil.derivation.document import Side, is_matrix
from mafsil.derivation.screw_method import Form
from mafsil.derivation.text import formula, side_text, step_sentence
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.model import Mechanism
from mafsil.model.denavit_hartenberg import Convention, DHRow
from mafsil.model.dh_from_axes import DHTable, dh_from_mechanism
from mafsil.model.loading import load_mechanism
from mafsil.robot import Robot, load
from mafsil.whole_file import write_whole

RULES = {
    "modified": "T_i-1,i = Rot(x, alpha_i-1) Trans(x, a_i-1) Trans(z, d_i) Rot(z, theta_i)",
    "classic": "T_i-1,i = Rot(z, theta_i) Trans(z, d_i) Trans(x, a_i) Rot(x, alpha_i)",
}
_BY_TABLE = {"fk": derive_fk, "jacobian": derive_jacobian}
_WRITE = {"text": to_text, "latex": to_latex, "html": to_html}
_ENDINGS = {".tex": "latex", ".html": "html", ".htm": "html"}


def derive(
    what: str,
    robot: str,
    tip: str | None,
    method: str | None,
    convention: str | None,
    format: str | None,
    out: str | None,
) -> Answer:
    """A derivation on the screen or in a file.

    Args:
        what: `fk`, `jacobian`, `ik` or `dynamics`.
        robot: name or file.
        tip: another tip link.
        method: `dh` or `screws`, of fk and jacobian; `dh` if None.
        convention: `modified` or `classic`, of fk and jacobian with a table; that of the robot if None.
        format: `text`, `latex` or `html`; by the ending of `out` if None.
        out: file, or None for the screen.

    Raises:
        MafsilError: no such robot, an arm without a table (helical or mimic joints), a method or convention for what
            has none, a file that cannot be written.
    """
    if ((method or convention) and what not in _BY_TABLE) or (method == "screws" and convention):
        raise InputError("cli.derive_method_given")
    mechanism = load_mechanism(robot, tip=tip)
    require_open_chain(mechanism, "derive")
    if what in _BY_TABLE:
        derivation = _BY_TABLE[what](mechanism, convention=convention, form=cast("Form", method or "dh"))
    else:
        derivation = Robot(mechanism).derive(what)
    kind = format or _ENDINGS.get(Path(out or "").suffix.lower(), "text")
    text = _WRITE[kind](derivation)
    data = _data(derivation)
    if out is None:
        return Answer(data, tuple(text.rstrip("\n").split("\n")))
    write_whole(Path(out), text.encode())
    error = f"{derivation.worst_error:.1e}"
    written = say("cli.derive_written", path=out, steps=len(derivation.steps), error=error)
    return Answer({**data, "out": out}, (written,))


def _data(derivation: Derivation) -> dict[str, Any]:
    """Steps as plain data: sentence and equations."""
    return {
        **derivation.to_dict(),
        "steps": [
            {
                "sentence": step_sentence(step),
                "lines": [
                    {
                        "left": [f"{name.letter}_{name.index}" if name.index else name.letter for name in line.left],
                        "right": [_plain(side) for side in line.sides],
                        "error": line.error,
                    }
                    for line in step.lines
                ],
            }
            for step in derivation.steps
        ],
    }


def _plain(side: Side) -> Any:
    return [[formula(x) for x in row] for row in side] if is_matrix(side) else side_text(side)


def dh(robot: str, convention: str | None, radians: bool, picture: str | None, tip: str | None) -> Answer:
    """Tables found from the joint axes.

    Args:
        robot: name or file.
        convention: `modified` or `classic`; both if None.
        radians: print angles in radians; in degrees otherwise.
        picture: file to draw the frames of the (first) table into.
        tip: another tip link.

    Raises:
        MafsilError: no such robot, a helical or mimic joint on the chain to the tip.
    """
    if picture is not None:
        require_kind(picture, PLAIN)
    mechanism = load(robot, tip=tip).mechanism
    tables = {name: dh_from_mechanism(mechanism, name) for name in ([convention] if convention else list(RULES))}
    names = _joint_names(mechanism)
    lines: list[str] = []
    for name, found in tables.items():
        lines += _lines(mechanism, name, found, names, radians=radians)
    data: dict[str, Any] = {"robot": mechanism.name, "tables": {name: _table_data(t) for name, t in tables.items()}}
    if picture is not None:
        from mafsil.figures.dh_frames import plot_dh_frames

        shown = next(iter(tables.values()))
        lines.append(draw_picture(lambda path: plot_dh_frames(mechanism, shown, path), picture, data))
    return Answer(data, tuple(lines))


def _joint_names(mechanism: Mechanism) -> list[str]:
    """Names of the joints on the chain to the tip, base first."""
    carried = {joint.child: joint for joint in mechanism.joints}
    chain: list[str] = []
    link = mechanism.tip
    while link in carried:
        if carried[link].moves:
            chain.append(carried[link].name)
        link = carried[link].parent
    return chain[::-1]


def _lines(mechanism: Mechanism, name: str, found: DHTable, joints: list[str], *, radians: bool) -> list[str]:
    unit = "rad" if radians else "°"
    subscript = "i-1" if found.convention is Convention.MODIFIED else "i"
    head = ["i", say("cli.joint"), f"alpha_{subscript} [{unit}]", f"a_{subscript} [m]", "d_i [m]", f"theta_i [{unit}]"]
    rows = [
        [str(i), joint, *_cells(row, i, radians=radians)]
        for i, (row, joint) in enumerate(zip(found.rows, joints, strict=True), 1)
    ]
    title = say("cli.dh_title", robot=mechanism.name, convention=say(f"cli.dh_{name}"))
    lines = [title, f"  {RULES[name]}", *table(head, rows, words=(1,))]
    for key, pose in (("dh_base", found.base), ("dh_tool", found.tool)):
        if not np.allclose(pose, np.eye(4), atol=ROUNDOFF):
            lines += [say(f"cli.{key}"), *matrix(np.where(np.abs(pose) < ROUNDOFF, 0.0, pose))]
    return [*lines, say("cli.dh_error", error=f"{found.residual:.1e}"), ""]


def _cells(row: DHRow, i: int, *, radians: bool) -> list[str]:
    def angle(value: float) -> float:
        return value if radians else to_degrees(value)

    revolute = row.kind == "R"
    d, theta = row.d + (0.0 if revolute else row.offset), row.theta + (row.offset if revolute else 0.0)
    return [
        _clean(angle(row.alpha)),
        _clean(row.a),
        _clean(d) if revolute else _after(i, d),
        _after(i, angle(theta)) if revolute else _clean(angle(theta)),
    ]


def _clean(value: float) -> str:
    return brief(0.0 if abs(value) < ROUNDOFF else value)


def _after(i: int, constant: float) -> str:
    """`q2`, `q2 + 90`, `q2 - 0.5`."""
    if abs(constant) < ROUNDOFF:
        return f"q{i}"
    return f"q{i} {'+' if constant > 0 else '-'} {brief(abs(constant))}"


def _table_data(found: DHTable) -> dict[str, Any]:
    return {
        "rows": [
            {"a": r.a, "alpha": r.alpha, "d": r.d, "theta": r.theta, "kind": r.kind, "offset": r.offset}
            for r in found.rows
        ],
        "base": found.base,
        "tool": found.tool,
        "residual": found.residual,
    }
