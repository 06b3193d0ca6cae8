"""Where the polynomials of mafsil.kernels.program come from: minimax fits by Remez exchange, 40 digits.

`python tests/kernels/minimax.py` prints the tables of mafsil.kernels.exact; test_transcendental compares them.
Rounding the coefficients to double adds less than the evaluation does: each is multiplied by a small number.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import mpmath as mp

Function = Callable[[mp.mpf], mp.mpf]
DIGITS = 40


def remez(f: Function, weight: Function, low: float, high: float, count: int) -> tuple[list[mp.mpf], mp.mpf]:
    """Coefficients of the polynomial p of `count` terms with least max |weight (p - f)|, and that error."""
    points = [
        low + (high - low) * (1 - mp.cos(mp.pi * (k + mp.mpf(1) / 2) / (count + 1))) / 2 for k in range(count + 1)
    ]
    grid = [low + (high - low) * (1 - mp.cos(mp.pi * k / 400)) / 2 for k in range(401)]
    samples = [(x, f(x), weight(x)) for x in grid]
    coefficients: list[mp.mpf] = []
    error = mp.mpf(0)
    for _ in range(6):
        system = mp.matrix(count + 1, count + 1)
        right = mp.matrix(count + 1, 1)
        for i, x in enumerate(points):
            for j in range(count):
                system[i, j] = x**j
            system[i, count] = (-1) ** i / weight(x)
            right[i] = f(x)
        solution = mp.lu_solve(system, right)
        coefficients, error = [solution[j] for j in range(count)], abs(solution[count])
        deviations = [(x, w * (_horner(coefficients, x) - y)) for x, y, w in samples]
        extrema = _alternating(deviations)
        if len(extrema) != count + 1:
            break
        points = extrema
    return coefficients, error


def _horner(coefficients: list[mp.mpf], x: mp.mpf) -> mp.mpf:
    total = mp.mpf(0)
    for c in reversed(coefficients):
        total = total * x + c
    return total


def _alternating(deviations: list[tuple[mp.mpf, mp.mpf]]) -> list[mp.mpf]:
    """The largest deviation of every run of one sign."""
    runs: list[tuple[mp.mpf, mp.mpf]] = []
    for x, d in deviations:
        if not runs or (d > 0) != (runs[-1][1] > 0):
            runs.append((x, d))
        elif abs(d) > abs(runs[-1][1]):
            runs[-1] = (x, d)
    return [x for x, _ in runs]


def _series(terms: Callable[[int], mp.mpf], z: mp.mpf, first: int = 0) -> mp.mpf:
    total, power = mp.mpf(0), mp.mpf(1)
    for k in range(first, first + 160):
        term = terms(k) * power
        total += term
        if abs(term) < mp.mpf(10) ** (-DIGITS - 3) * abs(total):
            break
        power *= z
    return total


def _asin_term(k: int) -> mp.mpf:
    return mp.binomial(2 * k, k) / (mp.mpf(4) ** k * (2 * k + 1))


QUARTER = (mp.pi / 4) ** 2 * mp.mpf("1.0001")
TABLES: dict[str, tuple[Function, Function, mp.mpf, int]] = {
    # name: (f, weight, upper end of z, number of terms); every f is even in its argument or entire
    "SIN": (
        lambda z: _series(lambda k: mp.mpf(-1) ** k / mp.factorial(2 * k + 1), z, 1),
        lambda z: z,
        QUARTER,
        6,
    ),
    "COS": (lambda z: _series(lambda k: mp.mpf(-1) ** k / mp.factorial(2 * k), z, 2), lambda z: z * z, QUARTER, 6),
    "TANH": (
        lambda z: (mp.tanh(mp.sqrt(z)) / mp.sqrt(z) - 1) / z,
        lambda z: z,
        mp.mpf("0.3026"),
        11,
    ),
    "LOG": (lambda z: 2 * _series(lambda k: mp.mpf(1) / (2 * k + 1), z, 1), lambda z: z, mp.mpf("0.02945"), 7),
    "LOG_LONG": (lambda z: 2 * _series(lambda k: mp.mpf(1) / (2 * k + 1), z, 2), lambda z: z * z, mp.mpf("0.02945"), 8),
    "ATAN": (lambda z: _series(lambda k: mp.mpf(-1) ** k / (2 * k + 1), z, 1), lambda z: z, mp.mpf("0.1717"), 11),
    "ASIN": (lambda z: _series(_asin_term, z, 1), lambda z: z, mp.mpf("0.25"), 13),
}
# exp(r) = 1 + r + r^2 EXP(r) on |r| <= ln(2) / 2: not even, both signs of r.
EXP_TERMS = 11


def tables() -> dict[str, list[float]]:
    """Every table, recomputed."""
    with mp.workdps(DIGITS):
        low = mp.mpf(10) ** -9
        result = {
            name: [float(c) for c in remez(f, w, low, top, count)[0]] for name, (f, w, top, count) in TABLES.items()
        }
        bound = mp.log(2) / 2 * mp.mpf("1.0001")

        def tail(r: mp.mpf) -> mp.mpf:
            return _series(lambda k: 1 / mp.factorial(k), r, 2)

        coefficients, _ = remez(tail, lambda r: r**2 + mp.mpf(10) ** -6, -bound, bound, EXP_TERMS)
        result["EXP"] = [float(c) for c in coefficients]
        return result


if __name__ == "__main__":
    for name, table in tables().items():
        sys.stdout.write(f"{name} = (\n" + "".join(f"    {c.hex()},\n" for c in table).replace("'", "") + ")\n")
