"""Parametric arms: formulas, masses, kernels of families; deflection and frequencies against closed forms of beams."""

from __future__ import annotations

from math import cos, cosh, pi, sin, sinh, sqrt

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

import mafsil as mf
from mafsil.design import FlexibleArm, ParametricArm, Tube
from mafsil.design.family import ArmNumbers, may_reach, reach_and_void
from mafsil.performance.velocity.scaling import ranges

TABLE = {
    "name": "six", "convention": "modified",
    "parameters": {"upper": {"value": 0.4, "low": 0.2, "high": 0.6}, "wall": 0.004},
    "joint": [
        {"d": 0.3, "drive": {"mass": 5.0}},
        {"alpha": "-pi / 2", "tube": {"outer": 0.1, "wall": "wall", "material": "steel"},
         "drive": {"mass": 5.0, "radius": 0.06, "length": 0.1, "stiffness": 2e4}},
        {"a": "upper", "tube": {"outer": 0.08, "wall": "wall"}, "drive": {"mass": 3.0}},
        {"a": 0.05, "d": "1.1 * upper + 0.02 ** 2", "alpha": "-pi / 2", "drive": {"mass": 1.0}},
        {"alpha": "pi / 2", "drive": {"mass": 1.0}},
        {"alpha": "-(pi / 2)", "tube": {"outer": 0.05, "wall": 0.003}},
    ],
    "tool": {"xyz": [0.0, 0.0, 0.1]},
}  # fmt: skip


def test_numbers_of_formulas() -> None:
    arm = ParametricArm.of(TABLE)
    assert arm.free == ("upper",)
    robot = arm.robot(upper=0.5)
    rows = [{"d": 0.3}, {"alpha": -pi / 2}, {"a": 0.5}, {"a": 0.05, "d": 0.5504, "alpha": -pi / 2},
            {"alpha": pi / 2}, {"alpha": -pi / 2}]  # fmt: skip
    tool = np.eye(4)
    tool[2, 3] = 0.1
    plain = mf.Robot.from_dh(rows, "modified", tool=tool)
    q = np.linspace(-1, 1, 6)
    np.testing.assert_allclose(robot.fk(q), plain.fk(q), atol=1e-15)
    assert isinstance(robot.plot, object)


def test_masses_of_tubes_and_drives() -> None:
    arm = ParametricArm.of(TABLE).at(upper=0.5)
    area = lambda outer, wall: pi / 4 * (outer**2 - (outer - 2 * wall) ** 2)  # noqa: E731
    upper = 7850 * area(0.1, 0.004) * 0.5
    fore = 2700 * area(0.08, 0.004) * np.hypot(0.05, 0.5504)
    hand = 2700 * area(0.05, 0.003) * 0.1
    assert arm.mass == pytest.approx(5 + 5 + 3 + 1 + 1 + upper + fore + hand)
    # Shoulder stretched out: weight of each part times its distance, by hand.
    reach = 0.05 + 0.5
    q = np.zeros(6)
    torque = 9.81 * (upper * 0.25 + 3 * 0.5 + fore * (0.5 + 0.025) + (1 + 1 + hand) * reach)
    assert arm.robot.gravity_torque(q)[1] == pytest.approx(-torque)
    # A drive turns with the link before it: drive 2 is the shoulder's and never moves joint 2.
    shoulder = arm.robot.mechanism.links[1].inertial
    assert shoulder is not None
    assert shoulder.mass == 5.0
    assert np.trace(shoulder.inertia) == pytest.approx(5 * (0.06**2 + 0.1**2 / 6))


def test_tube_is_the_difference_of_two_cylinders() -> None:
    tube = mf.design.Tube(0.1, 0.02)
    made = tube.inertial(np.array([0.0, 0.0, 0.7]))
    outer, inner = 2700 * pi * 0.05**2 * 0.7, 2700 * pi * 0.03**2 * 0.7
    assert made.mass == pytest.approx(outer - inner)
    assert made.inertia[2, 2] == pytest.approx(outer * 0.05**2 / 2 - inner * 0.03**2 / 2)
    across = outer * (3 * 0.05**2 + 0.49) / 12 - inner * (3 * 0.03**2 + 0.49) / 12
    assert made.inertia[0, 0] == pytest.approx(across)


def test_kernels_of_a_family_are_those_of_each_robot() -> None:
    arm, rng = ParametricArm.of(TABLE), np.random.default_rng(0)
    designs = [arm.at(upper=value) for value in (0.25, 0.4, 0.55)]
    family = ArmNumbers.stack([ArmNumbers.of(design.robot) for design in designs])
    q, qd, qdd = rng.uniform(-2, 2, (3, 3, 6))
    F = rng.normal(size=(3, 6))
    T, J = family.pose_and_jacobian(q)
    tau = family.torque(q, qd, qdd, F)
    for k, design in enumerate(designs):
        np.testing.assert_allclose(T[k], design.robot.fk(q[k]), atol=1e-14)
        np.testing.assert_allclose(J[k], design.robot.jacobian_body(q[k]), atol=1e-14)
        np.testing.assert_allclose(tau[k], design.robot.inverse_dynamics(q[k], qd[k], qdd[k], F[k]), atol=1e-12)


@pytest.mark.parametrize("name", ["puma560", "panda", "cobra600", "scara_rrrp"])
def test_numbers_of_library_arms(name: str) -> None:
    robot = mf.load(name)
    numbers = ArmNumbers.of(robot)
    q = np.random.default_rng(1).uniform(-1, 1, (5, robot.n))
    np.testing.assert_allclose(numbers.pose_and_jacobian(q)[0], robot.fk(q), atol=1e-14)
    tau = robot.inverse_dynamics(q, q, q) if robot.mechanism.links[1].inertial else np.zeros_like(q)
    np.testing.assert_allclose(numbers.torque(q, q, q, np.zeros(6)), tau, atol=1e-12)


def test_files_and_their_faults(tmp_path) -> None:
    file = tmp_path / "arm.toml"
    text = """
convention = "modified"
[parameters]
l = { value = 0.4, low = 0.2, high = 0.6 }
[[joint]]
tube = { outer = 0.1, wall = 0.01 }
[[joint]]
a = "l"
"""
    file.write_text(text)
    assert ParametricArm.of(file).robot(l=0.3).n == 2
    for old, new, word in (
        ('"l"', '"m"', "'m'"),
        ('"l"', '"l("', "no value"),
        ('"l"', '"1 / 0"', "no value"),
        ('"l"', '"9.0 ** 9999"', "no value"),
        ('"l"', '"(-1.0) ** 0.5"', "no value"),
        ('"l"', '"l.real"', "no value"),
        ('"l"', '"' + "(" * 300 + '"', "no value"),
        ("outer", "out", "outer"),
        ("0.01 }", '0.01, material = "wood" }', "steel"),
        ("low = 0.2", "low = 0.5", "value"),
        ("wall = 0.01", "wall = 0.06", "wall"),
        ("{ outer = 0.1, wall = 0.01 }", "3", "table"),
        ("outer = 0.1, ", "", "outer"),
        ("outer = 0.1", "outer = nan", "number"),
        ("value = 0.4", 'value = "x"', "number"),
        ("[[joint]]\na", "[[joint]]\nb", "b"),
        ("[parameters]", "parameters = 3\n[other]", "parameters"),
    ):
        file.write_text(text.replace(old, new))
        with pytest.raises(mf.MafsilError, match=word):
            ParametricArm.of(file)
    file.write_text(text)
    arm = ParametricArm.of(file)
    for wrong in ({"l": 0.7}, {"m": 0.3}, {"l": float("nan")}, {"l": "x"}):
        with pytest.raises(mf.InputError):
            arm.at(**wrong)


L, OUTER, WALL, g = 0.8, 0.08, 0.004, 9.81
TUBE = {"outer": OUTER, "wall": WALL, "material": "steel"}
SECTION = Tube(OUTER, WALL, mf.design.parts.MATERIALS["steel"])
E, G, I, A = SECTION.material.young, SECTION.material.shear, SECTION.second_moment, SECTION.area
LINE = SECTION.material.density * A


def beam(**joint: object) -> mf.design.ArmDesign:
    """One link along x, its joint about y."""
    table = {"convention": "frames", "joint": [{"axis": [0.0, 1.0, 0.0], "tube": TUBE, **joint}]}
    return ParametricArm.of({**table, "tool": {"xyz": [L, 0.0, 0.0]}}).at()


def test_section_of_a_tube_is_that_of_two_discs() -> None:
    inner = OUTER - 2 * WALL
    assert pytest.approx(pi / 4 * (OUTER**2 - inner**2)) == A
    assert pytest.approx(pi / 64 * (OUTER**4 - inner**4)) == I
    with pytest.raises(mf.InputError, match="wall"):
        Tube(0.1, 0.06)


def test_cantilever_under_its_weight_a_payload_and_a_wrench() -> None:
    arm = FlexibleArm(beam(), payload=5.0)
    weight, push = LINE * g, 5.0 * g
    sag, slope = (
        weight * L**4 / (8 * E * I) + push * L**3 / (3 * E * I),
        weight * L**3 / (6 * E * I) + push * L**2 / (2 * E * I),
    )
    np.testing.assert_allclose(arm.deflection([0.0]), [0, slope, 0, 0, 0, -sag], rtol=1e-9, atol=1e-15)
    C = FlexibleArm(beam()).compliance([0.0]).reshape(6, 6)
    assert C[0, 0] == pytest.approx(L / (G * 2 * I))
    assert C[3, 3] == pytest.approx(L / (E * A))
    assert C[4, 4] == pytest.approx(L**3 / (3 * E * I))
    assert C[2, 4] == pytest.approx(L**2 / (2 * E * I))
    np.testing.assert_allclose(C, C.T, atol=1e-18)


@pytest.mark.parametrize("payload", [0.0, 2.0, 50.0])
def test_frequencies_of_a_cantilever_with_a_mass_at_its_end(payload: float) -> None:
    """1 + cos b cosh b + mu b (cos b sinh b - sin b cosh b) = 0, mu = payload / mass of the beam."""
    mu = payload / (LINE * L)

    def condition(b: float) -> float:
        return 1 + cos(b) * cosh(b) + mu * b * (cos(b) * sinh(b) - sin(b) * cosh(b))

    first = brentq(condition, 0.1, 1.9)
    second = brentq(condition, 3.8, 4.8)
    wanted = [b**2 / L**2 * sqrt(E * I / LINE) / (2 * pi) for b in (first, second)]
    found = FlexibleArm(beam(), payload=payload).frequencies([0.3], 6)
    # Both planes of a round tube: each frequency twice, and stretch and torsion among them.
    np.testing.assert_allclose(found[:2], wanted[0], rtol=2e-4)
    assert (np.abs(found / wanted[1] - 1) < 5e-3).sum() == 2


def test_spring_of_a_joint_alone() -> None:
    table = {"convention": "frames", "tool": {"xyz": [L, 0.0, 0.0]}}
    design = ParametricArm.of({**table, "joint": [{"axis": [0.0, 1.0, 0.0], "drive": {"stiffness": 3e3}}]}).at()
    arm = FlexibleArm(design, payload=4.0)
    assert arm.deflection([0.0])[5] == pytest.approx(-4.0 * g * L * L / 3e3)
    assert arm.frequencies([0.0], 1)[0] == pytest.approx(sqrt(3e3 / (4.0 * L**2)) / (2 * pi))
    assert np.isinf(arm.frequencies([0.0], 2)[1])


def pieces(
    q: tuple[float, float], lengths: tuple[float, float], springs: tuple[float, float], payload: float, per: int
):
    """A plane arm of rigid pieces with springs between them: sag of the tip and lowest frequency, by virtual work.

    Nothing is shared with the finite elements: positions of midpoints are differentiated with respect to the bends.
    """
    angles, steps, stiffness = [], [], []
    for k, length in enumerate(lengths):
        h = length / per
        # Half pieces at both ends, so that hinges lie where the bending is lumped.
        steps += [h / 2, *([h] * (per - 1)), h / 2]
        stiffness += [springs[k], *([E * I / h] * per)]
        angles += [q[k], *([0.0] * per)]
    directions = np.cumsum(angles)
    ends = np.concatenate(
        [[[0.0, 0.0]], np.cumsum(np.array(steps)[:, None] * np.stack([np.cos(directions), np.sin(directions)], 1), 0)]
    )
    N = len(steps)
    middle = (ends[1:] + ends[:-1]) / 2

    def jacobian(point: np.ndarray, upto: int) -> np.ndarray:
        away = [point - ends[i] if i <= upto else np.zeros(2) for i in range(N)]
        return np.array([[-y, x] for x, y in away]).T

    K, M, load = np.diag(stiffness), np.zeros((N, N)), np.zeros(N)
    for i, h in enumerate(steps):
        J, w = jacobian(middle[i], i), np.array([1.0 if j <= i else 0.0 for j in range(N)])
        M += LINE * h * (J.T @ J + h**2 / 12 * np.outer(w, w))
        load += J.T @ np.array([0.0, -LINE * h * g])
    J = jacobian(ends[-1], N)
    M += payload * J.T @ J
    load += J.T @ np.array([0.0, -payload * g])
    sag = J @ np.linalg.solve(K, load)
    lowest = np.linalg.eigvals(np.linalg.solve(K, M)).real.max()
    return sag, 1 / sqrt(lowest) / (2 * pi)


@pytest.mark.parametrize("q", [(0.0, 0.0), (0.4, 0.9), (1.2, -2.0)])
def test_plane_arm_against_rigid_pieces_with_springs(q: tuple[float, float]) -> None:
    lengths, springs, payload = (0.6, 0.5), (4e4, 2e4), 3.0
    table = {
        "convention": "frames",
        "gravity": [0.0, -g, 0.0],
        "tool": {"xyz": [lengths[1], 0.0, 0.0]},
        "joint": [
            {"tube": TUBE, "drive": {"stiffness": springs[0]}},
            {"xyz": [lengths[0], 0.0, 0.0], "tube": TUBE, "drive": {"stiffness": springs[1]}},
        ],
    }
    arm = FlexibleArm(ParametricArm.of(table).at(), payload=payload)
    sag, lowest = pieces(q, lengths, springs, payload, 80)
    np.testing.assert_allclose(arm.deflection(list(q))[3:5], sag, rtol=0.01, atol=1e-7)
    # The arm also sways out of its plane: its frequency in the plane is among the first.
    found = arm.frequencies(list(q), 4)
    assert np.abs(found / lowest - 1).min() < 0.01
    assert arm.deflection([q, q]).shape == (2, 6)


@pytest.mark.parametrize("name", ["puma560", "ur5e", "panda", "iiwa7", "planar3r", "stanford_arm"])
@pytest.mark.parametrize("task", ["pose", "position"])
def test_poses_that_an_arm_has_are_never_proved_out_of_reach(name: str, task: str) -> None:
    robot, rng = mf.load(name), np.random.default_rng(0)
    arm = ArmNumbers.stack([ArmNumbers.of(robot)]).spread()
    poses = robot.fk(rng.uniform(-pi, pi, (2000, robot.n)))
    assert may_reach(arm, poses, task).all()
    (far,), _ = reach_and_void(
        ArmNumbers.stack([ArmNumbers.of(robot)]), np.full((1, robot.n), -pi), np.full((1, robot.n), pi)
    )
    away = poses.copy()
    away[:, :3, 3] += 3.0 * far * rng.choice([-1.0, 1.0], (2000, 3))
    assert may_reach(arm, away, task).all() == (name == "stanford_arm")


@pytest.mark.parametrize("name", ["puma560", "ur5e", "panda", "iiwa7", "planar3r", "stanford_arm"])
def test_no_configuration_is_farther_or_nearer_than_the_extreme_distances(name: str) -> None:
    robot = mf.load(name)
    arm, (low, high) = ArmNumbers.of(robot), ranges(robot)
    away = np.linalg.norm(
        robot.fk(np.random.default_rng(3).uniform(low, high, (200_000, robot.n)))[:, :3, 3] - arm.shoulder, axis=1
    )
    (far,), (near,) = reach_and_void(ArmNumbers.stack([arm]), low[None], high[None])
    assert near <= away.min()
    assert away.max() <= far
    assert away.max() > 0.97 * far


SPATIAL = {
    "convention": "frames", "gravity": [0.0, 0.0, -9.81],
    "joint": [
        {"axis": [0, 0, 1], "tube": {"outer": 0.1, "wall": 0.005, "material": "steel"}, "drive": {"stiffness": 4e4}},
        {"xyz": [0.0, 0.0, 0.5], "axis": [0, 1, 0], "tube": {"outer": 0.08, "wall": 0.003},
         "drive": {"mass": 4.0, "stiffness": 2e4}},
        {"xyz": [0.6, 0.1, 0.0], "axis": [0, 1, 0], "tube": {"outer": 0.06, "wall": 0.003},
         "drive": {"mass": 2.0, "stiffness": 1e4}},
    ],
    "tool": {"xyz": [0.5, 0.0, 0.1]},
}  # fmt: skip


def finite_elements(design: mf.design.ArmDesign, q: np.ndarray, payload: float, per: int = 12) -> tuple:
    """Sag (3,) of the tip and two lowest frequencies by linear elements with one point of integration, lumped masses.

    Nothing is shared with the house's beams: displacements and rotations are interpolated apart, the strains at the
    middle are u' + r x t (shear made stiff by a thousand), r' (bending, torsion) and t . u' (stretch).
    """
    robot, g = design.robot, np.array([0.0, 0.0, -9.81])
    frames = [robot.fk(q, frame=link.name) for link in robot.mechanism.links[1:]]
    ends = [*(T[:3, 3] for T in frames), robot.fk(q)[:3, 3]]
    n = len(frames)
    N = n * (6 * per + 1)
    K, M, load = np.zeros((N, N)), np.zeros((N, N)), np.zeros(N)
    before, free = np.zeros((6, N)), 0  # displacement and rotation of the node that stands

    def add_mass(mass: float, at: np.ndarray) -> None:
        M[:] += mass * at[:3].T @ at[:3]
        load[:] += mass * at[:3].T @ g

    for k, (T, tube, drive) in enumerate(zip(frames, design.tubes, design.drives, strict=True)):
        add_mass(drive.mass if k else 0.0, before)
        K[free, free] += drive.stiffness
        before = before.copy()
        before[3:, free] += T[:3, :3] @ np.asarray(robot.mechanism.joints[k].axis)
        free += 1
        h = np.linalg.norm(ends[k + 1] - ends[k]) / per
        t, mass = (ends[k + 1] - ends[k]) / (h * per), tube.material.density * tube.area * h
        along, across = np.outer(t, t), np.eye(3) - np.outer(t, t)
        E, G, A, I = tube.material.young, tube.material.shear, tube.area, tube.second_moment
        cross_t = np.array([[0.0, t[2], -t[1]], [-t[2], 0.0, t[0]], [t[1], -t[0], 0.0]])  # r -> r x t
        for _ in range(per):
            after = np.zeros((6, N))
            after[:, free : free + 6] = np.eye(6)
            free += 6
            slope, bend = (after[:3] - before[:3]) / h, (after[3:] - before[3:]) / h
            shear = across @ (slope - cross_t @ (after[3:] + before[3:]) / 2)
            K += h * (1e3 * G * A * shear.T @ shear + E * A * slope.T @ along @ slope)
            K += h * bend.T @ (E * I * across + 2 * G * I * along) @ bend
            for node in (before, after):
                add_mass(mass / 2, node)
                M += mass * I / A * node[3:].T @ along @ node[3:]
            before = after
    add_mass(payload, before)
    slow = eigh(M, K, eigvals_only=True, subset_by_index=[N - 2, N - 1])
    return before[:3] @ np.linalg.solve(K, load), 1 / np.sqrt(slow[::-1]) / (2 * pi)


@pytest.mark.parametrize(("q", "payload"), [((0.3, 0.4, 0.5), 0.0), ((-1.0, -0.6, 1.4), 3.0), ((2.0, 0.1, -0.2), 12.0)])
def test_an_arm_in_space_against_finite_elements_within_one_percent(q: tuple, payload: float) -> None:
    design = ParametricArm.of(SPATIAL).at()
    sag, frequencies = finite_elements(design, np.array(q), payload)
    arm = FlexibleArm(design, payload=payload)
    np.testing.assert_allclose(arm.deflection(q)[3:], sag, atol=0.01 * np.linalg.norm(sag))
    np.testing.assert_allclose(arm.frequencies(q, 2), frequencies, rtol=0.01)
