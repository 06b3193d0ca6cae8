"""Inertial parameters as vectors: ten numbers a link, in which joint efforts are linear."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, frozen
from mafsil.mechanics.tolerances import DEPENDENT
from mafsil.model import Inertial, Mechanism
from mafsil.model.joint import require_lines

LABELS = ("m", "hx", "hy", "hz", "Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz")
"""Mass, first moment, inertia about the origin of the frame; products with the minus sign inside."""


@dataclass(frozen=True, eq=False, slots=True)
class BaseParameters:
    """The fewest numbers that determine all joint efforts.

    Attributes:
        labels: the k independent parameters, such as "link3.Ixx"; each stands for itself plus what it absorbs.
        columns: (k,) their places among the 10 L.
        combination: (k, 10 L): base values = combination @ all parameters.
        silent: parameters that no motion of this robot can tell.
    """

    labels: tuple[str, ...]
    columns: tuple[int, ...]
    combination: Floats
    silent: tuple[str, ...]

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.labels)


def parameters_of(inertial: Inertial | None) -> Floats:
    """(10,) of a body in its frame; zeros for None."""
    if inertial is None:
        return np.zeros(10)
    m, c = inertial.mass, inertial.com
    I = inertial.inertia + m * (c @ c * np.eye(3) - np.outer(c, c))
    return np.array([m, *(m * c), I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]])


def inertial_of(parameters: ArrayLike) -> Inertial:
    """The body with these (10,) parameters; a mass of zero puts the centre of mass at the origin."""
    m, hx, hy, hz, xx, yy, zz, xy, xz, yz = as_batch("parameters", parameters, (10,), finite=True)
    c = np.array([hx, hy, hz]) / m if m else np.zeros(3)
    about_origin = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Inertial(float(m), frozen(c), frozen(about_origin - m * (c @ c * np.eye(3) - np.outer(c, c))))


def moved_parameters(parameters: Floats, R: Floats, p: Floats) -> Floats:
    """(*batch, 10) of bodies seen from a frame in which their present frame has the pose (R, p): linear in them.

    Args:
        parameters: (*batch, 10) in their present frame.
        R, p: (3, 3), (3,) pose of that frame in the new one.
    """
    mass, h = parameters[..., 0, None], parameters[..., 1:4] @ R.T
    xx, yy, zz, xy, xz, yz = np.moveaxis(parameters[..., 4:], -1, 0)
    I = np.stack([np.stack(row, -1) for row in ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))], -2)
    g = 2.0 * h + mass * p
    shift = (g @ p)[..., None, None] * np.eye(3) - (g[..., :, None] * p + p[:, None] * g[..., None, :]) / 2.0
    I = R @ I @ R.T + shift
    six = [I[..., i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    return np.concatenate([mass, h + mass * p, np.stack(six, -1)], axis=-1)


def inertial_parameters(mechanism: Mechanism) -> Floats:
    """(L, 10) parameters of all links, each in its own frame, in the order of `mechanism.links`."""
    return np.array([parameters_of(link.inertial) for link in mechanism.links])


def reflected_inertias(mechanism: Mechanism) -> Floats:
    """(n,) inertia [kg m^2 | kg] that rotors add to the diagonal of the mass matrix, through the square of the gear.

    Raises:
        ModelError: a joint with a rotor follows another along a curve.
    """
    require_lines(joint for joint in mechanism.joints if joint.actuator and joint.actuator.reflected_inertia)
    place = {joint.name: k for k, joint in enumerate(mechanism.coordinates)}
    reflected = np.zeros(mechanism.n)
    for joint in mechanism.joints:
        if joint.moves and joint.actuator is not None:
            leader, multiplier = (joint.mimic.leader, joint.mimic.multiplier) if joint.mimic else (joint.name, 1.0)
            reflected[place[leader]] += multiplier**2 * joint.actuator.reflected_inertia
    return reflected


def base_parameters(mechanism: Mechanism, regressors: Floats) -> BaseParameters:
    """Base parameters from the regressor at many states.

    Args:
        mechanism: names of the links.
        regressors: (N, n, L, 10) at N states rich enough, such as random ones.

    Reference: as `independent_parameters`.
    """
    labels = tuple(f"{link.name}.{label}" for link in mechanism.links for label in LABELS)
    return independent_parameters(labels, regressors.reshape(-1, len(labels)))


def independent_parameters(labels: tuple[str, ...], W: Floats) -> BaseParameters:
    """The parameters that a linear model can tell from each other.

    Columns are taken in order and kept where they are not combinations of those before; from the base outward this is
    the numerical counterpart of moving inertia towards the base.

    Args:
        labels: P names.
        W: (rows, P) the model at states rich enough, such as random ones.

    Reference: Gautier, Numerical calculation of the base inertial parameters of robots, J. Robotic Systems 8, 1991.
    """
    size = np.linalg.norm(W, axis=0)
    threshold = DEPENDENT * float(size.max(initial=0.0))
    basis, kept = np.zeros((len(W), 0)), list[int]()
    for k in np.flatnonzero(size > threshold):
        rest = W[:, k] / size[k]
        for _ in range(2):
            rest = rest - basis @ (basis.T @ rest)
        length = float(np.linalg.norm(rest))
        if length > DEPENDENT:
            basis = np.column_stack([basis, rest / length])
            kept.append(int(k))
    scaled = cast("Floats", np.linalg.lstsq(W[:, kept] / size[kept], W, rcond=None)[0])
    combination = scaled / size[kept, None]
    combination[np.abs(combination) < DEPENDENT] = 0.0
    silent = tuple(label for label, column in zip(labels, combination.T, strict=True) if not column.any())
    return BaseParameters(tuple(labels[k] for k in kept), tuple(kept), frozen(combination), silent)
