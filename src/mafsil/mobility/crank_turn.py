"""A linkage of mobility 1 driven once round by its crank: positions, rates, accelerations, pin forces, motor torque.

A crank that goes round has constant speed. One that cannot swings harmonically between its ends, where it rests, so
that rates stay finite at dead points; no row stands on one, since there the motor moves nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer
from mafsil.arrays import Floats, number, positive, whole
from mafsil.errors import ModelError
from mafsil.geometry import pose
from mafsil.messages import say
from mafsil.messages.tables import number as shown
from mafsil.messages.tables import table
from mafsil.mobility.assembly_existence import can_assemble, close_drawing
from mafsil.mobility.crank_range import BESIDE, CrankRange, RangeEnd, TurnStatus
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.linkage_file import LinkageLoads, in_space, read_loads
from mafsil.mobility.linkages.loop_closure import are_lengths, body_poses, units
from mafsil.mobility.linkages.mechanism_linkage import LinkageLike, as_linkage
from mafsil.mobility.pin_forces import PinForces, driven_motion, pin_forces

MOST_SHOWN = 12
"""Rows of the table that is printed, or a few more."""


@dataclass(frozen=True, eq=False, repr=False)
class CrankTurn(
    Answer,
    data="crank range time angle arc theta rates accelerations followers transmission "
    "torque=loads.torque forces=loads.forces moments=loads.moments unique=loads.unique",
):
    """A linkage driven by its crank at constant speed, row by row; true if the whole curve was covered.

    Attributes:
        linkage: as drawn.
        crank: name of the driven joint.
        status: whether it goes round, or between which coordinates it moves.
        speed: of the crank; between ends its largest [rad/s | m/s].
        turns: of the crank until all bodies stand as at the beginning; zero where it does not go round.
        ends: where the crank turns back or a joint meets its limit, in the order of the curve, with the reason.
        time: (k,) since the beginning [s].
        angle: (k,) coordinate of the crank [rad | m], zero where it is drawn.
        arc: (k,) which stretch between dead points.
        theta, rates, accelerations: (k, F) of all joints [rad | m] and time derivatives.
        poses: (k, N, 4, 4) displacements of the bodies from where they are drawn.
        twists, twist_rates: (k, N, 6) (omega, v) of the bodies about the middle of the linkage, and time derivatives.
        followers: names of the joints on the ground of one freedom that something else drives.
        transmission: (k, m) transmission angle of each follower [rad]; NaN where nothing is transmitted.
        loads: forces in the joints and effort of the motor.
    """

    linkage: Linkage
    crank: str
    status: TurnStatus
    speed: float
    turns: int
    ends: tuple[RangeEnd, ...]
    time: Floats
    angle: Floats
    arc: NDArray[np.intp]
    theta: Floats
    rates: Floats
    accelerations: Floats
    poses: Floats
    twists: Floats
    twist_rates: Floats
    followers: tuple[str, ...]
    transmission: Floats
    loads: PinForces

    @property
    def range(self) -> tuple[float, float]:
        """Least and greatest coordinate of the crank on the curve [rad | m]."""
        ends = [each.crank for each in self.ends] or self.angle.tolist()
        return min(ends), max(ends)

    @property
    def least_transmission(self) -> float:
        """Least transmission angle [rad]; NaN where nothing is transmitted."""
        known = self.transmission[np.isfinite(self.transmission)]
        return float(known.min()) if known.size else np.nan

    def point(self, body: str, at: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Position, velocity and acceleration (k, 3) of a point of a body [m, m/s, m/s^2].

        Args:
            body: its name.
            at: (2,) or (3,) place in the drawing [m].

        Raises:
            ModelError: no such body.
        """
        if body not in self.linkage.bodies:
            raise ModelError("mobility.no_output", output=body, known=", ".join(self.linkage.bodies))
        place = in_space("at", at)
        k = self.linkage.bodies.index(body)
        x = np.asarray(pose.act(self.poses[:, k], place))
        r = x - self.linkage.middle
        w, alpha = self.twists[:, k, :3], self.twist_rates[:, k, :3]
        v = self.twists[:, k, 3:] + np.cross(w, r)
        # The twist is that of the point at the middle, through which bodies pass: its rate holds a transport term.
        a = self.twist_rates[:, k, 3:] + np.cross(alpha, r) + np.cross(w, v)
        return x, v, a

    def explain(self, language: str | None = None) -> str:
        """Whether the crank goes round; why not; transmission, motor torque and largest pin force."""
        lines = [self.status.sentence(language, **self.details())]
        lines += dict.fromkeys(each.sentence(self._shown(each.crank), language) for each in self.ends)
        if not self.ends and np.isfinite(self.least_transmission):
            row, column = np.unravel_index(int(np.nanargmin(self.transmission)), self.transmission.shape)
            lines.append(
                say(
                    "mobility.turn_transmission", language=language, angle=float(np.degrees(self.least_transmission)),
                    joint=self.followers[int(column)], at=self._shown(float(self.angle[row])),
                )
            )  # fmt: skip
        return "\n".join(lines + self.loads.sentences(language))

    def details(self) -> dict[str, object]:
        """What the sentence of the status mentions."""
        low, high = map(self._shown, self.range)
        arcs = len(set(self.arc.tolist()))
        return {
            "crank": self.crank, "rows": len(self.angle), "turns": self.turns, "low": low, "high": high, "arcs": arcs
        }  # fmt: skip

    def _shown(self, coordinate: float) -> str:
        """A coordinate of the crank for people."""
        return f"{coordinate:.6g} m" if self._slides else f"{np.degrees(coordinate):.6g} deg"

    @property
    def _slides(self) -> bool:
        return bool(are_lengths(self.linkage)[self.linkage.columns_of([self.crank])[0]])

    def _table(self) -> list[str]:
        head, columns = self.columns()
        return table(head, [tuple(map(shown, row.tolist())) for row in columns[:: max(1, len(columns) // MOST_SHOWN)]])

    def columns(self, language: str | None = None) -> tuple[tuple[str, ...], Floats]:
        """Heads and rows (k, c) of the table of the turn: crank, output, transmission, torque, largest pin force."""
        scale = 1.0 if self._slides else float(np.degrees(1.0))
        x, v, a = self.point(self.linkage.output, self.output_point())
        heads = [f"{self.crank} [{'m' if self._slides else 'deg'}]", "x [m]", "y [m]", "|v| [m/s]", "|a| [m/s^2]"]
        rows = [scale * self.angle, x[:, 0], x[:, 1], np.linalg.norm(v, axis=1), np.linalg.norm(a, axis=1)]
        for k, name in enumerate(self.followers):
            heads.append(say("mobility.turn_transmission_head", language=language, joint=name))
            rows.append(np.degrees(self.transmission[:, k]))
        unit = "N" if self._slides else "N m"
        heads += [
            say("mobility.turn_torque_head", language=language, unit=unit),
            say("mobility.turn_force_head", language=language),
        ]
        rows += [self.loads.torque, np.linalg.norm(self.loads.forces, axis=-1).max(axis=-1)]
        return tuple(heads), np.stack(rows, axis=-1)

    def series(self) -> dict[str, Floats]:
        """Everything as named columns (k,): t, q, qd, qdd of each coordinate, mu, effort of the motor, joint forces."""
        found = {"t": self.time}
        for signal, values in (("q", self.theta), ("qd", self.rates), ("qdd", self.accelerations)):
            found |= {f"{signal}[{name}]": values[:, k] for k, name in enumerate(self.linkage.coordinate_names)}
        found |= {f"mu[{name}]": self.transmission[:, k] for k, name in enumerate(self.followers)}
        found["tau"] = self.loads.torque
        for j, name in enumerate(self.loads.joints):
            found |= {f"f{axis}[{name}]": self.loads.forces[:, j, i] for i, axis in enumerate("xyz")}
        return found

    def output_point(self) -> Floats:
        """(3,) the middle of the joints of the output, where it is drawn [m]."""
        body = self.linkage.output
        return np.mean([each.point for each in self.linkage.joints if body in (each.parent, each.child)], axis=0)


def turn_crank(
    linkage: LinkageLike,
    crank: str | None = None,
    *,
    speed: float = 1.0,
    rows: int = 360,
    loads: LinkageLoads | None = None,
) -> CrankTurn:
    """Drive a linkage of mobility 1 by one of its joints through all configurations that it reaches.

    1. The curve of configurations from where it is drawn.
    2. Its arcs between dead points of the crank, or the whole turn.
    3. Rows on each arc, closed by Newton's method with the crank held.
    4. Rates and accelerations: at constant speed of the crank, between ends in a harmonic motion. Where branches cross,
       as of a parallelogram in line, the loops do not decide them: they are continued from both sides.
    5. Forces in the joints and the effort of the motor, from masses and loads; transmission angles.

    Args:
        linkage: a Linkage, the name of one of the library, a TOML file of bodies and joints.
        crank: name of the driven joint, of one freedom; the only actuated one if None.
        speed: of the crank, between ends the largest [rad/s | m/s]; its sign is that of the beginning.
        rows: for each turn of the crank, or each stretch between dead points.
        loads: masses, forces, gravity; those of the file, else none, if None.

    Raises:
        ModelError: no linkage, no such joint, or no single actuated joint.
        InputError: the mobility is not 1 where it is drawn, or the crank does not move there.
    """
    drawn, loads = _drawn(linkage, loads)
    name, count = _crank_of(drawn, crank), whole("rows", rows, 4, 100_000)
    rate = number("speed", speed)
    positive("speed", abs(rate))
    column = int(drawn.columns_of([name])[0])
    range_ = CrankRange.of(drawn, name, np.sign(rate))  # 1, 2
    p, arc = range_.rows(count)
    theta, found = range_.close(p, arc)  # 3
    beside = np.flatnonzero(range_.crosses(theta, p, arc))  # 4
    around = (p[beside, None] + BESIDE * np.array([1.0, -1.0, 2.0, -2.0])).ravel()
    extra, near = range_.close(around, np.repeat(arc[beside], 4))
    every = np.concatenate([theta, extra])
    time, v, a = range_.timing(np.concatenate([p, around]), np.concatenate([arc, np.repeat(arc[beside], 4)]), abs(rate))
    motion = driven_motion(drawn, every, column, v, a)
    forces, transmission, followers = pin_forces(motion, loads)  # 5
    scale, size = units(drawn), np.append(np.ones(3), np.full(3, drawn.size))
    values = (
        motion.rates * scale, motion.accelerations * scale, motion.twists * size, motion.twist_rates * size,
        transmission, forces.torque, forces.forces, forces.moments,
    )  # fmt: skip
    rates, accelerations, twists, twist_rates, transmission, torque, pins, moments = (
        _continue(each, len(theta), beside) for each in values
    )
    complete = bool(found.all() and near.all())
    return CrankTurn(
        drawn, name, range_.status if complete else TurnStatus.INCOMPLETE, rate, range_.turns, range_.ends,
        time[: len(theta)], theta[:, column], arc, theta, rates, accelerations, motion.state.poses[: len(theta)],
        twists, twist_rates, followers, transmission, replace(forces, torque=torque, forces=pins, moments=moments),
    )  # fmt: skip


def _drawn(source: LinkageLike, loads: LinkageLoads | None) -> tuple[Linkage, LinkageLoads]:
    """A linkage closed where it is drawn, and what bears on it there; of a file with the masses and loads in it."""
    linkage = as_linkage(source)
    if loads is None:
        file = isinstance(source, str | PathLike) and Path(source).suffix.lower() == ".toml"
        loads = read_loads(cast("str", source)) if file and not isinstance(source, Linkage) else LinkageLoads()
    loads.require_bodies(linkage)
    if not linkage.apart:
        return linkage, loads
    theta = can_assemble(linkage).theta
    closed = close_drawing(linkage)
    return closed, loads if theta is None else loads.displace(linkage.bodies, body_poses(linkage, theta))


def _crank_of(linkage: Linkage, crank: str | None) -> str:
    """The driven joint by name, or the only actuated one.

    Raises:
        ModelError: none or several are actuated, or it has no single freedom.
    """
    driven = [each.name for each in linkage.joints if each.actuated] if crank is None else [crank]
    one = {each.name: each for each in linkage.joints if each.freedoms == 1}
    if crank is not None:
        linkage.index_of(driven)
    if len(driven) != 1 or driven[0] not in one:
        raise ModelError("mobility.which_crank", given=", ".join(driven) or "-", known=", ".join(one))
    return driven[0]


def _continue(values: Floats, rows: int, beside: NDArray[np.intp]) -> Floats:
    """Values of the rows; of some the limit from both sides, (4 (f(h) + f(-h)) - f(2 h) - f(-2 h)) / 6.

    Args:
        values: (rows + 4 m, ...) of the rows, then of the four neighbours of each of m.
        rows: their number.
        beside: (m,) which have neighbours.
    """
    found = values[:rows].copy()
    near = values[rows:].reshape(len(beside), 4, *values.shape[1:])
    found[beside] = (4 * (near[:, 0] + near[:, 1]) - near[:, 2] - near[:, 3]) / 6
    return found
