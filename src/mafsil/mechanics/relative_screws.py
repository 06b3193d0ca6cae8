"""How one body moves against another: screws of the joints between them, seen from a frame of the first.

Only the joints between count: what both bodies have in common towards the base moves neither against the other.
"""

from __future__ import annotations

from collections.abc import Sequence

import mafsil.expression as ex
from mafsil.mechanics.body_tree import Attachment, BodyTree
from mafsil.mechanics.placement import Expression, Placement, constant, pose_outward
from mafsil.mechanics.quantities.jacobian import joint_screw


def relative_screws(
    tree: BodyTree, steps: Sequence[Placement], frame: Attachment, body: int
) -> tuple[Expression, Expression, Expression]:
    """J (6, n) with V = J qd, the twist of an attached frame {c} against a body {b}, in {c}; and R_cb, p_cb.

    1. Inward from {c} to the body that both have in common: a joint there adds its screw.
    2. Outward to {b}: a joint there takes its screw away.

    Args:
        tree: of the bodies.
        steps: pose of each body in its parent.
        frame: {c}.
        body: index of {b}.
    """
    inward, outward = tree.path(frame.body), tree.path(body)
    shared = sum(1 for a, b in zip(inward, outward, strict=False) if a == b)
    columns: list[Expression] = [ex.zeros(6, 1) for _ in range(tree.n)]

    def add(i: int, sign: float, z: Expression, moment: Expression) -> None:
        own = tree.bodies[i]
        columns[own.coordinate] = columns[own.coordinate] + sign * steps[i].slopes[0] * joint_screw(own, z, moment)

    # 1.
    R, p = constant(frame.R), constant(frame.p)
    for i in reversed(inward[shared:]):
        add(i, 1.0, R[2, :].T, R.T @ ex.vertcat(-p[1], p[0], 0))
        R, p = ex.horzcat(*(steps[i].to_parent(R[:, k]) for k in range(3))), steps[i].offset + steps[i].to_parent(p)
    # 2.
    R, p = R.T, -(R.T @ p)
    for i in outward[shared:]:
        R, p = pose_outward(steps[i], R, p)
        add(i, -1.0, R[:, 2], ex.cross(p, R[:, 2]))
    return (ex.horzcat(*columns) if columns else ex.zeros(6, 0)), R, p
