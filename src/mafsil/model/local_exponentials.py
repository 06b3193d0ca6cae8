"""Local product of exponentials: T(q) = M_1 exp([A_1] q_1) ... M_n exp([A_n] q_n) tool, between tables and screws.

Constants move through exponentials by M exp([A] q) M^-1 = exp([Ad(M) A] q), so S_i = Ad(M_1 ... M_i) A_i.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Unpack

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, as_batch
from mafsil.errors import ModelError
from mafsil.model.denavit_hartenberg import Convention
from mafsil.model.dh_from_axes import DHTable, screws
from mafsil.model.exponentials import ArmParts, Screws, chain_to_tip, mechanism_from_screws
from mafsil.model.loading import of_mechanism
from mafsil.model.mechanism import Mechanism
from mafsil.model.placement import adjoint, checked_pose, inverse, screw_motion


class LocalScrews(NamedTuple):
    """Parameters of a local product of exponentials.

    Attributes:
        M: (n, 4, 4) constant poses of each joint's frame in the one before; the base pose is in the first.
        A: (n, 6) screw axis (omega, v) of each joint in its own frame.
        tool: (4, 4) pose of the tip in the last frame.
    """

    M: PoseMatrix
    A: Floats
    tool: PoseMatrix


@of_mechanism
def local_screws(mechanism: Mechanism) -> LocalScrews:
    """The local form of the chain to the tip, in the frames of the mechanism's own joints.

    Args:
        mechanism: fixed joints on the chain are multiplied into the constants.

    Raises:
        ModelError: a joint of the chain mimics another.
    """
    before, constants, axes = np.asarray(mechanism.T_sb), list[PoseMatrix](), list[Floats]()
    for joint in chain_to_tip(mechanism):
        if joint.mimic is not None:
            raise ModelError("screws.mimic", joint=joint.name, leader=joint.mimic.leader)
        before = before @ joint.T_pj
        if joint.moves:
            constants.append(before)
            axes.append(joint.screw)
            before = np.eye(4)
    return LocalScrews(np.reshape(constants, (-1, 4, 4)), np.reshape(axes, (-1, 6)), before @ mechanism.T_lt)


def local_screws_of_table(table: DHTable) -> LocalScrews:
    """The local form of a table: M_i its link transforms at q = 0, A_i = (0,0,1,0,0,0) or (0,0,0,0,0,1).

    A classic table has its axes one frame earlier; its last transform becomes part of the tool.

    Args:
        table: in either convention.
    """
    links = [row.transform(table.convention) for row in table.rows]
    about_z, along_z = [0.0, 0, 1, 0, 0, 0], [0.0, 0, 0, 0, 0, 1]
    axes = np.array([about_z if row.kind == "R" else along_z for row in table.rows])
    if table.convention is Convention.MODIFIED:
        return LocalScrews(np.stack([table.base @ links[0], *links[1:]]), axes, np.asarray(table.tool))
    return LocalScrews(np.stack([np.asarray(table.base), *links[:-1]]), axes, links[-1] @ table.tool)


def mechanism_from_local_screws(
    M: Sequence[ArrayLike], A: ArrayLike, tool: ArrayLike | None = None, **parts: Unpack[ArmParts]
) -> Mechanism:
    """The serial arm of a local product of exponentials.

    Args:
        M: n poses (4, 4).
        A: (n, 6) unit screws in the frames that M leads to.
        tool: (4, 4); identity if None.
        **parts: as in `mechanism_from_screws`.

    Raises:
        ModelError: as many poses as screws are not given, a pose is none, a screw is not of unit length.
    """
    axes = np.atleast_2d(as_batch("A", A, (6,), finite=True))
    if len(M) != len(axes):
        raise ModelError("serial.length", name="M", got=len(M), expected=len(axes))
    before, space = np.eye(4), list[Floats]()
    for i, (constant, axis) in enumerate(zip(M, axes, strict=True)):
        before = before @ checked_pose(f"M[{i}]", constant)
        space.append(adjoint(before) @ axis)
    end = before if tool is None else before @ checked_pose("tool", tool)
    return mechanism_from_screws(np.reshape(space, (-1, 6)), end, **parts)


@of_mechanism
def shift_zero(mechanism: Mechanism, q0: ArrayLike) -> Screws:
    """Screws and home pose when the configuration q0 is called zero: T(q) = exp([S'_1] (q_1 - q0_1)) ... home'.

    S'_i = Ad(exp([S_1] q0_1) ... exp([S_i-1] q0_i-1)) S_i, home' = T(q0).

    Args:
        mechanism: its chain to the tip.
        q0: (n,) coordinates of the chain's joints [rad | m].

    Raises:
        ModelError: a joint of the chain mimics another.
        InputError: not one finite number per joint.
    """
    S_s, _, home = screws(mechanism)
    values = as_batch("q0", q0, (len(S_s),), finite=True)
    T, moved = np.eye(4), list[Floats]()
    for S, value in zip(S_s, values, strict=True):
        moved.append(adjoint(T) @ S)
        T = T @ screw_motion(S, float(value))
    S_new, home = np.reshape(moved, (-1, 6)), T @ home
    return Screws(S_new, S_new @ adjoint(inverse(home)).T, home)
