"""Random wrench sets on which all routes must agree: any number by command.

python tests/grasp/random_sets.py --count 100000 [--seed 1]
"""

from __future__ import annotations

import argparse

import numpy as np

from mafsil.grasp import Contact, Grasp, three_fingers
from mafsil.grasp.closure import closure
from mafsil.grasp.closure_methods import closure_by_all_methods
from mafsil.grasp.contact_batch import wrench_closures
from mafsil.grasp.two_fingers import nguyen
from mafsil.solvers.rational import Location, locate_origin


def wrench_set(rng: np.random.Generator) -> np.ndarray:
    """m = 3 or 6, n from 1 to 40; whole numbers (many on the boundary), floats, leading dependent columns."""
    m = int(rng.choice([3, 6]))
    n = int(rng.integers(1, 41)) if rng.random() < 0.4 else int(rng.integers(m + 1, 3 * m))
    kind = rng.integers(3)
    A = rng.integers(-2, 3, (m, n)).astype(float) if kind == 0 else rng.normal(size=(m, n)) - rng.uniform(0, 0.3)
    if kind == 2 and n > 1:
        A[:, 1] = 2.0 * A[:, 0]
    A[:, ~A.any(axis=0)] = np.eye(m)[:, :1]
    return A


def check(A: np.ndarray) -> bool:
    """All routes, the single test, the batch and exact arithmetic on one set; proofs are verified. Was it closed?"""
    exact = locate_origin(A.T.tolist())
    want = exact.place is Location.INSIDE
    found = closure(A, margins=False)
    answers = {name: route.closed for name, route in closure_by_all_methods(A).items()}
    assert set(answers.values()) == {want}, (answers, exact.place, A.tolist())
    assert found.force_closure == want, (found, exact.place, A.tolist())
    assert bool(wrench_closures(A[None]).force_closure[0]) == want, A.tolist()
    size = np.abs(A).max()
    if want:
        assert found.combination.min() > 0
        assert np.abs(A @ found.combination).max() <= 1e-7 * size
    else:
        assert np.linalg.norm(found.certificate) > 0.5
        assert (A.T @ found.certificate).min() >= -1e-7 * size, (found, A.tolist())
    return want


def check_nguyen(theta: np.ndarray) -> bool:
    """The theorem against exact arithmetic on the same four edges."""
    found = nguyen(theta)
    assert found.force_closure == (locate_origin(found.matrix.T.tolist()).place is Location.INSIDE), theta.tolist()
    return found.force_closure


def check_three(rng: np.random.Generator) -> bool:
    """The three-finger theorem against round cones, the linear program inside and outside of them as judges."""
    points = rng.normal(size=(3, 3))
    inward = points.mean(axis=0) - points
    normals = inward / np.linalg.norm(inward, axis=1)[:, None] + 0.3 * rng.normal(size=(3, 3))
    grasp = Grasp([Contact(p, n, rng.uniform(0.3, 1.0)) for p, n in zip(points, normals, strict=True)])
    closed = three_fingers(grasp.contacts).force_closure
    assert closed == grasp.closure(margins=False).force_closure, grasp
    inner, outer = (
        bool(wrench_closures(grasp.matrix(12, outer=side)[None]).force_closure[0]) for side in (False, True)
    )
    assert inner <= closed <= outer, grasp
    return closed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    rng = np.random.default_rng(given.seed)
    closed = sum(check(wrench_set(rng)) for _ in range(given.count))
    middle, half = rng.uniform(-np.pi, np.pi, (given.count, 2)), rng.uniform(0.02, 1.2, (given.count, 2))
    pairs = np.stack([half + middle, half - middle], axis=2)
    facing = sum(check_nguyen(theta) for theta in pairs.reshape(given.count, 4))
    held = sum(check_three(rng) for _ in range(given.count))
    print(
        f"{given.count} wrench sets, {closed} closed, all routes agree; {given.count} pairs, {facing} closed; "
        f"{given.count} triples, {held} closed"
    )


if __name__ == "__main__":
    main()
