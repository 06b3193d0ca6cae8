"""Paper, ink and words shared by the pictures of performance."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mafsil.messages import say

INK, SHELL, SOFT = "#39424a", "#9aa4ad", "#dfe3e6"
VELOCITY, FORCE, SINGULAR, VOID = "#2f6fd0", "#d9702a", "#c4312c", "#f3efe6"


def sheet(width: float, height: float) -> Any:
    """An empty figure of that size [inch], drawn without a screen."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def flat_axes(axes: Any, x: str, y: str, *, equal: bool = True) -> None:
    """Equal scales, a light grid behind everything, no box."""
    if equal:
        axes.set_aspect("equal", adjustable="box")
    axes.set_axisbelow(True)
    axes.grid(color=SOFT, linewidth=0.6)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.tick_params(labelsize=8, color=SOFT)
    for side in axes.spines.values():
        side.set_visible(False)


def legend(axes: Any) -> None:
    """Names of curves, readable where a curve passes behind them."""
    axes.legend(fontsize=7, facecolor="white", edgecolor="none", framealpha=0.8)


def label(key: str, language: str | None = None, **details: object) -> str:
    """Words of a picture."""
    return say(f"performance.label_{key}", language=language, **details)


def save(figure: Any, path: Path) -> None:
    """Write a figure; no dates in files, so that the same numbers give the same bytes."""
    import matplotlib

    metadata = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(Path(path).suffix.lower(), {})
    with matplotlib.rc_context({"svg.hashsalt": "mafsil", "text.color": INK, "axes.labelcolor": INK}):
        figure.savefig(path, dpi=170, bbox_inches="tight", pad_inches=0.08, metadata=metadata)
