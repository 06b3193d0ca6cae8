"""The word that a misspelt one most probably means."""

from __future__ import annotations

from functools import lru_cache

LONGEST = 60
"""Characters beyond which nothing is compared."""
_OTHER, _ADDED, _EXCHANGED, _STYLE = 1.0, 0.9, 0.7, 0.1
"""What it costs to type another letter, one too many or few, two exchanged; another case or sign between words."""


@lru_cache(maxsize=4096)
def nearest_words(word: str, known: tuple[str, ...]) -> tuple[str, ...]:
    """The known words that lie nearest to a misspelt one, all of the same distance; none if none is near.

    Letters exchanged count less than letters added or left out, and these less than other letters; case, blanks and
    underscores count nearly nothing. A word of up to five letters may have one fault, of up to three none
    of the last kind, a longer one more.
    """
    if not word or len(word) > LONGEST:
        return ()
    allowed = _ADDED if len(word) <= 3 else max(_OTHER, len(word) / 4)
    distances = {name: _distance(word, name, allowed) for name in known if abs(len(name) - len(word)) <= allowed + 1}
    least = min(distances.values(), default=allowed + 1)
    return tuple(sorted(name for name, distance in distances.items() if distance <= least)) if least <= allowed else ()


def _distance(a: str, b: str, enough: float) -> float:
    """Weighted edits between two words; more than `enough` as soon as that is certain."""
    before: list[float] = []
    row = [_step(b[:j]) for j in range(len(b) + 1)]
    for i in range(1, len(a) + 1):
        earlier, before, row = before, row, [row[0] + _gap(a[i - 1])]
        for j in range(1, len(b) + 1):
            best = min(
                before[j - 1] + _change(a[i - 1], b[j - 1]), before[j] + _gap(a[i - 1]), row[j - 1] + _gap(b[j - 1])
            )
            if i > 1 and j > 1 and a[i - 1] == b[j - 2] != a[i - 2] == b[j - 1]:
                best = min(best, earlier[j - 2] + _EXCHANGED)
            row.append(best)
        if min(row) > enough:
            return enough + 1
    return row[-1]


def _step(text: str) -> float:
    return sum(map(_gap, text))


def _gap(letter: str) -> float:
    return _STYLE if letter in "_-: ." else _ADDED


def _change(a: str, b: str) -> float:
    if a == b:
        return 0.0
    return _STYLE if a.lower() == b.lower() or {a, b} <= set("_-: .") else _OTHER
