"""Formulas of vectors, angles and turns as trees: evaluated for the check, and written as text, LaTeX and MathML.

How letters look: names split into letter and index, sines and cosines as c_12, s_3 or in full.

Letters with an index inside sentences: z_i, T_i-1,i, J_s; every format sets them in its own way.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from html import escape
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from mafsil.derivation.polynomial import Angle, Factor, Symbol

_LETTER = re.compile(
    r"(?<![A-Za-z0-9_α-ωΑ-Ω\u0307\u0308-])"
    r"(?:(?P<letter>[A-Za-zα-ωΑ-Ω\u1e00-\u1eff][\u0307\u0308]?)"
    r"_(?P<index>[0-9A-Za-z]+(?:[-+]1)?(?:,[0-9A-Za-z]+(?:[-+]1)?)*)(?![A-Za-z0-9_])"
    r"|(?P<greek>[α-ω])(?P<digit>\d))"
)
"""A letter, Latin or Greek, perhaps with dots above, and its index; an Arabic letter may be joined to it."""
GREEK = {
    "theta": "θ", "alpha": "α", "delta": "δ", "det": "det", "Gamma": "Γ", "tau": "τ",
    "phi": "φ", "dtheta": "θ̇", "ddtheta": "θ̈", "dq": "q̇", "ddq": "q̈",
}  # fmt: skip


class Glyph(NamedTuple):
    """A letter with an index below it."""

    letter: str
    below: str


def glyph(name: str) -> Glyph:
    """Letter and index of a name: theta3 is θ with 3, t_x is t with x."""
    plain = name.rstrip("_")
    stem, _, index = plain.partition("_")
    if not index:
        stem = plain.rstrip("0123456789")
        index = plain[len(stem) :]
    return Glyph(GREEK.get(stem) or _dot(stem), index + ("'" if name.endswith("_") else ""))


def _dot(stem: str) -> str:
    """A rate, dx or ddx, as its letter with dots above."""
    dots = {2: "\u0307", 3: "\u0308"}.get(len(stem), "")
    return unicodedata.normalize("NFC", stem[-1] + dots) if dots and stem[:-1] in ("d", "dd") else stem


def factor_glyph(factor: Factor) -> Glyph | None:
    """A length, c_12 or s_3; None if the angle has to be written in full."""
    if isinstance(factor, Symbol):
        return glyph(factor.name)
    short = short_index(factor.angle)
    return None if short is None else Glyph("s" if factor.sine else "c", short)


def short_index(angle: Angle) -> str | None:
    """`123` for theta1 + theta2 + theta3, None for anything else or ten and more joints."""
    names = [name for name, _ in angle]
    joints = [name.removeprefix("theta") for name in names]
    plain = all(k == 1 for _, k in angle) and all(len(j) == 1 and j.isdigit() for j in joints)
    return "".join(joints) if plain else None


def signed_angles(angle: Angle) -> list[tuple[str, int, Glyph]]:
    """Sign, multiple and letter of every summand of an angle."""
    return [("−" if k < 0 else "+", abs(k), glyph(name)) for name, k in angle]


def number_text(value: float) -> str:
    """A coefficient: whole numbers and one half exactly, others with ten digits; without sign."""
    return "½" if abs(value) == 0.5 else f"{abs(value):.10g}"


def superscript(power: int) -> str:
    """A power in small raised digits; nothing for the first."""
    return "" if power == 1 else str(power).translate(_RAISED)


_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


def with_letters(sentence: str, plain: Callable[[str], str], letter: Callable[[str, str], str]) -> str:
    """The sentence with every letter and index set by `letter`, everything else by `plain`."""
    pieces: list[str] = []
    end = 0
    for found in _LETTER.finditer(sentence):
        pieces.append(plain(sentence[end : found.start()]))
        pieces.append(letter(found["letter"] or found["greek"], found["index"] or found["digit"]))
        end = found.end()
    return "".join([*pieces, plain(sentence[end:])])


Values: TypeAlias = Mapping[str, Any]
"""Numbers (states,), vectors (states, 3) or matrices (states, 3, 3) of every name."""


@dataclass(frozen=True, slots=True, eq=False)
class Expression:
    """One operation on others; a leaf holds a name or a number.

    Attributes:
        kind: key of `_UNARY` or `_BINARY`, or `name`, `number`.
        parts: operands.
        leaf: name or number.
    """

    kind: str
    parts: tuple[Expression, ...] = ()
    leaf: str | float = ""

    def __add__(self, other: Expression) -> Expression:
        return Expression("+", (self, other))

    def __sub__(self, other: Expression) -> Expression:
        return Expression("−", (self, other))

    def __mul__(self, other: Expression) -> Expression:
        """Numbers, or a number or matrix and a vector, side by side."""
        return Expression(" ", (self, other))

    def __truediv__(self, other: Expression) -> Expression:
        return Expression("/", (self, other))

    def __neg__(self) -> Expression:
        return Expression("neg", (self,))

    def dot(self, other: Expression) -> Expression:
        """Scalar product."""
        return Expression("·", (self, other))

    def cross(self, other: Expression) -> Expression:
        """Vector product."""
        return Expression("×", (self, other))

    def evaluate(self, values: Values, sign: float = 1.0) -> Any:
        """Its numbers.

        Args:
            values: of the names.
            sign: that the plus-minus sign stands for.
        """
        if self.kind == "name":
            return values[str(self.leaf)]
        if self.kind == "number":
            return np.float64(self.leaf)
        operands = [part.evaluate(values, sign) for part in self.parts]
        if self.kind in _UNARY:
            return _UNARY[self.kind](*operands)
        return _BINARY[self.kind](sign, *operands)

    @property
    def signed(self) -> bool:
        """Whether a plus-minus sign stands in it."""
        return self.kind == "±" or any(part.signed for part in self.parts)

    def text(self) -> str:
        """As plain text."""
        return _written(self, _TEXT)

    def latex(self) -> str:
        """As LaTeX."""
        return _written(self, _LATEX)

    def mathml(self) -> str:
        """As MathML, without the enclosing element."""
        return f"<mrow>{_written(self, _MATHML)}</mrow>"


def name_expression(name: str) -> Expression:
    """A name."""
    return Expression("name", leaf=name)


def number(value: float) -> Expression:
    """A number."""
    return Expression("number", leaf=value)


def function(name: str, *parts: Expression) -> Expression:
    """One of sqrt, square, cos, sin, acos, atan2, Rot (axis, angle), transpose."""
    return Expression(name, parts)


def plus_minus(first: Expression, second: Expression) -> Expression:
    """Both of first + second and first - second."""
    return Expression("±", (first, second))


def _scale(_sign: float, a: Any, b: Any) -> Any:
    if np.ndim(a) == 3:
        return np.einsum("kij,kj->ki", a, b) if np.ndim(b) == 2 else a @ b
    return a[..., None] * b if np.ndim(b) == 2 and np.ndim(a) == 1 else a * b


def _turn(_sign: float, axis: Any, angle: Any) -> Any:
    """(states, 3, 3) rotation about a unit axis."""
    K = np.zeros((*axis.shape[:1], 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        K[:, j, i], K[:, i, j] = axis[:, k], -axis[:, k]
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + s * K + (1 - c) * (K @ K)


_UNARY: dict[str, Callable[[Any], Any]] = {
    "neg": lambda a: -a,
    "sqrt": lambda a: np.sqrt(np.maximum(a, 0.0)),
    "square": lambda a: (a * a).sum(axis=-1) if np.ndim(a) == 2 else a * a,
    "cos": np.cos,
    "sin": np.sin,
    "acos": lambda a: np.arccos(np.clip(a, -1.0, 1.0)),
    "transpose": lambda a: np.swapaxes(a, -1, -2),
}
_BINARY: dict[str, Callable[[float, Any, Any], Any]] = {
    "+": lambda _, a, b: a + b,
    "−": lambda _, a, b: a - b,
    " ": _scale,
    "/": lambda _, a, b: a / b,
    "·": lambda _, a, b: (a * b).sum(axis=-1),
    "×": lambda _, a, b: np.cross(a, b),
    "±": lambda sign, a, b: a + sign * b,
    "atan2": lambda _, a, b: np.arctan2(a, b),
    "Rot": _turn,
}
"""Operations on one operand, and on two; these also take the sign that a plus-minus stands for."""
_BINDING = {"+": 1, "−": 1, "±": 1, "neg": 1, "/": 2, "·": 2, "×": 2, " ": 3}
"""How strongly operations hold their operands; weaker ones inside stronger ones get brackets."""


@dataclass(frozen=True)
class _Style:
    """How leaves and operations look in one format."""

    name: Callable[[str], str]
    number: Callable[[float], str]
    between: Mapping[str, str]
    bracket: Callable[[str], str]
    call: Callable[[str, list[str]], str]
    fraction: Callable[[str, str], str] | None = None


def _written(node: Expression, style: _Style, outer: int = 0) -> str:
    if node.kind == "name":
        return style.name(str(node.leaf))
    if node.kind == "number":
        return style.number(float(node.leaf))
    binding = _BINDING.get(node.kind)
    if binding is None:
        return style.call(node.kind, [_written(part, style, 4 if node.kind == "square" else 0) for part in node.parts])
    if node.kind == "/" and style.fraction is not None:
        return style.fraction(*(_written(part, style) for part in node.parts))
    if node.kind == "neg":
        text = style.between["−"].strip() + _written(node.parts[0], style, 2)
    else:
        # The right operand of a difference, a quotient or a vector product needs brackets at equal binding.
        right = binding + (node.kind in ("−", "/", "×", "·", "±"))
        left, last = node.parts
        text = _written(left, style, binding) + style.between[node.kind] + _written(last, style, right)
    return style.bracket(text) if binding < outer else text


def _plain_name(name: str) -> str:
    letter = glyph(name)
    return letter.letter + (letter.below if letter.below.isdigit() or not letter.below else f"_{letter.below}")


_TEXT = _Style(
    _plain_name,
    lambda x: ("−" if x < 0 else "") + number_text(x),
    {"+": " + ", "−": " − ", "±": " ± ", "/": " / ", "·": "·", "×": " × ", " ": " "},
    lambda text: f"({text})",
    lambda name, parts: {
        "sqrt": lambda: f"√({parts[0]})",
        "square": lambda: f"{parts[0]}²",
        "transpose": lambda: f"{parts[0]}ᵀ",
    }.get(name, lambda: f"{name}({', '.join(parts)})")(),
)
_LETTERS = {"θ": r"\theta", "φ": r"\varphi"}


def _latex_name(name: str) -> str:
    letter = glyph(name)
    base = _LETTERS.get(letter.letter, letter.letter)
    return f"{base}_{{{letter.below}}}" if letter.below else base


_LATEX = _Style(
    _latex_name,
    lambda x: ("-" if x < 0 else "") + number_text(x).replace("½", r"\tfrac{1}{2}"),
    {"+": " + ", "−": " - ", "±": r" \pm ", "/": " / ", "·": r" \cdot ", "×": r" \times ", " ": r"\,"},
    lambda text: rf"\left({text}\right)",
    lambda name, parts: {
        "sqrt": lambda: rf"\sqrt{{{parts[0]}}}",
        "square": lambda: f"{parts[0]}^2",
        "transpose": lambda: rf"{parts[0]}^{{\top}}",
    }.get(name, lambda: rf"\operatorname{{{name}}}\left({', '.join(parts)}\right)")(),
    lambda a, b: rf"\frac{{{a}}}{{{b}}}",
)


def _mathml_name(name: str) -> str:
    letter = glyph(name)
    base = f"<mi>{escape(letter.letter)}</mi>"
    return f"<msub>{base}<mtext>{escape(letter.below)}</mtext></msub>" if letter.below else base


def _mathml_call(name: str, parts: list[str]) -> str:
    if name == "sqrt":
        return f"<msqrt><mrow>{parts[0]}</mrow></msqrt>"
    if name in ("square", "transpose"):
        raised = "<mn>2</mn>" if name == "square" else "<mo>⊤</mo>"
        return f"<msup><mrow>{parts[0]}</mrow>{raised}</msup>"
    return f"<mi>{name}</mi><mrow><mo>(</mo>{'<mo>,</mo>'.join(parts)}<mo>)</mo></mrow>"


_MATHML = _Style(
    _mathml_name,
    lambda x: ("<mo>−</mo>" if x < 0 else "") + f"<mn>{number_text(x)}</mn>",
    {
        "+": "<mo>+</mo>",
        "−": "<mo>−</mo>",
        "±": "<mo>±</mo>",
        "/": "<mo>/</mo>",
        "·": "<mo>·</mo>",
        "×": "<mo>×</mo>",
        " ": '<mspace width="0.2em"></mspace>',
    },
    lambda text: f"<mrow><mo>(</mo>{text}<mo>)</mo></mrow>",
    _mathml_call,
    lambda a, b: f"<mfrac><mrow>{a}</mrow><mrow>{b}</mrow></mfrac>",
)
