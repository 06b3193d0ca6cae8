"""R3: derivative kernels against the complex step through textbook mechanics, and both modes of differentiation.

`python -m tests.reliability.derivatives --cases 1000000 --resume DIR`

Every shard is one robot: an arm of the library with masses, or a random tree with slides, screws, followers and
branches. A tenth of the coordinates stand on quarter turns. Errors are relative to the robot's natural size, as in
`mafsil.verify`; no finite differences anywhere.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from mafsil.mechanics.arm_size import ArmSize
from mafsil.mechanics.catalogue import quantity
from mafsil.mechanics.quantity import States, random_states
from mafsil.mechanics.textbook import Textbook, along, gradient, inverse
from mafsil.model import JointKind, Mechanism, library
from mafsil.robot import Robot
from mafsil.robot.trace import trace
from mafsil.verification.verify import Judge, call
from tests.oracles.casadi_expression import as_casadi
from tests.oracles.random_tree import random_tree
from tests.reliability import figures

LIMIT, MODES_LIMIT = 1e-11, 1e-12
CHUNK = 500
QUARTERS = 0.1
TREES = 12
EFFORTS = ("inverse_dynamics", "forward_dynamics")


def work(seed: int, cases: int) -> dict[str, int]:
    """States of one robot; counts of errors by their size."""
    robot, book, modes = subject(seed % len(subjects()))
    sizes, count = ArmSize.of(robot.mechanism), {"cases": cases}
    for start in range(0, cases, CHUNK):
        drawn = random_states(robot.mechanism, sizes, min(CHUNK, cases - start), seed * cases + start)
        judge = Judge(book, sizes, on_seams(book, drawn, seed, start), LIMIT)
        for name, errors in (*from_complex_steps(robot, book, judge), *from_both_modes(robot, modes, judge)):
            for key, value in histogram(name, errors).items():
                count[key] = count.get(key, 0) + value
    return count


@cache
def subjects() -> tuple[tuple[str, int], ...]:
    """Names of arms with masses behind every joint, then numbers of random trees."""
    arms = [name for name in library.robots() if _moves_masses(library.load(name))]
    return tuple((name, 0) for name in arms) + tuple(("tree", number) for number in range(TREES))


def _moves_masses(mechanism: Mechanism) -> bool:
    M = Textbook(mechanism).mass_matrix(np.full((1, mechanism.n), 0.3))[0]
    size = np.sqrt(np.diag(M))
    return bool(size.min() > 0 and np.linalg.eigvalsh(M / np.outer(size, size))[0] > 1e-6)


@cache
def subject(number: int) -> tuple[Robot, Textbook, dict[str, Any]]:
    """The robot, its second method, and for inverse and forward dynamics the Jacobians by both modes."""
    name, seed = subjects()[number]
    mechanism = _tree(seed) if name == "tree" else library.load(name)
    return Robot(mechanism), Textbook(mechanism), {routine: _modes(mechanism, routine) for routine in EFFORTS}


def _tree(number: int) -> Mechanism:
    """The first random tree from this seed on in which every joint moves a mass."""
    rng = np.random.default_rng(1000 + number)
    return next(tree for tree in iter(lambda: random_tree(rng, most_joints=9), None) if _moves_masses(tree))


def _modes(mechanism: Mechanism, routine: str) -> Any:
    """A casadi.Function of the routine's inputs: [0] its Jacobians by forward mode, [1] by reverse mode, (3 n, n)."""
    row = quantity(routine)
    symbols = [ca.SX.sym(name, mechanism.n) for name in row.inputs]
    value = as_casadi(trace(mechanism, row, None))(*symbols)
    modes = [
        ca.vertcat(*(ca.densify(ca.jacobian(value, x, {"helper_options": {"ad_weight": weight}})) for x in symbols))
        for weight in (0, 1)
    ]
    return ca.Function(routine, symbols, [ca.vec(mode.T) for mode in modes], {"cse": True})


def on_seams(book: Textbook, drawn: States, seed: int, start: int) -> States:
    """A tenth of the turning coordinates on quarter turns, a tenth of the rates at rest; efforts of these motions."""
    rng = np.random.default_rng((seed, start))
    turning = np.array([joint.kind is JointKind.REVOLUTE for joint in book.mechanism.coordinates])
    quarters = rng.integers(-2, 3, drawn.q.shape) * (np.pi / 2)
    q = np.where((rng.random(drawn.q.shape) < QUARTERS) & turning, quarters, drawn.q)
    qd = np.where(rng.random(drawn.q.shape) < QUARTERS, 0.0, drawn.qd)
    return States(q, qd, drawn.qdd, book.newton_euler(q, qd, drawn.qdd).tau)


def from_complex_steps(robot: Robot, book: Textbook, judge: Judge) -> Iterator[tuple[str, np.ndarray]]:
    """Errors of every routine that is a derivative of another."""
    s = judge.drawn
    for name, reference in references(book, s):
        yield name, judge.error(name, call(robot, quantity(name), s), reference)


def references(book: Textbook, s: States) -> Iterator[tuple[str, np.ndarray]]:
    """Derivatives of poses, Jacobians, energies, the mass matrix and the recursion, all by the complex step."""
    T, dT = book.pose(s.q), gradient(book.pose, s.q)
    yield "jacobian_space", _coordinates(np.einsum("bijn,bjk->bnik", dT, inverse(T)))
    yield "jacobian_body", _coordinates(np.einsum("bij,bjkn->bnik", inverse(T), dT))
    yield "jacobian_space_rate", along(book.jacobian_space, s.q, s.qd)
    yield "jacobian_body_rate", along(book.jacobian_body, s.q, s.qd)
    yield "gravity_torque", gradient(book.potential_energy, s.q)
    dM = gradient(book.mass_matrix, s.q)
    Gamma = (dM + np.swapaxes(dM, 2, 3) - np.moveaxis(dM, 3, 1)) / 2
    yield "christoffel_symbols", Gamma
    yield "coriolis_matrix", np.einsum("bijk,bk->bij", Gamma, s.qd)

    def efforts(q: np.ndarray, qd: np.ndarray) -> np.ndarray:
        return book.newton_euler(q + 0j, qd + 0j, repeated(s.qdd, len(q)) + 0j).tau

    by_q = gradient(lambda q: efforts(q, repeated(s.qd, len(q))), s.q)
    by_qd = gradient(lambda qd: efforts(repeated(s.q, len(qd)), qd), s.qd)
    M = book.mass_matrix(s.q)
    Minv = np.linalg.inv(M)
    yield "inverse_dynamics_derivatives", np.stack([by_q, by_qd, M], axis=1)
    yield "forward_dynamics_derivatives", np.stack([-Minv @ by_q, -Minv @ by_qd, Minv], axis=1)


def repeated(x: np.ndarray, count: int) -> np.ndarray:
    """Rows of states repeated for the directions in which `gradient` asks."""
    return np.repeat(x, count // len(x), axis=0)


def _coordinates(X: np.ndarray) -> np.ndarray:
    """(b, 6, n) from twists (b, n, 4, 4)."""
    return np.stack([X[..., 2, 1], X[..., 0, 2], X[..., 1, 0], *np.moveaxis(X[..., :3, 3], -1, 0)], axis=1)


def from_both_modes(robot: Robot, modes: dict[str, Any], judge: Judge) -> Iterator[tuple[str, np.ndarray]]:
    """Forward mode against reverse mode, and the kernels in closed form against forward mode."""
    n = robot.n
    for routine, function in modes.items():
        row = quantity(f"{routine}_derivatives")
        columns = function(*(getattr(judge.drawn, name).T for name in row.inputs))
        forward, reverse = (np.asarray(x.full()).T.reshape(-1, 3, n, n) for x in columns)
        yield f"modes_of_{routine}", judge.error(row.name, forward, reverse)
        yield f"kernel_and_mode_of_{routine}", judge.error(row.name, call(robot, row, judge.drawn), forward)


def histogram(name: str, errors: np.ndarray) -> dict[str, int]:
    """How many lie below each power of ten, and how many beyond the limit."""
    limit = MODES_LIMIT if name.startswith("modes") else LIMIT
    below = {f"{name}_below_1e-{k}": int((errors <= 10.0**-k).sum()) for k in (15, 14, 13, 12)}
    return {**below, f"bad_{name}": int((~(errors <= limit)).sum())}


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "cases", 100_000, 1_000)
    sys.exit(not figures.run("R3", options, work)["passed"])
