"""Jacobians of closed chains: the twist of a link per rate of the driven joints, and what a wrench asks of them.

With the driven joints a, the passive ones p, the loops' rows J and the tree's Jacobian J_t of all joints:

    qd_p = G qd_a,   G = -J_p^+ J_a,   J_closed = J_t,a + J_t,p G,   tau_a = J_closed' F.

Reference: Lynch & Park, Modern Robotics, sec. 7.2; Murray, Li & Sastry, A Mathematical Introduction, sec. 3.5.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, Integers
from mafsil.errors import InputError
from mafsil.parallel.closed_terms import LoopConditions
from mafsil.parallel.tolerances import RANK
from mafsil.robot.closed_states import require_closed, row_name
from mafsil.solvers import decompositions

LEFT = 1e-6
"""Share of a rate that passive joints may leave over, or add where the driven ones rest: what typed digits leave."""


def closed_jacobian(
    chain: LoopConditions, q: ArrayLike, actuated: Integers, form: Literal["body", "space"], frame: str | None
) -> Floats:
    """(*batch, 6, a) twist of a frame per rate of the driven joints.

    1. Rates of the passive joints that keep the loops closed while one driven joint moves: the shortest.
    2. They leave nothing over: the driven joints can be moved independently.
    3. What they may have besides does not move the frame, as the spin of a rod does not.

    Args:
        chain: with loops.
        q: (*batch, n) coordinates that close the loops.
        actuated: (a,) the driven coordinates.
        form: whether the twist is that of the frame or of {s}.
        frame: link name; the tip frame if None.

    Raises:
        InputError: coordinates that open a loop, or at which the driven joints do not decide the frame's twist, or
            cannot be moved independently; which in the batch, is said.
        ModelError: no such frame.
    """
    tree = chain.robot
    require_closed(tree.mechanism, q)
    J = chain.terms(q).J
    passive = np.setdiff1d(np.arange(chain.n), actuated)
    # Columns count alike: a rate of a prismatic joint is taken over the size.
    scaled: Floats = (tree.jacobian_body if form == "body" else tree.jacobian_space)(q, frame=frame) * chain.unit
    own, others = J[..., actuated] * chain.unit[actuated], J[..., passive] * chain.unit[passive]
    # 1
    inverse = decompositions.pinv(others, RANK)
    G: Floats = -inverse @ own
    # 2
    apart = _largest(others @ G + own) > LEFT * np.maximum(_largest(own), 1.0)
    # 3
    idle = np.eye(len(passive)) - inverse @ others
    loose = _largest(scaled[..., passive] @ idle) > LEFT * np.maximum(_largest(scaled), 1.0)
    _require(chain, actuated, {"contradicted": apart, "undecided": loose})
    return (scaled[..., actuated] + scaled[..., passive] @ G) / chain.unit[actuated]


def _largest(A: Floats) -> Floats:
    """(*batch) largest entry; that of NaN is NaN, which no comparison finds wrong."""
    return np.abs(A).max(axis=(-1, -2), initial=0.0)


def _require(chain: LoopConditions, actuated: Integers, wrong: dict[str, NDArray[np.bool_]]) -> None:
    places: list[int] = actuated.tolist()
    for kind, rows in wrong.items():
        if np.any(rows):
            index = tuple(int(k) for k in np.argwhere(rows)[0])
            raise InputError(
                f"parallel.jacobian_{kind}", robot=chain.robot.name, row=row_name(index),
                driven=", ".join(chain.robot.joint_names[k] for k in places) or "-",
            )  # fmt: skip
