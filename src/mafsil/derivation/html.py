"""Derivations as one self-contained page with MathML; Arabic from right to left, formulas from left to right."""

from __future__ import annotations

from html import escape

from mafsil.derivation.document import Derivation, Factors, Grid, Line, Name, Side, Step, is_matrix
from mafsil.derivation.expression import (
    Expression,
    Glyph,
    factor_glyph,
    glyph,
    number_text,
    signed_angles,
    with_letters,
)
from mafsil.derivation.grouping import Part, factor_out, powers
from mafsil.derivation.polynomial import Entries, Factor, Polynomial, Trig
from mafsil.derivation.text import checked_sentence, language_code, split_angle, step_sentence
from mafsil.messages import direction, in_sentence, say

_STYLE = """
:root { color-scheme: light dark; }
body { font-family: system-ui, "Noto Sans Arabic", sans-serif; line-height: 1.6; }
body { max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
.formula { direction: ltr; text-align: left; overflow-x: auto; padding: .25rem 0; }
table.parameters { direction: ltr; border-collapse: collapse; margin: .5rem 0; }
table.parameters td, table.parameters th { padding: .15rem .9rem; border-bottom: 1px solid #8886; text-align: center; }
math { font-size: 1.08em; } mtd { padding: .15em .5em; }
mtable.matrix { border-left: 1.5px solid; border-right: 1.5px solid; border-radius: .45em; }
li { margin: 1.2rem 0; } .checked { border-inline-start: 4px solid #2f9e57; padding-inline-start: .8rem; }
"""


def to_html(derivation: Derivation, language: str | None = None) -> str:
    """The derivation as a self-contained HTML page.

    Args:
        derivation: checked.
        language: `en` or `ar`; the current one if None.

    Raises:
        InputError: another language.
    """
    code = language_code(language)
    title = say(derivation.key, language=code, robot=derivation.robot)
    tab = escape(in_sentence(title, code))
    checked = checked_sentence(derivation, code) if derivation.states else ""
    return (
        f'<!doctype html>\n<html lang="{code}" dir="{direction(code)}">\n<head>\n<meta charset="utf-8">\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<title>{tab}</title>\n'
        f"<style>{_STYLE}</style>\n</head>\n<body>\n<h1>{sentence(title, code)}</h1>\n{steps_html(derivation, code)}\n"
        f'<p class="checked">{sentence(checked, code)}</p>\n</body>\n</html>\n'
    )


def steps_html(derivation: Derivation, code: str) -> str:
    """The steps as a numbered list, for a page that has its own head."""
    return "<ol>\n" + "\n".join(_step(step, code) for step in derivation.steps) + "\n</ol>"


def sentence(text: str, code: str) -> str:
    """Words of a sentence; letters with an index as formulas, numbers, names and formulas kept in their direction."""
    return in_sentence(text, code, "page", words=escape, foreign=_letter)


def _letter(text: str) -> str:
    return with_letters(text, escape, lambda letter, index: _math(_sub(letter, index)))


def formula(polynomial: Polynomial) -> str:
    """MathML of a formula, without the enclosing element."""
    return _sum(factor_out(polynomial))


def _step(step: Step, code: str) -> str:
    grid = "" if step.grid is None else _grid(step.grid)
    lines = "\n".join(
        f'<div class="formula"><math dir="ltr" displaystyle="true">{_line(line)}</math></div>' for line in step.lines
    )
    return f"<li>{sentence(step_sentence(step, code), code)}\n{grid}{lines}</li>"


def _grid(grid: Grid) -> str:
    head = "".join(f"<th>{_math(cell if isinstance(cell, str) else _name(cell))}</th>" for cell in grid.head)
    rows = "".join("<tr>" + "".join(f"<td>{_cell(cell)}</td>" for cell in row) + "</tr>" for row in grid.rows)
    return f'<table class="parameters"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>\n'


def _cell(cell: Polynomial | str) -> str:
    if isinstance(cell, Polynomial):
        return _math(formula(cell))
    if not cell.startswith("theta"):
        return _math(f"<mn>{escape(cell)}</mn>")
    stem, sign, rest = split_angle(cell)
    return _math(_sub(*glyph(stem)) + (f"<mo>{sign}</mo><mn>{rest}</mn>" if sign else ""))


def _math(inside: str) -> str:
    return f'<math dir="ltr">{inside}</math>'


def _line(line: Line) -> str:
    left = "".join(_name(name) for name in line.left)
    return "<mo>=</mo>".join([piece for piece in (left, *(_side(side) for side in line.sides)) if piece])


def _side(side: Side) -> str:
    if isinstance(side, str):
        return f"<mtext>{escape(side)}</mtext>"
    if isinstance(side, Expression):
        return side.mathml()
    if isinstance(side, Polynomial):
        return formula(side)
    if isinstance(side, Factors):
        return "".join(_bracket(formula(f)) if len(f.terms) > 1 else formula(f) for f in side.formulas)
    if is_matrix(side):
        return _matrix(side)
    return "".join(_name(name) for name in side if isinstance(name, Name))


def _matrix(entries: Entries) -> str:
    rows = "".join("<mtr>" + "".join(f"<mtd>{formula(x)}</mtd>" for x in row) + "</mtr>" for row in entries)
    return f'<mtable class="matrix">{rows}</mtable>'


def _bracket(inside: str) -> str:
    return f"<mrow><mo>(</mo>{inside}<mo>)</mo></mrow>"


def _name(name: Name) -> str:
    if name.index:
        return _sub(name.letter, name.index)
    named = name.letter.replace("_", "").isalnum()
    letter = glyph(name.letter) if named else Glyph(name.letter, "")
    if letter.below:
        return _sub(*letter)
    return f"<mi>{escape(letter.letter)}</mi>" if letter.letter.isalpha() else f"<mo>{escape(letter.letter)}</mo>"


def _sub(letter: str, index: str) -> str:
    kind = "mn" if index.isdigit() else "mtext"
    return f"<msub><mi>{escape(letter)}</mi><{kind}>{escape(index)}</{kind}></msub>"


def _sum(parts: tuple[Part, ...]) -> str:
    text = ""
    for part in parts:
        if part.number < 0:
            text += "<mo>−</mo>"
        elif text:
            text += "<mo>+</mo>"
        text += _part(part)
    return f"<mrow>{text or '<mn>0</mn>'}</mrow>"


def _part(part: Part) -> str:
    pieces = [_power(f, power) for f, power in powers(part.factors)]
    if part.bracket:
        pieces.append(_bracket(_sum(part.bracket)))
    pieces += [_power(f, power) for f, power in powers(part.behind)]
    if abs(part.number) != 1.0 or not pieces:
        pieces.insert(0, f"<mn>{number_text(part.number)}</mn>")
    return '<mspace width="0.2em"></mspace>'.join(pieces)


def _power(factor: Factor, power: int) -> str:
    if power == 1:
        return _factor(factor)
    whole = _factor(factor) if factor_glyph(factor) is not None else _bracket(_factor(factor))
    return f"<msup><mrow>{whole}</mrow><mn>{power}</mn></msup>"


def _factor(factor: Factor) -> str:
    short = factor_glyph(factor)
    if short is not None:
        return _sub(*short) if short.below else f"<mi>{escape(short.letter)}</mi>"
    assert isinstance(factor, Trig)
    inside = ""
    for sign, multiple, letter in signed_angles(factor.angle):
        inside += f"<mo>{sign}</mo>" if inside or sign == "−" else ""
        inside += ("" if multiple == 1 else f"<mn>{multiple}</mn>") + _sub(*letter)
    return f"<mrow><mi>{'sin' if factor.sine else 'cos'}</mi>{_bracket(inside)}</mrow>"
