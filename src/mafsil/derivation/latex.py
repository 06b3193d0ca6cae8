"""Derivations as LaTeX, for LuaLaTeX or XeLaTeX; Arabic runs from right to left, formulas from left to right."""

from __future__ import annotations

import unicodedata

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
from mafsil.derivation.text import formula as plain_formula
from mafsil.messages import in_sentence, say

_GREEK = {
    "θ̇": r"\dot{\theta}", "θ̈": r"\ddot{\theta}", "q̇": r"\dot{q}", "q̈": r"\ddot{q}", "V̇": r"\dot{V}",
    "ẋ": r"\dot{x}", "ẏ": r"\dot{y}", "ż": r"\dot{z}", "Γ": r"\Gamma", "τ": r"\tau",
    "θ": r"\theta", "α": r"\alpha", "δ": r"\delta", "ω": r"\omega", "ṗ": r"\dot p",
}  # fmt: skip
_SPECIAL = {
    **{letter: f"${command}$" for letter, command in _GREEK.items()},
    "−": "$-$",
    "×": r"$\times$",
    "·": r"$\cdot$",
    "∂": r"$\partial$",
    "½": r"$\tfrac{1}{2}$",
    "±": r"$\pm$",
    "²": "$^2$",
    "ᵀ": r"$^{\mathsf{T}}$",
    "°": r"$^\circ$",
    "q̇": r"$\dot q$",
    "_": r"\_",
    "&": r"\&",
    "%": r"\%",
    "#": r"\#",
    "$": r"\$",
}
_DOTS = {"\u0307": r"\dot", "\u0308": r"\ddot"}
_WIDEST = 100
_LANGUAGES = {"en": "english", "ar": "arabic"}


def to_latex(derivation: Derivation, language: str | None = None) -> str:
    """The derivation as a LaTeX document.

    Args:
        derivation: checked.
        language: `en` or `ar`; the current one if None.

    Raises:
        InputError: another language.
    """
    code = language_code(language)
    body = [
        r"\section*{" + sentence(say(derivation.key, language=code, robot=derivation.robot), code) + "}",
        r"\begin{enumerate}",
    ]
    for step in derivation.steps:
        body += _step(step, code)
    body.append(r"\end{enumerate}")
    if derivation.states:
        body.append(sentence(checked_sentence(derivation, code), code))
    return "\n".join([*_head(code), *body, r"\end{document}", ""])


def formula(polynomial: Polynomial) -> str:
    """One formula, common factors in front of brackets."""
    return _sum(factor_out(polynomial))


def sentence(text: str, code: str) -> str:
    """Words of a sentence, letters with an index as formulas; in Arabic what is not Arabic in its own direction."""
    return in_sentence(text, code, "latex", words=_escape, foreign=_with_letters)


def _with_letters(text: str) -> str:
    return with_letters(text, _escape, lambda letter, index: f"${_letter(letter)}_{{{index}}}$")


def _head(code: str) -> list[str]:
    head = [
        r"\documentclass{article}",
        r"\usepackage{amsmath}",
        r"\usepackage[a4paper,margin=20mm]{geometry}",
        r"\usepackage{fontspec}",
        r"\usepackage{polyglossia}",
        rf"\setmainlanguage{{{_LANGUAGES[code]}}}",
    ]
    if code == "ar":
        head.append(r"\newfontfamily\arabicfont[Script=Arabic]{Amiri}")
    return [*head, r"\setcounter{MaxMatrixCols}{12}", r"\allowdisplaybreaks", r"\begin{document}"]


def _escape(text: str) -> str:
    for special, command in _SPECIAL.items():
        if special in ("$",):
            continue
        text = text.replace(special, command)
    return text


def _step(step: Step, code: str) -> list[str]:
    lines = [r"\item " + sentence(step_sentence(step, code), code)]
    if step.grid is not None:
        lines += _grid(step.grid)
    for line in step.lines:
        lines += _line(line)
    return lines


def _grid(grid: Grid) -> list[str]:
    head = " & ".join("$" + (cell if isinstance(cell, str) else _name(cell)) + "$" for cell in grid.head)
    rows = [" & ".join(f"${_cell(cell)}$" for cell in row) + r" \\" for row in grid.rows]
    columns = "c" * len(grid.head)
    return [
        r"\begin{center}\begin{tabular}{" + columns + "}",
        head + r" \\ \hline",
        *rows,
        r"\end{tabular}\end{center}",
    ]


def _cell(cell: Polynomial | str) -> str:
    if isinstance(cell, Polynomial):
        return formula(cell)
    stem, sign, rest = split_angle(cell) if cell.startswith("theta") else (cell, "", "")
    named = _glyph(glyph(stem)) if stem.startswith("theta") else stem
    return (named + sign + rest).replace("−", "-").replace("°", r"^\circ")


def _line(line: Line) -> list[str]:
    """One display; wide matrices entry by entry."""
    left = r"\,".join(_name(name) for name in line.left)
    sides = [side for side in line.sides if not is_matrix(side)]
    wide = [side for side in line.sides if is_matrix(side) and _width(side) > _WIDEST]
    shown = [_side(side) for side in sides] + [_matrix(s) for s in line.sides if is_matrix(s) and s not in wide]
    displays = [" = ".join([piece for piece in (left, *shown) if piece])] if shown else []
    for matrix in wide:
        for r, row in enumerate(matrix, 1):
            for c, x in enumerate(row, 1):
                if not x.is_zero:
                    displays.append(rf"\bigl({left}\bigr)_{{{r},{c}}} = {formula(x)}")
    return [rf"\[ {display} \]" for display in displays]


def _width(entries: Entries) -> int:
    columns = list(zip(*entries, strict=True))
    return sum(max(len(plain_formula(x)) for x in column) + 3 for column in columns)


def _side(side: Side) -> str:
    if isinstance(side, str):
        text = side.replace("−", "-").replace("°", r"^\circ")
        # The blank before a unit, not those within a vector.
        number, _, unit = text[text.rfind(")") + 1 :].partition(" ")
        number = text[: text.rfind(")") + 1] + number
        return rf"{number}\ \mathrm{{{unit.replace('²', '^2')}}}" if unit else number
    if isinstance(side, Expression):
        return side.latex()
    if isinstance(side, Polynomial):
        return formula(side)
    if isinstance(side, Factors):
        return r"\,".join(f"({formula(f)})" if len(f.terms) > 1 else formula(f) for f in side.formulas)
    assert not is_matrix(side)
    return r"\,".join(_name(name) for name in side if isinstance(name, Name))


def _matrix(entries: Entries) -> str:
    rows = r" \\ ".join(" & ".join(formula(x) for x in row) for row in entries)
    return rf"\begin{{bmatrix}} {rows} \end{{bmatrix}}"


def _name(name: Name) -> str:
    if not name.index:
        return _glyph(glyph(name.letter.strip())) if name.letter.strip().isalnum() else _words(name.letter)
    index = "".join(_GREEK.get(letter, letter) for letter in name.index.replace("−", "-"))
    return f"{_letter(name.letter)}_{{{index}}}"


def _letter(text: str) -> str:
    """A letter, Greek ones by name, dots above as accents."""
    if text in _GREEK:
        return _GREEK[text]
    base, dots = text[:-1], _DOTS.get(unicodedata.normalize("NFD", text)[-1:], "")
    return rf"{dots}{{{unicodedata.normalize('NFD', text)[0]}}}" if dots and len(base) <= 1 else text


def _words(text: str) -> str:
    for letter, command in _GREEK.items():
        text = text.replace(letter, command)
    return (
        text.replace("∂", r"\partial ")
        .replace("det J", r"\det J")
        .replace("×", r"\times")
        .replace("·", r"\cdot ")
        .replace("−", "-")
    )


def _glyph(letter: Glyph) -> str:
    base = _letter(letter.letter)
    return f"{base}_{{{letter.below}}}" if letter.below else base


def _sum(parts: tuple[Part, ...]) -> str:
    text = ""
    for part in parts:
        sign = "-" if part.number < 0 else "+"
        text += f" {sign} " if text else ("-" if sign == "-" else "")
        text += _part(part)
    return text or "0"


def _part(part: Part) -> str:
    pieces = [_power(f, power) for f, power in powers(part.factors)]
    if part.bracket:
        pieces.append(f"({_sum(part.bracket)})")
    pieces += [_power(f, power) for f, power in powers(part.behind)]
    if abs(part.number) != 1.0 or not pieces:
        pieces.insert(0, number_text(part.number).replace("½", r"\tfrac{1}{2}"))
    return r"\,".join(pieces)


def _power(factor: Factor, power: int) -> str:
    """A factor with its power; sines and cosines written in full get brackets around them."""
    text = _factor(factor)
    if power == 1:
        return text
    return f"{text}^{{{power}}}" if factor_glyph(factor) is not None else f"({text})^{{{power}}}"


def _factor(factor: Factor) -> str:
    short = factor_glyph(factor)
    if short is not None:
        return _glyph(short)
    assert isinstance(factor, Trig)
    inside = ""
    for sign, multiple, letter in signed_angles(factor.angle):
        shown = "-" if sign == "−" else "+"
        inside += f" {shown} " if inside else ("-" if shown == "-" else "")
        inside += ("" if multiple == 1 else str(multiple)) + _glyph(letter)
    return rf"\{'sin' if factor.sine else 'cos'}({inside})"
