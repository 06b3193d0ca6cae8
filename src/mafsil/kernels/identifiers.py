"""Names that every C compiler and every linker takes, made from any text."""

from __future__ import annotations

import re
from hashlib import blake2b

_LONGEST = 31
"""C99 promises so many significant characters of an external name."""


def identifier(text: str) -> str:
    """A C identifier that reminds of the text; letters of other scripts become a short hash."""
    slug = re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")
    if not text.isascii() or not slug or len(slug) > _LONGEST:
        slug = (
            f"{slug[:20].strip('_') or 'robot'}_{blake2b(text.encode('utf-8', 'replace'), digest_size=3).hexdigest()}"
        )
    return slug if slug[0].isalpha() else f"r{slug}"
