"""The robots of the library: published poses, reaches and masses, other descriptions of the same robots, and laws."""

from importlib import metadata
from math import pi
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from mafsil.errors import ModelError
from mafsil.messages import catalogue
from mafsil.model import JointKind, library
from mafsil.model.appearance import pieces
from mafsil.model.dh_from_axes import screws
from mafsil.model.library import registry, six_joints, textbook

ROBOTS = {name: library.load(name) for name in library.robots()}


def bracket(S):
    (x, y, z), v = S[:3], S[3:]
    return np.array([[0, -z, y, v[0]], [z, 0, -x, v[1]], [-y, x, 0, v[2]], [0, 0, 0, 0]])


def link_poses(mechanism, q):
    poses = {mechanism.links[0].name: mechanism.T_sb}
    for joint, value in zip(mechanism.joints, q, strict=True):
        poses[joint.child] = poses[joint.parent] @ joint.T_pj @ expm(bracket(joint.screw) * value)
    return poses


def tip_pose(mechanism, q):
    return link_poses(mechanism, q)[mechanism.tip] @ mechanism.T_lt


def inside(mechanism, rng):
    """A random configuration within the limits."""
    low, high = mechanism.limits.lower, mechanism.limits.upper
    return rng.uniform(np.where(np.isfinite(low), low, -pi), np.where(np.isfinite(high), high, pi))


# ---- every robot


@pytest.mark.parametrize("name", library.robots())
def test_robot_has_a_title_in_both_languages(name):
    for language in catalogue.LANGUAGES:
        assert name in catalogue.keys(language, "library"), f"{name} needs a line in messages/{language}/library.toml"


@pytest.mark.parametrize("name", library.robots())
def test_every_robot_says_where_its_numbers_come_from(name):
    robot = ROBOTS[name]
    assert robot.name == name
    assert len(robot.provenance.source) > 10
    assert robot.provenance.notes


@pytest.mark.parametrize("name", library.robots())
def test_every_robot_can_be_drawn(name):
    assert all(pieces(ROBOTS[name])[:-1])


@pytest.mark.parametrize("name", library.robots())
def test_limits_are_ordered_and_positive(name):
    limits = ROBOTS[name].limits
    assert (limits.lower < limits.upper).all()
    for rates in (limits.velocity, limits.acceleration, limits.jerk, limits.effort):
        assert (rates > 0).all()


NO_RIGID_BODY = {("puma560", "column"), ("puma560", "forearm")}
"""Published numbers that no rigid body has; their provenance says so."""


@pytest.mark.parametrize("name", library.robots())
def test_every_moving_link_has_the_masses_of_a_rigid_body(name):
    for link in ROBOTS[name].links[1:]:
        inertial = link.inertial
        assert inertial is not None, link.name
        np.testing.assert_array_equal(inertial.inertia, inertial.inertia.T)
        if (name, link.name) in NO_RIGID_BODY:
            continue
        small, middle, large = np.linalg.eigvalsh(inertial.inertia)
        assert inertial.mass > 0
        assert small >= -1e-15
        assert large <= (small + middle) * (1 + 1e-6) + 1e-15, link.name


@pytest.mark.parametrize("name", library.robots())
def test_mass_matrix_is_positive_definite_inside_the_limits(name):
    """M = sum J' G J by screws; only the arm of point masses may lose rank, stretched out."""
    robot, rng = ROBOTS[name], np.random.default_rng(0)
    for _ in range(5):
        q = inside(robot, rng)
        assert np.linalg.eigvalsh(mass_matrix(robot, q))[0] > 1e-9


def mass_matrix(robot, q):
    poses, columns, total = link_poses(robot, q), [], np.diag(reflected(robot))
    for joint in robot.joints:
        T = poses[joint.child]
        R, p = T[:3, :3], T[:3, 3]
        w = R @ joint.screw[:3]
        columns.append(np.array([*w, *(R @ joint.screw[3:] - np.cross(w, p))]))
        J = np.zeros((6, robot.n))
        J[:, : len(columns)] = np.transpose(columns)
        link = next(link for link in robot.links if link.name == joint.child)
        c = R @ link.inertial.com + p
        Jv = J[3:] + np.cross(J[:3].T, c).T
        total = total + link.inertial.mass * Jv.T @ Jv + J[:3].T @ R @ link.inertial.inertia @ R.T @ J[:3]
    return total


def reflected(robot):
    return [joint.actuator.reflected_inertia if joint.actuator else 0.0 for joint in robot.joints]


@pytest.mark.parametrize("name", library.robots())
def test_pinocchio_agrees_on_pose_mass_matrix_and_gravity(name):
    """The same numbers handed to another library, built joint by joint."""
    pin = pytest.importorskip("pinocchio")
    robot, rng = ROBOTS[name], np.random.default_rng(1)
    model = pin.Model()
    parent = 0
    for joint, link in zip(robot.joints, robot.links[1:], strict=True):
        np.testing.assert_array_equal(joint.axis, [0, 0, 1])
        kind = pin.JointModelPZ() if joint.kind is JointKind.PRISMATIC else pin.JointModelRZ()
        place = robot.T_sb @ joint.T_pj if parent == 0 else joint.T_pj
        parent = model.addJoint(parent, kind, pin.SE3(np.array(place)), joint.name)
        body = pin.Inertia(link.inertial.mass, np.array(link.inertial.com), np.array(link.inertial.inertia))
        model.appendBodyToJoint(parent, body, pin.SE3.Identity())
    model.gravity.linear = np.array(robot.gravity)
    data = model.createData()
    for _ in range(3):
        q = inside(robot, rng)
        pin.forwardKinematics(model, data, q)
        np.testing.assert_allclose(data.oMi[-1].homogeneous @ robot.T_lt, tip_pose(robot, q), atol=1e-12)
        M = pin.crba(model, data, q)
        M = np.triu(M) + np.triu(M, 1).T
        np.testing.assert_allclose(M, mass_matrix(robot, q) - np.diag(reflected(robot)), atol=1e-10)


# ---- published numbers


@pytest.mark.parametrize(
    ("q", "position", "approach"),
    [
        ([0, 0, 0, 0, 0, 0], [0.4521, -0.15005, 0.4318], [0, 0, 1]),
        ([0, pi / 2, -pi / 2, 0, 0, 0], [0.0203, -0.15005, 0.8636], [0, 0, 1]),
        ([0, 0, -pi / 2, 0, 0, 0], [0.8636, -0.15005, -0.0203], [1, 0, 0]),
        ([0, pi / 4, pi, 0, pi / 4, 0], [0.59630, -0.15005, -0.01435], [0, 0, -1]),
    ],
)
def test_puma_reaches_its_published_poses(q, position, approach):
    """Poses qz, qr, qs, qn of P. I. Corke, Robotics, Vision and Control."""
    T = tip_pose(ROBOTS["puma560"], q)
    np.testing.assert_allclose(T[:3, 3], position, atol=1e-5)
    if q[-2] == 0:
        np.testing.assert_allclose(T[:3, 2], approach, atol=1e-12)


def test_puma_gravity_load_at_its_nominal_pose():
    """Gravity torque at qn as printed by P. I. Corke: (0, 31.6399, 6.0351, 0, 0.0283, 0) N m."""
    robot = ROBOTS["puma560"]
    q = np.array([0, pi / 4, pi, 0, pi / 4, 0])

    def potential(q):
        poses = link_poses(robot, q)
        return -sum(
            link.inertial.mass * robot.gravity @ (poses[link.name] @ [*link.inertial.com, 1])[:3]
            for link in robot.links[1:]
        )

    step = 1e-6 * np.eye(6)
    load = [(potential(q + d) - potential(q - d)) / 2e-6 for d in step]
    np.testing.assert_allclose(load, [0, 31.6399, 6.0351, 0, 0.0283, 0], atol=1e-4)


def test_puma_mass_matrix_at_its_nominal_pose():
    """Inertia at qn as printed by P. I. Corke, motors included."""
    M = mass_matrix(ROBOTS["puma560"], np.array([0, pi / 4, pi, 0, pi / 4, 0]))
    np.testing.assert_allclose(np.diag(M), [3.6594, 4.4137, 0.9378, 0.1925, 0.1713, 0.1941], atol=1e-4)
    np.testing.assert_allclose(M[0, 1:4], [-0.4044, 0.1006, -0.0025], atol=1e-4)


def test_puma_friction_is_converted_to_the_joint():
    friction = ROBOTS["puma560"].joints[0].friction
    assert friction.viscous == pytest.approx(1.48e-3 * 62.6111**2)
    assert friction.coulomb == pytest.approx(0.395 * 62.6111)
    assert friction.coulomb_negative == pytest.approx(0.435 * 62.6111)


def test_puma_speeds_are_the_published_ones_at_the_joints():
    """Load referenced speeds of P. I. Corke, Visual control of robots, table 2.21."""
    np.testing.assert_allclose(ROBOTS["puma560"].limits.velocity, [1.92, 1.51, 2.40, 5.34, 5.09, 5.74], atol=0.005)


def test_puma_may_stand_on_its_base():
    raised = six_joints.puma560(base_height=0.672)
    np.testing.assert_allclose(
        tip_pose(raised, np.zeros(6))[:3, 3] - tip_pose(ROBOTS["puma560"], np.zeros(6))[:3, 3], [0, 0, 0.672]
    )


@pytest.mark.parametrize(
    ("name", "position"),
    [
        ("ur3e", [-0.24355 - 0.2132, -0.13105 - 0.0921, 0.15185 - 0.08535]),
        ("ur5e", [-0.425 - 0.3922, -0.1333 - 0.0996, 0.1625 - 0.0997]),
        ("ur10e", [-0.6127 - 0.57155, -0.17415 - 0.11655, 0.1807 - 0.11985]),
    ],
)
def test_universal_robots_stretched_out(name, position):
    np.testing.assert_allclose(tip_pose(ROBOTS[name], np.zeros(6))[:3, 3], position, atol=1e-15)


@pytest.mark.parametrize(("name", "reach"), [("ur3e", 0.5), ("ur5e", 0.85)])
def test_universal_robots_reach_of_the_data_sheet(name, reach):
    """From axis 1 to the flange, arm stretched out, as the data sheets round it."""
    flange = tip_pose(ROBOTS[name], np.zeros(6))[:3, 3]
    assert np.hypot(*flange[:2]) == pytest.approx(reach, abs=0.01)


def test_panda_at_rest_and_in_the_ready_pose():
    np.testing.assert_allclose(tip_pose(ROBOTS["panda"], np.zeros(7))[:3, 3], [0.088, 0, 0.926], atol=1e-15)
    ready = [0, -pi / 4, 0, -3 * pi / 4, 0, pi / 2, pi / 4]
    T = tip_pose(ROBOTS["panda"], ready)
    np.testing.assert_allclose(T[:3, 3], [0.30689, 0, 0.59028], atol=1e-5)
    np.testing.assert_allclose(T[:3, 2], [0, 0, -1], atol=1e-12)


def test_iiwa_stands_upright():
    T = tip_pose(ROBOTS["iiwa7"], np.zeros(7))
    np.testing.assert_allclose(T[:3, 3], [0, 0, 1.266], atol=1e-12)
    np.testing.assert_allclose(T[:3, :3], np.eye(3), atol=1e-15)


def test_iiwa_is_the_published_table():
    """Lengths 340, 400, 400, 126 mm, twists of a quarter turn, classic convention."""
    q = np.random.default_rng(2).uniform(-1, 1, 7)
    T = np.eye(4)
    for value, d, alpha in zip(q, [0.34, 0, 0.4, 0, 0.4, 0, 0.126], [-1, 1, 1, -1, -1, 1, 0], strict=True):
        T = T @ expm(bracket([0, 0, value, 0, 0, 0])) @ expm(bracket([0, 0, 0, 0, 0, d]))
        T = T @ expm(bracket([alpha * pi / 2, 0, 0, 0, 0, 0]))
    np.testing.assert_allclose(tip_pose(ROBOTS["iiwa7"], q), T, atol=1e-12)


def test_spherical_shoulder_and_wrist_of_the_iiwa():
    S_s = screws(ROBOTS["iiwa7"]).S_s
    for joints, height in ((slice(0, 3), 0.34), (slice(4, 7), 1.14)):
        for S in S_s[joints]:
            np.testing.assert_allclose(-np.cross(S[:3], [0, 0, height]), S[3:], atol=1e-12)


@pytest.mark.capability("02-13")
def test_melfa_has_its_published_reach_and_stands_upright_at_zero():
    """RV-7FL: 908 mm from axis 2 to the wrist centre, joint 3 such that elbow and wrist are in line."""
    robot = ROBOTS["rv7flm"]
    np.testing.assert_allclose(tip_pose(robot, np.zeros(6))[:3, 3], [-0.05, 0, 0.4 + 0.435 + 0.47 + 0.085], atol=1e-15)
    q = np.array([0, 0, np.arctan2(0.05, 0.47), 0, 0, 0])
    T = tip_pose(robot, q)
    wrist = T[:3, 3] - 0.085 * T[:3, 2]
    assert np.linalg.norm(wrist - [0, 0, 0.4]) == pytest.approx(0.908, abs=5e-4)
    forward = tip_pose(robot, np.radians([0, 0, 90, 0, 0, 0]))
    np.testing.assert_allclose(forward[:3, 2], [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(np.degrees(robot.limits.velocity), [288, 321, 360, 337, 450, 720])


def test_stanford_arm_has_its_boom_third_and_its_wrist_in_one_point():
    robot = ROBOTS["stanford_arm"]
    assert [joint.kind is JointKind.PRISMATIC for joint in robot.joints] == [False, False, True, False, False, False]
    S_s, _, home = screws(robot)
    wrist = home[:3, 3] - 10.35 * 0.0254 * home[:3, 2]
    for S in S_s[3:]:
        np.testing.assert_allclose(-np.cross(S[:3], wrist), S[3:], atol=1e-12)


def test_stanford_arm_reaches_pauls_worked_example():
    """R. P. Paul, AIM-177, table 2.1: two decimals, inches."""
    inch, turn = 0.0254, pi / 180
    q = [-95.7 * turn, -112.4 * turn, 22.16 * inch, -38.2 * turn, 80.4 * turn, 68.9 * turn]
    T = tip_pose(ROBOTS["stanford_arm"], q)
    np.testing.assert_allclose(T[:3, 3] / inch, [0.0, 19.78, 1.30], atol=0.01)
    np.testing.assert_allclose(T[:3, :3], [[-0.63, 0, -0.78], [0, 1, 0], [0.78, 0, -0.63]], atol=0.01)


def test_cobra_works_in_the_plane_and_down():
    robot = ROBOTS["cobra600"]
    np.testing.assert_allclose(tip_pose(robot, np.zeros(4))[:3, 3], [0.6, 0, 0.387], atol=1e-15)
    np.testing.assert_allclose(tip_pose(robot, [0, 0, 0.21, 0])[:3, 3], [0.6, 0, 0.177], atol=1e-15)


# ---- the same robots described by others


def robot_file(*path):
    try:
        package = metadata.distribution("example-robot-data")
    except metadata.PackageNotFoundError:
        pytest.skip("example-robot-data is not installed")
    file = Path(package.locate_file("cmeel.prefix/share/example-robot-data/robots")).joinpath(*path)
    if not file.exists():
        pytest.skip(f"{file.name} is not installed")
    return file


def pinocchio_pose(file, frame, q, base=None):
    pin = pytest.importorskip("pinocchio")
    model = pin.buildModelFromUrdf(str(file))
    data = model.createData()
    full = np.zeros(model.nq)
    full[: len(q)] = q
    pin.framesForwardKinematics(model, data, full)
    pose = data.oMf[model.getFrameId(frame)]
    return model, (data.oMf[model.getFrameId(base)].inverse() * pose if base else pose).homogeneous


def test_panda_agrees_with_its_urdf_on_poses_masses_and_limits():
    file = robot_file("panda_description", "urdf", "panda.urdf")
    robot, rng = ROBOTS["panda"], np.random.default_rng(3)
    for _ in range(5):
        q = inside(robot, rng)
        model, pose = pinocchio_pose(file, "panda_link8", q)
        np.testing.assert_allclose(tip_pose(robot, q), pose, atol=1e-9)
    for k, link in enumerate(robot.links[1:7], start=1):
        theirs = model.inertias[k]
        assert link.inertial.mass == pytest.approx(theirs.mass)
        np.testing.assert_allclose(link.inertial.com, theirs.lever, atol=1e-12)
        np.testing.assert_allclose(link.inertial.inertia, theirs.inertia, atol=1e-9)
    limits = robot.limits
    np.testing.assert_allclose(limits.lower, model.lowerPositionLimit[:7])
    np.testing.assert_allclose(limits.upper, model.upperPositionLimit[:7])
    np.testing.assert_allclose(limits.effort, model.upperEffortLimit[:7])
    np.testing.assert_allclose(limits.velocity, model.upperVelocityLimit[:7])


def test_ur5_agrees_with_its_urdf_on_poses_and_masses():
    """Masses to 3 percent: older copies of the maker's table give the forearm 2.275 kg instead of 2.33 kg."""
    file = robot_file("ur_description", "urdf", "ur5_robot.urdf")
    robot, rng = ROBOTS["ur5"], np.random.default_rng(4)
    for _ in range(5):
        q = rng.uniform(-pi, pi, 6)
        model, pose = pinocchio_pose(file, "tool0", q, base="base")
        np.testing.assert_allclose(tip_pose(robot, q), pose, atol=1e-9)
    ours = [link.inertial.mass for link in robot.links[1:]]
    theirs = [model.inertias[k].mass for k in range(1, 7)]
    np.testing.assert_allclose(ours, theirs, rtol=0.03)


# ---- parametric arms


def test_planar_arms_lie_on_the_page():
    for name in ("planar2r", "planar3r", "planar2r_point_masses"):
        np.testing.assert_array_equal(ROBOTS[name].gravity, [0, -9.81, 0])
        np.testing.assert_array_equal(screws(ROBOTS[name]).S_s[:, :3], [[0, 0, 1]] * ROBOTS[name].n)


def test_point_masses_sit_at_the_ends_of_the_links():
    arm = textbook.planar2r_point_masses((0.8, 0.5), (2.0, 1.5))
    q = np.array([0.4, -0.7])
    M = mass_matrix(arm, q)
    c2 = np.cos(q[1])
    m11 = (2.0 + 1.5) * 0.8**2 + 1.5 * (2 * 0.8 * 0.5 * c2 + 0.5**2)
    m12 = 1.5 * (0.8 * 0.5 * c2 + 0.5**2)
    np.testing.assert_allclose(M, [[m11, m12], [m12, 1.5 * 0.5**2]], atol=1e-14)


def test_offset_puma_reaches_the_closed_form_of_the_position():
    a1, a2, h, d = 0.5, 0.4, 0.6, 0.15
    arm = textbook.offset_puma(a1, a2, h, d, tool=0.0)
    q = np.array([0.3, 0.4, -0.9, 0.2, 0.1, -0.5])
    t1, t2, t23 = q[0], q[1], q[1] + q[2]
    rho, s = a1 * np.cos(t2) + a2 * np.cos(t23), a1 * np.sin(t2) + a2 * np.sin(t23)
    expected = [rho * np.cos(t1) - d * np.sin(t1), rho * np.sin(t1) + d * np.cos(t1), h + s]
    np.testing.assert_allclose(tip_pose(arm, q)[:3, 3], expected, atol=1e-14)


def test_lists_of_another_length_are_refused():
    with pytest.raises(ValueError, match="argument"):
        textbook.planar2r((1.0, 1.0), (1.0,))


# ---- the registry


def test_default_is_the_panda():
    assert library.load("default").name == "panda"


def test_names_are_sorted_and_each_is_its_makers():
    assert list(library.robots()) == sorted(registry.ROBOTS)


@pytest.mark.parametrize(
    ("name", "close"),
    [("puma", "puma560"), ("pandas", "panda"), ("ur5ee", "ur5e"), ("stanfrod_arm", "stanford_arm"), ("zzz", "panda")],
)
def test_an_unknown_name_is_answered_with_close_ones(name, close):
    with pytest.raises(ModelError, match=name) as caught:
        library.load(name)
    assert caught.value.key == "library.unknown"
    assert close in caught.value.message("en")
    assert close in caught.value.message("ar")
