"""Letters with an index inside sentences: z_i, T_i-1,i, J_s; every format sets them in its own way."""

from __future__ import annotations

import re
from collections.abc import Callable

_LETTER = re.compile(
    r"(?<![A-Za-z0-9_α-ωΑ-Ω\u0307\u0308-])"
    r"(?:(?P<letter>[A-Za-zα-ωΑ-Ω\u1e00-\u1eff][\u0307\u0308]?)"
    r"_(?P<index>[0-9A-Za-z]+(?:[-+]1)?(?:,[0-9A-Za-z]+(?:[-+]1)?)*)(?![A-Za-z0-9_])"
    r"|(?P<greek>[α-ω])(?P<digit>\d))"
)
"""A letter, Latin or Greek, perhaps with dots above, and its index; an Arabic letter may be joined to it."""


def with_letters(sentence: str, plain: Callable[[str], str], letter: Callable[[str, str], str]) -> str:
    """The sentence with every letter and index set by `letter`, everything else by `plain`."""
    pieces: list[str] = []
    end = 0
    for found in _LETTER.finditer(sentence):
        pieces.append(plain(sentence[end : found.start()]))
        pieces.append(letter(found["letter"] or found["greek"], found["index"] or found["digit"]))
        end = found.end()
    return "".join([*pieces, plain(sentence[end:])])
