"""Each number of dynamics by two methods that share no algorithm: Lagrange, twists, stacked matrices, recursions."""

import numpy as np
import pytest
from scipy.linalg import expm

import mafsil.expression as ex
from mafsil.errors import InputError
from mafsil.geometry import pose, twist
from mafsil.mechanics.body_tree import lump_bodies
from mafsil.mechanics.catalogue import quantity
from mafsil.mechanics.quantities.energy import christoffel_of
from mafsil.mechanics.rigid_body import RigidBody
from mafsil.mechanics.stacked_form import newton_euler, stacked_form, twist_torque
from mafsil.mechanics.twist_chain import TwistChain
from mafsil.model import Inertial, Joint, JointKind, Link, Mechanism, library
from mafsil.robot import Robot
from mafsil.robot.trace import trace
from tests.oracles.random_tree import random_tree
from tests.oracles.states import sample

ROBOTS = ("panda", "stanford_arm", "tree", "rods")


def rods():
    """Six links of one body each, revolute, prismatic and helical, a fixed flange behind."""
    rng = np.random.default_rng(5)
    links, joints = [Link("base", Inertial(3.0, np.array([0.1, 0.0, 0.2]), np.eye(3)))], []
    kinds = [JointKind.REVOLUTE, JointKind.REVOLUTE, JointKind.PRISMATIC, JointKind.HELICAL, JointKind.REVOLUTE]
    for k, kind in enumerate([*kinds, JointKind.FIXED]):
        inertial = Inertial(rng.uniform(0.5, 2), rng.uniform(-0.2, 0.2, 3), np.diag(rng.uniform(0.05, 0.07, 3)))
        links.append(Link(f"link{k + 1}", inertial))
        T = np.array(pose.exp(rng.uniform(-1, 1, 6)))
        axis = np.array(rng.standard_normal(3))
        pitch = 0.1 if kind is JointKind.HELICAL else 0.0
        axis = axis / np.linalg.norm(axis)
        joints.append(Joint(f"joint{k + 1}", kind, links[k].name, links[k + 1].name, T_pj=T, axis=axis, pitch=pitch))
    T_sb = np.array(pose.exp(rng.uniform(-1, 1, 6)))
    return Mechanism.assemble("rods", links, joints, T_sb=T_sb)


def mechanism_named(name):
    if name == "rods":
        return rods()
    return random_tree(np.random.default_rng(0), most_joints=12) if name == "tree" else library.load(name)


@pytest.fixture(params=ROBOTS, scope="module")
def robot(request):
    return Robot(mechanism_named(request.param))


@pytest.fixture(scope="module")
def s(robot):
    return sample(robot.mechanism, 3, np.random.default_rng(11))


def close(a, b, limit=1e-12):
    a, b = np.asarray(a), np.asarray(b)
    assert a.shape == b.shape
    assert np.abs(a - b).max() < limit * max(1.0, np.abs(b).max())


def evaluated(mechanism, build, *values):
    symbols = [ex.symbol(f"x{k}", len(value)) for k, value in enumerate(values)]
    return ex.Function("f", symbols, [build(*symbols)])(*values).full()


@pytest.mark.capability("09-9", "09-13", "09-19", "09-42", "09-48")
def test_three_roads_to_the_efforts(robot, s):
    """3-vectors in gauged frames, energies differentiated, twists at the centres of mass."""
    recursion = robot.inverse_dynamics(s.q, s.qd, s.qdd)
    close(robot.lagrange_torque(s.q, s.qd, s.qdd), recursion)
    tree = lump_bodies(robot.mechanism)
    for k in range(3):
        tau = evaluated(robot.mechanism, lambda *x: twist_torque(tree, *x), s.q[k], s.qd[k], s.qdd[k])
        close(tau.ravel(), recursion[k])


@pytest.mark.capability("09-20", "09-56", "09-57", "09-59")
def test_christoffel_symbols_by_derivatives_and_by_unit_rates(robot, s):
    """From dM/dq; and 2 Gamma_ijk = c_i(e_j + e_k) - c_i(e_j) - c_i(e_k); symmetric; C and c are their sums."""
    n, q, Gamma = robot.n, s.q[0], robot.christoffel_symbols(s.q)[0]
    M = trace(robot.mechanism, quantity("mass_matrix"), None)
    reference = evaluated(robot.mechanism, lambda x: ex.vertcat(*christoffel_of(ex.reshape(M(x), n, n), x)), q).reshape(
        n, n, n
    )
    close(Gamma, reference)
    close(Gamma, np.swapaxes(Gamma, 1, 2))
    unit = np.eye(n)
    single = robot.velocity_torque(q, unit)
    pairs = robot.velocity_torque(q, unit[:, None] + unit) - single[:, None] - single
    close(np.moveaxis(Gamma, 0, -1), pairs / 2)
    close(np.einsum("ijk,k->ij", Gamma, s.qd[0]), robot.coriolis_matrix(q, s.qd[0]))
    close(np.einsum("ijk,j,k->i", Gamma, s.qd[0], s.qd[0]), robot.velocity_torque(q, s.qd[0]))


@pytest.mark.capability("09-3")
def test_parts_of_the_velocity_efforts(robot, s):
    Gamma = robot.christoffel_symbols(s.q)
    close(robot.centrifugal_torque(s.q, s.qd), np.einsum("bijj,bj->bi", Gamma, s.qd**2))
    total = robot.centrifugal_torque(s.q, s.qd) + robot.coriolis_torque(s.q, s.qd)
    close(total, robot.velocity_torque(s.q, s.qd))


@pytest.mark.capability("09-51", "09-52", "09-53", "09-54", "09-57", "09-58")
def test_stacked_form(robot, s):
    q, qd = s.q[0], s.qd[0]
    form = stacked_form(robot.mechanism, q, qd)
    size = len(form.Gamma)
    one = np.eye(size)
    close(form.L, np.linalg.inv(one - form.Gamma))
    assert (np.linalg.matrix_power(form.Gamma, size // 6) == 0).all(), "nilpotent"
    close(form.M, robot.mass_matrix(q))
    close(form.c, robot.velocity_torque(q, qd))
    close(form.g, robot.gravity_torque(q))
    close(form.C, robot.coriolis_matrix(q, qd))
    close(form.C_newton_euler @ qd, form.c)
    close(form.C_skew @ qd, form.c)
    close(form.V, form.L @ form.A @ qd)
    # dM/dt - 2 C: skew for two of the three matrices that give c.
    dM = form.C + form.C.T
    close(dM - 2 * form.C_skew, -(dM - 2 * form.C_skew).T)
    assert abs(qd @ (dM - 2 * form.C_newton_euler) @ qd) < 1e-11 * max(1, np.abs(dM).max())


@pytest.mark.capability("09-53", "09-58")
def test_a_chain_is_nilpotent_of_no_lower_order_and_its_recursion_matrix_is_not_skew():
    mechanism = library.load("panda")
    s = sample(mechanism, 1, np.random.default_rng(0))
    form = stacked_form(mechanism, s.q[0], s.qd[0])
    assert np.abs(np.linalg.matrix_power(form.Gamma, 6)).max() > 0.1
    skew = form.C + form.C.T - 2 * form.C_newton_euler
    assert np.abs(skew + skew.T).max() > 1e-2
    with pytest.raises(InputError, match="q"):
        stacked_form(mechanism, s.q[0][:3], s.qd[0])


@pytest.mark.capability("09-41", "09-42", "09-45")
def test_link_twists_and_accelerations(robot, s):
    """Against body Jacobians of every link; gravity given back: a robot at rest does not accelerate."""
    V, dV = robot.link_twists(s.q, s.qd), robot.link_accelerations(s.q, s.qd, s.qdd)
    for k, name in enumerate(robot.mechanism.link_names):
        J, dJ = robot.jacobian_body(s.q, frame=name), robot.jacobian_body_rate(s.q, s.qd, frame=name)
        close(V[:, k], np.einsum("bij,bj->bi", J, s.qd))
        close(dV[:, k], np.einsum("bij,bj->bi", J, s.qdd) + np.einsum("bij,bj->bi", dJ, s.qd))
    close(robot.link_accelerations(s.q, 0 * s.qd, 0 * s.qdd), 0 * dV)


@pytest.mark.capability("09-43", "09-44", "09-47")
def test_link_wrenches(robot, s):
    """Their share along the joint is the effort; every link's balance of forces holds; the ground bears the rest."""
    q, qd, qdd, F_tip = (x[0] for x in s.arguments(("q", "qd", "qdd", "tip_wrench")))
    mechanism = robot.mechanism
    F, T = robot.link_wrenches(q, qd, qdd, F_tip), robot.link_poses(q)
    V, dV = robot.link_twists(q, qd), robot.link_accelerations(q, qd, qdd)
    index = {name: k for k, name in enumerate(mechanism.link_names)}
    efforts = np.zeros(robot.n)
    columns = {joint.name: c for c, joint in enumerate(mechanism.coordinates)}
    for k, link in enumerate(mechanism.links):
        balance = F[k].copy()
        for joint in mechanism.joints:
            if joint.parent == link.name:
                c = index[joint.child]
                balance -= twist_dual(np.linalg.inv(T[c]) @ T[k], F[c])
        if link.name == mechanism.tip:
            balance -= twist_dual(np.linalg.inv(mechanism.T_lt), F_tip)
        own = np.zeros(6)
        if link.inertial is not None:
            body, fall = RigidBody(link.inertial), T[k, :3, :3].T @ mechanism.gravity
            own = body.wrench(V[k], dV[k]) - body.spatial_inertia @ np.concatenate([np.zeros(3), fall])
        close(balance, own, 1e-11)
    for joint in mechanism.joints:
        if joint.moves:
            leader = joint.name if joint.mimic is None else joint.mimic.leader
            factor = 1.0 if joint.mimic is None else joint.mimic.multiplier
            c = columns[leader]
            armature = 0.0 if joint.actuator is None else joint.actuator.reflected_inertia
            efforts[c] += factor * (joint.screw @ F[index[joint.child]] + armature * factor * qdd[c])
    close(efforts, robot.inverse_dynamics(q, qd, qdd, F_tip), 1e-11)


def twist_dual(T, F):
    """Ad(T)' F."""
    return pose.adjoint(T).T @ F


@pytest.mark.capability("09-40", "09-43", "09-44")
def test_wrenches_at_the_centres_of_mass_are_those_of_the_textbook_recursion(s):
    robot = Robot(library.load("panda"))
    s = sample(robot.mechanism, 1, np.random.default_rng(1))
    chain = TwistChain.of(lump_bodies(robot.mechanism))
    values = (s.q[0], s.qd[0], s.qdd[0], s.tip_wrench[0])
    symbols = [ex.symbol(f"x{k}", len(value)) for k, value in enumerate(values)]
    rec = newton_euler(chain, *symbols)
    V, dV, F = (
        x.full() for x in ex.Function("r", symbols, [ex.horzcat(*x).T for x in (rec.V, rec.dV, rec.F)]).call(values)
    )
    carried = slice(1, 8)
    close(robot.com_twists(s.q[0], s.qd[0])[carried], V)
    close(robot.com_wrenches(*values)[carried], F)
    # The recursion's accelerations are the true ones less gravity, seen from each frame.
    gravity = np.array([np.linalg.inv(T) @ [*robot.mechanism.gravity, 0] for T in com_poses(robot, s.q[0])])[:, :3]
    true = robot.com_accelerations(*values[:3])[carried]
    close(true - np.concatenate([np.zeros((7, 3)), gravity[carried]], axis=1), dV)


def com_poses(robot, q):
    """Poses of the links turned so that their axes are parallel to {s} at zero."""
    T, home = robot.link_poses(q), robot.link_poses(np.zeros(robot.n))
    turned = T.copy()
    turned[:, :3, :3] = T[:, :3, :3] @ np.swapaxes(home[:, :3, :3], 1, 2)
    return turned


@pytest.mark.capability("09-1", "09-46")
def test_a_moving_base_is_a_robot_with_more_joints(robot, s):
    """The same arm on a helical and a prismatic joint whose motion is prescribed."""
    mechanism = robot.mechanism
    if any(joint.mimic for joint in mechanism.joints):
        pytest.skip("the names of the leaders would have to be carried over")
    rng = np.random.default_rng(8)
    screw = np.array([*(w := rng.standard_normal(3)) / np.linalg.norm(w), 0.0, 0.0, 0.0])
    joint = Joint("carrier", JointKind.HELICAL, "ground", mechanism.links[0].name, axis=screw[:3], pitch=0.3)
    links = [Link("ground"), *mechanism.links]
    carried = Robot(
        Mechanism.assemble(
            "carried",
            links,
            [joint, *mechanism.joints],
            tip=mechanism.tip,
            T_lt=mechanism.T_lt,
            T_sb=mechanism.T_sb,
            gravity=mechanism.gravity,
        )
    )
    q, qd, qdd, F = (x[0] for x in s.arguments(("q", "qd", "qdd", "tip_wrench")))
    rate, acceleration = 0.8, -1.3
    S = twist.transform(mechanism.T_sb, joint.screw)
    more = (np.concatenate([[value], x]) for value, x in ((0.0, q), (rate, qd), (acceleration, qdd)))
    efforts = carried.inverse_dynamics(*more, F)[1:]
    close(robot.inverse_dynamics(q, qd, qdd, F, S * rate, S * acceleration), efforts, 1e-11)
    named = robot.inverse_dynamics(q, qd, qdd, base_twist=S * rate, base_acceleration=S * acceleration)
    close(named, efforts - robot.jacobian_body(q).T @ F, 1e-11)
    close(robot.inverse_dynamics(q, qd, qdd, base_acceleration=0 * S), robot.inverse_dynamics(q, qd, qdd), 1e-13)


@pytest.mark.capability("09-46")
def test_a_base_that_falls_feels_no_gravity(robot, s):
    fall = np.concatenate([np.zeros(3), robot.mechanism.gravity])
    close(robot.inverse_dynamics(s.q, s.qd, 0 * s.qdd, base_acceleration=fall), robot.velocity_torque(s.q, s.qd), 1e-11)


@pytest.mark.capability("09-39", "09-40")
def test_home_poses_and_screws_give_the_relative_poses(robot, s):
    """X_i = Ad(T_ip) from the exponential of the joint screw, held against scipy's matrix exponential."""
    chain = TwistChain.of(lump_bodies(robot.mechanism))
    theta = chain.coupling @ s.q[0]
    X = evaluated(robot.mechanism, lambda q: ex.vertcat(*chain.adjoints(q)), s.q[0]).reshape(-1, 6, 6)
    for i, home in enumerate(chain.home):
        w, v = chain.A[i, :3], chain.A[i, 3:]
        bracket = np.array([[0, -w[2], w[1], v[0]], [w[2], 0, -w[0], v[1]], [-w[1], w[0], 0, v[2]], [0, 0, 0, 0]])
        T = home @ expm(bracket * theta[i])
        close(X[i], pose.adjoint(pose.inverse(T)), 1e-12)


@pytest.mark.capability("09-49", "09-50")
def test_energy_and_mass_matrix_as_sums_over_links(robot, s):
    """K = sum of V' G V / 2 and M = sum of J' G J over the links, armatures added."""
    V, M, K = robot.link_twists(s.q, s.qd), 0.0, 0.0
    for k, link in enumerate(robot.mechanism.links):
        if link.inertial is not None:
            body, J = RigidBody(link.inertial), robot.jacobian_body(s.q, frame=link.name)
            M = M + np.swapaxes(J, -1, -2) @ body.spatial_inertia @ J
            K = K + body.kinetic_energy(V[:, k])
    armature = np.zeros((robot.n, robot.n))
    columns = {joint.name: c for c, joint in enumerate(robot.mechanism.coordinates)}
    for joint in robot.mechanism.joints:
        if joint.moves and joint.actuator is not None:
            c = columns[joint.name if joint.mimic is None else joint.mimic.leader]
            factor = 1.0 if joint.mimic is None else joint.mimic.multiplier
            armature[c, c] += factor**2 * joint.actuator.reflected_inertia
    close(M + armature, robot.mass_matrix(s.q))
    close(K + np.einsum("bi,ij,bj->b", s.qd, armature, s.qd) / 2, robot.kinetic_energy(s.q, s.qd))
