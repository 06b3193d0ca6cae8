"""A sentence that can be said in either language, when it is read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from mafsil.messages import say


@dataclass(frozen=True, slots=True)
class Remark:
    """Something worth saying about a log, a fit or a file.

    Attributes:
        key: of the sentence in the message catalogue.
        details: what the sentence mentions; remarks among them are said in the same language.
    """

    key: str
    details: Mapping[str, object] = field(default_factory=dict[str, object])

    def sentence(self, language: str | None = None) -> str:
        """The sentence in the given language, or the current one."""
        said = {
            name: value.sentence(language) if isinstance(value, Remark) else value
            for name, value in self.details.items()
        }
        return say(self.key, language=language, **said)

    def __str__(self) -> str:
        return self.sentence()
