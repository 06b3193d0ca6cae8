"""How many contacts closure needs at least, for any mix of frictionless, hard and soft ones.

The frictional contacts span V with signs. In the q = m - dim V directions that V leaves open only the frictionless
contacts act, each with one sense: at least q + 1 of them are needed there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.grasp.closure import conditioning
from mafsil.grasp.contact import Contact
from mafsil.grasp.tolerances import RANK


@dataclass(frozen=True, eq=False)
class ContactCount:
    """What the models of the contacts can span.

    Attributes:
        rows: m, 3 in the plane and 6 in space.
        frictional: contacts with friction.
        spanned: dim V of their wrenches.
        frictionless: contacts without friction.
        needed: least number of frictionless contacts beside these frictional ones; 0 if V is everything.
        open_directions: (m, q) basis of the wrenches y with y . w = 0 for every frictional contact.
    """

    rows: int
    frictional: int
    spanned: int
    frictionless: int
    needed: int
    open_directions: Floats

    @property
    def enough(self) -> bool:
        """Whether closure is possible at all; if not, no change of places, normals or coefficients helps."""
        return self.frictionless >= self.needed


def count_contacts(contacts: Sequence[Contact]) -> ContactCount:
    """Least numbers of contacts for closure.

    In general position: in the plane 4 frictionless, 1 hard and 2, 2 hard; in space 7, 1 hard and 4, 1 soft and 3, 2
    hard and 2, 3 hard, 1 soft and 1 hard, 2 soft.

    Args:
        contacts: at least one, all in the plane or all in space.
    """
    M = conditioning([c.point for c in contacts])
    m = len(M)
    rough = [M @ c.basis for c in contacts if c.mu > 0 or c.gamma > 0]
    free = sum(c.mu == 0 and c.gamma == 0 for c in contacts)
    rank, basis = 0, np.eye(m)
    if rough:
        U, s, _ = np.linalg.svd(np.hstack(rough), full_matrices=True)
        rank = int((s > RANK * s[0]).sum())
        basis = U[:, rank:]
    return ContactCount(m, len(rough), rank, free, 0 if rank == m else m - rank + 1, M.T @ basis)
