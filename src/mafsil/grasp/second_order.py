"""Second order: a plane body that first order leaves free can still be held by the curvature at its contacts.

Along a first-order free motion y = (omega, v) the distance at contact i opens like s^2/2 times

  d_i'' = (k v_t - omega)(omega + kappa v_t) / (k + kappa)

with the tangential velocity v_t of the contact point, the curvature kappa of the body and k of the finger. Under an
equilibrium of pushes x > 0, the body is held if sum x_i d_i'' < 0 for every free motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.grasp.contact import Contact
from mafsil.grasp.grasp import Grasp
from mafsil.grasp.routes import positive_span
from mafsil.messages import say

NEGATIVE = 1e-9


class Immobility(Enum):
    """What holds the body; the values are keys of sentences."""

    FIRST_ORDER = "grasp.first_order"
    SECOND_ORDER = "grasp.second_order"
    NOT_SHOWN = "grasp.not_immobile"
    NO_EQUILIBRIUM = "grasp.no_equilibrium"

    @property
    def immobile(self) -> bool:
        """Whether the body is proven to be held."""
        return self in (Immobility.FIRST_ORDER, Immobility.SECOND_ORDER)

    def sentence(self, language: str | None = None) -> str:
        """The finding in words."""
        return say(self.value, language=language)


@dataclass(frozen=True, eq=False)
class SecondOrder:
    """The finding and its numbers.

    Attributes:
        immobility: first order, second order, or not shown.
        pushes: (n,) equilibrium of pushes used, sum 1.
        motions: (k, 3) orthonormal basis of first-order free motions.
        form: (k, k) quadratic form sum x_i d_i'' on that basis; negative definite proves immobility.
    """

    immobility: Immobility
    pushes: Floats
    motions: Floats
    form: Floats


def second_order(grasp: Grasp) -> SecondOrder:
    """Is a plane body held without friction, if not to first order then by curvature?

    Args:
        grasp: plane; curvatures of body and fingers as the contacts tell.

    Raises:
        InputError: in space.

    Reference:
        E. Rimon, J. W. Burdick, Mobility of bodies in contact, IEEE Trans. Robotics and Automation 14(5), 1998.
    """
    if grasp.dimension != 2:
        raise InputError("grasp.needs_plane", what="second_order")
    A = grasp.normals_matrix
    none = np.zeros((0, 3))
    if grasp.form_closure():
        return SecondOrder(Immobility.FIRST_ORDER, np.zeros(len(grasp)), none, np.zeros((0, 0)))
    span = positive_span(A)
    if span.evidence is None or not span.value > NEGATIVE:
        return SecondOrder(Immobility.NO_EQUILIBRIUM, np.zeros(len(grasp)), none, np.zeros((0, 0)))
    x = _equilibrium(A)
    U, s, _ = np.linalg.svd(A)
    motions = U[:, int((s > 1e-10 * s[0]).sum()) :].T
    parts = [_opening(contact, motions) for contact in grasp.contacts]
    form = np.einsum("i,ijk->jk", x, np.array([part for part, _ in parts]))
    size = float(x @ np.array([size for _, size in parts]))
    held = bool(np.linalg.eigvalsh(form).max() < -NEGATIVE * size)
    return SecondOrder(Immobility.SECOND_ORDER if held else Immobility.NOT_SHOWN, x, motions, form)


def _equilibrium(A: Floats) -> Floats:
    """Pushes of sum 1, all positive, as even as they can be."""
    from mafsil.solvers.linear_program import minimise

    m, n = A.shape
    equal = np.vstack([np.column_stack([A, A.sum(axis=1)]), np.append(np.ones(n), n)])
    best = minimise(np.append(np.zeros(n), -1.0), equal, np.append(np.zeros(m), 1.0))
    assert best is not None, "an equilibrium was found before"
    return best.x[:n] + best.x[n]


def _opening(contact: Contact, motions: Floats) -> tuple[Floats, float]:
    """(k, k) symmetric form of d'' on the basis, and the size of the terms that may cancel in it."""
    omega = motions[:, 0]
    velocity = motions[:, 1:] + omega[:, None] * np.array([-contact.point[1], contact.point[0]])
    sideways = velocity @ contact.tangents[0]
    kappa, k = contact.curvature, contact.finger_curvature
    if np.isinf(k):
        a, b = sideways, omega + kappa * sideways
    else:
        if k + kappa <= 0:
            raise InputError("grasp.curvatures", body=kappa, finger=k)
        a, b = (k * sideways - omega) / (k + kappa), omega + kappa * sideways
    size = float(np.linalg.norm(a) * (np.linalg.norm(omega) + np.linalg.norm(kappa * sideways)))
    return 0.5 * (np.outer(a, b) + np.outer(b, a)), size
