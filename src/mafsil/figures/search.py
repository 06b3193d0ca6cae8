"""A search as a picture that grows: every edge where and when it was asked for, and the path at the end."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from os import PathLike
from xml.sax.saxutils import escape

import numpy as np

from mafsil.arrays import Floats, JointVector, positive, require_kind
from mafsil.collision import Checker
from mafsil.errors import InputError
from mafsil.figures.motion_over_time import COLOURS
from mafsil.figures.performance_sheet import SINGULAR
from mafsil.figures.space import picture_file
from mafsil.messages import say
from mafsil.planning.planner_bench import SearchLog
from mafsil.whole_file import write_whole

SIZE = 640
CELLS = 120
"""Of the background, in each direction."""
PIECES = 8
"""Of an edge that is curved in the picture."""
MOST_EDGES = 6000
"""In the picture; of more, every second, third, ... is drawn."""


def plot_search(
    log: SearchLog,
    path: str | PathLike[str],
    *,
    show: Callable[[JointVector], Floats] | None = None,
    seconds: float = 10.0,
    language: str | None = None,
) -> None:
    """Animate a search: free edges, edges in collision, and the path.

    A problem of two coordinates is drawn over its free configurations; an arm by its tip seen from above.

    Args:
        log: of `mafsil.planning.log_search`.
        path: .svg; any browser plays it.
        show: (k, n) configurations -> (k, 2) places in the picture; None for the above.
        seconds: that the search takes in the picture.
        language: of the title; the current one if None.

    Raises:
        InputError: no such log, an ending of no SVG, places of a wrong shape.
    """
    file = picture_file(path, (".svg",))
    require_kind("log", log, "SearchLog", "edges", "free", "plan")
    positive("seconds", seconds)
    places = _Places(log, show)
    drawn = np.arange(0, len(log), max(1, -(-len(log) // MOST_EDGES)))
    begins = seconds * drawn / max(len(log), 1)
    title = escape(log.plan.explain(language).splitlines()[0])
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIZE} {SIZE + 30}" font-family="sans-serif">',
        f"<title>{title}</title>",
        f'<rect width="{SIZE}" height="{SIZE + 30}" fill="white"/>',
        *places.background(),
    ]
    for ends, free, begin in zip(log.edges[drawn], log.free[drawn], begins, strict=True):
        colour, width = (COLOURS[0], 1.2) if free else (SINGULAR, 0.5)
        parts.append(_line(places.line(ends), colour, width, float(begin), 0.9 if free else 0.5))
    if log.plan:
        parts.append(_line(places.line(log.plan.path), COLOURS[1], 3.0, seconds, 1.0))
    for q, colour in ((log.query.start, COLOURS[2]), *((goal, COLOURS[3]) for goal in np.atleast_2d(log.query.goal))):
        (x, y), *_ = places.line(q[None])
        parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="{colour}"/>')
    counts = say(
        "planning.search_counts", language=language, edges=len(log), refused=int((~log.free).sum()), drawn=len(drawn)
    )
    parts.append(f'<text x="10" y="{SIZE + 20}" font-size="14">{title}. {escape(counts)}</text></svg>\n')
    write_whole(file, "\n".join(parts).encode())


def _line(points: Floats, colour: str, width: float, begin: float, opacity: float) -> str:
    text = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return (
        f'<polyline points="{text}" fill="none" stroke="{colour}" stroke-width="{width}" opacity="0">'
        f'<set attributeName="opacity" to="{opacity}" begin="{begin:.3f}s" fill="freeze"/></polyline>'
    )


class _Places:
    """Configurations in the picture."""

    def __init__(self, log: SearchLog, show: Callable[[JointVector], Floats] | None) -> None:
        space = log.query.space
        self.space = space
        self.plane = show is None and not isinstance(space, Checker)
        self.show = show or (_tip(space) if isinstance(space, Checker) else _first_two)
        if self.plane and log.edges.shape[-1] != 2:
            self.plane = False
        ends = log.edges.reshape(-1, log.edges.shape[-1])
        known = np.concatenate([ends, log.query.start[None], np.atleast_2d(log.query.goal)])
        xy = np.asarray(self.show(known))
        if xy.shape != (len(known), 2):
            raise InputError("input.shape", name="show", expected=(len(known), 2), got=xy.shape, hint="")
        if self.plane and not isinstance(space, Checker):
            self.low, self.high = space.lower, space.upper
        else:
            self.low, self.high = xy.min(axis=0), xy.max(axis=0)
        self.wide = float(max((self.high - self.low).max(), 1e-9))

    def line(self, points: JointVector) -> Floats:
        """(k, 2) in the picture; between points that are curved there, more."""
        if not self.plane and len(points) > 1:
            shares = np.linspace(0.0, 1.0, PIECES, endpoint=False)[:, None]
            pieces = [a + shares * (b - a) for a, b in pairwise(points)]
            points = np.concatenate([*pieces, points[-1:]])
        xy = (np.asarray(self.show(points)) - self.low) / self.wide
        return np.stack([10 + (SIZE - 20) * xy[:, 0], SIZE - 10 - (SIZE - 20) * xy[:, 1]], axis=1)

    def background(self) -> list[str]:
        """Rows of cells that are not free, where the picture is the space of configurations itself."""
        if not self.plane or isinstance(self.space, Checker):
            return []
        edges: Floats = np.linspace(self.low, self.high, CELLS + 1).T
        x, y = (0.5 * (each[1:] + each[:-1]) for each in edges)
        cells = np.stack([np.repeat(x, CELLS), np.tile(y, CELLS)], axis=1)
        full = ~np.asarray(self.space.free(cells), dtype=np.bool_)
        parts: list[str] = []
        for column, blocked in enumerate(full.reshape(CELLS, CELLS)):
            jumps = np.flatnonzero(np.diff(np.concatenate([[0], blocked.astype(np.int8), [0]])))
            for first, last in jumps.reshape(-1, 2):
                corners = np.array([[edges[0][column], edges[1][last]], [edges[0][column + 1], edges[1][first]]])
                (x0, y0), (x1, y1) = self.line(corners)
                parts.append(
                    f'<rect x="{x0:.1f}" y="{y0:.1f}" width="{x1 - x0 + 0.3:.1f}" height="{y1 - y0:.1f}" fill="#ccc"/>'
                )
        return parts


def _tip(checker: Checker) -> Callable[[JointVector], Floats]:
    return lambda q: np.asarray(checker.robot.forward_kinematics(q))[..., :2, 3]


def _first_two(q: JointVector) -> Floats:
    return q[:, :2]
