"""Which sides an arm has, read from its axes and from how its closed form sees them; and the kernel that names them."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from mafsil import kernels
from mafsil.arrays import Vector3
from mafsil.ik.chain import Chain
from mafsil.ik.tolerances import COINCIDENT, DEFECT
from mafsil.kernels import Port, Signature
from mafsil.lazy_module import lazily
from mafsil.mechanics.arm_pattern import ArmPattern, Family, PositioningMethod
from mafsil.mechanics.arm_sides import (
    ArmSides,
    Carried,
    Elbow,
    HighElbow,
    Placing,
    PlaneElbow,
    Shoulder,
    Stroke,
)

if TYPE_CHECKING:
    import mafsil.mechanics.closed_form.line as closed_form_sides
    from mafsil.kernels import Kernel
else:
    closed_form_sides = lazily("mafsil.mechanics.closed_form.line")

LEVEL = 1e-6
"""Sine of the angle to the ground below which an axis is level, and to the upright below which a plane is."""

Z: Vector3 = np.array([0.0, 0.0, 1.0])

_Wrist: TypeAlias = tuple[Carried, Carried, Carried]


def sides_of(chain: Chain, pattern: ArmPattern) -> ArmSides:
    """The sides of an arm.

    Args:
        chain: of the arm, base first.
        pattern: of its closed form.
    """
    return _Sides(chain, pattern).arm_sides()


def branch_kernel(sides: ArmSides) -> Kernel:
    """Of q (n,) to the number of the branch, see `mafsil.mechanics.closed_form.line.sides_function`.

    Args:
        sides: of the arm.
    """
    return kernels.compile(
        Signature("branch_code", (Port("q", (len(sides.prismatic),)),), (Port("code"),)),
        partial(_build, sides),
        key=f"sides {sides.key}",
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics"),),
        recipe=(branch_kernel, (sides,)),
    )


def _build(sides: ArmSides) -> Any:
    """Its expressions are loaded only when a kernel has to be made."""
    return closed_form_sides.sides_function(sides)


class _Sides:
    """An arm while its sides are looked for; joints are counted from the base."""

    def __init__(self, chain: Chain, pattern: ArmPattern) -> None:
        self.chain, self.pattern = chain, pattern
        self.joints, self.real = pattern.joints, all(joint >= 0 for joint in pattern.joints[:3])

    def arm_sides(self) -> ArmSides:
        """The sides."""
        shoulder, elbow, wrist, exact = self._parts()
        chain = self.chain
        return ArmSides(chain.axes, chain.points, chain.prismatic, self.pattern.size, shoulder, elbow, wrist, exact)

    def _parts(self) -> tuple[Shoulder | None, Elbow | None, _Wrist | None, bool]:
        pattern = self.pattern
        if pattern.shifted:
            return None, None, None, False
        match pattern.family:
            case Family.PLANAR:
                return None, self._planar(), None, True
            case Family.THREE_PARALLEL | Family.LINKED:
                return self._three_parallel()
            case _ if pattern.reversed:
                return self._from_the_tip()
            case _:
                return self._from_the_base()

    def _axis(self, k: int, sense: float = 1.0) -> Carried:
        return Carried(sense * self.chain.axes[k], k)

    def _on(self, k: int, near: Vector3 | None = None) -> Carried:
        """A point of axis k: that nearest to another at q = 0."""
        w, r = self.chain.axes[k], self.chain.points[k]
        return Carried(r if near is None else np.asarray(r + w * (w @ (near - r)), dtype=np.float64), k)

    def _up(self, k: int) -> Carried:
        """Axis k in the sense that leads up."""
        height = float(self.chain.axes[k][2])
        return self._axis(k, -1.0 if height < -LEVEL else 1.0)

    def _turns(self, k: int) -> bool:
        """Whether a joint exists and turns."""
        return k >= 0 and not self.chain.prismatic[k]

    def _wrist(self) -> _Wrist | None:
        """The axes of a pattern's wrist; those of joints that do not exist stand still at the tip."""
        if max(self.joints[3:6], default=-1) < 0:
            return None
        axes = zip(self.joints[3:6], self.pattern.axes[3:6], strict=True)
        first, middle, last = (self._axis(k) if k >= 0 else Carried(w, len(self.chain)) for k, w in axes)
        return first, middle, last

    def _in_plane(self, h: int, S: Carried, E: Carried, W: Carried) -> Elbow:
        """An elbow of parallel axes without a first axis across them: seen from above, or by height."""
        w = self.chain.axes[h]
        if np.linalg.norm(np.cross(w, Z)) <= LEVEL:
            return PlaneElbow(self._up(h), S, E, W)
        return HighElbow(S, E, W, Carried(Z, 0))

    def _planar(self) -> Elbow | None:
        one, two, three = self.joints[:3]
        if min(one, two) < 0:
            return None
        W = Carried(self.pattern.points[2], three if three >= 0 else len(self.chain))
        return self._in_plane(one, self._on(one), self._on(two), W)

    def _three_parallel(self) -> tuple[Shoulder | None, Elbow | None, _Wrist | None, bool]:
        pattern, joints = self.pattern, self.joints
        a, b, c = sorted(joints[1:4])
        if a < 0:
            return None, None, None, False
        S = self._on(a)
        E, W = self._on(b, S.at), self._on(c, S.at)
        if pattern.family is Family.LINKED or pattern.reversed:
            revolute = [k for k in range(a) if not self.chain.prismatic[k]]
            elbow = HighElbow(S, E, W, self._up(revolute[0])) if revolute else self._in_plane(a, S, E, W)
            return None, elbow, None, False
        wrist = self._wrist()
        if not self._turns(joints[0]):
            return None, self._in_plane(a, S, E, W), wrist, joints[0] >= 0
        hub = Carried(pattern.centre, joints[4] if joints[4] >= 0 else len(self.chain))
        reach = Shoulder(self._axis(a), self._on(joints[0]), hub, self._up(joints[0]))
        return self._to_the_side(reach), PlaneElbow(self._axis(a), S, E, W, reach), wrist, True

    def _to_the_side(self, reach: Shoulder) -> Shoulder:
        """The shoulder's axis in the sense in which the upper arm lies aside of the first axis."""
        offset = float(reach.axis.at @ (reach.end.at - reach.start.at))
        aside = offset < -COINCIDENT * self.pattern.size
        return Shoulder(Carried(-reach.axis.at, reach.axis.after), reach.start, reach.end, reach.up) if aside else reach

    def _from_the_base(self) -> tuple[Shoulder | None, Elbow | None, _Wrist | None, bool]:
        """Three joints place a point; after them perhaps a wrist."""
        pattern, wrist = self.pattern, self._wrist()
        i, j, k = self.joints[:3]
        W = Carried(pattern.centre, min((one for one in self.joints[3:] if one >= 0), default=len(self.chain)))
        match pattern.positioning:
            case PositioningMethod.PARALLEL if not pattern.positioning_reversed and min(j, k) >= 0:
                return *self._across_a_plane(i, j, k, W), wrist, True
            case PositioningMethod.PARALLEL if pattern.positioning_reversed and self._turns(i) and j >= 0:
                # Axes 1 and 2 are parallel: an arm that reaches in a plane, and a third joint that changes the height.
                return None, self._in_plane(i, self._on(i), self._on(j), W), wrist, k < 0
            case PositioningMethod.MEET if not pattern.positioning_reversed and self.real:
                S = Carried(pattern.meeting, j)
                shoulder = Shoulder(self._axis(j), S, W, self._up(i))
                if not self._turns(k):
                    return shoulder, Stroke(self._axis(k), S, W), wrist, True
                return shoulder, HighElbow(S, self._on(k, pattern.meeting), W, self._up(i)), wrist, False
            case PositioningMethod.ACROSS if not pattern.positioning_reversed and self.real:
                out = Stroke(self._axis(j), self._on(i), W)
                return (
                    Shoulder(self._axis(k), self._on(k), W, self._up(i)) if self._turns(k) else None,
                    out,
                    wrist,
                    True,
                )
            case PositioningMethod.QUARTIC if self.real:
                return None, Placing((i, j, k), W), wrist, True
            case _:
                return None, None, wrist, pattern.positioning is PositioningMethod.LINEAR

    def _across_a_plane(self, i: int, j: int, k: int, W: Carried) -> tuple[Shoulder | None, Elbow]:
        """Joints j and k move the wrist in a plane that joint i turns, or shifts."""
        S = self._on(j)
        reach = Shoulder(self._axis(j), self._on(i), W, self._up(i)) if self._turns(i) else None
        shoulder = None if reach is None else self._to_the_side(reach)
        if not self._turns(k):
            return shoulder, Stroke(self._axis(k), S, W, self._axis(j))
        E = self._on(k, S.at)
        return shoulder, self._in_plane(j, S, E, W) if reach is None else PlaneElbow(self._axis(j), S, E, W, reach)

    def _from_the_tip(self) -> tuple[Shoulder | None, Elbow | None, _Wrist | None, bool]:
        """A spherical shoulder, and three joints or four after it that place it as seen from the tip."""
        pattern, chain = self.pattern, self.chain
        last, middle, bend = self.joints[:3]
        one, two, three = sorted(self.joints[3:6])
        if one < 0 or not self.real:
            return None, None, None, False
        S, up = Carried(pattern.centre, one), self._up(one)
        E = self._on(bend, S.at)
        along = 0.0 if chain.prismatic[bend] else float(chain.axes[three] @ (E.at - S.at))
        ahead = (-1.0 if along < -DEFECT * pattern.size else 1.0) * chain.axes[three]
        shoulder = Shoulder(self._axis(two), S, Carried(S.at + pattern.size * ahead, three), up)
        if pattern.positioning is PositioningMethod.QUARTIC:
            return shoulder, Placing((last, middle, bend), S), None, True
        meets = pattern.positioning is PositioningMethod.MEET
        jointed = meets or pattern.positioning is PositioningMethod.PARALLEL
        if not jointed or pattern.positioning_reversed or not (self._turns(middle) and self._turns(bend)):
            return shoulder, None, None, False
        W = Carried(pattern.meeting, middle) if meets else self._on(middle, E.at)
        after = [k for k in range(bend + 1, len(chain)) if not chain.prismatic[k]]
        wrist = (self._axis(after[-3]), self._axis(after[-2]), self._axis(after[-1])) if len(after) > 2 else None
        return shoulder, HighElbow(S, E, W, up), wrist, False
