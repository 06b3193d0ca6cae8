"""Equations of motion by Newton and Euler, in letters: twists outward, wrenches inward, in the frames of the table."""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.derivation.arm import SymbolicArm
from mafsil.derivation.bodies import Bodies, SymbolicBody
from mafsil.derivation.lagrange_method import rates
from mafsil.derivation.matrices import ZERO, Row, cross, minus, plus, scaled, transform, transpose
from mafsil.derivation.polynomial import Polynomial


@dataclass(frozen=True, slots=True, eq=False)
class NewtonEuler:
    """What the recursion passes through, each link in its own frame {i}; rows (omega, v) and (m, f).

    Attributes:
        V, dV: (n, 6) twists, and their derivatives with the base accelerating upwards instead of gravity.
        F: (n, 6) wrench that link i-1 exerts on link i.
        tau: (n,) efforts.
    """

    V: tuple[Row, ...]
    dV: tuple[Row, ...]
    F: tuple[Row, ...]
    tau: Row


def newton_euler(arm: SymbolicArm, bodies: Bodies) -> NewtonEuler:
    """V_i = Ad(T_i,i-1) V_i-1 + A_i qd_i and so on; F_i = Ad' F_i+1 + G dV - ad(V)' G V; tau_i = F_i . A_i.

    Args:
        arm: in letters.
        bodies: its masses in letters.

    Reference: Lynch & Park, Modern Robotics, sec. 8.3.
    """
    nothing: Row = (ZERO,) * 3
    twist = gain = (*nothing, *nothing)
    upwards = [transform(transpose(pose.R), minus(nothing, bodies.gravity)) for pose in arm.poses()[1:-1]]
    V: list[Row] = []
    dV: list[Row] = []
    steps = [row.transform() for row in arm.rows]
    for row, step, rate, acceleration in zip(arm.rows, steps, rates(arm), rates(arm, 2), strict=True):
        turn = transpose(step.R)
        place = 2 if row.row.kind == "R" else 5
        own = tuple(rate if k == place else ZERO for k in range(6))
        twist = plus(_carried(turn, step.p, twist), own)
        push = tuple(acceleration if k == place else ZERO for k in range(6))
        gain = plus(plus(_carried(turn, step.p, gain), _bracket(twist, own)), push)
        V.append(twist)
        dV.append(plus(gain, (*nothing, *upwards[len(dV)])))
    F = [_needed(body, twist, gain) for body, twist, gain in zip(bodies.links, V, dV, strict=True)]
    for i in reversed(range(len(F) - 1)):
        step = steps[i + 1]
        m, f = transform(step.R, F[i + 1][:3]), transform(step.R, F[i + 1][3:])
        F[i] = plus(F[i], (*plus(m, cross(step.p, f)), *f))
    places = [2 if row.row.kind == "R" else 5 for row in arm.rows]
    motors = [body.armature * x for body, x in zip(bodies.links, rates(arm, 2), strict=True)]
    tau = tuple(wrench[place] + motor for wrench, place, motor in zip(F, places, motors, strict=True))
    return NewtonEuler(tuple(V), tuple(dV), tuple(F), tau)


def _carried(turn: tuple[Row, ...], p: Row, V: Row) -> Row:
    """Ad(T_i,i-1) V = (R' w, R' (v + w x p))."""
    return (*transform(turn, V[:3]), *transform(turn, plus(V[3:], cross(V[:3], p))))


def _bracket(V: Row, W: Row) -> Row:
    """[V, W] = (w x w', w x v' - w' x v)."""
    return (*cross(V[:3], W[:3]), *plus(cross(V[:3], W[3:]), cross(V[3:], W[:3])))


def _needed(body: SymbolicBody, V: Row, dV: Row) -> Row:
    """G dV - ad(V)' G V with G about the origin of {i}."""
    P, rate = _momentum(body, V), _momentum(body, dV)
    dual = (*plus(cross(P[:3], V[:3]), cross(P[3:], V[3:])), *cross(P[3:], V[:3]))
    return minus(rate, dual)


def _momentum(body: SymbolicBody, V: Row) -> Row:
    """G V: linear m (v + w x c), angular I w + c x linear."""
    linear = scaled(body.mass, plus(V[3:], cross(V[:3], body.com)))
    return (*plus(transform(body.inertia, V[:3]), cross(body.com, linear)), *linear)


def same(one: Polynomial, other: Polynomial) -> bool:
    """Whether two formulas are one: sines and cosines multiplied out to sums of angles, where nothing is left."""
    return (one - other).multiplied_out().is_zero
