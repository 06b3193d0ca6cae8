"""What a check of a student's work hands back: findings that name the wrong entry and the likely mistake, in words."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

from mafsil.answer import Answer, Status
from mafsil.derivation.tolerances import ROUNDOFF
from mafsil.messages import say


class Mistake(Enum):
    """The mistakes that are looked for; the value is the name of the sentence."""

    SIGN = "sign"
    REVERSED = "reversed"
    DEGREES = "degrees"
    ANGLES_SWAPPED = "angles_swapped"
    LENGTHS_SWAPPED = "lengths_swapped"
    ROW_SHIFTED = "row_shifted"
    CONVENTION = "convention"
    OFFSET = "offset"
    KIND = "kind"
    CROSS_ORDER = "cross_order"
    POINT_AS_MOMENT = "point_as_moment"
    NO_MOMENT = "no_moment"
    PARTS_SWAPPED = "parts_swapped"
    NOT_UNIT = "not_unit"
    FRAME = "frame"
    OTHER_BASE = "other_base"
    POSITION_VECTOR = "position_vector"
    ZERO_CONFIGURATION = "zero_configuration"
    COLUMN_SWAPPED = "column_swapped"
    TRANSPOSED = "transposed"
    SINE_COSINE = "sine_cosine"
    ANGLE = "angle"
    TERM_SIGN = "term_sign"
    LETTER = "letter"
    LENGTHS = "lengths"
    VALUE = "value"


class ReviewStatus(Status):
    """Whether the work is right."""

    CORRECT = ("derivation.correct", True)
    WRONG = ("derivation.wrong", False)
    NOT_PROVEN = ("derivation.not_proven", False)


@dataclass(frozen=True, slots=True)
class Finding:
    """One wrong place.

    Attributes:
        mistake: the likely mistake.
        row, column: from 1, or None where the finding concerns the whole.
        entry: name of the quantity, such as `alpha` or `v`.
        given, expected: what stands there and what should, as text; empty where that says nothing. A table in the other
            convention: the names of both.
    """

    mistake: Mistake
    row: int | None = None
    column: int | None = None
    entry: str = ""
    given: str = ""
    expected: str = ""

    def message(self, language: str | None = None) -> str:
        """Place, values and mistake as a sentence."""
        pieces = [self._place(language)]
        details = {"given": self.given, "expected": self.expected}
        if self.given and self.mistake is not Mistake.CONVENTION:
            pieces.append(
                say("derivation.values" if self.expected else "derivation.stands", language=language, **details)
            )
        pieces.append(say(f"derivation.mistake_{self.mistake.value}", language=language, **details))
        return say("derivation.colon", language=language, place=pieces[0], rest=" ".join(pieces[1:]))

    def to_dict(self) -> dict[str, Any]:
        """Plain data, with the sentence."""
        details = {name: getattr(self, name) for name in ("row", "column", "entry", "given", "expected")}
        return {"mistake": self.mistake.value, **details, "sentence": self.message()}

    def _place(self, language: str | None) -> str:
        entry = f" {self.entry}" if self.entry else ""
        if self.row is not None and self.column is not None:
            return say("derivation.place_entry", language=language, row=self.row, column=self.column)
        if self.row is not None:
            return say("derivation.place_row", language=language, row=self.row, entry=entry)
        if self.column is not None:
            return say("derivation.place_column", language=language, column=self.column, entry=entry)
        return say("derivation.place_whole", language=language, entry=entry)


@dataclass(frozen=True, slots=True, repr=False)
class Review(Answer, entries="findings", data="correct proven findings others"):
    """The result of a check: true if nothing is wrong, iterable over the findings.

    Attributes:
        findings: nothing if the work is right.
        proven: the findings, repaired, make the work right; otherwise they are only where it differs.
        others: single mistakes that would explain the work as well.
    """

    findings: tuple[Finding, ...] = ()
    proven: bool = True
    others: tuple[Finding, ...] = ()

    @property
    def correct(self) -> bool:
        """Whether nothing is wrong."""
        return not self.findings

    def __bool__(self) -> bool:
        return self.correct

    def __repr__(self) -> str:
        return self.message()

    @property
    def status(self) -> ReviewStatus:
        """CORRECT, WRONG where the findings explain all of it, or NOT_PROVEN where they only say where it differs."""
        if self.correct:
            return ReviewStatus.CORRECT
        return ReviewStatus.WRONG if self.proven else ReviewStatus.NOT_PROVEN

    def message(self, language: str | None = None) -> str:
        """All findings, one a line, or that there is none."""
        if self.correct:
            return say("derivation.correct", language=language)
        lines = [finding.message(language) for finding in self.findings]
        if not self.proven:
            lines.insert(0, say("derivation.not_proven", language=language))
        elif [finding.mistake for finding in self.findings] == [Mistake.CONVENTION]:
            lines.append(say("derivation.right_otherwise", language=language, expected=self.findings[0].expected))
        lines += [
            say("derivation.or_else", language=language, finding=other.message(language)) for other in self.others
        ]
        return "\n".join(lines)

    def explain(self, language: str | None = None) -> str:
        """The same as `message`."""
        return self.message(language)


def shown(value: float) -> str:
    """A number with six digits; below the roundoff of lengths of some metres it is zero."""
    return f"{0.0 if abs(value) < ROUNDOFF else value:.6g}"
