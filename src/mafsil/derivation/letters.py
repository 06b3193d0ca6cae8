"""How letters look: names split into letter and index, sines and cosines as c_12, s_3 or in full.

Letters with an index inside sentences: z_i, T_i-1,i, J_s; every format sets them in its own way.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable
from typing import NamedTuple

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
