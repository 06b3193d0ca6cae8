"""A trajectory over time: position, velocity, acceleration and jerk of each coordinate, with their limits.

The phase plane of a timed path: path velocity over the path, the limit curve above it, which limit decides where.

Profiles side by side: position, velocity, acceleration and jerk of one coordinate, a line for each profile.

A diagnosed path: the joints over the path, with the stretches that cannot be passed and why.
"""

from __future__ import annotations

from os import PathLike
from textwrap import fill
from typing import Any

import numpy as np

from mafsil.arrays import Floats, require_kind, whole
from mafsil.errors import InputError
from mafsil.figures.performance_sheet import FORCE, INK, SHELL, SINGULAR, VELOCITY, flat_axes, save, sheet
from mafsil.figures.space import picture_file
from mafsil.messages import say
from mafsil.trajectory import Trajectory
from mafsil.trajectory.difficulties import PathDiagnosis
from mafsil.trajectory.motion import derivative
from mafsil.trajectory.motion_limits import Limits, motion_limits
from mafsil.trajectory.profiles import ProfileComparison
from mafsil.trajectory.timing import TimeOptimal

COLOURS = (VELOCITY, FORCE, "#4a9c5d", "#8a5fb0", "#b08a2e", "#3aa0a8", INK)
ROWS = (("upper", "position"), ("velocity", "velocity"), ("acceleration", "acceleration"), ("jerk", "jerk"))
"""Name in the catalogue of sentences, and in limits, of derivatives 0 to 3."""
SAMPLES = 600


def plot_trajectory(
    trajectory: Trajectory,
    path: str | PathLike[str],
    *,
    limits: Limits | None = None,
    names: tuple[str, ...] = (),
    language: str | None = None,
) -> None:
    """Draw u, v, a and jerk over time, one line for each coordinate; jumps stay jumps, limits are dashed.

    Args:
        trajectory: of n coordinates, without batch dimensions.
        path: .png, .svg or .pdf.
        limits: of the coordinates; drawn where all of them have the same.
        names: (n,) of the coordinates; their indices if empty.
        language: of the labels; the current one if None.

    Raises:
        InputError: no trajectory, a batch, or an ending of no picture.
    """
    file = picture_file(path)
    require_kind("trajectory", trajectory, "Trajectory", "duration", "at", "jerk", "breaks")
    if trajectory.at(0.0).u.ndim != 1:
        got = trajectory.at(0.0).u.shape
        raise InputError("input.shape", name="trajectory", expected="one motion (n,)", got=got, hint="")
    labels = names or tuple(str(k) for k in range(trajectory.n))
    bounds = None if limits is None else motion_limits(limits, trajectory.n)
    figure = sheet(6.4, 7.2)
    panels: Any = figure.subplots(4, 1, sharex=True)
    t = sample_times(trajectory)
    for order, (axes, (word, quantity)) in enumerate(zip(panels, ROWS, strict=True)):
        values = derivative(trajectory, t, order)
        for k, label in enumerate(labels):
            axes.plot(t, values[:, k], color=COLOURS[k % len(COLOURS)], linewidth=1.3, label=label)
        for side in () if bounds is None else getattr(bounds, quantity):
            if np.isfinite(side).all() and np.ptp(side) == 0.0:
                axes.axhline(float(side[0]), color=SINGULAR, linewidth=0.9, linestyle="--")
        for moment in trajectory.breaks()[1:-1] if len(trajectory.breaks()) <= 40 else ():
            axes.axvline(float(moment), color=SHELL, linewidth=0.4, zorder=0)
        last = "t [s]" if order == 3 else ""
        flat_axes(axes, last, say(f"trajectory.{word}", language=language), equal=False)
    panels[0].legend(loc="upper right", frameon=False, fontsize=8, ncols=min(len(labels), 7))
    save(figure, file)


def sample_times(trajectory: Trajectory) -> Floats:
    """Even times, and both sides of every break, where derivatives jump.

    Args:
        trajectory: any.
    """
    breaks = trajectory.breaks()
    even = np.linspace(0.0, trajectory.duration, SAMPLES)
    return np.unique(np.concatenate([even, breaks, np.nextafter(breaks[1:], 0.0)]))


PLACES = 2000
"""Of the curve."""


def plot_phase_plane(timed: TimeOptimal, path: str | PathLike[str], *, language: str | None = None) -> None:
    """Draw ds/dt over s, coloured by the limit that decides, below the largest ds/dt from which the end can be reached.

    Args:
        timed: of `mafsil.trajectory.time_optimal`.
        path: .png, .svg or .pdf.
        language: of the labels; the current one if None.

    Raises:
        InputError: no timed path, or an ending of no picture.

    Reference: J. Bobrow, S. Dubowsky, J. Gibson, Int. J. Robotics Research 4(3), 1985.
    """
    file = picture_file(path)
    require_kind("timed", timed, "TimeOptimal", "limit_curve", "bindings")
    figure = sheet(6.4, 3.6)
    axes: Any = figure.subplots()
    limit = timed.limit_curve
    axes.plot(
        limit[:, 0], limit[:, 1], color=SINGULAR, linewidth=0.9, linestyle="--", label=_word("limit_curve", language)
    )
    deciding = list(dict.fromkeys((one.quantity, one.joint) for one in timed.bindings))
    motion = timed.trajectory
    for binding in timed.bindings if motion is not None else ():
        assert motion is not None
        t = np.linspace(
            binding.begin, binding.end, max(int(PLACES * (binding.end - binding.begin) / timed.duration), 2)
        )
        s, rate, _ = motion.law.at(t)
        key = (binding.quantity, binding.joint)
        colour = COLOURS[deciding.index(key) % len(COLOURS)]
        axes.plot(s[:, 0], rate[:, 0], color=colour, linewidth=1.8, label=_name(key, language))
    handles, labels = axes.get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))
    axes.legend(once.values(), once.keys(), frameon=False, fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    axes.set_ylim(bottom=0.0)
    flat_axes(axes, "s", "ds/dt [1/s]", equal=False)
    save(figure, file)


def _word(name: str, language: str | None) -> str:
    return say(f"trajectory.{name}", language=language)


def _name(key: tuple[str, int], language: str | None) -> str:
    quantity, joint = key
    return _word(quantity, language) if joint < 0 else f"{_word(quantity, language)} {joint}"


STYLES = ("-", "--", ":")
"""Of lines, when there are more profiles than colours."""


def plot_profiles(
    comparison: ProfileComparison,
    path: str | PathLike[str],
    *,
    coordinate: int | None = None,
    language: str | None = None,
) -> None:
    """Draw u, v, a and jerk over time, one line for each profile; the coordinate's limits are dashed.

    Args:
        comparison: of `mafsil.trajectory.compare_profiles`.
        path: .png, .svg or .pdf.
        coordinate: index; the one that goes farthest if None.
        language: of the labels; the current one if None.

    Raises:
        InputError: no comparison, an index out of range, or an ending of no picture.
    """
    file = picture_file(path)
    require_kind("comparison", comparison, "ProfileComparison", "runs", "limits")
    shortest = comparison.runs[0].trajectory
    way = np.abs(np.ptp(shortest.at(np.linspace(0.0, shortest.duration, 101)).u, axis=0))
    k = int(way.argmax()) if coordinate is None else whole("coordinate", coordinate, 0, shortest.n - 1)
    figure = sheet(6.4, 7.6)
    panels: Any = figure.subplots(4, 1, sharex=True)
    for order, (axes, (word, quantity)) in enumerate(zip(panels, ROWS, strict=True)):
        for index, run in enumerate(comparison):
            t = sample_times(run.trajectory)
            style = STYLES[index // len(COLOURS) % len(STYLES)]
            values = derivative(run.trajectory, t, order)[:, k]
            axes.plot(t, values, color=COLOURS[index % len(COLOURS)], linewidth=1.2, linestyle=style, label=run.name)
        bounds = getattr(comparison.limits, quantity)[:, k]
        for side in bounds if order and np.isfinite(bounds).all() else ():
            axes.axhline(float(side), color=SINGULAR, linewidth=0.9, linestyle="--")
        flat_axes(axes, "t [s]" if order == 3 else "", say(f"trajectory.{word}", language=language), equal=False)
    panels[0].legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False, fontsize=7, ncols=6)
    save(figure, file)


NARROWEST = 0.004
"""Share of the path that a stretch is drawn wide at least."""


def plot_path_difficulties(diagnosis: PathDiagnosis, path: str | PathLike[str], *, language: str | None = None) -> None:
    """Draw the joints of the best chain of solutions over s, and their rates; difficulties are shaded and numbered.

    Args:
        diagnosis: of `mafsil.trajectory.diagnose_path`.
        path: .png, .svg or .pdf.
        language: of the texts; the current one if None.

    Raises:
        InputError: no diagnosis, or an ending of no picture.
    """
    file = picture_file(path)
    require_kind("diagnosis", diagnosis, "PathDiagnosis", "difficulties", "rates")
    figure = sheet(6.4, 5.2)
    panels: Any = figure.subplots(2, 1, sharex=True)
    rows = ((diagnosis.q, say("trajectory.upper", language=language)), (np.abs(diagnosis.rates), "|dq/ds|"))
    names = diagnosis.robot.joint_names
    for axes, (values, label) in zip(panels, rows, strict=True):
        for k, name in enumerate(names):
            axes.plot(
                diagnosis.s, values[:, k], color=COLOURS[k % len(COLOURS)], linewidth=1.2, marker=".", markersize=2.5,
                label=name,
            )  # fmt: skip
        for number, each in enumerate(diagnosis, start=1):
            begin, end = each.where.begin, max(each.where.end, each.where.begin + NARROWEST)
            axes.axvspan(begin, end, color=SINGULAR, alpha=0.15, linewidth=0)
            axes.annotate(
                str(number),
                ((begin + end) / 2, 1.0),
                xycoords=("data", "axes fraction"),
                ha="center",
                va="bottom",
                fontsize=8,
                color=SINGULAR,
            )
        flat_axes(axes, "s" if axes is panels[-1] else "", label, equal=False)
    panels[1].set_yscale("symlog", linthresh=1.0)
    panels[0].legend(frameon=False, fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    said = [f"{number}. {each.explain(language)}" for number, each in enumerate(diagnosis, start=1)]
    if said:
        figure.supxlabel("\n".join(fill(line, 95) for line in said), fontsize=7, x=0.02, ha="left")
    save(figure, file)
