"""What a robot carries: a tool with its tip frame, and a payload; both become part of a link."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import PoseMatrix, real_array, require_finite, single
from mafsil.errors import InputError
from mafsil.model.link import Inertial
from mafsil.model.loading import RobotLike, as_mechanism
from mafsil.model.mass_properties import require_physical, united
from mafsil.model.mechanism import Mechanism
from mafsil.model.placement import checked_pose, moved_inertial


def with_tool(
    robot: RobotLike,
    tool: ArrayLike | None = None,
    *,
    mass: float = 0.0,
    com: ArrayLike = (0.0, 0.0, 0.0),
    inertia: ArrayLike | None = None,
    link: str | None = None,
) -> Mechanism:
    """The robot with a tool mounted: a new tip frame, and the tool's mass on the link that carries it.

    Args:
        robot: a Robot, a Mechanism, a name of the library or a file.
        tool: pose (4, 4) of the new tip frame in the frame on which the tool is mounted, or its origin (3,) [m] alone;
            the mounting frame itself if None.
        mass: of the tool [kg].
        com: (3,) centre of mass [m] in the mounting frame.
        inertia: (3, 3) about the centre of mass, axes as the mounting frame [kg m^2]; zero (a point mass) if None.
        link: the tool is mounted on this link, in its frame; on the present tip frame if None.

    Raises:
        InputError: wrong shapes, NaN or infinities.
        ModelError: an unknown link, a matrix that is no pose, mass properties that no body has.
    """
    mechanism = with_payload(robot, mass, com=com, inertia=inertia, link=link)
    T_lm = mechanism.T_lt if link is None else np.eye(4)
    T_mt = np.eye(4) if tool is None else _pose("tool", tool)
    return mechanism.with_tip(mechanism.tip if link is None else link, T_lm @ T_mt)


def with_payload(
    robot: RobotLike,
    mass: float,
    *,
    com: ArrayLike = (0.0, 0.0, 0.0),
    inertia: ArrayLike | None = None,
    link: str | None = None,
) -> Mechanism:
    """The robot with a body fixed to it; the tip frame stays.

    Args:
        robot: a Robot, a Mechanism, a name of the library or a file.
        mass: of the body [kg].
        com: (3,) centre of mass [m] in the tip frame, or in the frame of `link`.
        inertia: (3, 3) about the centre of mass, axes as that frame [kg m^2]; zero (a point mass) if None.
        link: that carries the body, in whose frame the numbers are; the tip frame if None.

    Raises:
        InputError: wrong shapes, NaN or infinities, a negative mass.
        ModelError: an unknown link, mass properties that no body has.
    """
    mechanism = as_mechanism(robot)
    carrier = mechanism.link(mechanism.tip if link is None else link)
    kilograms = float(single("mass", mass, ()))
    if kilograms < 0.0:
        raise InputError("input.range", name="mass", value=kilograms, low=0.0, high=np.inf)
    own = np.zeros((3, 3)) if inertia is None else single("inertia", inertia, (3, 3))
    body = Inertial(kilograms, single("com", com, (3,)), own)
    if own.any():
        require_physical(body)
    if not kilograms:
        return mechanism
    if link is None:
        body = moved_inertial(body, mechanism.T_lt)
    loaded = replace(carrier, inertial=united(carrier.inertial, body))
    return replace(mechanism, links=tuple(loaded if item is carrier else item for item in mechanism.links))


def _pose(name: str, value: ArrayLike) -> PoseMatrix:
    """A pose (4, 4), or the origin of one."""
    array = real_array(name, value)
    if array.shape == (3,):
        T = np.eye(4)
        T[:3, 3] = require_finite(name, array)
        return T
    if array.shape != (4, 4):
        raise InputError("input.shape", name=name, expected="(4, 4) or (3,)", got=array.shape, hint="")
    return checked_pose(name, array)
