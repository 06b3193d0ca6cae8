"""From a desired motion X(t) to the twists that a rate formula asks for."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector6, as_batch, positive, require_kind, single
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.ik.tolerances import SIXTH_ORDER

WEIGHTS = ((1, 45.0 / 60.0), (2, -9.0 / 60.0), (3, 1.0 / 60.0))
"""Central differences of sixth order."""


def twist_of_motion(X: Callable[[float], ArrayLike], t: float, *, step: float = SIXTH_ORDER) -> tuple[Vector6, Vector6]:
    """The body and the space twist of a motion at a time.

    [V_b] = X^-1 dX/dt,  [V_s] = dX/dt X^-1 = Ad(X) V_b

    Args:
        X: of the time [s], a pose (4, 4) in {s}.
        t: the time [s].
        step: of the central differences of log(X(t)^-1 X(t + h)) [s]; the motion must be smooth over three of them.

    Returns:
        V_b, V_s (6,) each [rad/s, m/s].

    Raises:
        InputError: no function, a pose of a wrong shape, a step that is not positive.
    """
    require_kind("X", X, "function of time", "__call__")
    h, time = positive("step", step), float(single("t", t, ()))
    here = single("X(t)", X(time), (4, 4))
    back = pose.inverse(here)
    V_b = np.zeros(6)
    for k, weight in WEIGHTS:
        ahead, behind = (single("X(t)", X(time + s * k * h), (4, 4)) for s in (1, -1))
        V_b += weight / h * (pose.log(back @ ahead) - pose.log(back @ behind))
    return V_b, pose.adjoint(here) @ V_b


def twists_between(poses: ArrayLike, times: ArrayLike) -> Floats:
    """(k - 1, 6) body twists that lead from each sample of a motion to the next exactly, constant over the step.

    V_b = log(X_k^-1 X_{k+1}) / (t_{k+1} - t_k)

    Args:
        poses: (k, 4, 4) in {s}.
        times: (k,) increasing [s].

    Raises:
        InputError: wrong shapes, times that do not increase.
    """
    X: PoseMatrix = as_batch("poses", poses, (4, 4), finite=True)
    if X.ndim != 3:
        raise InputError("input.shape", name="poses", expected="(k, 4, 4)", got=X.shape, hint="")
    clock = single("times", times, (len(X),))
    if (np.diff(clock) <= 0.0).any():
        raise InputError("ik.times", name="times", index=int((np.diff(clock) <= 0.0).argmax()) + 1)
    return pose.log(pose.inverse(X[:-1]) @ X[1:]) / np.diff(clock)[:, None]
