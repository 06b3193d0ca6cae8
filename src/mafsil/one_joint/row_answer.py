"""Answers about one joint: a status for each row of the batch, numbers beside it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer, Status
from mafsil.messages import say
from mafsil.messages.tables import number, table


class RowAnswer(Answer):
    """One verdict for each row; every array of it has the batch in front. True if all rows succeeded.

    Subclasses are frozen dataclasses whose first attribute is `verdict`.

    Attributes:
        statuses: what the numbers of `verdict` mean.
        verdict: (*batch) which of `statuses`.
    """

    __slots__ = ()
    statuses: ClassVar[tuple[Status, ...]]
    verdict: NDArray[np.int8]

    @property
    def status(self) -> Status | tuple[Status, ...]:
        """The status; of a batch one for each row."""
        found = tuple(self.statuses[k] for k in self.verdict.ravel().tolist())
        return found if self.verdict.ndim else found[0]

    def details(self) -> dict[str, object]:
        """Numbers that the sentence of a single answer mentions."""
        return {name: float(value) for name, value in self._columns().items()}

    def __bool__(self) -> bool:
        return self.verdict.size > 0 and all(self.statuses[k].succeeded for k in set(self.verdict.ravel().tolist()))

    def __len__(self) -> int:
        return self.verdict.size

    def __iter__(self) -> Iterator[Any]:
        arrays = self._arrays()
        for index in np.ndindex(self.verdict.shape):
            own: Any = self
            yield replace(own, **{name: value[index] for name, value in arrays.items()})

    def _table(self) -> list[str]:
        if not self.verdict.ndim:
            return []
        columns = {name: value.ravel().tolist() for name, value in self._columns().items()}
        names = [self.statuses[k].name.lower() for k in self.verdict.ravel().tolist()]
        rows = [(f"{k} {name}", *(number(column[k]) for column in columns.values())) for k, name in enumerate(names)]
        return table(("", *columns), rows)

    def explain(self, language: str | None = None) -> str:
        """The sentence; of a batch one for each status that occurs, with the number of its rows."""
        if not self.verdict.ndim:
            return self.statuses[int(self.verdict)].sentence(language, **self.details())
        flat: list[int] = self.verdict.ravel().tolist()
        kinds = sorted(set(flat))
        counts = [flat.count(kind) for kind in kinds]
        lines = [
            say(
                "one_joint.rows", language=language, count=count, of=len(self), status=say(
                    self.statuses[k].key + "_many", language=language
                )
            )
            for k, count in zip(kinds, counts, strict=True)
        ]  # fmt: skip
        return "\n".join(lines) or say("one_joint.no_rows", language=language)

    def to_dict(self) -> dict[str, Any]:
        """Plain data: names of statuses, arrays, numbers."""
        names = [self.statuses[k].name.lower() for k in self.verdict.ravel().tolist()]
        own: Any = self
        rest = {each.name: getattr(own, each.name) for each in fields(own) if each.name != "verdict"}
        return {"status": names if self.verdict.ndim else names[0], **rest}

    def _arrays(self) -> dict[str, NDArray[Any]]:
        own: Any = self
        pairs: list[tuple[str, Any]] = [(each.name, getattr(own, each.name)) for each in fields(own)]
        return {name: value for name, value in pairs if hasattr(value, "dtype")}

    def _columns(self) -> dict[str, NDArray[Any]]:
        return {
            name: value
            for name, value in self._arrays().items()
            if name != "verdict" and value.shape == self.verdict.shape and value.dtype.kind in "fiub"
        }
