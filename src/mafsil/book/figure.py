"""Figures of the book by number: drawn anew from live objects, with sliders, captions in two languages, errata."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from io import StringIO
from os import PathLike
from typing import Any, ClassVar

import numpy as np

from mafsil.arrays import number as require_number
from mafsil.book.entry import Entry, EntryStatus, Fact, Index, Slider
from mafsil.errors import InputError
from mafsil.figures import space
from mafsil.figures.panel import Panel, draw_panels
from mafsil.figures.panel_data import PanelView
from mafsil.figures.space import picture_file
from mafsil.messages import LANGUAGES, in_line


@dataclass(frozen=True, eq=False)
class Drawing:
    """What a maker of a figure returns.

    Attributes:
        panels: by name; one whose name has words in the catalogue gets them as its heading.
        objects: live, by name.
        facts: numbers that the figure states.
        columns: number of panels beside each other.
        cell: width and height of a panel [inch].
        picture: draws the matplotlib figure instead of the panels, from another module of `mafsil.figures`.
    """

    panels: Mapping[str, Panel] = field(default_factory=dict[str, Panel])
    objects: Mapping[str, Any] = field(default_factory=dict[str, Any])
    facts: Iterable[Fact] = ()
    columns: int | None = None
    cell: tuple[float, float] | None = None
    picture: Callable[[], Any] | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Figure(Entry):
    """A figure of the book, drawn from live objects; see `Entry` for number, objects, facts and words.

    Attributes:
        parameters: its sliders by name, at their present values.
        drawing: what its maker returned.
    """

    AREA: ClassVar[str] = "book_figures"
    parameters: Mapping[str, Slider]
    drawing: Drawing

    @property
    def panels(self) -> Mapping[str, Panel]:
        """The elements of its parts, by name; empty where another module draws it."""
        return self.drawing.panels

    def draw(self) -> Any:
        """A matplotlib figure, titled in the current language."""
        if self.drawing.picture is not None:
            return self.drawing.picture()
        headings = {name: self.words(name) for name in self.panels}
        return draw_panels(self.panels, headings, self.title, self.drawing.columns, self.drawing.cell)

    def live_data(self, language: Sequence[str] = LANGUAGES) -> dict[str, Any]:
        """What a page needs to redraw it without Python: each slider with the drawings along it, the others at theirs.

        Args:
            language: of the words.
        """
        points = sum(len(one.points) for panel in self.panels.values() for one in panel.elements)
        count = SAMPLES if points < MANY_POINTS else SAMPLES // 2 + 1
        samples = {
            name: [figure(self.number, **{name: float(x)}) for x in np.linspace(s.least, s.greatest, count)]
            for name, s in self.parameters.items()
        }
        drawn = [self, *(one for along in samples.values() for one in along)]
        sheets = {name: PanelView([one.panels[name] for one in drawn if name in one.panels]) for name in self.panels}

        def parts(one: Figure) -> list[Any]:
            return [sheet.changes(one.panels.get(name), self.panels[name]) for name, sheet in sheets.items()]

        def facts(one: Figure) -> dict[str, list[str]]:
            return {code: [in_line(one.fact_line(fact, code), code) for fact in one.facts] for code in language}

        sliders = [
            {"name": name, "unit": s.unit, "least": s.least, "greatest": s.greatest, "value": s.value,
             "frames": [[parts(one), facts(one)] for one in samples[name]]}
            for name, s in self.parameters.items()
        ]  # fmt: skip
        panels = [sheet.whole(self.panels[name]) for name, sheet in sheets.items()]
        headings = [{code: in_line(self.words(name, code), code) for code in language} for name in sheets]
        return {"panels": panels, "headings": headings, "facts": facts(self), "sliders": sliders}

    def save(self, path: str | PathLike[str]) -> None:
        """Draw it into a file.

        Args:
            path: .png, .svg or .pdf.
        """
        space.save(self.draw, picture_file(path))

    def _repr_html_(self) -> str:
        """The drawing and below it the words, for a notebook."""
        text = StringIO()
        self.draw().savefig(text, format="svg", bbox_inches="tight", metadata={"Date": None})
        image = text.getvalue()
        return f"<figure>{image[image.index('<svg') :]}<figcaption>{super()._repr_html_()}</figcaption></figure>"


SAMPLES, MANY_POINTS = 25, 600
"""Drawings along a slider, between which a page interpolates; points of a figure of which half as many are enough."""


@dataclass(frozen=True, slots=True)
class _Maker:
    make: Callable[..., Drawing]
    status: EntryStatus
    sliders: Mapping[str, Slider]


CHAPTERS = (*(f"chapter_{k}" for k in (*range(2, 9), 10)), "remarks")
"""Modules of the entries, and of what is said beside them."""
_INDEX: Index[_Maker] = Index(CHAPTERS, "book.unknown_figure")


def draws(
    number: str, *, status: EntryStatus = EntryStatus.FIXED, **sliders: Slider
) -> Callable[[Callable[..., Drawing]], Callable[..., Drawing]]:
    """Declare what makes a figure; its sliders are passed by name.

    Args:
        number: as the source has it.
        status: how much of it the source fixes.
        sliders: by the names of the maker's arguments.
    """

    def declare(make: Callable[..., Drawing]) -> Callable[..., Drawing]:
        _INDEX.declare(number, _Maker(make, status, sliders))
        return make

    return declare


def figure(number: str, /, **values: float) -> Figure:
    """A figure of the book, drawn at the given values of its sliders.

    Args:
        number: such as "2.5".
        values: of sliders by name.

    Raises:
        InputError: no figure of that number, no slider of that name, or a value beyond its ends.
    """
    maker = _INDEX[number]
    for name, value in values.items():
        if name not in maker.sliders:
            raise InputError("book.unknown_slider", number=number, name=name, known=", ".join(maker.sliders) or "-")
        slider = maker.sliders[name]
        if not slider.least <= require_number(name, value) <= slider.greatest:
            ends = {"least": slider.least, "greatest": slider.greatest}
            raise InputError("book.beyond_slider", name=name, value=value, **ends, unit=slider.unit)
    now = {name: values.get(name, slider.value) for name, slider in maker.sliders.items()}
    drawing = maker.make(**now)
    sliders = {n: Slider(s.least, s.greatest, now[n], s.unit) for n, s in maker.sliders.items()}
    return Figure(number, maker.status, drawing.objects, tuple(drawing.facts), sliders, drawing)


def figures() -> list[str]:
    """Numbers of all figures of the book that are drawn here."""
    return _INDEX.numbers()


def module_of(number: str) -> str:
    """Name of the module of this package that draws a figure."""
    return _INDEX[number].make.__module__.rpartition(".")[2]
