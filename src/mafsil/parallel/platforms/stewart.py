"""The platform on six extending legs (Gough, Stewart; 6-UPS, 6-SPS): lengths, rates, statics, poses of given lengths.

Leg i goes from a_i on the base, in {s}, to b_i on the platform, in {b}: d_i = p + R b_i - a_i, s_i = |d_i|.

References: Lynch & Park, Modern Robotics, sec. 7.1-7.2; Merlet, Parallel Robots, ch. 4.

Poses of a platform found from a first guess, with how exactly every leg fits.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, Integers, as_batch, frozen, positive, radians, single, whole
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.geometry.quaternion import to_quaternion
from mafsil.lazy_module import lazily
from mafsil.parallel.legs.leg_lines import forces_for, line_matrix, rates, resultant, unit_vectors
from mafsil.parallel.platforms.assembly_modes import PlatformModes, modes_of, of_size_one, poses_of
from mafsil.parallel.platforms.certificate import Certificate, certificate_of
from mafsil.parallel.platforms.platform_paths import Start, all_poses, nearly_real, own_start
from mafsil.parallel.platforms.platform_sets import CORRECTIONS
from mafsil.parallel.singular_kinds import SingularKinds, singular_kinds
from mafsil.parallel.tolerances import LENGTH

if TYPE_CHECKING:
    import mafsil.parallel.platforms.stewart_loops as stewart_loops
else:
    stewart_loops = lazily("mafsil.parallel.platforms.stewart_loops")


Frame = Literal["space", "body"]
AXES = ("x", "y", "z")
MOST_RUNS = 8
"""Random lengths at which poses are counted, until the most of them were found twice."""


@dataclass(frozen=True, eq=False)
class StewartPlatform:
    """A platform on six legs that extend, by the places of their ends.

    Attributes:
        base: (6, 3) ends a_i on the base, in {s} [m].
        platform: (6, 3) ends b_i on the platform, in {b} [m].
    """

    base: Floats
    platform: Floats

    def __post_init__(self) -> None:
        for name in ("base", "platform"):
            object.__setattr__(self, name, frozen(single(name, getattr(self, name), (6, 3))))

    @classmethod
    def on_circles(
        cls, base: float, platform: float, base_angles: ArrayLike, platform_angles: ArrayLike
    ) -> StewartPlatform:
        """Ends on two circles in the planes z = 0 of both frames.

        Args:
            base, platform: radii [m].
            base_angles, platform_angles: (6,) of the ends [rad].
        """
        places = [
            positive(name, radius) * np.stack([np.cos(angle), np.sin(angle), np.zeros(6)], axis=-1)
            for name, radius, angle in (
                ("base", base, radians("base_angles", single("base_angles", base_angles, (6,)), places=True)),
                (
                    "platform",
                    platform,
                    radians("platform_angles", single("platform_angles", platform_angles, (6,)), places=True),
                ),
            )
        ]
        return cls(places[0], places[1])

    @cached_property
    def size(self) -> float:
        """Largest distance of an end from the middle of its body [m]: lengths are judged over it."""
        return float(of_size_one(self.base, self.platform)[2])

    def leg_vectors(self, T: ArrayLike) -> Floats:
        """(*batch, 6, 3) d_i = p + R b_i - a_i in {s} [m], for poses T_sb (*batch, 4, 4)."""
        pose_sb = pose.check(T)
        return pose_sb[..., None, :3, 3] + self.platform @ np.swapaxes(pose_sb[..., :3, :3], -1, -2) - self.base

    def lengths(self, T: ArrayLike, signed: bool = False) -> Floats:
        """(*batch, 6) lengths of the legs [m] for poses T_sb (*batch, 4, 4): inverse kinematics in closed form.

        Args:
            T: (*batch, 4, 4) poses T_sb.
            signed: both branches, (*batch, 6, 2): s_i, and -s_i of a slider that passes through its pivot.

        Raises:
            InputError: T is no pose.
        """
        s = np.linalg.norm(self.leg_vectors(T), axis=-1)
        return np.stack([s, -s], axis=-1) if signed else s

    def inverse_kinematics(self, T: ArrayLike) -> Floats:
        """(*batch, 6) `lengths` of the legs [m] for poses T_sb (*batch, 4, 4), under the name that all robots have."""
        return self.lengths(T)

    def jacobian(self, T: ArrayLike, frame: Frame = "space") -> Floats:
        """(*batch, 6, 6) G with s' = G V, by the lines of the legs: rows (a_i x u_i, u_i) in {s}.

        Args:
            T: (*batch, 4, 4) poses T_sb.
            frame: of the twist V: `space` or `body`.

        Raises:
            InputError: T is no pose, a leg has length zero, or an unknown frame.
        """
        _, u = unit_vectors(self.leg_vectors(T))
        G = line_matrix(self.base, u)
        if frame == "space":
            return G
        if frame != "body":
            raise InputError("input.choice", name="frame", value=frame, known="space, body")
        return G @ pose.adjoint(np.asarray(T, dtype=np.float64))

    def leg_rates(self, T: ArrayLike, V: ArrayLike, frame: Frame = "space") -> Floats:
        """(*batch, 6) rates of the lengths [m/s] for twists V (*batch, 6) of the platform."""
        return rates(self.jacobian(T, frame), V)

    def leg_accelerations(self, T: ArrayLike, V: ArrayLike, Vd: ArrayLike) -> Floats:
        """(*batch, 6) second derivatives of the lengths [m/s^2], for a motion simulator that follows a trajectory.

        Args:
            T: (*batch, 4, 4) poses.
            V: (*batch, 6) twists in {s}.
            Vd: (*batch, 6) their derivatives by time.
        """
        twist, change, d = as_batch("V", V, (6,)), as_batch("Vd", Vd, (6,)), self.leg_vectors(T)
        s, u = unit_vectors(d)
        end, w = self.base + d, twist[..., None, :3]
        moving = twist[..., None, 3:] + np.cross(w, end)
        along = (u * moving).sum(axis=-1)
        bending = (u * np.cross(w, moving)).sum(axis=-1) + ((moving**2).sum(axis=-1) - along**2) / s
        return rates(line_matrix(self.base, u), change) + bending

    def twist(self, T: ArrayLike, leg_rates: ArrayLike, frame: Frame = "space") -> Floats:
        """(*batch, 6) twists for rates of the lengths (*batch, 6) [m/s].

        Args:
            T: (*batch, 4, 4) poses T_sb.
            leg_rates: (*batch, 6) [m/s].
            frame: of the twist: `space` or `body`.

        Raises:
            InputError: a pose is singular.
        """
        return forces_for(np.swapaxes(self.jacobian(T, frame), -1, -2), as_batch("leg_rates", leg_rates, (6,)))

    def wrench(self, T: ArrayLike, forces: ArrayLike, frame: Frame = "space") -> Floats:
        """(*batch, 6) wrench of the legs on the platform for their forces (*batch, 6) [N], pushing positive."""
        return resultant(self.jacobian(T, frame), forces)

    def leg_forces(self, T: ArrayLike, F: ArrayLike, frame: Frame = "space") -> Floats:
        """(*batch, 6) forces of the legs [N] whose wrench on the platform is F (*batch, 6).

        To hold a load F_load give F = -F_load.

        Args:
            T: (*batch, 4, 4) poses T_sb.
            F: (*batch, 6) wrenches (m, f).
            frame: of the wrench: `space` or `body`.

        Raises:
            InputError: a pose is singular, so that some wrench needs forces without bound.
        """
        return forces_for(self.jacobian(T, frame), F)

    def external_wrench(self, T: ArrayLike, forces: ArrayLike, frame: Frame = "space") -> Floats:
        """(*batch, 6) the wrench from outside on a platform at rest, from the measured forces of its legs [N].

        The platform as a sensor of force and torque: F_ext = -G' tau.
        """
        return -self.wrench(T, forces, frame)

    def wrench_noise(self, T: ArrayLike, frame: Frame = "body") -> Floats:
        """(*batch, 6) standard deviation of `external_wrench` per unit of independent noise on every leg."""
        return np.linalg.norm(self.jacobian(T, frame), axis=-2)

    def forward_near(
        self, lengths: ArrayLike, T_guess: ArrayLike, max_steps: int = 50, *, signed: bool = False
    ) -> ForwardPoses:
        """Poses of given lengths by Newton's method from first ones, in batches, compiled.

        Args:
            lengths: (*batch, 6) of the legs [m].
            T_guess: (*batch, 4, 4) first poses.
            max_steps: most steps.
            signed: take negative lengths too, of sliders that pass through their pivot: the poses are the same.

        Raises:
            InputError: a wrong shape, a guess that is no pose, a negative length and not `signed`.

        Returns:
            Poses; those that were not found are marked and hold the last pose of the search.
            Memory: 25 numbers for each row beyond the answer.
        """
        s, guess = (
            magnitudes_of(as_batch("lengths", lengths, (6,), finite=True), signed),
            pose.check(T_guess, "T_guess"),
        )
        most = whole("max_steps", max_steps, 1, 10_000)
        shape = np.broadcast_shapes(s.shape[:-1], guess.shape[:-2])
        first = np.concatenate([to_quaternion(guess[..., :3, :3]), guess[..., :3, 3]], axis=-1)
        starts = np.ascontiguousarray(np.broadcast_to(first, (*shape, 7)).reshape(-1, 7))
        wanted = np.ascontiguousarray(np.broadcast_to(s, (*shape, 6)).reshape(-1, 6))
        count = len(starts)
        x, error, pivot = np.empty((count, 7)), np.empty(count), np.empty(count)
        steps = np.zeros(count, dtype=np.int64)
        limit = LENGTH * max(self.size, float(np.abs(wanted).max(initial=0.0)))
        stewart_loops.newton(wanted, starts, self.base, self.platform, limit, most, x, error, steps, pivot)
        T = poses_of(x).reshape(*shape, 4, 4)
        found = np.asarray(error <= limit)
        return ForwardPoses(T, found.reshape(shape), error.reshape(shape), steps.reshape(shape), pivot.reshape(shape))

    def forward_kinematics(self, lengths: ArrayLike, *, signed: bool = False) -> PlatformModes:
        """All poses with legs of these lengths, real ones as poses, complex ones counted.

        At the first call the isolated poses of this platform for general complex lengths are found once: forty, or
        fewer if its geometry is special. Each is then followed to every row of lengths.

        Args:
            lengths: (*batch, 6) of the legs [m].
            signed: take negative lengths too, of sliders that pass through their pivot: the poses are the same.

        Returns:
            Its modes; `finite` reaches `expected` where no pose can be missing or double.

        Raises:
            InputError: a wrong shape, a negative length and not `signed`.
        """
        s = magnitudes_of(as_batch("lengths", lengths, (6,), finite=True), signed)
        a, b = (np.broadcast_to(p, (*s.shape[:-1], 6, 3)) for p in (self.base, self.platform))
        return modes_of(a, b, s, self._starts, len(self._starts[0].poses))

    def eliminant(self, lengths: ArrayLike, coordinate: Literal["x", "y", "z"] = "z") -> Polynomial:
        """The polynomial whose zeros are one coordinate of all poses, complex ones too; of degree 40 in general.

        From the poses themselves: the product of the differences to each, in units of the platform's size.

        Args:
            lengths: (6,) of the legs [m].
            coordinate: of the middle of the platform's ends, in {s} [m].

        Returns:
            A polynomial of the coordinate [m], of leading coefficient one in its own window. Of degree 40 its zeros are
            only as good as the last digits of its coefficients allow; the poses are `forward_kinematics`.

        Raises:
            InputError: wrong lengths, an unknown coordinate, a geometry without isolated poses.
        """
        s = magnitudes_of(single("lengths", lengths, (6,)), signed=False)
        if coordinate not in AXES:
            raise InputError("input.choice", name="coordinate", value=coordinate, known=", ".join(AXES))
        a, b, size = of_size_one(self.base, self.platform)
        found = all_poses(a[None], b[None], s[None] / float(size), self._starts, len(self._starts[0].poses))
        places = found.complexes[0, :, 4 + AXES.index(coordinate)]
        places = places[np.isfinite(places)]
        if not len(places):
            raise InputError("parallel.eliminant_without_poses")
        middle, unit = float(self.base.mean(axis=0)[AXES.index(coordinate)]), float(size)
        return Polynomial(np.poly(places)[::-1].real, domain=[middle - unit, middle + unit], window=[-1.0, 1.0])

    def certificate(self, lengths: ArrayLike) -> Certificate:
        """What is proven of the poses for one row of lengths (6,): that they exist, differ, and are all.

        Args:
            lengths: (6,) of the legs [m].
        """
        s = np.abs(single("lengths", lengths, (6,)))
        a, b, size = of_size_one(self.base, self.platform)
        rows = s[None] / float(size)
        found = all_poses(a[None], b[None], rows, self._starts, len(self._starts[0].poses))
        x = found.complexes[0]
        x = x[np.isfinite(x).all(axis=1)]
        # Real poses stand as they were made real, the others as they were found.
        real_x = found.x[0, : int(found.real[0])]
        complex_x = [each for each in x if not nearly_real(each, real_x)]
        together = np.concatenate([real_x.astype(np.complex128), np.array(complex_x).reshape(-1, 7)])
        return certificate_of(a, b, rows[0], together, np.arange(len(together)) < len(real_x))

    def singularity(self, T: ArrayLike) -> SingularKinds:
        """Kind of singularity at poses (*batch, 4, 4): the second where the lines of the legs depend on each other.

        Its motions and moments are about the middle of the platform, so that its measure does not depend on {s}.
        """
        G = self.jacobian(T)
        middle = np.asarray(T, dtype=np.float64)[..., :3, 3]
        shift = np.cross(np.broadcast_to(middle[..., None, :], (*G.shape[:-1], 3)), G[..., 3:])
        about = np.concatenate([G[..., :3] - shift, G[..., 3:]], axis=-1)
        return singular_kinds(about, np.broadcast_to(np.eye(6), G.shape), self.size, 3)

    @cached_property
    def _starts(self) -> list[Start]:
        a, b, _ = of_size_one(self.base, self.platform)
        starts = list[Start]()
        while len(starts) < MOST_RUNS:
            starts.append(own_start(a, b, len(starts)))
            starts.sort(key=lambda start: -len(start.poses))
            if len(starts) >= len(CORRECTIONS) and len(starts[0].poses) == len(starts[1].poses):
                break
        return starts[: len(CORRECTIONS)]


def magnitudes_of(lengths: Floats, signed: bool) -> Floats:
    """Lengths without their signs.

    Args:
        lengths: of legs [m].
        signed: whether negative ones are taken.

    Raises:
        InputError: a negative length and not `signed`.
    """
    if not signed and (lengths < 0).any():
        raise InputError("parallel.negative_length", value=float(lengths.min()))
    return np.abs(lengths)


class ForwardStatus(Status):
    """How a search for poses ended."""

    FOUND = ("parallel.forward_found", True)
    SOME = ("parallel.forward_some", False)
    SINGULAR = ("parallel.forward_singular", False)
    NOT_FOUND = ("parallel.forward_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class ForwardPoses(Answer, data="T found error steps"):
    """Poses of the platform near first ones; true if all were found, iterable over the rows of the batch.

    Attributes:
        T: (*batch, 4, 4) the last poses of the search, in {s}.
        found: (*batch,) whether every leg fits.
        error: (*batch,) largest error of a leg [m].
        steps: (*batch,) Newton steps.
        pivot: (*batch,) least over largest pivot of the last step: zero at a singular pose.
    """

    T: Floats
    found: Booleans
    error: Floats
    steps: Integers
    pivot: Floats

    @property
    def status(self) -> ForwardStatus:
        """Found everywhere, somewhere, nowhere; or stopped at a singular pose."""
        if self.found.all():
            return ForwardStatus.FOUND
        if self.found.any():
            return ForwardStatus.SOME
        return ForwardStatus.SINGULAR if (self.pivot == 0.0).all() else ForwardStatus.NOT_FOUND

    def __len__(self) -> int:
        return int(self.found.size)

    def __iter__(self) -> Iterator[Floats]:
        return iter(self.T.reshape(-1, 4, 4))

    def explain(self, language: str | None = None) -> str:
        """How many were found, and the largest error of a leg."""
        return self.status.sentence(
            language, found=int(self.found.sum()), count=self.found.size, error=float(self.error.max(initial=0.0)),
            steps=int(self.steps.max(initial=0)),
        )  # fmt: skip
