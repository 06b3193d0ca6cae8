"""Fixed-step integration methods as data. A wrong digit fails at import: each checks its own order conditions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.errors import InputError
from mafsil.solvers.tolerances import ORDER_CONDITION

Row = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Tableau:
    """An explicit Runge-Kutta method: k_i = f(t + c_i h, y + h sum_j a_ij k_j), y' = y + h sum_i b_i k_i.

    Attributes:
        name: as the field calls it.
        a: rows i of the lower triangle, row i of length i.
        b: (s,) weights.
        c: (s,) nodes, the row sums of a.
        order: of the global error, at most four.

    Raises:
        InputError: a row sum or an order condition is violated.

    Reference: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, sec. II.2.
    """

    name: str
    a: tuple[Row, ...]
    b: Row
    c: Row
    order: int

    def __post_init__(self) -> None:
        a = np.zeros((len(self.b), len(self.b)))
        for i, row in enumerate(self.a):
            a[i, :i] = row
        b, c = np.array(self.b), np.array(self.c)
        _require(self.name, "a 1 = c", float(np.abs(a.sum(axis=1) - c).max()))
        for order, law, value, expected in (
            (1, "b 1 = 1", b.sum(), 1.0),
            (2, "b c = 1/2", b @ c, 1 / 2),
            (3, "b c^2 = 1/3", b @ c**2, 1 / 3),
            (3, "b a c = 1/6", b @ a @ c, 1 / 6),
            (4, "b c^3 = 1/4", b @ c**3, 1 / 4),
            (4, "b (c a c) = 1/8", b @ (c * (a @ c)), 1 / 8),
            (4, "b a c^2 = 1/12", b @ a @ c**2, 1 / 12),
            (4, "b a a c = 1/24", b @ a @ a @ c, 1 / 24),
        ):
            if order <= self.order:
                _require(self.name, law, abs(float(value) - expected))

    @property
    def stages(self) -> int:
        """Evaluations of the right-hand side per step."""
        return len(self.b)


@dataclass(frozen=True, slots=True)
class Splitting:
    """A method for q'' = a(t, q, v) that alternates kicks v += k h a(t, q, v) and drifts q += d h v, kick first.

    Attributes:
        name: as the field calls it.
        kicks, drifts: (s,) fractions of the step; each sums to one.
        order: of the global error for forces that depend on the velocity.

    Raises:
        InputError: a sum differs from one.

    Reference: Hairer, Lubich and Wanner, Geometric Numerical Integration, sec. I.1.2.
    """

    name: str
    kicks: Row
    drifts: Row
    order: int

    def __post_init__(self) -> None:
        _require(self.name, "sum of kicks = 1", abs(sum(self.kicks) - 1.0))
        _require(self.name, "sum of drifts = 1", abs(sum(self.drifts) - 1.0))


def _require(name: str, law: str, error: float) -> None:
    if error > ORDER_CONDITION:
        raise InputError("solvers.tableau", name=name, law=law, error=error)


Method = Tableau | Splitting

EULER = Tableau("Euler", ((),), (1.0,), (0.0,), 1)
MIDPOINT = Tableau("midpoint", ((), (1 / 2,)), (0.0, 1.0), (0.0, 1 / 2), 2)
HEUN = Tableau("Heun", ((), (1.0,)), (1 / 2, 1 / 2), (0.0, 1.0), 2)
RK4 = Tableau(
    "classical Runge-Kutta",
    ((), (1 / 2,), (0.0, 1 / 2), (0.0, 0.0, 1.0)),
    (1 / 6, 1 / 3, 1 / 3, 1 / 6),
    (0.0, 1 / 2, 1 / 2, 1.0),
    4,
)
SEMI_IMPLICIT_EULER = Splitting("semi-implicit Euler", (1.0,), (1.0,), 1)

METHODS: dict[str, Method] = {
    "euler": EULER,
    "midpoint": MIDPOINT,
    "heun": HEUN,
    "rk4": RK4,
    "semi_implicit_euler": SEMI_IMPLICIT_EULER,
}


def method(name: str) -> Method:
    """The method of that name.

    Raises:
        InputError: there is none; the sentence lists the names.
    """
    if name not in METHODS:
        raise InputError("input.choice", name="method", value=name, known=", ".join(METHODS))
    return METHODS[name]
