"""Equations of motion by Lagrange, in letters: centres of mass, mass matrix, Christoffel symbols, gravity.

Letters for masses, centres of mass and inertias of an arm's links stand each in the frame {i} of the table. How long
equations of motion are: terms on paper, operations of the compiled expressions.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.derivation.arm import NOTHING, SymbolicArm
from mafsil.derivation.document import Derivation, Grid, Step
from mafsil.derivation.grouping import Part, factor_out
from mafsil.derivation.polynomial import (
    ZERO,
    Entries,
    Factor,
    Polynomial,
    Row,
    Trig,
    constant,
    dot,
    plus,
    simplify,
    symbol,
    transform,
)
from mafsil.derivation.tolerances import ROUNDOFF
from mafsil.errors import ModelError
from mafsil.kernels.reduce import reduce
from mafsil.kernels.tape import read
from mafsil.mechanics.catalogue import quantity
from mafsil.model import Inertial, JointKind, Mechanism
from mafsil.model.appearance import part_of
from mafsil.model.exponentials import chain_to_tip
from mafsil.model.mass_properties import combine_bodies
from mafsil.robot.trace import trace


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicBody:
    """What a joint carries up to the next one.

    Attributes:
        mass: m_i, or zero.
        com: (3,) in {i}.
        inertia: (3, 3) about the centre of mass, in the axes of {i}.
        armature: inertia of the motor, seen at the joint.
    """

    mass: Polynomial
    com: Row
    inertia: Entries
    armature: Polynomial


@dataclass(frozen=True, slots=True, eq=False)
class Bodies:
    """All bodies, gravity, and the numbers behind the letters.

    Attributes:
        links: in the order of the table's rows.
        gravity: (3,) in {s}.
        letters: number of every letter.
    """

    links: tuple[SymbolicBody, ...]
    gravity: Row
    letters: dict[str, float]


def symbolic_bodies(arm: SymbolicArm) -> Bodies:
    """Letters for everything that has mass.

    Args:
        arm: in letters.

    Raises:
        ModelError: a moving joint beside the chain to the tip carries mass.
    """
    letters: dict[str, float] = {}
    flat = _is_flat(arm)
    found = [_body(arm, i, inertial, flat, letters) for i, inertial in enumerate(_inertials(arm), start=1)]
    return Bodies(tuple(found), _gravity(arm.mechanism, letters), letters)


def _inertials(arm: SymbolicArm) -> list[tuple[Inertial | None, float]]:
    """Of every row: mass properties of the rigid part in {i}, and the motor's inertia."""
    mechanism = arm.mechanism
    chain = [joint for joint in chain_to_tip(mechanism) if joint.kind is not JointKind.FIXED]
    heads, home = part_of(mechanism), _home(mechanism)
    places = [mechanism.link_names.index(joint.child) for joint in chain]
    for k, link in enumerate(mechanism.links):
        if heads[k] not in (0, *places) and link.inertial is not None and link.inertial.mass:
            raise ModelError("derivation.branch", link=link.name, tip=mechanism.tip)
    T_s = np.array(arm.table.base)
    found: list[tuple[Inertial | None, float]] = []
    for row, joint, place in zip(arm.table.rows, chain, places, strict=True):
        T_s = T_s @ row.transform(arm.table.convention)
        parts = [
            (link.inertial, np.linalg.inv(T_s) @ home[k])
            for k, link in enumerate(mechanism.links)
            if heads[k] == place and link.inertial is not None and link.inertial.mass
        ]
        armature = 0.0 if joint.actuator is None else joint.actuator.reflected_inertia
        found.append((combine_bodies(parts) if parts else None, armature))
    return found


def _home(mechanism: Mechanism) -> list[Floats]:
    """Poses of all links in {s} at zero coordinates."""
    poses = [np.asarray(mechanism.T_sb)]
    for joint, parent in zip(mechanism.joints, mechanism.parents, strict=True):
        poses.append(poses[parent] @ joint.T_pj)
    return poses


def _is_flat(arm: SymbolicArm) -> bool:
    """All axes turning and parallel: only the moments about them count."""
    return all(row.row.kind == "R" and not row.alpha and row.alpha_quarters % 2 == 0 for row in arm.rows[1:]) and (
        arm.rows[0].row.kind == "R"
    )


def _body(
    arm: SymbolicArm, i: int, properties: tuple[Inertial | None, float], flat: bool, letters: dict[str, float]
) -> SymbolicBody:
    inertial, armature = properties
    motor = _letter(f"I_{i}m", armature, letters, 0.0)
    if inertial is None:
        return SymbolicBody(ZERO, (ZERO, ZERO, ZERO), ((ZERO,) * 3,) * 3, motor)
    mass = _letter(f"m{i}", inertial.mass, letters, 0.0)
    return SymbolicBody(
        mass, _com(arm, i, np.array(inertial.com), flat, letters), _inertia(i, inertial.inertia, flat, letters), motor
    )


def _com(arm: SymbolicArm, i: int, com: Floats, flat: bool, letters: dict[str, float]) -> Row:
    """One letter r_i along x, the link's own length where they are equal, three letters otherwise."""
    com = np.where(np.abs(com) < NOTHING, 0.0, com)
    length = arm.letters.get(f"L{i}")
    if flat:
        com[2] = 0.0
    if not com[1:].any():
        if length is not None and abs(com[0] - length) < NOTHING:
            return symbol(f"L{i}"), ZERO, ZERO
        return _letter(f"r{i}", float(com[0]), letters, 0.0), ZERO, ZERO
    x, y, z = (_letter(f"r_{i}{axis}", float(value), letters, 0.0) for axis, value in zip("xyz", com, strict=True))
    return x, y, z


def _inertia(i: int, inertia: Floats, flat: bool, letters: dict[str, float]) -> Entries:
    roundoff = ROUNDOFF * float(np.abs(inertia).max())
    if flat:
        moment = _letter(f"I{i}", float(inertia[2, 2]), letters, roundoff)
        return ((ZERO, ZERO, ZERO), (ZERO, ZERO, ZERO), (ZERO, ZERO, moment))
    names = ("xx", "xy", "xz", "yy", "yz", "zz")
    places = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
    entries = {
        place: _letter(f"I_{i}{name}", float(inertia[place]), letters, roundoff)
        for name, place in zip(names, places, strict=True)
    }
    return tuple(tuple(entries[min(r, c), max(r, c)] for c in range(3)) for r in range(3))


def _gravity(mechanism: Mechanism, letters: dict[str, float]) -> Row:
    """(0, 0, -g) and the like: one letter times a direction in numbers."""
    size = float(np.linalg.norm(mechanism.gravity))
    if size == 0.0:
        return ZERO, ZERO, ZERO
    letters["g"] = size
    x, y, z = (symbol("g") * constant(round(float(c), 15)) for c in mechanism.gravity / size)
    return x, y, z


def _letter(name: str, value: float, letters: dict[str, float], roundoff: float) -> Polynomial:
    if abs(value) <= roundoff:
        return ZERO
    letters[name] = value
    return symbol(name)


@dataclass(frozen=True, slots=True, eq=False)
class Lagrange:
    """All that the method passes through; n joints.

    Attributes:
        positions: (n, 3) centres of mass in {s}.
        velocities: (n, 3) their derivatives along the motion.
        kinetic, potential: (n,) energies of the links.
        M: (n, n) mass matrix.
        christoffel: Gamma[i][j][k].
        c, g, tau: (n,) velocity efforts, gravity efforts, efforts.
        rates: (n,) the symbols of the coordinates' rates.
    """

    positions: tuple[Row, ...]
    velocities: tuple[Row, ...]
    kinetic: Row
    potential: Row
    M: Entries
    christoffel: tuple[Entries, ...]
    c: Row
    g: Row
    tau: Row

    rates: Row

    @property
    def C(self) -> Entries:
        """(n, n) Coriolis matrix: C_ij = sum of Gamma_ijk qd_k."""
        return tuple(
            tuple(_sum(x * rate for x, rate in zip(row, self.rates, strict=True)) for row in symbols)
            for symbols in self.christoffel
        )


def coordinate_names(arm: SymbolicArm) -> tuple[str, ...]:
    """Theta1, q2 and so on."""
    return tuple(f"theta{i}" if row.row.kind == "R" else f"q{i}" for i, row in enumerate(arm.rows, start=1))


def rates(arm: SymbolicArm, order: int = 1) -> Row:
    """(n,) symbols of the coordinates' first or second derivatives."""
    return tuple(symbol("d" * order + name) for name in coordinate_names(arm))


def lagrange(arm: SymbolicArm, bodies: Bodies) -> Lagrange:
    """tau_i = sum m_ij qdd_j + sum Gamma_ijk qd_j qd_k + dP/dq_i.

    Args:
        arm: in letters.
        bodies: its masses in letters.

    Reference: Lynch & Park, Modern Robotics, sec. 8.1.
    """
    names, qd, qdd = coordinate_names(arm), rates(arm), rates(arm, 2)
    poses = arm.poses()[1:-1]
    positions = tuple(plus(pose.p, transform(pose.R, body.com)) for pose, body in zip(poses, bodies.links, strict=True))
    columns = [[tuple(simplify(x.derivative(name)) for x in p) for name in names] for p in positions]
    velocities = tuple(
        tuple(_sum(column[axis] * rate for column, rate in zip(each, qd, strict=True)) for axis in range(3))
        for each in columns
    )
    shares = [_share(arm, bodies, k, columns[k]) for k in range(arm.n)]
    M = _add(shares)
    kinetic = tuple(_quadratic(share, qd) for share in shares)
    potential = tuple(
        simplify(-body.mass * dot(bodies.gravity, p)) for body, p in zip(bodies.links, positions, strict=True)
    )
    christoffel = _christoffel(M, names)
    c = tuple(_quadratic(symbols, qd, half=False) for symbols in christoffel)
    g = tuple(simplify(_sum(P.derivative(name) for P in potential)) for name in names)
    tau = tuple(
        _sum(m * x for m, x in zip(row, qdd, strict=True)) + ci + gi for row, ci, gi in zip(M, c, g, strict=True)
    )
    return Lagrange(positions, velocities, kinetic, potential, M, christoffel, c, g, tau, qd)


def _share(arm: SymbolicArm, bodies: Bodies, k: int, columns: list[Row]) -> Entries:
    """M J' J + W' I W of link k, W its angular columns in {k}; its motor on the diagonal."""
    body, n = bodies.links[k], arm.n
    spins = [_axis(arm, j, k) for j in range(n)]
    turned = [transform(body.inertia, spin) for spin in spins]
    rows: list[Row] = []
    for i in range(n):
        row = [simplify(body.mass * dot(columns[i], columns[j]) + dot(spins[i], turned[j])) for j in range(n)]
        if i == k:
            row[i] = row[i] + body.armature
        rows.append(tuple(row))
    return tuple(rows)


def _axis(arm: SymbolicArm, j: int, k: int) -> Row:
    """(3,) the axis of joint j seen from {k}, zero for slides and later joints."""
    if j > k or arm.rows[j].row.kind != "R":
        return ZERO, ZERO, ZERO
    return arm.between(j + 1, k + 1).R[2]


def _add(shares: list[Entries]) -> Entries:
    n = len(shares[0])
    return tuple(tuple(simplify(_sum(share[i][j] for share in shares)) for j in range(n)) for i in range(n))


def _christoffel(M: Entries, names: tuple[str, ...]) -> tuple[Entries, ...]:
    """Gamma_ijk = (dm_ij/dq_k + dm_ik/dq_j - dm_jk/dq_i) / 2."""
    n, half = len(names), constant(0.5)
    slope = [[[x.derivative(name) for name in names] for x in row] for row in M]
    return tuple(
        tuple(
            tuple(simplify(half * (slope[i][j][k] + slope[i][k][j] - slope[j][k][i])) for k in range(n))
            for j in range(n)
        )
        for i in range(n)
    )


def _quadratic(A: Entries, x: Row, *, half: bool = True) -> Polynomial:
    """X' A x, halved for energies."""
    total = _sum(a * x[i] * x[j] for i, row in enumerate(A) for j, a in enumerate(row))
    return simplify(constant(0.5) * total) if half else total


def _sum(terms: Iterable[Polynomial]) -> Polynomial:
    return sum(terms, start=ZERO)


QUANTITIES = ("mass_matrix", "velocity_torque", "gravity_torque", "inverse_dynamics")
HEAD = ("", "+", "×", "sin, cos")


def compiled_operations(mechanism: Mechanism, name: str) -> dict[str, int]:
    """Operations of a compiled quantity by kind, after its equal subexpressions were shared."""
    return reduce(read(trace(mechanism, quantity(name), None))).counts()


def operations(*formulas: Polynomial) -> tuple[int, int, int, int]:
    """Terms, sums, products and different sines and cosines of formulas as they are printed."""
    trigs: set[Factor] = set()
    sums = products = terms = 0
    for formula in formulas:
        terms += len(formula.terms)
        trigs |= {factor for monomial in formula.terms for factor in monomial if isinstance(factor, Trig)}
        more = _cost(factor_out(formula))
        sums, products = sums + more[0], products + more[1]
    return terms, sums, products, len(trigs)


def counts_step(arm: SymbolicArm, method: Lagrange) -> Step:
    """Terms and operations of what was derived, beside those of the compiled routine.

    Args:
        arm: in letters.
        method: its equations.
    """
    upper = [method.M[i][j] for i in range(arm.n) for j in range(i, arm.n)]
    rows: list[tuple[str, ...]] = []
    for name, formulas in (("M", upper), ("c", method.c), ("g", method.g), ("τ", method.tau)):
        rows.append((name, *(str(x) for x in operations(*formulas))))
    compiled = compiled_operations(arm.mechanism, "inverse_dynamics")
    grid = Grid(("", "n", "+", "×", "sin"), tuple(rows))
    return Step("derivation.counts", {"operations": sum(compiled.values()), "terms": rows[-1][1]}, (), grid)


def too_long(mechanism: Mechanism) -> Derivation:
    """In place of formulas that fill pages: how many operations they take, and how to get the numbers.

    Args:
        mechanism: the arm.
    """
    rows: list[tuple[str, ...]] = []
    for name in QUANTITIES:
        counts = compiled_operations(mechanism, name)
        trigs = counts.get("sin", 0) + counts.get("cos", 0)
        fused = sum(counts.get(op, 0) for op in ("fma", "fms", "fnma", "fnms"))
        products = counts.get("mul", 0) + fused
        sums = counts.get("add", 0) + counts.get("sub", 0) + fused
        rows.append((name, str(sums), str(products), str(trigs)))
    details = {"robot": mechanism.name, "joints": mechanism.n}
    step = Step("derivation.too_long", details, (), Grid(HEAD, tuple(rows)))
    return Derivation("derivation.dynamics_title", mechanism.name, (step,), 0)


def _cost(parts: tuple[Part, ...]) -> tuple[int, int]:
    """Sums and products of a formula as written."""
    sums, products = max(len(parts) - 1, 0), 0
    for part in parts:
        inside = _cost(part.bracket)
        factors = len(part.factors) + len(part.behind) + bool(part.bracket) + (abs(part.number) != 1.0)
        sums, products = sums + inside[0], products + inside[1] + max(factors - 1, 0)
    return sums, products
