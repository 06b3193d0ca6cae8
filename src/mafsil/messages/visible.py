"""Names of strangers on our screens: control and direction characters are shown by number, never obeyed."""

from __future__ import annotations

import unicodedata


def visible(text: str) -> str:
    """The text with control, format and separator characters written as `<U+202E>`.

    Args:
        text: a name or sentence that may come from a file; a terminal or a page would obey an escape sequence or a
            change of direction in it.

    Returns:
        The same text if it has none of them; ordinary spaces stay, and so do isolates that are all closed.
    """
    kept = _ISOLATES if _is_balanced(text) else ""
    return "".join(f"<U+{ord(c):04X}>" if _obey(c) and c not in kept else c for c in text)


def _is_balanced(text: str) -> bool:
    """Whether every isolate is closed in its own line: then it turns nothing outside it."""
    depth = 0
    for character in text:
        if character in _ISOLATES:
            depth += -1 if character == "\u2069" else 1
        if depth < 0 or (character == "\n" and depth):
            return False
    return depth == 0


def _obey(character: str) -> bool:
    return unicodedata.category(character) in {"Cc", "Cf", "Zl", "Zp", "Cs", "Co"} and character not in _HARMLESS


# Joiners shape Arabic letters; marks only stand beside their neighbours and cannot turn what follows.
_HARMLESS = "\u200c\u200d\u200e\u200f\u061c"
# Ours: left to right, first strong letter, end. A stranger has no need to turn his own name to the left.
_ISOLATES = "\u2066\u2068\u2069"
