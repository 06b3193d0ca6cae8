"""Arguments of other kinds are refused in our words."""

import contextlib

import numpy as np
import pytest

import mafsil as mf
from mafsil import parallel

NONSENSE = (None, 3.5, np.inf, [np.nan], np.zeros((3, 5)), object(), [[1, 2], [3]], "x", {}, -1, 10**9)
TAKES = {
    "driven": lambda x: parallel.driven_rates(np.eye(3), x),
    "four-bar": lambda x: parallel.planar.output_angles(x, 0.1),
    "points": parallel.planar.singular_points,
    "file": parallel.read_parallel,
    "chain": parallel.ClosedChain,
    "robot": lambda x: parallel.closed_inverse_kinematics(x, np.eye(4)),
    "delta": lambda x: parallel.DeltaRobot(x, 0.1, 0.3, 0.8),
    "platform": lambda x: parallel.StewartPlatform(x, x),
}


@pytest.mark.parametrize("name", TAKES)
def test_nonsense_raises_nothing_foreign(name):
    for given in NONSENSE:
        with contextlib.suppress(mf.MafsilError):
            TAKES[name](given)
