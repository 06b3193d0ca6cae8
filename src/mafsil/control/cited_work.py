"""A work that modules of the package follow."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Citation:
    """One work.

    Attributes:
        key: short name, such as `khatib1987`.
        authors, title, where: as one cites it.
        year: of publication.
        modules: of the package that follow it.
    """

    key: str
    authors: str
    title: str
    where: str
    year: int
    modules: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.authors}: {self.title}. {self.where}, {self.year}."

    def bibtex(self) -> str:
        """The entry for a bibliography in LaTeX."""
        return (
            f"@misc{{{self.key},\n  author = {{{self.authors.replace(', ', ' and ')}}},\n  title = {{{self.title}}},\n"
            f"  howpublished = {{{self.where}}},\n  year = {{{self.year}}}\n}}"
        )


def modules(*names: str) -> tuple[str, ...]:
    """Full names of modules: `modules("control.hybrid")` is `("mafsil.control.hybrid",)`."""
    return tuple(f"mafsil.{name}" for name in names)
