"""Friction cones as they are, round: what finitely many wrenches cannot say is asked of the support function.

A contact with unit push gives the wrenches B (1, mu d, tau), |d| <= 1, |tau| <= gamma; in the direction y they reach

  h(y) = g_n + mu |g_t| + gamma |g_tau|,  g = B' y
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mafsil.arrays import Floats
from mafsil.grasp.ball import Support
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


def support(contacts: Sequence[Contact], transform: Floats, *, together: bool = False) -> Support:
    """Support function of all wrenches with total push 1, or with push up to 1 at each contact.

    Args:
        contacts: of the grasp.
        transform: (m, m) applied to the wrenches: change of frame and units.
        together: each contact pushes up to 1 on its own (sum of the sets) instead of 1 in total (hull of their union).
    """
    bases = [transform @ contact.basis for contact in contacts]

    def reach(u: Floats) -> tuple[float, Floats]:
        points = np.column_stack([B @ furthest(contact, B.T @ u) for contact, B in zip(contacts, bases, strict=True)])
        heights = u @ points
        if not together:
            return float(heights.max()), points
        total = points @ (heights > 0)
        return float(u @ total), total[:, None]

    return reach


def has_round_cones(contacts: Sequence[Contact]) -> bool:
    """Whether some cone is not spanned by finitely many edges."""
    return any(contact.dimension == 3 and contact.mu > 0 for contact in contacts)
