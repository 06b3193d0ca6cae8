"""A single rigid body: classical and twist-wrench form, momentum, energy, changes of frame."""

import numpy as np
import pytest

from mafsil.errors import ModelError
from mafsil.geometry import pose, twist, wrench
from mafsil.mechanics.rigid_body import RigidBody
from mafsil.model import Inertial
from mafsil.model.mass_properties import particles


def cloud(seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.1, 1, 12), rng.standard_normal((12, 3))


def close(a, b, limit=1e-12):
    assert np.abs(np.asarray(a) - b).max() < limit * max(1.0, np.abs(b).max())


@pytest.mark.capability("09-23", "09-24", "09-26", "09-27", "09-30", "09-31", "09-32", "09-37")
def test_wrench_is_the_sum_over_point_masses():
    """Newton for every point: a_r = a + alpha x r + omega x (omega x r), a = dv + omega x v."""
    masses, points = cloud()
    V, dV = np.random.default_rng(1).standard_normal((2, 6))
    w, v, alpha, a = V[:3], V[3:], dV[:3], dV[3:] + np.cross(V[:3], V[3:])
    accelerations = a + np.cross(alpha, points) + np.cross(w, np.cross(w, points))
    forces = masses[:, None] * accelerations
    body = RigidBody(particles(masses, points))
    close(body.wrench(V, dV), np.concatenate([np.cross(points, forces).sum(0), forces.sum(0)]))
    velocities = v + np.cross(w, points)
    close(body.kinetic_energy(V), np.array(masses @ (velocities**2).sum(-1) / 2))
    linear = masses[:, None] * velocities
    close(body.momentum(V), np.concatenate([np.cross(points, linear).sum(0), linear.sum(0)]))


@pytest.mark.capability("09-30", "09-32", "09-37")
def test_classical_and_twist_form_agree():
    """Force and moment about the centre of mass, moved to the frame's origin, are the wrench."""
    body = RigidBody(particles(*cloud(2)))
    V, dV = np.random.default_rng(3).standard_normal((2, 50, 6))
    f = body.force(V, dV)
    m = body.moment(V, dV) + np.cross(body.inertial.com, f)
    close(body.wrench(V, dV), np.concatenate([m, f], axis=-1))
    close(body.acceleration(V, body.wrench(V, dV)), dV, 1e-10)


@pytest.mark.capability("09-33")
def test_energy_and_inertia_in_another_frame():
    body = RigidBody(particles(*cloud(4)))
    T_ab, V_b = pose.exp([0.3, -0.2, 0.9, 0.5, 1.0, -0.7]), np.random.default_rng(5).standard_normal(6)
    V_a = twist.transform(T_ab, V_b)
    close(V_a @ body.seen_from(T_ab) @ V_a / 2, body.kinetic_energy(V_b))
    close(RigidBody(Inertial(2.0, np.zeros(3), np.diag([1.0, 2, 2.5]))).spatial_inertia, np.diag([1, 2, 2.5, 2, 2, 2]))


@pytest.mark.capability("09-35", "09-36")
def test_brackets():
    """[w1 x w2] = [w1][w2] - [w2][w1]; Jacobi; [ad_V]' is dual to the bracket; it commutes with changes of frame."""
    V, W, U, F = np.random.default_rng(6).standard_normal((4, 6))
    hat = [np.array([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]]) for x in (V[:3], W[:3])]
    product = np.cross(V[:3], W[:3])
    commutator = hat[0] @ hat[1] - hat[1] @ hat[0]
    close(commutator[[2, 0, 1], [1, 2, 0]], product)
    b = twist.bracket
    close(b(V, b(W, U)) + b(W, b(U, V)) + b(U, b(V, W)), np.zeros(6))
    close(wrench.dual_bracket(V, F) @ W, F @ b(V, W))
    T = pose.exp([0.3, -0.2, 0.9, 0.5, 1.0, -0.7])
    close(twist.transform(T, b(V, W)), b(twist.transform(T, V), twist.transform(T, W)))


def test_a_thin_rod_has_no_acceleration_about_itself():
    body = RigidBody(Inertial(1.0, np.zeros(3), np.diag([0.1, 0.1, 0.0])))
    with pytest.raises(ModelError, match="principal moments"):
        body.acceleration(np.zeros(6), np.ones(6))
