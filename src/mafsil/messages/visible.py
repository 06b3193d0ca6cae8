"""Names of strangers on our screens: control and direction characters are shown by number, never obeyed."""

from __future__ import annotations

import unicodedata


def visible(text: str) -> str:
    """The text with control, format and separator characters written as `<U+202E>`.

    Args:
        text: a name or sentence that may come from a file; a terminal or a page would obey an escape sequence or a
            change of direction in it.

    Returns:
        The same text if it has none of them; ordinary spaces stay.
    """
    return "".join(f"<U+{ord(c):04X}>" if _obeyed(c) else c for c in text)


def _obeyed(character: str) -> bool:
    return unicodedata.category(character) in {"Cc", "Cf", "Zl", "Zp", "Cs", "Co"} and character not in _HARMLESS


# Joiners shape Arabic letters; marks only stand beside their neighbours and cannot turn what follows.
_HARMLESS = "\u200c\u200d\u200e\u200f\u061c"
