"""How long equations of motion are: terms on paper, operations of the compiled expressions."""

from __future__ import annotations

from mafsil.derivation.arm import SymbolicArm
from mafsil.derivation.document import Derivation, Grid, Step
from mafsil.derivation.factored import Part, factor_out
from mafsil.derivation.lagrange_method import Lagrange
from mafsil.derivation.polynomial import Factor, Polynomial, Trig
from mafsil.kernels.reduce import reduce
from mafsil.kernels.tape import read
from mafsil.mechanics.catalogue import quantity
from mafsil.model import Mechanism
from mafsil.robot.trace import trace

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
