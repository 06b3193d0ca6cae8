"""Screws and home pose of an arm, read from its mechanism: its product-of-exponentials description."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Vector6
from mafsil.errors import ModelError
from mafsil.model.exponentials import Screws, chain_to_tip
from mafsil.model.loading import of_mechanism
from mafsil.model.mechanism import Mechanism
from mafsil.model.placement import adjoint, inverse


@of_mechanism
def screws(mechanism: Mechanism) -> Screws:
    """Screw axes of the joints between base and tip, and the home pose.

    Args:
        mechanism: its chain to the tip may have fixed joints; branches beside the chain are left out. The order is
            that of the chain, which for an arm without branches is that of q.

    Raises:
        ModelError: a joint of the chain mimics another: its motion is no screw of its own.
    """
    T_sl = mechanism.T_sb
    columns: list[Vector6] = []
    for joint in chain_to_tip(mechanism):
        if joint.mimic is not None:
            raise ModelError("screws.mimic", joint=joint.name, leader=joint.mimic.leader)
        T_sl = T_sl @ joint.T_pj
        if joint.moves:
            columns.append(adjoint(T_sl) @ joint.screw)
    home = T_sl @ mechanism.T_lt
    S_s = np.reshape(columns, (-1, 6))
    return Screws(S_s, S_s @ adjoint(inverse(home)).T, home)
