"""Derivations as plain text for terminals."""

from __future__ import annotations

from mafsil.derivation.document import Derivation, Factors, Grid, Line, Name, Side, Step, is_matrix
from mafsil.derivation.expression import Expression, factor_glyph, glyph, number_text, signed_angles, superscript
from mafsil.derivation.grouping import Part, factor_out, powers
from mafsil.derivation.polynomial import Entries, Factor, Polynomial, Trig
from mafsil.errors import InputError
from mafsil.messages import LANGUAGES, in_cell, in_sentence, say
from mafsil.messages import language as current_language

WIDEST = 110
"""Matrices wider than this [columns] are written entry by entry."""


def to_text(derivation: Derivation, language: str | None = None) -> str:
    """The derivation as lines of text.

    Args:
        derivation: checked.
        language: `en` or `ar`; the current one if None.

    Raises:
        InputError: another language.
    """
    language = language_code(language)
    title = say(derivation.key, language=language, robot=derivation.robot)
    lines = [in_sentence(title, language)]
    for k, step in enumerate(derivation.steps, start=1):
        sentence = in_sentence(step_sentence(step, language), language)
        lines += ["", f"{k}. {sentence}", *(in_cell(row, language) for row in _body(step))]
    if derivation.states:
        lines += ["", in_sentence(checked_sentence(derivation, language), language)]
    return "\n".join(lines) + "\n"


def language_code(language: str | None) -> str:
    """The code of a language, the current one if None.

    Raises:
        InputError: the package does not speak it.
    """
    if language is not None and language not in LANGUAGES:
        raise InputError("input.choice", name="language", value=language, known=", ".join(LANGUAGES))
    return language or current_language()


def checked_sentence(derivation: Derivation, language: str | None = None) -> str:
    """How the lines were checked, and how well they passed."""
    error = f"{derivation.worst_error:.1e}"
    return say(derivation.checked, language=language, states=derivation.states, error=error)


def step_sentence(step: Step, language: str | None = None) -> str:
    """The sentence of a step."""
    return say(step.key, language=language, **dict(step.details))


def formula(polynomial: Polynomial) -> str:
    """c1 (a2 c2 + a3 c23) − d3 s1."""
    return sum_text(factor_out(polynomial))


def sum_text(parts: tuple[Part, ...]) -> str:
    """A sum; 0 if it has no summands."""
    text = ""
    for part in parts:
        minus = part.number < 0
        sign = (" − " if minus else " + ") if text else ("−" if minus else "")
        text += sign + _part(part)
    return text or "0"


def _part(part: Part) -> str:
    pieces = [_power(f, power) for f, power in powers(part.factors)]
    if part.bracket:
        pieces.append(f"({sum_text(part.bracket)})")
    pieces += [_power(f, power) for f, power in powers(part.behind)]
    if abs(part.number) != 1.0 or not pieces:
        pieces.insert(0, number_text(part.number))
    return " ".join(pieces)


def _power(factor: Factor, power: int) -> str:
    """L1², s2², θ̇1²."""
    return factor_text(factor) + superscript(power)


def factor_text(factor: Factor) -> str:
    """c12, a3 or cos(θ1 − θ2)."""
    short = factor_glyph(factor)
    if short is not None:
        return short.letter + (f"_{short.below}" if short.below.isalpha() else short.below)
    assert isinstance(factor, Trig)
    inside = ""
    for sign, multiple, letter in signed_angles(factor.angle):
        inside += f" {sign} " if inside else ("−" if sign == "−" else "")
        inside += ("" if multiple == 1 else str(multiple)) + letter.letter + letter.below
    return f"{'sin' if factor.sine else 'cos'}({inside})"


def _body(step: Step) -> list[str]:
    grid = [] if step.grid is None else _grid(step.grid)
    return [*grid, *(row for line in step.lines for row in _line(line))]


def _grid(grid: Grid) -> list[str]:
    head = [cell if isinstance(cell, str) else name_text(cell) for cell in grid.head]
    rows = [head, *([cell_text(cell) for cell in row] for row in grid.rows)]
    return ["   " + row for row in _align(rows)]


def cell_text(cell: Polynomial | str) -> str:
    """A cell of a table."""
    if isinstance(cell, Polynomial):
        return formula(cell)
    stem, sign, rest = split_angle(cell)
    letter = glyph(stem)
    return f"{letter.letter}{letter.below}{sign}{rest}" if stem.startswith("theta") else cell


def split_angle(cell: str) -> tuple[str, str, str]:
    """`theta2+90°` as name, sign and offset."""
    sign = next((m for m in "+−" if m in cell[1:]), "")
    stem, _, rest = cell.partition(sign) if sign else (cell, "", "")
    return stem, sign, rest


def name_text(name: Name) -> str:
    """T_03, θ2."""
    letter = glyph(name.letter) if not name.index else None
    if letter is not None:
        return letter.letter + letter.below
    return f"{name.letter}_{name.index}" if name.index else name.letter


def _line(line: Line) -> list[str]:
    """An equation, its matrices beside or below it."""
    left = " ".join(name_text(name) for name in line.left)
    text, below = "   " + left, list[str]()
    for side in line.sides:
        if not is_matrix(side):
            text += (" = " if text.strip() else "") + side_text(side)
        else:
            rows = _matrix(side)
            if max(len(row) for row in rows) > WIDEST:
                below += [f"      {left}[{r},{c}] = {x}" for r, c, x in _entries(side)]
            else:
                text += " ="
                below += ["      " + row for row in rows]
    return [text, *below]


def side_text(side: Side) -> str:
    """A side that is no matrix."""
    if isinstance(side, str):
        return side
    if isinstance(side, Expression):
        return side.text()
    if isinstance(side, Polynomial):
        return formula(side)
    if isinstance(side, Factors):
        return " ".join(f"({formula(f)})" if len(f.terms) > 1 else formula(f) for f in side.formulas)
    names = [name for name in side if isinstance(name, Name)]
    return "".join(name_text(name) + (" " if name.index and name.letter in "TREP" else "") for name in names).rstrip()


def _matrix(entries: Entries) -> list[str]:
    rows = _align([[formula(x) for x in row] for row in entries])
    return [f"[ {row} ]" for row in rows]


def _entries(entries: Entries) -> list[tuple[int, int, str]]:
    """Entries that are not zero, numbered from 1."""
    cells = [(r, c, formula(x)) for r, row in enumerate(entries, 1) for c, x in enumerate(row, 1)]
    return [cell for cell in cells if cell[2] != "0"]


def _align(rows: list[list[str]]) -> list[str]:
    widths = [max(len(row[c]) for row in rows) for c in range(len(rows[0]))]
    return ["   ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
