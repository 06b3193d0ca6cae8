"""Six-bars of a crank and two dyads (Watt, Stephenson III): configurations, and lengths from hinges in positions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mobility.library.planar import pins
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.synthesis.crank_chain import Placed
from mafsil.mobility.synthesis.dyads import (
    Complexes,
    PoseConditions,
    as_points,
    common_pole,
    cranks_and_blocks,
    spread,
    unit_numbers,
)
from mafsil.mobility.synthesis.motion import dyads_through
from mafsil.mobility.tolerances import BULKY, NO_LENGTH

GROUND, CRANK, COUPLER, ROCKER, LAST, OUTPUT = range(6)
BODIES = ("ground", "crank", "coupler", "rocker", "floating link", "output link")
Form = Literal["watt", "stephenson"]


@dataclass(frozen=True)
class DyadArm:
    """One link of a dyad: from a point of an earlier body to the hinge where both links of the dyad meet.

    Attributes:
        body: number of the earlier body.
        point: on it, from its first hinge along and across its link, as a complex number [m].
        length: of the arm [m].
    """

    body: int
    point: complex
    length: float


@dataclass(frozen=True)
class SixBar:
    """A crank about A and two dyads; bodies are ground, crank, coupler and rocker, floating link and output link.

    Attributes:
        A: (2,) pivot of the crank [m].
        crank: its length [m].
        arms: of the first and of the second dyad, each from a moving body, then from ground or crank.
        form: Watt's chain or Stephenson's.
        point: of the floating link that follows a path, or None; complex as in `DyadArm`.
    """

    A: Floats
    crank: float
    arms: tuple[tuple[DyadArm, DyadArm], tuple[DyadArm, DyadArm]]
    form: Form
    point: complex | None = None

    @property
    def kind(self) -> str:
        """Key of its sentence."""
        return f"six_bar_{self.form}"

    @property
    def dyads(self) -> int:
        """Two."""
        return len(self.arms)

    @property
    def pivots(self) -> Floats:
        """(m, 2) fixed pivots [m]."""
        on_ground = [arm.point for pair in self.arms for arm in pair if arm.body == GROUND]
        return np.concatenate([self.A[None], as_points(np.array(on_ground))])

    @property
    def lengths(self) -> dict[str, float]:
        """Of the crank, the arms of both dyads, and from the floating link's hinge to the point that is led [m]."""
        names = ("AB", "BC", "CD", "PQ", "QE")
        values = [self.crank, *(arm.length for pair in self.arms for arm in pair)]
        led = {} if self.point is None else {"PT": abs(self.point)}
        return dict(zip(names, values, strict=True)) | led

    def bodies(self, theta: ArrayLike, modes: Sequence[int]) -> tuple[Complexes, Complexes, Floats]:
        """Places (6, k) of the bodies' first hinges, unit directions (6, k), and cosines (k, 2) of the dyads.

        Where a dyad does not close, its links lie in line.

        Args:
            theta: (k,) angles of the crank in the world [rad].
            modes: +1 or -1 of each dyad: which side of the line between its ends the hinge is on.
        """
        angle = np.asarray(theta, dtype=np.float64)
        A = np.full(angle.shape, complex(*self.A))
        places, ways = [np.zeros_like(A), A], [np.ones_like(A), unit_numbers(angle)]
        cosines: list[Floats] = []
        for (left, right), mode in zip(self.arms, modes, strict=True):
            P, R = (places[arm.body] + arm.point * ways[arm.body] for arm in (left, right))
            s = np.maximum(np.abs(R - P), LEAST_DIVISOR)
            a, b = left.length, right.length
            cosines.append((a * a + b * b - s * s) / (2 * a * b))
            turn = np.clip((a * a + s * s - b * b) / (2 * a * s), -1.0, 1.0)
            u = (R - P) / s * (turn + 1j * mode * np.sqrt(1.0 - turn**2))
            v = P + a * u - R
            places += [P, R]
            ways += [u, v / np.maximum(np.abs(v), LEAST_DIVISOR)]
        return np.stack(places), np.stack(ways), np.stack(cosines, axis=-1)

    def cosines(self, theta: Floats, modes: Sequence[int]) -> Floats:
        """(k, 2) cosines of the transmission angles of both dyads; beyond -1 and 1 it does not close."""
        return self.bodies(theta, modes)[2]

    def path_points(self, theta: ArrayLike, modes: Sequence[int]) -> Floats:
        """(k, 2) the point that follows a path; of a six-bar for a function the hinge of the output link [m]."""
        places, ways, _ = self.bodies(theta, modes)
        point = self.arms[1][0].length if self.point is None else self.point
        return as_points(places[LAST] + point * ways[LAST])

    def output_angle(self, theta: ArrayLike, modes: Sequence[int]) -> Floats:
        """(k,) angle of the output link from its fixed pivot to its hinge, in the world [rad]."""
        return np.angle(self.bodies(theta, modes)[1][OUTPUT])

    def drawn(self, theta: float, modes: Sequence[int]) -> Linkage:
        """The linkage at an angle of the crank, for `mf.mobility`, `turn_crank` and pictures."""
        places, ways, _ = self.bodies(np.array([theta]), modes)
        z: list[complex] = places[:, 0].tolist()
        hinges = [("A", GROUND, CRANK, complex(*self.A))]
        for (left, right), body, names in zip(self.arms, (COUPLER, LAST), ("BCD", "PQE"), strict=True):
            meet = z[body] + left.length * complex(ways[body, 0])
            ends = zip(names, (left.body, body, right.body), (body, body + 1, body + 1), (z[body], meet, z[body + 1]),
                       strict=True)  # fmt: skip
            hinges += list(ends)
        joints = pins([(name, BODIES[i], BODIES[j], as_points(place)) for name, i, j, place in hinges], "A")
        output = BODIES[OUTPUT if self.point is None else LAST]
        return Linkage.of(joints, name=f"{self.form} six-bar", output=output, planar=True)


@dataclass(frozen=True, eq=False)
class BodyPositions:
    """Bodies in N positions, from which a six-bar is measured.

    Attributes:
        places: (N,) of their first hinges [m].
        ways: (N,) unit directions to another point.
    """

    places: list[Complexes]
    ways: list[Complexes]

    @classmethod
    def of(cls, *links: tuple[Complexes, Complexes]) -> BodyPositions:
        """Bodies by the places (N,), (N,) of their first hinge and of another point."""
        ways = [(end - first) / np.maximum(np.abs(end - first), LEAST_DIVISOR) for first, end in links]
        return cls([first for first, _ in links], ways)

    def point(self, body: int, places: Complexes) -> complex:
        """A point of a body by its places (N,)."""
        return complex(((places - self.places[body]) * np.conj(self.ways[body])).mean())

    def poses(self, body: int, base: int) -> PoseConditions:
        """Poses of a body as seen from another one."""
        z = (self.places[body] - self.places[base]) * np.conj(self.ways[base])
        turn = np.unwrap(np.angle(self.ways[body] * np.conj(self.ways[base])))
        return PoseConditions.of(np.column_stack([as_points(z), turn]))

    def links(self, body: int, base: int) -> list[tuple[Complexes, Complexes]]:
        """Places (N,), (N,) of both ends of all links that fit between two bodies: on the first and on the base."""
        conditions = self.poses(body, base)
        if common_pole(conditions) is not None:
            return []
        dyads, _, infinite = dyads_through(conditions, 0)
        ends: list[tuple[Complexes, Complexes]] = []
        for one in cranks_and_blocks(dyads)[0] if not infinite else []:
            near, far = complex(*one.point), complex(*one.pivot)
            ends.append((self.places[body] + near * self.ways[body], self.places[base] + far * self.ways[base]))
        return ends


def measure_six_bar(
    form: Form, A: complex, B: Complexes, C: Complexes, D: Complexes,
    second: tuple[int, Complexes, Complexes, int, Complexes], traced: Complexes | None,
) -> Placed | None:  # fmt: skip
    """The six-bar of hinges in N positions, closed again by its crank; None if a link has no length.

    Args:
        form: Watt's or Stephenson's.
        A: pivot of the crank.
        B, C, D: (N,) hinges of the driving four-bar.
        second: body and places of P, places of Q, body and places of E.
        traced: (N,) places of the point of the link P-Q, or None.
    """
    body, P, Q, base, E = second
    ground = np.zeros_like(B), np.ones_like(B)
    bodies = BodyPositions.of(ground, (np.full_like(B, A), B), (B, C), (D, C), (P, Q), (E, Q))
    pairs = (((CRANK, B, C), (GROUND, D, C)), ((body, P, Q), (base, E, Q)))
    (a, b), (c, d) = (
        [DyadArm(k, bodies.point(k, z), float(np.abs(z - end).mean())) for k, z, end in one] for one in pairs
    )
    crank, size = float(np.abs(B - A).mean()), float(spread(B if traced is None else traced))
    lengths = [crank, *(arm.length for arm in (a, b, c, d))]
    if min(lengths) < NO_LENGTH * size or max(lengths) > BULKY * size:
        return None
    point = None if traced is None else bodies.point(LAST, traced)
    linkage = SixBar(as_points(A), crank, ((a, b), (c, d)), form, point)
    theta = np.angle(B - A)
    sides = [(np.conj(right - left) * (hinge - left)).imag for left, right, hinge in ((B, D, C), (P, E, Q))]
    modes = np.where(np.stack(sides, axis=1) >= 0, 1, -1)
    residual = 0.0
    for k, mode in enumerate(modes.tolist()):
        places, ways, _ = linkage.bodies(theta[k : k + 1], mode)
        gaps = [np.abs(places[:, 0] - np.array([each[k] for each in bodies.places])).max()]
        gaps += [d.length * abs(complex(ways[OUTPUT, 0] - bodies.ways[OUTPUT][k]))]
        if traced is not None:
            gaps.append(np.hypot(*(linkage.path_points(theta[k : k + 1], mode)[0] - as_points(traced[k]))))
        residual = max(residual, *map(float, gaps))
    return Placed(linkage, theta, modes, residual)
