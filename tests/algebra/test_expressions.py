"""Expressions evaluated by CasADi itself, without the kernels: the same numbers, whatever is in the cache."""

from __future__ import annotations

from functools import cache
from math import pi

import mpmath as mp
import numpy as np
import pytest

from mafsil.algebra.euler_sequence import SEQUENCES
from mafsil.algebra.membership import function
from mafsil.geometry import euler, pose, rotation, screw

EPS = 2.0**-52


@cache
def built(source: str, inputs: tuple, outputs: tuple, constants: tuple = ()) -> object:
    return function(source, inputs, outputs, None, constants)


@pytest.mark.capability("04-44")
@pytest.mark.parametrize("sequence", sorted(SEQUENCES))
def test_euler_expressions(sequence: str):
    angles = np.array([0.4, -1.1, 2.2])
    matrix = built("euler.matrix", (("a", (3,)),), (("R", (3, 3)),), (sequence,))
    both = built("euler.angles", (("R", (3, 3)),), (("a", (2, 3)),), (sequence,))
    rates = built("euler.rate_matrix", (("a", (3,)),), (("E", (3, 3)),), (sequence,))
    turn = built("euler.to_quaternion", (("a", (3,)),), (("q", (4,)),), (sequence,))
    R = np.array(matrix(angles)).reshape(3, 3)
    assert np.abs(R - rotation.from_euler(angles, sequence)).max() <= 2 * EPS
    for row in np.array(both(R.ravel())).reshape(2, 3):
        assert np.abs(np.array(matrix(row)).reshape(3, 3) - R).max() <= 16 * EPS
    assert (
        np.abs(np.array(rates(angles)).reshape(3, 3) - euler.rates_to_angular_velocity(angles, sequence)).max()
        <= 4 * EPS
    )
    assert np.abs(np.array(turn(angles)).ravel() - euler.quaternion_from_euler(angles, sequence)).max() <= 4 * EPS


@pytest.mark.capability("04-92", "04-95")
@pytest.mark.parametrize("amount", [0.0, 1e-300, 1e-12, 1e-9, 1e-8, 1e-4, 0.3, pi - 1e-9, pi, 5.0])
def test_displacement_of_a_unit_screw_needs_no_switch(amount: float):
    S = screw.from_axis([2.0, -1.0, 2.0], [0.3, 0.2, -0.5], 0.1)
    call = built("screw.displacement", (("S", (6,)), ("q", ())), (("T", (4, 4)),))
    T = np.array(call(S, amount)).reshape(4, 4)
    assert np.abs(T - pose.exp(S * amount)).max() <= 4 * EPS * max(1, amount)
    with mp.workdps(60):
        s = [mp.mpf(float(x)) for x in S]
        A = mp.matrix([[0, -s[2], s[1], s[3]], [s[2], 0, -s[0], s[4]], [-s[1], s[0], 0, s[5]], [0, 0, 0, 0]])
        exact, term = mp.eye(4), mp.eye(4)
        for k in range(1, 80):
            term = term * A * mp.mpf(amount) / k
            exact += term
        p = [float(abs(mp.mpf(float(T[i, 3])) - exact[i, 3])) for i in range(3)]
    assert max(p) <= 8 * EPS * amount


def test_displacement_along_a_translation():
    call = built("screw.displacement", (("S", (6,)), ("q", ())), (("T", (4, 4)),))
    T = np.array(call(np.array([0, 0, 0, 0, 0.6, 0.8]), 2.0)).reshape(4, 4)
    assert np.array_equal(T, pose.from_translation([0, 1.2, 1.6]))
