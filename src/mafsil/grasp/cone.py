"""Friction cones as they are, round: what finitely many wrenches cannot say is asked of the support function.

A contact with unit push gives the wrenches B (1, mu d, tau), |d| <= 1, |tau| <= gamma; in the direction y they reach

  h(y) = g_n + mu |g_t| + gamma |g_tau|,  g = B' y
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.grasp import loops
from mafsil.grasp.contact import Contact


def furthest(contact: Contact, g: Floats) -> Floats:
    """Contact force with unit push, in components of the contact's basis, that goes furthest along g.

    Args:
        contact: where.
        g: (k,) direction in the same components.
    """
    best = np.zeros(len(g))
    best[0] = 1.0
    d = contact.dimension
    if contact.mu > 0 and (size := float(np.linalg.norm(g[1:d]))) > 0:
        best[1:d] = contact.mu * g[1:d] / size
    if contact.model == "soft":
        best[3] = contact.gamma * (1.0 if g[3] >= 0 else -1.0)
    return best


@dataclass(frozen=True, eq=False)
class ConeWrenches:
    """Wrenches of unit push at each contact, a disc (in the plane a segment) for each.

    Their hull is what total push 1 can give.

    Attributes:
        discs: (contacts, 4, m) centre, two friction directions, torsion; as in `solvers.hull_growth_loops`.
    """

    discs: Floats

    @staticmethod
    def of(contacts: Sequence[Contact], transform: Floats) -> ConeWrenches:
        """The set of some contacts.

        Args:
            contacts: of the grasp.
            transform: (m, m) applied to the wrenches: change of frame and units.
        """
        found = np.empty((len(contacts), 4, len(transform)))
        points, normals = np.array([c.point for c in contacts]), np.array([c.normal for c in contacts])
        coefficients = np.array([(c.mu, c.gamma) for c in contacts])
        loops.disc_loops.contact_discs(points, normals, coefficients, np.ascontiguousarray(transform), found)
        return ConeWrenches(found)

    def rim(self, edges: int) -> Floats:
        """(m, contacts edges) points on the rims of the discs, torsion to and fro in turn.

        Args:
            edges: points of each disc.
        """
        columns = np.empty((self.discs.shape[2], len(self.discs) * edges))
        loops.disc_loops.rim_columns(self.discs, edges, columns)
        return columns

    def transform(self, M: Floats) -> ConeWrenches:
        """The set in other coordinates.

        Args:
            M: (m, m) applied to the wrenches.
        """
        return ConeWrenches(self.discs @ M.T)

    def furthest(self, u: Floats) -> tuple[float, Floats]:
        """h(u) = max u . w over the set, and the wrench of each contact that goes furthest.

        Args:
            u: (m,) direction.

        Returns:
            h(u), wrenches (m, contacts).
        """
        along = self.discs @ u
        size = np.hypot(along[:, 1], along[:, 2])
        weight = np.ones_like(along)
        weight[:, 1:3] = along[:, 1:3] / np.where(size > 0, size, 1.0)[:, None]
        weight[:, 3] = np.where(along[:, 3] >= 0, 1.0, -1.0)
        points = np.einsum("kp,kpm->mk", weight, self.discs)
        return float((u @ points).max()), points


def has_round_cones(contacts: Sequence[Contact]) -> bool:
    """Whether some cone is not spanned by finitely many edges."""
    return any(contact.dimension == 3 and contact.mu > 0 for contact in contacts)
