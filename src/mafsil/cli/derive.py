"""`mafsil derive`: forward and inverse kinematics, Jacobians and equations of motion as formulas, in numbered steps."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

from mafsil.cli.answer import Answer
from mafsil.cli.state import require_open_chain
from mafsil.derivation import Derivation, derive_fk, derive_jacobian, to_html, to_latex, to_text
from mafsil.derivation.document import Side, is_matrix
from mafsil.derivation.screw_method import Form
from mafsil.derivation.text import formula, side_text, step_sentence
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.model.loading import load_mechanism
from mafsil.robot import Robot
from mafsil.whole_file import write_whole

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
