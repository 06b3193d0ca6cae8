"""What Python says to windows: in all languages, numbers and names kept in their own direction."""

from __future__ import annotations

from collections.abc import Callable

from mafsil.messages import LANGUAGES
from mafsil.messages.isolates import in_sentence


def in_all_languages(said: Callable[[str], str]) -> dict[str, str]:
    """A sentence by language.

    Args:
        said: from the code of a language to the sentence.
    """
    return {code: in_sentence(said(code), code) for code in LANGUAGES}
