"""Names of the library's mechanisms in the language of the reader; names of others as they were given."""

from __future__ import annotations

import re

from mafsil.messages import say
from mafsil.messages.catalogue import keys


def spoken_name(name: str, language: str | None = None) -> str:
    """The name of a linkage as sentences and pictures say it; a dash where it has none.

    Args:
        name: as the linkage has it, such as `four-bar` or `chain of 7`.
        language: `en` or `ar`; the current one if None.
    """
    numbers = re.findall(r"(?<![\w-])\d+(?![\w-])", name)
    key = re.sub(r"[^a-z0-9]+", "_", re.sub(r"(?<![\w-])\d+(?![\w-])", "n", name).lower())
    if len(numbers) > 1 or key not in keys("en", "mechanisms"):
        return name or "-"
    return say(f"mechanisms.{key}", language=language, n=numbers[0] if numbers else "")
