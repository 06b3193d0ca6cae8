"""Masses of the bodies of a linkage, forces on them, gravity; in its file the tables [[body]] and [[load]].

gravity = [0, -9.81]

[[body]]
name = "coupler"
mass = 2.0
center = [2.5, 2.5]        # of mass, where the body is drawn
inertia = 0.8              # about it: of the plane, or three or six numbers xx, yy, zz, xy, xz, yz

[[load]]
body = "rocker"
at = [4, 3]
force = [0, -100]          # and moment = [0, 0, 5]
follows = true             # the force turns with the body; else it keeps its direction
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, frozen, not_negative, real_array, single
from mafsil.errors import InputError, ModelError
from mafsil.fields import check_fields
from mafsil.mobility.linkages.linkage import Linkage

GRAVITY = (0.0, 0.0, -9.81)
SYMMETRIC = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Rows and columns of the six numbers of an inertia."""
NOT_REAL = 1e-9
"""Share of its largest eigenvalue by which an inertia may be negative or break the triangle inequality: rounding."""


def in_space(name: str, value: ArrayLike) -> Floats:
    """(3,) of two or three numbers, the third being zero."""
    given = real_array(name, value)
    return frozen(single(name, np.append(given, 0.0) if given.shape == (2,) else given, (3,)))


def _inertia(name: str, value: ArrayLike) -> Floats:
    """(3, 3) of one number about z, three principal ones, six, or all."""
    given = real_array(name, value)
    I = np.zeros((3, 3))
    if given.shape == (3, 3):
        I = given
    elif given.ndim == 0:
        # A lamina of the plane: no torque about x and y is asked for where it stays in it.
        I = np.diag([given / 2, given / 2, given]).astype(np.float64)
    elif given.shape in ((3,), (6,)):
        for (i, j), each in zip(SYMMETRIC, given.tolist(), strict=False):
            I[i, j] = I[j, i] = each
    else:
        raise InputError("input.shape", name=name, expected="(), (3,), (6,) or (3, 3)", got=given.shape, hint="")
    J = single(name, I, (3, 3))
    a, b, c = np.linalg.eigvalsh(J).tolist()
    if np.abs(J - J.T).max() > NOT_REAL * abs(c) or min(a, a + b - c) < -NOT_REAL * abs(c):
        raise InputError("mobility.inertia", name=name, principal=f"{a:.6g}, {b:.6g}, {c:.6g}")
    return frozen(J)


@dataclass(frozen=True, eq=False)
class BodyMass:
    """Mass of a body.

    Attributes:
        body: its name.
        mass: [kg].
        center: (3,) of mass, where the body is drawn; two numbers in the plane [m].
        inertia: (3, 3) about the center of mass, in the axes of the drawing [kg m^2]; one number is that about z.
    """

    body: str
    mass: float
    center: Floats = field(default_factory=lambda: frozen(np.zeros(3)))
    inertia: Floats = field(default_factory=lambda: frozen(np.zeros((3, 3))))
    __post_init__ = check_fields(mass=not_negative, center=in_space, inertia=_inertia)


@dataclass(frozen=True, eq=False)
class BodyLoad:
    """A force and a moment from outside on a body.

    Attributes:
        body: its name.
        force, moment: (3,) [N], [N m].
        at: (3,) point of the body at which the force acts, where it is drawn [m].
        follows: whether both turn with the body; else they keep their directions.
    """

    body: str
    force: Floats = field(default_factory=lambda: frozen(np.zeros(3)))
    at: Floats = field(default_factory=lambda: frozen(np.zeros(3)))
    moment: Floats = field(default_factory=lambda: frozen(np.zeros(3)))
    follows: bool = False
    __post_init__ = check_fields(force=in_space, at=in_space, moment=in_space)


@dataclass(frozen=True, eq=False)
class LinkageLoads:
    """What bears on a linkage.

    Attributes:
        masses, loads: of its bodies.
        gravity: (3,) acceleration [m/s^2].
    """

    masses: Sequence[BodyMass] = ()
    loads: Sequence[BodyLoad] = ()
    gravity: Floats = field(default_factory=lambda: frozen(GRAVITY))
    __post_init__ = check_fields(gravity=in_space)

    def __bool__(self) -> bool:
        return bool(len(self.masses) or len(self.loads))

    def require_bodies(self, linkage: Linkage) -> None:
        """Refuse masses and loads of bodies that a linkage has not.

        Raises:
            ModelError: the sentence names the body.
        """
        for each in (*self.masses, *self.loads):
            if each.body not in linkage.bodies:
                raise ModelError("mobility.no_such_body", body=each.body, known=", ".join(linkage.bodies))

    def displace(self, bodies: Sequence[str], T: Floats) -> LinkageLoads:
        """The same of bodies that are drawn elsewhere, displaced by T (N, 4, 4)."""

        def of(body: str) -> Floats:
            return T[bodies.index(body)]

        masses = [
            replace(
                each, center=of(each.body)[:3, :3] @ each.center + of(each.body)[:3, 3],
                inertia=of(each.body)[:3, :3] @ each.inertia @ of(each.body)[:3, :3].T,
            )
            for each in self.masses
        ]  # fmt: skip
        loads = [replace(each, at=of(each.body)[:3, :3] @ each.at + of(each.body)[:3, 3]) for each in self.loads]
        return replace(self, masses=masses, loads=loads)
