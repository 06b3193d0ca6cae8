"""Equations of motion derived step by step: energies, mass matrix, Christoffel symbols, efforts, by two methods.

Equations of motion by Newton and Euler, in letters: twists outward, wrenches inward, in the frames of the table.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.derivation.arm import SymbolicArm, symbolic_arm
from mafsil.derivation.document import Derivation, Line, Name, Side, Step, table_step
from mafsil.derivation.lagrange_method import (
    Bodies,
    Lagrange,
    SymbolicBody,
    coordinate_names,
    counts_step,
    lagrange,
    rates,
    symbolic_bodies,
    too_long,
)
from mafsil.derivation.polynomial import (
    ZERO,
    Polynomial,
    Row,
    cross,
    minus,
    plus,
    scale_row,
    simplify,
    transform,
    transpose,
)
from mafsil.derivation.tolerances import LIMIT
from mafsil.derivation.verification import STATES, DerivationError, Judge
from mafsil.errors import ModelError
from mafsil.model import Mechanism
from mafsil.model.exponentials import chain_to_tip
from mafsil.model.loading import of_mechanism

MOST_JOINTS = 4
"""Longer chains get counts instead of formulas."""
LONGEST_DETERMINANT = 24
"""Terms up to which the determinant of the mass matrix is written."""
LONGEST_TWIST = 160
"""Length of the recursion's twists and wrenches up to which they are written."""


@of_mechanism
def derive_dynamics(mechanism: Mechanism) -> Derivation:
    """M(q) qdd + c(q, qd) + g(q) = tau as formulas, in numbered steps, every line compared with the compiled robot.

    Lagrange with Christoffel symbols first, then the recursion of Newton and Euler by twists and wrenches; both give
    the same formulas, term by term. Chains of more than four joints get the size of their equations instead.

    Args:
        mechanism: its chain to the tip may have revolute and prismatic joints; nothing else that moves may have mass.

    Raises:
        ModelError: a helical or mimic joint, no joint at all, no mass, or a branch with mass.
        DerivationError: a line differs from the compiled robot, or the two methods differ; nothing is handed out then.

    Reference: Lynch & Park, Modern Robotics, ch. 8.
    """
    arm = symbolic_arm(mechanism)
    bodies = symbolic_bodies(arm)
    if all(body.mass.is_zero and body.armature.is_zero for body in bodies.links):
        raise ModelError("derivation.massless", robot=mechanism.name)
    if arm.n > MOST_JOINTS:
        return too_long(mechanism)
    judge = DynamicsJudge(arm, bodies)
    method, other = lagrange(arm, bodies), newton_euler(arm, bodies)
    steps = [
        table_step(arm),
        _letters(bodies),
        *_energies(judge, method),
        *_equations(judge, method),
        *_recursion(judge, method, other),
        counts_step(arm, method),
    ]
    return Derivation("derivation.dynamics_title", mechanism.name, tuple(steps), STATES)


class DynamicsJudge(Judge):
    """The compiled robot at random states with rates and accelerations.

    Attributes:
        bodies: in letters.
        qd, qdd: (states, n) rates and accelerations.
        places: of the chain's joints among the robot's coordinates.
    """

    def __init__(self, arm: SymbolicArm, bodies: Bodies, seed: int = 6) -> None:
        super().__init__(arm)
        self.bodies = bodies
        rng = np.random.default_rng(seed)
        self.places = list(arm.coordinates)
        self.qd, self.qdd = np.zeros_like(self.q), np.zeros_like(self.q)
        self.qd[:, self.places] = rng.uniform(-2, 2, (STATES, arm.n))
        self.qdd[:, self.places] = rng.uniform(-3, 3, (STATES, arm.n))
        self.values.update(bodies.letters)
        for k, place in enumerate(self.places):
            for order, array in ((1, self.qd), (2, self.qdd)):
                self.values["d" * order + coordinate_names(arm)[k]] = array[:, place]

    def centres(self) -> Floats:
        """(n, states, 3) centres of mass in {s}, from the compiled poses and the numbers of the description."""
        found: list[Floats] = []
        for frame, body in zip(self.frames[1:], self.bodies.links, strict=True):
            com = np.array([float(np.asarray(x.evaluate(self.values)).ravel()[0]) for x in body.com])
            found.append(frame[:, :3, :3] @ com + frame[:, :3, 3])
        return np.stack(found)


def _letters(bodies: Bodies) -> Step:
    lines = tuple(
        Line((Name(name),), (f"{value:.10g} {_unit(name)}".replace("-", "−"),))
        for name, value in bodies.letters.items()
    )
    return Step("derivation.masses", {}, lines)


def _unit(name: str) -> str:
    units = {"m": "kg", "I": "kg m²", "r": "m", "g": "m/s²"}
    return units[name[0]]


def _energies(judge: DynamicsJudge, method: Lagrange) -> list[Step]:
    """Centres of mass, their velocities, K and P of every link, one step each."""
    arm, robot = judge.arm, judge.robot
    bodies, centres = judge.bodies.links, judge.centres()
    heavy = [k for k in range(arm.n) if not bodies[k].mass.is_zero]
    shown = [axis for axis in range(3) if any(not method.positions[k][axis].is_zero for k in heavy)]
    places = [
        judge.line((Name("xyz"[axis], str(k + 1)),), method.positions[k][axis], truth=centres[k][:, axis])
        for k in heavy
        for axis in shown
    ]
    speeds = [
        judge.line((Name(("ẋ", "ẏ", "ż")[axis], str(k + 1)),), method.velocities[k][axis], truth=moved[:, axis])
        for k, moved in ((k, _velocities(judge, k)) for k in heavy)
        for axis in shown
    ]
    P = [judge.line((Name("P", str(k + 1)),), method.potential[k], truth=_height(judge, centres, k)) for k in heavy]
    K = _kinetic_lines(judge, method)
    total = simplify(sum(method.kinetic, start=ZERO))
    truth = np.asarray(robot.kinetic_energy(judge.q, judge.qd))
    if np.abs(judge.number(total) - truth).max() > LIMIT * max(1.0, np.abs(truth).max()):
        raise DerivationError("derivation.differs", line="K", error=float("nan"), limit=LIMIT)
    return [
        Step("derivation.centres", {}, tuple(places)),
        Step("derivation.speeds", {}, tuple(speeds)),
        Step("derivation.kinetic", {}, tuple(K)),
        Step("derivation.potential", {}, tuple(P)),
    ]


def _velocities(judge: DynamicsJudge, k: int) -> Floats:
    """(states, 3) velocity of a centre of mass: the joints' space screws at that point."""
    rows, p = judge.J_s[:, :, : k + 1], judge.centres()[k]
    V = np.einsum("bij,bj->bi", rows, judge.qd[:, judge.places[: k + 1]])
    return V[:, 3:] + np.cross(V[:, :3], p)


def _height(judge: DynamicsJudge, centres: Floats, k: int) -> Floats:
    mass = float(np.asarray(judge.bodies.links[k].mass.evaluate(judge.values)))
    return -mass * centres[k] @ np.asarray(judge.arm.mechanism.gravity)


def _kinetic_lines(judge: DynamicsJudge, method: Lagrange) -> list[Line]:
    """K_i of every link: its own numbers, as there is no compiled quantity of one link alone."""
    lines: list[Line] = []
    for k, energy in enumerate(method.kinetic):
        body = judge.bodies.links[k]
        if body.mass.is_zero and body.armature.is_zero:
            continue
        v, R = _velocities(judge, k), judge.frames[k + 1][:, :3, :3]
        V = np.einsum("bij,bj->bi", judge.J_s[:, :3, : k + 1], judge.qd[:, judge.places[: k + 1]])
        omega = np.einsum("bji,bj->bi", R, V)
        numbers = np.array([[float(np.asarray(x.evaluate(judge.values))) for x in row] for row in body.inertia])
        mass, motor = (float(np.asarray(x.evaluate(judge.values))) for x in (body.mass, body.armature))
        truth = mass * (v * v).sum(-1) / 2 + np.einsum("bi,ij,bj->b", omega, numbers, omega) / 2
        truth = truth + motor * judge.qd[:, judge.places[k]] ** 2 / 2
        lines.append(judge.line((Name("K", str(k + 1)),), energy, truth=truth))
    return lines


def _equations(judge: DynamicsJudge, method: Lagrange) -> list[Step]:
    """M, its determinant, Christoffel symbols, C, c, g, tau."""
    arm, robot, at = judge.arm, judge.robot, np.ix_(range(STATES), judge.places, judge.places)
    M = np.asarray(robot.mass_matrix(judge.q))[at]
    entries = [
        judge.line((Name("M", f"{i + 1}{j + 1}"),), method.M[i][j], truth=M[:, i, j])
        for i in range(arm.n)
        for j in range(i, arm.n)
    ]
    entries += _determinant(judge, method, M)
    Gamma = np.asarray(robot.christoffel_symbols(judge.q))[np.ix_(range(STATES), *[judge.places] * 3)]
    symbols = [
        judge.line((Name("Γ", f"{i + 1}{j + 1}{k + 1}"),), *_name(method, i, j, k), truth=Gamma[:, i, j, k])
        for i in range(arm.n)
        for j in range(arm.n)
        for k in range(j, arm.n)
        if not method.christoffel[i][j][k].is_zero
    ]
    C = np.asarray(robot.coriolis_matrix(judge.q, judge.qd))[at]
    matrix = judge.line((Name("C"),), method.C, truth=C)
    c = np.asarray(robot.velocity_torque(judge.q, judge.qd))[:, judge.places]
    g = np.asarray(robot.gravity_torque(judge.q))[:, judge.places]
    tau = np.asarray(robot.inverse_dynamics(judge.q, judge.qd, judge.qdd))[:, judge.places]
    return [
        Step("derivation.mass_matrix", {}, tuple(entries)),
        Step("derivation.christoffel", {}, tuple(symbols)),
        Step("derivation.velocity_terms", {}, (matrix, *_vector(judge, "c", method.c, c))),
        Step("derivation.gravity_terms", {}, tuple(_vector(judge, "g", method.g, g))),
        Step("derivation.equations", {}, tuple(_vector(judge, "τ", method.tau, tau))),
    ]


def _name(method: Lagrange, i: int, j: int, k: int) -> tuple[Side, ...]:
    """A Christoffel symbol, with its twin in front where the last two indices differ."""
    twin: tuple[Side, ...] = () if j == k else ((Name("Γ", f"{i + 1}{k + 1}{j + 1}"),),)
    return (*twin, method.christoffel[i][j][k])


def _determinant(judge: DynamicsJudge, method: Lagrange, M: Floats) -> list[Line]:
    """Det M of two joints, and of three where it is short."""
    rows = method.M
    if len(rows) == 1:
        return []
    if len(rows) == 2:
        value = rows[0][0] * rows[1][1] - rows[0][1] * rows[1][0]
    elif len(rows) == 3 and max(len(x.terms) for row in rows for x in row) <= 3:
        value = sum((rows[0][k] * _minor(rows, k) for k in range(3)), start=ZERO)
    else:
        return []
    short = simplify(value)
    if len(short.terms) > LONGEST_DETERMINANT:
        return []
    return [judge.line((Name("det M"),), short, truth=np.linalg.det(M))]


def _minor(rows: tuple[Row, ...], k: int) -> Polynomial:
    a, b = ((1, 2), (2, 0), (0, 1))[k]
    return rows[1][a] * rows[2][b] - rows[1][b] * rows[2][a]


def _vector(judge: DynamicsJudge, letter: str, formulas: Row, truth: Floats) -> list[Line]:
    return [judge.line((Name(letter, str(i + 1)),), formula, truth=truth[:, i]) for i, formula in enumerate(formulas)]


def _recursion(judge: DynamicsJudge, method: Lagrange, other: NewtonEuler) -> list[Step]:
    """The second method, and that it ends where the first did.

    Raises:
        DerivationError: it does not.
    """
    for i, (one, two) in enumerate(zip(method.tau, other.tau, strict=True), start=1):
        if not same(one, two):
            raise DerivationError("derivation.methods_differ", joint=i)
    lines = [*_twists(judge, "V", other.V), *_twists(judge, "V̇", other.dV), *_twists(judge, "F", other.F)]
    tau = np.asarray(judge.robot.inverse_dynamics(judge.q, judge.qd, judge.qdd))[:, judge.places]
    last = [
        judge.line((Name("τ", str(i + 1)),), (Name("F", str(i + 1)), Name("·"), Name("A", str(i + 1))), truth=tau[:, i])
        for i in range(judge.arm.n)
    ]
    return [Step("derivation.recursion", {}, tuple(lines)), Step("derivation.methods_agree", {}, tuple(last))]


def _twists(judge: DynamicsJudge, letter: str, rows: tuple[Row, ...]) -> list[Line]:
    """Those that are short enough to be read, as rows of six."""
    truth = _recursion_numbers(judge, letter)
    return [
        judge.line((Name(letter, str(i + 1)),), (row,), truth=truth[i][:, None])
        for i, row in enumerate(rows)
        if sum(x.length for x in row) <= LONGEST_TWIST
    ]


def _recursion_numbers(judge: DynamicsJudge, letter: str) -> Floats:
    """(n, states, 6) from the compiled link quantities, moved to the frames of the table."""
    robot, mechanism = judge.robot, judge.arm.mechanism
    T = np.asarray(robot.link_poses(judge.q))
    if letter == "V":
        own = np.asarray(robot.link_twists(judge.q, judge.qd))
    elif letter == "F":
        own = np.asarray(robot.link_wrenches(judge.q, judge.qd, judge.qdd))
    else:
        own = np.asarray(robot.link_accelerations(judge.q, judge.qd, judge.qdd)).copy()
        own[..., 3:] -= np.einsum("blji,j->bli", T[..., :3, :3], np.asarray(mechanism.gravity))
    found: list[Floats] = []
    for i, link in enumerate(_carried_links(judge.arm), start=1):
        X: Floats = np.asarray(np.linalg.inv(judge.frames[i]) @ T[:, link], dtype=np.float64)
        R, p = X[:, :3, :3], X[:, :3, 3]
        one, two = (np.einsum("bij,bj->bi", R, own[:, link, part]) for part in (slice(0, 3), slice(3, 6)))
        moved = (one + np.cross(p, two), two) if letter == "F" else (one, two + np.cross(p, one))
        found.append(np.concatenate(moved, axis=-1))
    return np.stack(found)


def _carried_links(arm: SymbolicArm) -> list[int]:
    """For every row the link that its joint carries."""
    names = arm.mechanism.link_names
    return [names.index(joint.child) for joint in chain_to_tip(arm.mechanism) if joint.moves]


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
        twist = plus(_carry_twist(turn, step.p, twist), own)
        push = tuple(acceleration if k == place else ZERO for k in range(6))
        gain = plus(plus(_carry_twist(turn, step.p, gain), _bracket(twist, own)), push)
        V.append(twist)
        dV.append(plus(gain, (*nothing, *upwards[len(dV)])))
    F = [_wrench_needed(body, twist, gain) for body, twist, gain in zip(bodies.links, V, dV, strict=True)]
    for i in reversed(range(len(F) - 1)):
        step = steps[i + 1]
        m, f = transform(step.R, F[i + 1][:3]), transform(step.R, F[i + 1][3:])
        F[i] = plus(F[i], (*plus(m, cross(step.p, f)), *f))
    places = [2 if row.row.kind == "R" else 5 for row in arm.rows]
    motors = [body.armature * x for body, x in zip(bodies.links, rates(arm, 2), strict=True)]
    tau = tuple(wrench[place] + motor for wrench, place, motor in zip(F, places, motors, strict=True))
    return NewtonEuler(tuple(V), tuple(dV), tuple(F), tau)


def _carry_twist(turn: tuple[Row, ...], p: Row, V: Row) -> Row:
    """Ad(T_i,i-1) V = (R' w, R' (v + w x p))."""
    return (*transform(turn, V[:3]), *transform(turn, plus(V[3:], cross(V[:3], p))))


def _bracket(V: Row, W: Row) -> Row:
    """[V, W] = (w x w', w x v' - w' x v)."""
    return (*cross(V[:3], W[:3]), *plus(cross(V[:3], W[3:]), cross(V[3:], W[:3])))


def _wrench_needed(body: SymbolicBody, V: Row, dV: Row) -> Row:
    """G dV - ad(V)' G V with G about the origin of {i}."""
    P, rate = _momentum(body, V), _momentum(body, dV)
    dual = (*plus(cross(P[:3], V[:3]), cross(P[3:], V[3:])), *cross(P[3:], V[:3]))
    return minus(rate, dual)


def _momentum(body: SymbolicBody, V: Row) -> Row:
    """G V: linear m (v + w x c), angular I w + c x linear."""
    linear = scale_row(body.mass, plus(V[3:], cross(V[:3], body.com)))
    return (*plus(transform(body.inertia, V[:3]), cross(body.com, linear)), *linear)


def same(one: Polynomial, other: Polynomial) -> bool:
    """Whether two formulas are one: sines and cosines multiplied out to sums of angles, where nothing is left."""
    return (one - other).multiplied_out().is_zero
