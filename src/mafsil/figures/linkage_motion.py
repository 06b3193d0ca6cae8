"""Moving pictures of linkages: along the whole curve of their configurations, or to and fro along each free motion."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.figures.linkage import is_flat, skeleton
from mafsil.figures.space import picture_file
from mafsil.messages import in_line
from mafsil.messages.visible import visible
from mafsil.mobility import Linkage, Mobility, mobility, trace_motion
from mafsil.mobility.instantaneous import null_space
from mafsil.mobility.linkages import body_poses, close_loops_near
from mafsil.mobility.linkages.loop_closure import loop_matrix, units

FRAMES = 60
"""Of the whole curve, or of one motion to and fro."""
LONGEST_CURVE = 600
"""Steps of a curve that is followed."""
REACH = 0.6
"""How far a free motion is followed to each side [rad, sizes]."""
FEWEST = 5
"""Steps to each side, where there are many free motions."""
MOTIONS = 6
"""Free motions that are shown."""
_TRAIL = "#d33f3a"


def save_linkage_motion(linkage: Linkage, path: str | PathLike[str], *, found: Mobility | None = None) -> None:
    """Write a moving picture of a linkage, with the curve of a point of its output.

    A linkage of mobility 1 with loops goes through all configurations that `trace_motion` reaches, back again where the
    curve does not close; others swing along one free motion after the other.

    Args:
        linkage: as drawn, closed.
        path: .gif.
        found: its report; asked for if None.

    Raises:
        InputError: a linkage that cannot move.
    """
    file = picture_file(path, (".gif",))
    report = mobility(linkage) if found is None else found
    motion = motion_frames(linkage, report)
    import matplotlib
    from matplotlib.animation import FuncAnimation, PillowWriter
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with matplotlib.rc_context({"font.size": 8}):
        figure = Figure(figsize=(5.2, 4.4))
        FigureCanvasAgg(figure)
        flat = is_flat(linkage)
        axes: Any = figure.add_axes((0.02, 0.02, 0.96, 0.88), projection=None if flat else "3d")
        figure.suptitle(in_line(visible(report.explain().split("\n")[0])), fontsize=9, wrap=True)
        trail, box = _output_point(linkage, motion), _box(linkage, motion)

        def show(k: int) -> list[Any]:
            axes.cla()
            skeleton(axes, linkage, motion[k], report)
            axes.plot(*trail[: k + 1, : 2 if flat else 3].T, color=_TRAIL, linewidth=0.9, zorder=1)
            axes.set(**{f"{name}lim": tuple(box[:, i]) for i, name in enumerate("xy" if flat else "xyz")})
            axes.set_aspect("equal")
            axes.axis("off")
            return []

        FuncAnimation(figure, show, frames=len(motion), blit=False).save(file, writer=PillowWriter(fps=16), dpi=80)


def motion_frames(linkage: Linkage, found: Mobility) -> Floats:
    """(frames, F) closed configurations, one after the other.

    Args:
        linkage: as drawn, closed.
        found: its report.

    Raises:
        InputError: a linkage that cannot move.
    """
    if not found.finite.mobility or not linkage.coordinates:
        raise InputError("mobility.picture_rigid", name=linkage.name or "-", reason=found.explain().split("\n")[0])
    if found.instantaneous.mobility == 1 and linkage.loops:
        curve = trace_motion(linkage, steps=LONGEST_CURVE)
        path = _evenly(curve.theta, units(linkage))
        return path if curve.status.name == "CLOSED" else np.concatenate([path, path[::-1]])
    rates = found.instantaneous.rates[:, :MOTIONS].T
    steps = max(FRAMES // (2 * len(rates)), FEWEST)
    return np.concatenate([_swing(linkage, rate, steps) for rate in rates])


def _evenly(theta: Floats, scale: Floats) -> Floats:
    """The curve at places that are equally far from each other along it."""
    steps: Floats = np.linalg.norm(np.diff(theta / scale, axis=0), axis=1)
    gone: Floats = np.concatenate([[0.0], np.cumsum(steps)])
    places = np.searchsorted(gone, np.linspace(0.0, float(gone[-1]), FRAMES), side="left")
    return theta[np.unique(np.minimum(places, len(theta) - 1))]


def _swing(linkage: Linkage, rate: Floats, steps: int) -> Floats:
    """From where it is drawn to one side, to the other, and back."""
    there, back = _follow(linkage, rate, steps), _follow(linkage, -rate, steps)
    return np.concatenate([there, there[::-1], back, back[::-1]])


def _follow(linkage: Linkage, rate: Floats, steps: int) -> Floats:
    """(k, F) configurations along a free motion, as far as its loops close, at most `REACH`."""
    scale, step = units(linkage), REACH / steps
    here, along = np.zeros(linkage.coordinates), rate / float(np.linalg.norm(rate))
    path = [here]
    for _ in range(steps):
        moved = close_loops_near(linkage, here + step * along * scale)
        if not moved or float(np.linalg.norm((moved.theta - here) / scale)) > 2.0 * step:
            break
        here = moved.theta
        path.append(here)
        free = null_space(loop_matrix(linkage, here))[1]
        onward = free @ (free.T @ along)
        along = onward / (float(np.linalg.norm(onward)) or 1.0)
    return np.array(path)


def _output_point(linkage: Linkage, motion: Floats) -> Floats:
    """(frames, 3) the middle of the joints of the output, which moves on a coupler curve in a four-bar."""
    body = linkage.output
    drawn = np.mean([each.point for each in linkage.joints if body in (each.parent, each.child)], axis=0)
    T = body_poses(linkage, motion)[:, linkage.bodies.index(body)]
    return np.asarray(T[:, :3, :3] @ drawn + T[:, :3, 3], dtype=np.float64)


def _box(linkage: Linkage, motion: Floats) -> Floats:
    """(2, 3) lower and upper corners of all joints in all frames, with a margin."""
    T = body_poses(linkage, motion)
    points = [
        T[:, linkage.bodies.index(body), :3, :3] @ each.point + T[:, linkage.bodies.index(body), :3, 3]
        for each in linkage.joints
        for body in (each.parent, each.child)
    ]
    every = np.concatenate(points)
    margin = 0.1 * linkage.size
    return np.array([every.min(axis=0) - margin, every.max(axis=0) + margin])
