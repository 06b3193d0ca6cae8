"""Formulas of docstrings as MathML: `theta_1 = atan2(p_y, p_x)`, `T^-1 = (R', -R' p)`, `v_s = dp/dt - omega_s x p`."""

from __future__ import annotations

import re
from html import escape

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "zeta": "ζ", "eta": "η", "theta": "θ",
    "mu": "μ", "xi": "ξ", "pi": "π", "rho": "ρ", "sigma": "σ", "tau": "τ", "phi": "φ", "psi": "ψ", "omega": "ω",
    "Lambda": "Λ", "Sigma": "Σ", "Omega": "Ω",
}  # fmt: skip
RATES = {"qd": ("q", "˙"), "qdd": ("q", "¨"), "sd": ("s", "˙")}
SIGNS = {"in": "∈", "<=": "≤", ">=": "≥", "-": "−", "*": "·", "...": "…"}
TOKEN = re.compile(
    r"d(?P<top>[A-Za-z]*)/d(?P<below>[A-Za-z]+)|(?P<word>[A-Za-z]+2?(?:_[A-Za-z0-9]+)?)|(?P<number>\d+(?:\.\d+)?)"
    r"|(?P<sign>\.\.\.|<=|>=|[-+*/^'=<>|,()\[\]{}])"
)
SPACE = '<mspace width="0.2em"/>'
CLOSING = {"(": ")", "[": "]", "{": "}"}


def mathml(formula: str) -> str:
    """A formula as a `math` element, from left to right.

    Args:
        formula: in the notation of docs/conventions.md.
    """
    return f'<math dir="ltr">{_Reader(formula).row()}</math>'


class _Reader:
    """Reads tokens from left to right; powers and transposes belong to what stands before them."""

    def __init__(self, text: str) -> None:
        self._tokens = list(TOKEN.finditer(text))[::-1]

    def row(self, end: str = "") -> str:
        """All up to a closing bracket, which is taken too."""
        parts: list[str] = []
        while self._tokens and self._next() != end:
            sign = self._next()
            if parts and sign == "'":
                self._tokens.pop()
                parts[-1] = f"<msup>{parts[-1]}<mo>⊤</mo></msup>"
            elif parts and sign == "^":
                self._tokens.pop()
                minus = self._sign(self._tokens.pop()[0]) if self._next() == "-" else ""
                parts[-1] = f"<msup>{parts[-1]}<mrow>{minus}{self._part(False)}</mrow></msup>"
            else:
                parts.append(self._part(bool(parts) and not parts[-1].startswith("<mo")))
        if self._tokens:
            self._tokens.pop()
        return f"<mrow>{''.join(parts)}</mrow>"

    def _next(self) -> str:
        return self._tokens[-1][0] if self._tokens else ""

    def _part(self, follows: bool) -> str:
        """The next number, name, derivative, root, bracket or sign.

        Args:
            follows: whether it follows a value, so that an x before another one is a cross.
        """
        token = self._tokens.pop()
        if token["below"]:
            top = f"<mi>d</mi>{_name(token['top'])}" if token["top"] else "<mi>d</mi>"
            return f"<mfrac><mrow>{top}</mrow><mrow><mi>d</mi>{_name(token['below'])}</mrow></mfrac>"
        if token["number"]:
            return f"<mn>{token[0]}</mn>"
        if token["sign"]:
            if closing := CLOSING.get(token[0]):
                return f"<mrow>{self._sign(token[0])}{self.row(closing)}{self._sign(closing)}</mrow>"
            return self._sign(token[0])
        if token[0] == "sqrt" and self._next() == "(":
            self._tokens.pop()
            return f"<msqrt>{self.row(')')}</msqrt>"
        joins = token[0] == "x" and follows and bool(self._tokens) and not self._tokens[-1]["sign"]
        if joins or token[0] in SIGNS:
            return self._sign("×" if joins else token[0])
        after = SPACE if is_word(token[0]) and self._tokens and not self._tokens[-1]["sign"] else ""
        return (SPACE if is_word(token[0]) and follows else "") + _name(token[0]) + after

    def _sign(self, sign: str) -> str:
        return f'<mo stretchy="false">{escape(SIGNS.get(sign, sign))}</mo>'


def is_word(name: str) -> bool:
    """Whether a name is a word such as `cos` or `rank`, no letter with an index."""
    head = name.partition("_")[0]
    return len(head) > 1 and head not in GREEK and head not in RATES


def _name(word: str) -> str:
    """A name with its index: `theta_1`, `qd_a`."""
    head, _, index = word.partition("_")
    if head in RATES:
        letter, dots = RATES[head]
        base = f"<mover><mi>{letter}</mi><mo>{dots}</mo></mover>"
    else:
        base = f"<mi>{GREEK.get(head, head)}</mi>"
    return f"<msub>{base}<mi>{GREEK.get(index, index)}</mi></msub>" if index else base
