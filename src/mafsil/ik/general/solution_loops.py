"""The compiled loop: all solutions of six joints for a batch of poses, with a certificate for each.

Imported only where poses are solved: numba is loaded with it.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false, reportUntypedNamedTuple=false
from __future__ import annotations

from math import atan2, cos, hypot, pi, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.ik.general.circle_loops import CELLS, ORDER, harmonics, zeros_on_circle
from mafsil.ik.general.elimination_loops import determinants, eliminated, inner_joints, outer_joints
from mafsil.ik.general.image_loops import coefficients_of, fitted_circle, turned_circle
from mafsil.ik.general.polish_loops import CLOSED, STEPS, last_joint, noted, polished, twins
from mafsil.solvers.loops import compiled

CANDIDATES = 48
"""Zeros of one determinant that are looked at."""

ROUNDING = 2.0**-52

DISTURBANCE = 1e-10
"""Of the equations, relative, by which the effect of rounding is measured."""


class Arm(NamedTuple):
    """Constants of an arm; those of the roads have one row for each road.

    Attributes:
        joints, backwards, before, lines, after, products, left, unit: constants of the roads.
        frames: (7, 3, 4) the chain as frames between joints that move about or along z.
        slides: (6,) which joints slide.
        fourier: (nodes, nodes) from samples of the determinant to its coefficients, and to those that must be zero.
        degree: of the trigonometric polynomial.
        twist: where the half angle of joint d is zero.
        turns: (t,) turns of that half angle that are tried.
    """

    joints: NDArray[np.int64]
    backwards: NDArray[np.bool_]
    before: Floats
    lines: NDArray[np.int64]
    after: Floats
    products: Floats
    left: Floats
    unit: Floats
    frames: Floats
    slides: NDArray[np.bool_]
    fourier: Floats
    degree: int
    twist: float
    turns: Floats


class Room(NamedTuple):
    """Arrays to work in, and the nodes of the circle; one for each thread."""

    cosines: Floats
    sines: Floats
    angles: Floats
    image_cosines: Floats
    image_sines: Floats
    weights: Floats
    disturbed: Floats
    kept: Floats
    changes: Floats
    disturbance: Floats
    C: Floats
    Q: Floats
    A: Floats
    beta: Floats
    M: Floats
    K: Floats
    v: Floats
    f: Floats
    m: Floats
    s: Floats
    out: Floats
    x: Floats
    J: Floats
    T: Floats
    form: Floats
    last: Floats
    ab: Floats
    coefficients: Floats
    zeros: Floats
    t: Floats
    stack: Floats
    q: Floats


@compiled
def room(nodes, degree):
    """Room for determinants sampled at so many nodes."""
    angles = 2 * pi / nodes * np.arange(nodes)
    return Room(
        np.cos(angles), np.sin(angles), angles, np.empty(nodes), np.empty(nodes), np.empty(nodes),
        np.empty((6, 27)), np.empty(nodes), np.empty((2, degree + 1)), np.cos(np.arange(162.0) ** 2).reshape(6, 27),
        np.empty((14, 9)), np.empty((14, 15)), np.empty((6, 27)), np.empty(16), np.empty((6, 9, nodes)),
        np.empty((6, 6, nodes)), np.empty((3, nodes)), np.empty(nodes), np.empty((6, 9)), np.empty((6, 6)),
        np.empty(5), np.empty(14), np.empty((6, 7)), np.empty((2, 3, 4)), np.empty(3), np.empty(3), np.empty(2),
        np.empty((2, degree + 1)), np.empty(CANDIDATES), np.empty((ORDER + 2, CELLS)), np.empty((64, ORDER + 3)),
        np.empty(6),
    )  # fmt: skip


@compiled
def sampled(X, arm, w, road):
    """Coefficients of the determinant from samples on the circle; the largest of those that must be zero.

    Arguments as the attributes of `Arm` and `Room` in `solution_loops`.
    """
    eliminated(
        X, arm.before[road], arm.lines[road], arm.after[road], arm.products[road], arm.left[road], arm.unit[road],
        w.C, w.Q, w.A, w.beta,
    )  # fmt: skip
    determinants(w.A, w.cosines, w.sines, len(w.angles), w.M, w.K, w.v, w.f)
    return coefficients_of(w.f, arm.fourier, arm.degree, w.coefficients)


@compiled
def sampled_again(arm, w):
    """The same on an image of the circle that evens out samples of different size: its centre, squeeze and dust."""
    nodes = len(w.angles)
    centre, squeeze = fitted_circle(w.f, arm.degree, w.angles)
    turned_circle(centre, squeeze, arm.degree, w.angles, w.image_cosines, w.image_sines, w.weights)
    determinants(w.A, w.image_cosines, w.image_sines, nodes, w.M, w.K, w.v, w.f)
    for l in range(nodes):
        w.f[l] *= w.weights[l]
    dust = coefficients_of(w.f, arm.fourier, arm.degree, w.coefficients)
    return centre, squeeze, dust + _rounding(arm, w)


@compiled
def _rounding(arm, w):
    """What rounding in the equations does to the coefficients, measured by a larger disturbance."""
    nodes = len(w.angles)
    for r in range(6):
        most = 0.0
        for j in range(27):
            most = max(most, abs(w.A[r, j]))
        for j in range(27):
            w.disturbed[r, j] = w.A[r, j] + DISTURBANCE * most * w.disturbance[r, j]
    for l in range(nodes):
        w.kept[l] = w.f[l]
    determinants(w.disturbed, w.image_cosines, w.image_sines, nodes, w.M, w.K, w.v, w.f)
    for l in range(nodes):
        w.f[l] = w.f[l] * w.weights[l] - w.kept[l]
    coefficients_of(w.f, arm.fourier, arm.degree, w.changes)
    small, large, total = 1e300, 0.0, 0.0
    for k in range(8):
        small, large = min(small, abs(w.beta[8 + k])), max(large, abs(w.beta[8 + k]))
    for k in range(arm.degree + 1):
        total += abs(w.changes[0, k]) + abs(w.changes[1, k])
    return 0.5 * ROUNDING / DISTURBANCE * (1 + large / (small + 1e-300)) * total


@compiled
def candidate(P, arm, w, road, zero, turn):
    """All six joints that go with a zero of the determinant, into w.q; how well the zero determines them.

    Arguments as the attributes of `Arm` and `Room` in `solution_loops`.
    """
    j, q, slides = arm.joints[road], w.q, arm.slides
    rank = inner_joints(w.A, zero, turn, w.m, w.s, w.out)
    c, s = w.out[0], w.out[1]
    q[j[2]] = zero
    if slides[j[3]]:
        q[j[3]] = s / (c if c != 0.0 else 1e-300) - arm.twist
        scale = 1.0 / (c * c if c != 0.0 else 1e-300)
        w.form[0], w.form[1], w.form[2] = 1.0, c * s * scale, s * s * scale
    else:
        q[j[3]] = arm.twist + 2 * atan2(s, c)
        w.form[0], w.form[1], w.form[2] = c * c, c * s, s * s
    if slides[j[4]]:
        value = w.out[3] / (w.out[2] if w.out[2] != 0.0 else 1e-300)
        w.last[0], w.last[1], w.last[2] = 1.0, value, value * value
        q[j[4]] = value
    else:
        sign = 1.0 if w.out[2] > 0 else -1.0
        length = hypot(w.out[3], w.out[4]) * sign + 1e-300
        w.last[0], w.last[1], w.last[2] = 1.0, w.out[3] / length, w.out[4] / length
        q[j[4]] = atan2(w.last[2], w.last[1])
    outer_joints(w.C, w.beta, arm.left[road], zero, w.form, w.last, slides[j[0]], slides[j[1]], w.x, w.ab)
    q[j[0]], q[j[1]] = w.ab[0], w.ab[1]
    q[j[5]] = last_joint(arm.frames, slides, P, q, j[5], w.T)
    return rank


@compiled
def explored(P, arm, w, road, zero, found, q_out, size_out):
    """Solutions that a zero leads to; their number then, and whether one of them explains the zero.

    Arguments as the attributes of `Arm` and `Room` in `solution_loops`.
    """
    third, hit = arm.joints[road, 2], False
    for t in range(len(arm.turns)):
        rank = candidate(P, arm, w, road, zero, arm.turns[t])
        size = polished(arm.frames, arm.slides, P, w.q, STEPS, w.J, w.T)
        if size < CLOSED:
            # The solution must be that of this zero, else the zero is not explained.
            away = w.q[third] - zero
            away -= 2 * pi * np.round(away / (2 * pi))
            hit = abs(away) < 1e-3
            found = noted(w.q, size, arm.slides, found, q_out, size_out)
        if hit and rank > 1e-9:
            break
    return found, hit


@compiled
def solved(P, Q, order, arm, q_out, size_out, proof_out, road_out):
    """All solutions of a batch of poses.

    Args:
        P, Q: (b, 3, 4) displacements of the loop and their inverses, in units of the arm.
        order: roads to take one after the other until one proves that nothing is missing.
        arm: its constants.
        q_out, size_out: (b, 16, 6) and (b, 16) solutions and their errors.
        proof_out, road_out: (b,) 1 if the list is proven complete; how many roads were taken.
    """
    w = room(arm.fourier.shape[1], arm.degree)
    waves, factors = harmonics(arm.degree)
    for b in range(len(P)):
        found, centre, squeeze = 0, 0.0, 1.0
        proof_out[b] = 0
        for attempt in range(2 * len(order)):
            road, again = order[attempt // 2], attempt % 2 == 1
            if again:
                centre, squeeze, dust = sampled_again(arm, w)
            else:
                road_out[b] = 1 + attempt // 2
                dust = sampled(Q[b] if arm.backwards[road] else P[b], arm, w, road)
            number, certain = zeros_on_circle(w.coefficients, arm.degree, dust, waves, factors, w.zeros, w.t, w.stack)
            if again:
                for z in range(number):
                    w.zeros[z] = centre + 2 * atan2(sin(0.5 * w.zeros[z]) / squeeze, squeeze * cos(0.5 * w.zeros[z]))
            elif not certain and number > 0:
                continue
            proven = certain
            for z in range(number):
                found, hit = explored(P[b], arm, w, road, w.zeros[z], found, q_out[b], size_out[b])
                proven = proven and hit
            if proven and found == number:
                proof_out[b] = 1
                break
        if proof_out[b] == 0:
            twins(arm.frames, arm.slides, P[b], found, q_out[b], size_out[b], w.J, w.T)
