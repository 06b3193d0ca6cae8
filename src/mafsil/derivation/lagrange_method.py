"""Equations of motion by Lagrange, in letters: centres of mass, mass matrix, Christoffel symbols, gravity.

How long equations of motion are: terms on paper, operations of the compiled expressions.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from mafsil.derivation.arm import SymbolicArm
from mafsil.derivation.bodies import Bodies
from mafsil.derivation.document import Derivation, Grid, Step
from mafsil.derivation.factored import Part, factor_out
from mafsil.derivation.matrices import ZERO, Entries, Row, dot, plus, transform
from mafsil.derivation.polynomial import Factor, Polynomial, Trig, constant, simplify, symbol
from mafsil.kernels.reduce import reduce
from mafsil.kernels.tape import read
from mafsil.mechanics.catalogue import quantity
from mafsil.model import Mechanism
from mafsil.robot.trace import trace


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
