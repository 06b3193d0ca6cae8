"""One joint in pictures: root loci with their responses, measured responses, runs side by side, friction over speed."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, require_kind
from mafsil.errors import InputError
from mafsil.figures.motion_over_time import COLOURS
from mafsil.figures.performance_sheet import SINGULAR, SOFT, flat_axes, legend, save, sheet
from mafsil.figures.space import picture_file
from mafsil.messages import say
from mafsil.messages.isolates import in_cell
from mafsil.messages.tables import number
from mafsil.one_joint import ErrorDynamics, JointRun, RootLocus, measure_response
from mafsil.one_joint.drives import SpeedFriction
from mafsil.one_joint.polynomial import Complexes
from mafsil.one_joint.response_measures import MeasureStatus

PLACES = 600
"""Of a curve."""
MOST_CURVES = 6
"""Responses, runs and laws in one picture."""
DECAYS = 6.0
"""Slowest time constants that responses are shown for."""


def plot_root_locus(
    locus: RootLocus,
    path: str | PathLike[str],
    *,
    gains: ArrayLike = (),
    start: ArrayLike | None = None,
    language: str | None = None,
) -> None:
    """Draw the branches in the plane of the roots, where they meet and cross, and the responses at some gains.

    Args:
        locus: of `mafsil.one_joint.root_locus`.
        path: .png, .svg or .pdf.
        gains: (m,) whose roots are marked, with the error over time beside; at most six.
        start: (n,) error and its derivatives at time 0; 1 and zeros if None.
        language: of the labels; the current one if None.

    Raises:
        InputError: no root locus, gains outside of those of the locus, or an ending of no picture.
    """
    file = picture_file(path)
    require_kind("locus", locus, "RootLocus", "gains", "roots", "meetings")
    chosen = np.atleast_1d(np.asarray(gains, dtype=np.float64))[:MOST_CURVES]
    low, high = float(locus.gains[0]), float(locus.gains[-1])
    if not ((chosen >= low) & (chosen <= high)).all():
        raise InputError("input.range", name="gains", value=chosen.tolist(), low=low, high=high)
    figure = sheet(8.0 if len(chosen) else 4.4, 3.6)
    axes: Any = figure.subplots(1, 2 if len(chosen) else 1, squeeze=False)[0]
    plane = axes[0]
    for branch in _through_meetings(locus).T:
        plane.plot(branch.real, branch.imag, color=COLOURS[0], linewidth=1.2)
    plane.plot(locus.roots[0].real, locus.roots[0].imag, "x", color=COLOURS[0], markersize=6)
    plane.axvline(0.0, color=SINGULAR, linewidth=0.8, linestyle="--")
    for key, points in (("meeting", locus.meetings), ("crossing", 1j * locus.crossings)):
        shape = "s" if key == "meeting" else "D"
        both = np.concatenate([points, points.conj()])
        label = say(f"pictures.locus_{key}", language=language)
        plane.plot(both.real, both.imag, shape, color=SINGULAR, fillstyle="none", markersize=6, label=label)
    marked = [locus.roots[int(np.abs(locus.gains - gain).argmin())] for gain in chosen]
    t = np.linspace(0.0, float(np.median([_decay(s) for s in marked])) if marked else 1.0, PLACES)
    for k, (gain, s) in enumerate(zip(chosen.tolist(), marked, strict=True)):
        colour = COLOURS[(k + 1) % len(COLOURS)]
        plane.plot(s.real, s.imag, "o", color=colour, markersize=5)
        axes[1].plot(t, _response(s, start, t), color=colour, linewidth=1.2, label=f"K = {number(gain)}")
    legend(plane)
    flat_axes(plane, "Re s [1/s]", "Im s [1/s]", equal=False)
    if len(chosen):
        legend(axes[1])
        flat_axes(axes[1], "t [s]", say("pictures.error_of_one", language=language), equal=False)
    save(figure, file)


def plot_error_response(
    t: ArrayLike, error: ArrayLike, path: str | PathLike[str], *, band: float = 0.02, language: str | None = None
) -> None:
    """Draw an error over time with what is measured of it: steady error, overshoot, settling time and its band.

    Of a record that ends before the error has come to rest only the curve is drawn: nothing else is known.

    Args:
        t: (k,) times [s].
        error: (k,) of one joint.
        path: .png, .svg or .pdf.
        band: of the settling time, as a share of the way.
        language: of the labels; the current one if None.

    Raises:
        InputError: no times or errors, or an ending of no picture.
    """
    file = picture_file(path)
    measured = measure_response(t, error, band=band)
    times, values = np.asarray(t, dtype=np.float64), np.asarray(error, dtype=np.float64)
    if times.ndim != 1:
        raise InputError("input.shape", name="t", expected="(k,)", got=times.shape, hint="")
    figure = sheet(6.0, 3.2)
    axes: Any = figure.subplots()
    if measured.status is not MeasureStatus.STILL_MOVING:
        rest = float(measured.steady_error)
        width = band * abs(float(values[0]) - rest)
        axes.axhspan(rest - width, rest + width, color=SOFT)
        axes.axhline(rest, color="0.5", linewidth=0.8, label=_say("steady_error", rest, language))
    axes.plot(times, values, color=COLOURS[0], linewidth=1.4)
    for key, at in (("settling_time", float(measured.settling_time)), ("peak_time", float(measured.peak_time))):
        if np.isfinite(at):
            label = _say(key, at, language) if key == "settling_time" else _overshoot(measured.overshoot, language)
            axes.axvline(at, color=SINGULAR if key == "settling_time" else COLOURS[1], linestyle="--", label=label)
    if axes.get_legend_handles_labels()[0]:
        legend(axes)
    flat_axes(axes, "t [s]", say("pictures.error_of_one", language=language), equal=False)
    save(figure, file)


def plot_joint_runs(runs: Mapping[str, JointRun], path: str | PathLike[str], *, language: str | None = None) -> None:
    """Draw runs side by side: angle, error and torque over time; of a single run the torque's P, I and D parts.

    Args:
        runs: by the names that the legend gives them, each of one joint; at most six.
        path: .png, .svg or .pdf.
        language: of the labels; the current one if None.

    Raises:
        InputError: no runs, more than six, runs of many rows, or an ending of no picture.
    """
    file = picture_file(path)
    _require_some("runs", runs)
    for run in runs.values():
        require_kind("runs", run, "JointRun", "theta", "parts")
        if run.t.ndim != 1:
            raise InputError("input.shape", name="runs", expected="(k,)", got=run.t.shape, hint="")
    figure = sheet(9.0, 3.0)
    angle, error, torque = figure.subplots(1, 3)
    for k, (name, run) in enumerate(runs.items()):
        colour = COLOURS[k % len(COLOURS)]
        angle.plot(run.t, run.theta, color=colour, linewidth=1.2, label=name)
        error.plot(run.t, run.error, color=colour, linewidth=1.2)
        torque.plot(run.t, run.torque, color=colour, linewidth=1.2)
    if len(runs) == 1:
        (only,) = runs.values()
        for k, part in enumerate("PID"):
            torque.plot(only.t, only.parts[:, k], linestyle="--", linewidth=0.9, color=COLOURS[k + 1], label=part)
        legend(torque)
    legend(angle)
    labels = ("pictures.angle", "pictures.error_in_rad", "pictures.torque")
    for axes, key in zip((angle, error, torque), labels, strict=True):
        flat_axes(axes, "t [s]", say(key, language=language), equal=False)
    save(figure, file)


def plot_friction_laws(
    laws: Mapping[str, SpeedFriction], path: str | PathLike[str], *, speed: float = 1.0, language: str | None = None
) -> None:
    """Draw friction over speed, with its interval at rest as a vertical line.

    Args:
        laws: by the names that the legend gives them, each of one joint; at most six.
        path: .png, .svg or .pdf.
        speed: largest that is shown [rad/s].
        language: of the labels; the current one if None.

    Raises:
        InputError: no laws, more than six, or an ending of no picture.
    """
    file = picture_file(path)
    _require_some("laws", laws)
    figure = sheet(5.0, 3.4)
    axes: Any = figure.subplots()
    there = np.linspace(speed / PLACES, speed, PLACES)
    for k, (name, law) in enumerate(laws.items()):
        require_kind("laws", law, "SpeedFriction", "torque", "interval")
        colour = COLOURS[k % len(COLOURS)]
        low, high = (float(np.asarray(x)) for x in law.interval(0.0))
        back = np.asarray(law.torque(-there[::-1]), dtype=np.float64).reshape(-1)
        on = np.asarray(law.torque(there), dtype=np.float64).reshape(-1)
        rest = np.array([low, high])
        x, y = np.concatenate([-there[::-1], [0.0, 0.0], there]), np.concatenate([back, rest, on])
        axes.plot(x, y, color=colour, linewidth=1.4, label=name)
    legend(axes)
    flat_axes(axes, say("pictures.speed", language=language), say("pictures.friction", language=language), equal=False)
    save(figure, file)


def _through_meetings(locus: RootLocus) -> Complexes:
    """(k + m, n) branches that go through the points where they meet, between the gains of the locus too.

    Both branches that are nearest to a meeting between its two neighbouring gains stand on it; the others go on evenly.
    """
    rows, gains = list(locus.roots), [float(gain) for gain in locus.gains]
    for gain, point in zip(locus.meeting_gains.tolist(), locus.meetings.tolist(), strict=True):
        k = bisect_left(gains, gain)
        if not 0 < k < len(gains) or gain in gains:
            continue
        share = (gain - gains[k - 1]) / (gains[k] - gains[k - 1])
        between = (1.0 - share) * rows[k - 1] + share * rows[k]
        for place in (point, point.conjugate()) if point.imag else (point,):
            between[np.argsort(np.abs(between - place))[:2]] = place
        rows.insert(k, between)
        gains.insert(k, gain)
    return np.stack(rows)


def _decay(s: Complexes) -> float:
    """How long the error of these roots is worth being shown [s]."""
    return DECAYS / max(float(np.abs(s.real).min()), 0.05 * float(np.abs(s).max()))


def _response(s: Complexes, start: ArrayLike | None, t: Floats) -> Floats:
    """The error at times that these roots make."""
    first = np.eye(1, len(s))[0] if start is None else np.asarray(start, dtype=np.float64)
    return ErrorDynamics.of(*np.poly(s).real).response(t, first)


def _require_some(name: str, given: Mapping[str, object]) -> None:
    require_kind(name, given, "Mapping", "items")
    if not 1 <= len(given) <= MOST_CURVES:
        raise InputError("input.range", name=name, value=len(given), low=1, high=MOST_CURVES)


def _say(key: str, value: float, language: str | None) -> str:
    unit = " s" if key == "settling_time" else ""
    return f"{say(f'pictures.{key}', language=language)} {in_cell(number(value) + unit, language)}"


def _overshoot(value: Floats, language: str | None) -> str:
    share = in_cell(f"{number(100.0 * float(value))} %", language)
    return f"{say('pictures.overshoot', language=language)} {share}"
