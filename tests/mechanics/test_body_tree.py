"""The choice of body frames and the regrouping of inertias change expressions, never results."""

import numpy as np
import pytest

import mafsil.expression as ex
from mafsil.arrays import frozen
from mafsil.mechanics.articulated_body import articulated_body
from mafsil.mechanics.body_tree import BodyTree, RigidInertia, lump_bodies, rotation_onto
from mafsil.mechanics.frame_choice import in_chosen_frames, regroup, without_rounding
from mafsil.mechanics.quantities.forward_dynamics import by_mass_matrix, mass_matrix
from mafsil.mechanics.quantities.inverse_dynamics import inverse_dynamics
from mafsil.mechanics.tolerances import TYPED
from mafsil.model import Inertial, Joint, JointKind, Link, Mechanism

SEEDS = range(12)


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    """Any rotation, or one by right angles."""
    R = np.eye(3)[rng.permutation(3)] if rng.random() < 0.4 else np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return R * np.sign(np.linalg.det(R))


def random_tree(seed: int) -> Mechanism:
    """Branches, all kinds of joints, fixed joints between, parallel, right-angled and skew axes."""
    rng = np.random.default_rng(seed)
    links, joints = [Link("base")], []
    for i in range(int(rng.integers(2, 9))):
        A = rng.normal(size=(3, 3))
        inertial = (
            None if rng.random() < 0.1 else Inertial(2.0, frozen(rng.normal(size=3)), frozen(A @ A.T + np.eye(3)))
        )
        links.append(Link(f"link{i}", inertial))
        T = np.eye(4)
        T[:3, :3] = random_rotation(rng)
        T[:3, 3] = rng.normal(size=3) * (rng.random(3) < 0.6)
        kind = rng.choice(
            [JointKind.REVOLUTE, JointKind.REVOLUTE, JointKind.PRISMATIC, JointKind.HELICAL, JointKind.FIXED]
        )
        axis = rng.normal(size=3) if rng.random() < 0.5 else np.eye(3)[rng.integers(3)] * rng.choice([-1.0, 1.0])
        parent = links[int(rng.integers(max(0, i - 2), i + 1))].name
        joints.append(
            Joint(f"joint{i}", kind, parent, f"link{i}", frozen(T), frozen(axis / np.linalg.norm(axis)), pitch=0.3)
        )
    links.append(Link("hand", Inertial(1.0, frozen([0.1, 0.2, 0.3]), frozen(np.eye(3)))))
    joints.append(Joint("wrist", JointKind.REVOLUTE, f"link{i}", "hand"))
    return Mechanism.assemble("random", links, joints)


def efforts(tree: BodyTree, states: np.ndarray) -> np.ndarray:
    symbols = [ex.symbol(name, tree.n) for name in ("q", "qd", "qdd")]
    function = ex.Function("tau", symbols, [inverse_dynamics(tree, *symbols)])
    return np.array([function(*state).full().ravel() for state in states])


@pytest.mark.parametrize("seed", SEEDS)
def test_frames_and_grouping_leave_the_efforts_alone(seed: int) -> None:
    tree = lump_bodies(random_tree(seed))
    states = np.random.default_rng(seed).uniform(-2, 2, (5, 3, tree.n))
    reference = efforts(tree, states)
    scale = np.abs(reference).max()
    for other in (in_chosen_frames(tree), regroup(tree), regroup(in_chosen_frames(tree))):
        np.testing.assert_allclose(efforts(other, states), reference, atol=1e-12 * scale, rtol=0)


@pytest.mark.capability("09-62")
@pytest.mark.parametrize("seed", SEEDS)
def test_two_roads_to_the_acceleration(seed: int) -> None:
    tree = regroup(in_chosen_frames(lump_bodies(random_tree(seed))))
    q, qd, tau, F = (ex.symbol(name, size) for name, size in (("q", tree.n), ("qd", tree.n), ("tau", tree.n), ("F", 6)))
    M = ex.Function("M", [q], [mass_matrix(tree, q)])
    sample = M(np.ones(tree.n)).full()
    if np.linalg.eigvalsh(sample).min() < 1e-9 * np.abs(sample).max():
        pytest.skip("a massless end: the mass matrix is singular")
    methods = [
        ex.Function("qdd", [q, qd, tau, F], [method(tree, q, qd, tau, F)])
        for method in (by_mass_matrix, articulated_body)
    ]
    rng = np.random.default_rng(seed)
    for state, wrench in zip(rng.uniform(-1, 1, (5, 3, tree.n)), rng.uniform(-1, 1, (5, 6)), strict=True):
        one, other = (method(*state, wrench).full().ravel() for method in methods)
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9 * np.abs(one).max())


def test_lengths_shrink_for_a_right_angled_arm() -> None:
    """What the choice of frames is for: fewer operations."""
    from mafsil.model import library

    tree = lump_bodies(library.load("puma560"))
    symbols = [ex.symbol(name, tree.n) for name in ("q", "qd", "qdd")]

    def count(of: BodyTree) -> int:
        return len(ex.Function("tau", symbols, [ex.cse(inverse_dynamics(of, *symbols))]).order)

    assert count(regroup(tree)) < 0.9 * count(tree)
    skew = lump_bodies(random_tree(3))
    symbols = [ex.symbol(name, skew.n) for name in ("q", "qd", "qdd")]
    assert count(regroup(in_chosen_frames(skew))) < 0.9 * count(regroup(skew))


@pytest.mark.parametrize("axis", [*np.eye(3), *-np.eye(3), np.array([1e-9, 0, -1.0]), np.array([0.6, 0, -0.8])])
def test_rotation_onto_an_axis(axis: np.ndarray) -> None:
    axis = axis / np.linalg.norm(axis)
    R = rotation_onto(axis)
    np.testing.assert_allclose(R[:, 2], axis, atol=1e-16)
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=3e-16)
    assert np.linalg.det(R) == pytest.approx(1, abs=1e-15)


def test_roundoff_is_removed_and_real_angles_stay() -> None:
    typed = 1.57079632679
    c, s = np.cos(typed), np.sin(typed)
    R = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    assert (without_rounding(R) == np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])).all()
    real = np.pi / 2 - 5 * TYPED
    R = np.array([[1, 0, 0], [0, np.cos(real), -np.sin(real)], [0, np.sin(real), np.cos(real)]])
    assert (without_rounding(R) == R).all()


@pytest.mark.capability("09-27")
def test_inertia_moves_like_its_particles() -> None:
    rng = np.random.default_rng(0)
    points, masses = rng.normal(size=(20, 3)), rng.uniform(0.1, 1, 20)

    def of_particles(r: np.ndarray) -> RigidInertia:
        squares = masses @ (r**2).sum(1)
        return RigidInertia(masses.sum(), masses @ r, squares * np.eye(3) - np.einsum("k,ki,kj", masses, r, r))

    R, p = random_rotation(rng), rng.normal(size=3)
    moved, direct = of_particles(points).in_frame(R, p), of_particles(points @ R.T + p)
    np.testing.assert_allclose(moved.h, direct.h, atol=1e-13)
    np.testing.assert_allclose(moved.I, direct.I, atol=1e-12)
    com = masses @ points / masses.sum()
    central = of_particles(points - com)
    about_com = RigidInertia.about_com(masses.sum(), com, central.I)
    np.testing.assert_allclose(about_com.I, of_particles(points).I, atol=1e-12)
