"""One linkage of a synthesis where it stands in the plane, with the defects found in it and their numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, Integers, whole
from mafsil.messages import say
from mafsil.mobility.four_bar import FourBar, GrashofClass
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.slider_crank import SliderCrank
from mafsil.mobility.spaces.planar_positions import wrap_angle
from mafsil.mobility.synthesis.assessment import Assessment
from mafsil.mobility.synthesis.fitting import Positions


class CandidateStatus(Status):
    """Whether a linkage can be driven through its positions, or the first reason why not."""

    FREE = ("synthesis.candidate_free", True)
    CIRCUIT = ("synthesis.candidate_circuit", False)
    BRANCH = ("synthesis.candidate_branch", False)
    ORDER = ("synthesis.candidate_order", False)


@dataclass(frozen=True, eq=False, repr=False)
class Candidate(
    Answer,
    data="A D direction B C theta modes circuits defects transmission residual miss along across turned",
):
    """A linkage driven by its crank; true if no defect was found.

    Attributes:
        linkage: the `FourBar` or `SliderCrank`, in its own frame.
        A, D: (2,) fixed pivots of crank and rocker [m]; D of a slider-crank is the point of its line nearest to A.
        direction: angle of the linkage's x axis in the world: from A to D, or along the line of the block [rad].
        B, C: (N, 2) moving pivots in the positions [m].
        theta: (N,) angles of the crank from `direction` in (-pi, pi] [rad].
        modes: (N,) assembly mode of each position, as in the methods of `linkage`.
        circuits: (N,) positions with the same number lie on one circuit.
        defects: all that were found.
        transmission: (N,) transmission angle at the positions in [0, pi/2] [rad].
        worst: the least one on the way between them; 0 beyond a dead point [rad].
        residual: largest change of a length between positions [m].
        miss: distance of the farthest position from what was asked, in least squares [m | rad]; 0 where all are met.
        along, across, turned: the coupler's frame from B: along B -> C, to the left of it [m], angle from it [rad].
    """

    linkage: FourBar | SliderCrank
    A: Floats
    D: Floats
    direction: float
    B: Floats
    C: Floats
    theta: Floats
    modes: Integers
    circuits: Integers
    defects: tuple[CandidateStatus, ...]
    transmission: Floats
    worst: float
    residual: float
    miss: float
    along: float
    across: float
    turned: float

    @property
    def status(self) -> CandidateStatus:
        """The first defect, or that there is none."""
        return self.defects[0] if self.defects else CandidateStatus.FREE

    @property
    def grashof(self) -> GrashofClass | None:
        """What goes round; None for a slider-crank (`linkage.full_turn` says it)."""
        return self.linkage.grashof if isinstance(self.linkage, FourBar) else None

    @property
    def kind(self) -> str:
        """The key of the sentence about what goes round."""
        if isinstance(self.linkage, FourBar):
            return f"mobility.{self.linkage.grashof.value}"
        return "synthesis.slider_full" if self.linkage.full_turn else "synthesis.slider_swings"

    def drawn(self, position: int = 0) -> Linkage:
        """The linkage in its own frame at a position, for `mafsil.figures.linkage.save_linkage` and `mf.mobility`."""
        return self.linkage.linkage(float(self.theta[position]), int(self.modes[position]))

    def moving_pivots(self, theta: ArrayLike, mode: int = 0) -> tuple[Floats, Floats]:
        """(*batch, 2) B and C in the world at angles of the crank (*batch,) [m].

        Where the linkage does not close, those of the nearest dead point; `linkage.positions(theta).missing` says where
        and by how much.
        """
        if isinstance(self.linkage, FourBar):
            found = self.linkage.positions(theta)
            angle, ends = found.theta[..., mode, 0], found.C[..., mode, :]
            C = ends[..., 0] + 1j * ends[..., 1]
        else:
            places = self.linkage.positions(theta)
            angle, C = places.theta, places.x[..., mode] + 1j * self.linkage.offset
        return self._in_world(self.linkage.crank * np.exp(1j * angle)), self._in_world(C)

    def _in_world(self, z: Any) -> Floats:
        turned = complex(*self.A) + np.exp(1j * self.direction) * z
        return np.stack([turned.real, turned.imag], axis=-1)

    def coupler_poses(self, theta: ArrayLike, mode: int = 0) -> Floats:
        """(*batch, 3) poses (x, y, phi) of the coupler's frame at angles of the crank [m, rad]."""
        B, C = self.moving_pivots(theta, mode)
        step = (C - B)[..., 0] + 1j * (C - B)[..., 1]
        u = step / np.abs(step)
        z = (self.along + 1j * self.across) * u
        return np.stack([B[..., 0] + z.real, B[..., 1] + z.imag, wrap_angle(np.angle(u) + self.turned)], axis=-1)

    def coupler_curves(self, samples: int = 361) -> tuple[Floats, ...]:
        """What the origin of the coupler's frame draws: pieces (k, 2) of both modes, one for each reach of the crank.

        Args:
            samples: angles of the crank over a turn, of which those are left out at which the linkage does not close.
        """
        theta = np.linspace(-np.pi, np.pi, whole("samples", samples, 2, 1_000_000))
        closes = self.linkage.positions(theta).reachable
        reaches = np.split(np.arange(len(theta)), np.flatnonzero(np.diff(closes)) + 1)
        return tuple(
            self.coupler_poses(theta[reach], mode)[..., :2] for mode in (0, 1) for reach in reaches if closes[reach[0]]
        )

    def explain(self, language: str | None = None) -> str:
        """Lengths and class, each defect with its numbers, and the transmission angle at worst."""
        kind = say(self.kind, language=language)
        lines = [say(f"synthesis.{self._form()}", language=language, kind=kind, **self._lengths())]
        details = self._details()
        lines += [each.sentence(language, **details) for each in self.defects or (CandidateStatus.FREE,)]
        if self.miss > 0.0:
            lines.append(say("synthesis.misses", language=language, miss=self.miss))
        return "\n".join(lines)

    def _form(self) -> str:
        return "four_bar" if isinstance(self.linkage, FourBar) else "slider_crank"

    def _lengths(self) -> dict[str, float]:
        names = ("crank", "coupler", "rocker", "ground") if isinstance(self.linkage, FourBar) else (
            "crank", "rod", "offset")  # fmt: skip
        return {name: float(getattr(self.linkage, name)) for name in names}

    def _details(self) -> dict[str, Any]:
        angles = np.degrees(self.theta)
        return {
            "angle": float(np.degrees(self.worst)),
            "first": position_numbers(self.circuits == self.circuits[0]),
            "others": position_numbers(self.circuits != self.circuits[0]),
            "one_side": position_numbers(self.modes == self.modes[0]),
            "other_side": position_numbers(self.modes != self.modes[0]),
            "least": float(np.degrees(self.transmission.min())),
            "angles": ", ".join(f"{angle:.1f}" for angle in angles),
        }

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return Answer.to_dict(self) | {
            "form": self._form(),
            **self._lengths(),
            "kind": self.kind.rpartition(".")[2],
            "worst_transmission": self.worst,
        }


def position_numbers(which: Any) -> str:
    """Numbers of positions, from 1 on; a dash for none."""
    return ", ".join(str(k + 1) for k in np.flatnonzero(which)) or "-"


def candidate(positions: Positions, found: Assessment, k: int) -> Candidate:
    """The k-th linkage of a batch.

    Args:
        positions: the batch.
        found: what was found of it.
        k: its index.
    """
    A, D = complex(positions.A[k]), complex(positions.D[k])
    lengths = found.lengths[k].tolist()
    if positions.slider:
        linkage: FourBar | SliderCrank = SliderCrank(lengths[0], lengths[1], lengths[3])
        direction = float(np.angle(D))
        D = A + 1j * D * lengths[3]
        modes = (found.branches[k] < 0).astype(int)
    else:
        linkage, direction = FourBar(*lengths), float(np.angle(D - A))
        modes = (found.branches[k] > 0).astype(int)
    checks = (
        (CandidateStatus.CIRCUIT, found.circuit_defect[k]),
        (CandidateStatus.BRANCH, found.branch_defect[k]),
        (CandidateStatus.ORDER, found.order_defect[k]),
    )
    along, across, turned = positions.frame[k].tolist()
    miss = 0.0 if positions.misses is None else float(positions.misses[k])
    return Candidate(
        linkage, np.array([A.real, A.imag]), np.array([D.real, D.imag]), direction,
        _points(positions.B[k]), _points(positions.C[k]), found.theta[k], modes, found.circuits[k],
        tuple(status for status, defect in checks if defect), found.transmission[k], float(found.worst[k]),
        float(found.residual[k]), miss, along, across, turned,
    )  # fmt: skip


def _points(z: Any) -> Floats:
    return np.stack([z.real, z.imag], axis=-1)
