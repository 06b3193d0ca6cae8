"""Worked examples of the book by number: live objects, printed numbers, ours, and errata."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from math import pi, radians
from typing import Any, ClassVar

import numpy as np

import mafsil.control as control
import mafsil.mobility as mo
import mafsil.one_joint as oj
import mafsil.parallel as pa
from mafsil.book.entry import Entry, EntryStatus, Fact, Index
from mafsil.geometry import planar
from mafsil.grasp import Contact, Grasp
from mafsil.model import Inertial
from mafsil.model.library.textbook import planar2r_point_masses
from mafsil.one_joint.drives import Gear, matching_ratio
from mafsil.performance.singularities import rank
from mafsil.robot import Robot, as_robot

Worked = tuple[Mapping[str, Any], Iterable[Fact]]
"""Objects by name and facts of an example."""


@dataclass(frozen=True, eq=False, repr=False)
class Example(Entry):
    """A worked example of the book: what it is about, its printed numbers and ours; see `Entry`."""

    AREA: ClassVar[str] = "book_examples"


_INDEX: Index[Callable[[], Worked]] = Index(("remarks",), "book.unknown_example")


def works(number: str) -> Callable[[Callable[[], Worked]], Callable[[], Worked]]:
    """Declare what computes a worked example.

    Args:
        number: as the source has it, with a name where the source has none: "5.1.4 RRRP".
    """

    def declare(compute: Callable[[], Worked]) -> Callable[[], Worked]:
        _INDEX.declare(number, compute)
        return compute

    return declare


def example(number: str, /) -> Example:
    """A worked example of the book.

    Args:
        number: such as "2.4" or "5.1.4 RRRP".

    Raises:
        InputError: no example of that number.
    """
    objects, facts = _INDEX[number]()
    return Example(number, EntryStatus.FIXED, objects, tuple(facts))


def examples() -> list[str]:
    """Numbers of all worked examples of the book that are computed here."""
    return _INDEX.numbers()


def _count(**printed: int) -> Worked:
    """Mobility of mechanisms of the library beside the printed one, by name."""
    reports = {name: mo.mobility(name) for name in printed}
    return reports, [Fact(name, reports[name].count.mobility, value) for name, value in printed.items()]


@works("2.1")
def four_bar_and_slider_crank() -> Worked:
    """One freedom each, the slider-crank counted twice."""
    return _count(four_bar=1, slider_crank=1, slotted_slider_crank=1)


@works("2.2")
def planar_classics() -> Worked:
    """Serial chain of three links, five-bar, six-bars."""
    objects, facts = _count(five_bar=2, stephenson=1, watt=1)
    chain = mo.mobility(mo.library.chain(3))
    return {**objects, "chain": chain}, [Fact("chain", chain.mobility, 3), *facts]


@works("2.3")
def overlapping_joints() -> Worked:
    """Two joints at one place."""
    objects, facts = _count(overlapping_joints=3)
    linkage = objects["overlapping_joints"].linkage
    return objects, [*facts, Fact("links", len(linkage.bodies), 7), Fact("joints", len(linkage.joints))]


@works("2.4")
def singular_cases() -> Worked:
    """A parallelogram whose third crank changes nothing; a five-bar that moves with both motors locked."""
    cranks = mo.mobility("three_cranks")
    robot = pa.FiveBar(2**0.5, 1.4, 1.4, 2**0.5, 2.0)
    theta = robot.chain_angles([pi / 4, 3 * pi / 4])
    H = robot.chain.loop_matrix(theta[:4])
    locked = 3 - int(np.linalg.matrix_rank(H[:, 1:4], tol=1e-9))
    facts = (
        Fact("count", cranks.count.mobility, 0), Fact("true", cranks.mobility, 1), Fact("locked", locked, 1),
        Fact("rank", int(np.linalg.matrix_rank(H))),
    )  # fmt: skip
    return {"three_cranks": cranks, "five_bar": robot, "theta": theta}, facts


@works("2.5")
def stewart_gough() -> Worked:
    """Six freedoms; twelve if every leg has two balls."""
    objects, facts = _count(six_ups=6, six_sps=12)
    linkage = objects["six_ups"].linkage
    return objects, [*facts, Fact("links", len(linkage.bodies), 14), Fact("joints", len(linkage.joints), 18)]


@works("2.6")
def three_upu() -> Worked:
    """Three freedoms by count, more at home with radial axes."""
    objects, facts = _count(three_upu=3)
    radial = mo.mobility("radial_three_upu")
    return {**objects, "radial": radial}, [*facts, Fact("at_home", radial.instantaneous.rates.shape[1])]


@works("2.7")
def scara_task() -> Worked:
    """Task space of a SCARA: place and heading."""
    robot = as_robot("scara_rrrp")
    task = int(np.linalg.matrix_rank(robot.jacobian_space([0.3, 0.7, -0.4, 0.1])))
    return {"robot": robot}, [Fact("task", task, 4), Fact("joints", robot.n, 4)]


@works("2.8")
def spray_arm_task() -> Worked:
    """Task space of a spray-painting arm: place and direction of the nozzle."""
    robot, q = as_robot("elbow6r"), np.array([0.3, 0.5, -0.7, 0.4, 0.6, -0.2])
    J, z = robot.jacobian(q), robot.forward_kinematics(q)[:3, 2]
    cross = np.array([[0, -z[2], z[1]], [z[2], 0, -z[0]], [-z[1], z[0], 0]])
    task = int(np.linalg.matrix_rank(np.vstack([-cross @ J[:3], J[3:]]), tol=1e-9))
    facts = Fact("task", task, 5), Fact("redundancy", robot.n - task), Fact("rank", int(rank(robot, q)))
    return {"robot": robot, "q": q}, facts


@works("3.2.2")
def rectangle() -> Worked:
    """A rectangle held by four frictionless contacts, as printed and as the text means it."""

    def held(signs: tuple[float, float], l: tuple[float, float, float, float]) -> Grasp:
        places = ([l[0], 1.5], [2.5, l[1]], [signs[0] * l[2], -1.5], [-2.5, signs[1] * l[3]])
        pushes = ([0.0, -1.0], [-1.0, 0.0], [0.0, 1.0], [1.0, 0.0])
        return Grasp([Contact(place, push) for place, push in zip(places, pushes, strict=True)])

    printed, meant = held((1.0, 1.0), (1.0, 1.2, 1.2, 1.0)), held((-1.0, -1.0), (1.0, 1.2, 1.2, 1.0))
    facts = Fact("printed_signs", int(bool(printed.closure())), 1), Fact("pinwheel", int(bool(meant.closure())), 1)
    return {"printed": printed, "pinwheel": meant}, facts


@works("3.2.4")
def l_shaped_body() -> Worked:
    """A finger in the inner corner is two contacts; two more hold the body."""
    L = 2.0
    contacts = (([0, 0], [-1, 0]), ([0, 0], [0, -1]), ([-1, L], [1, 0]), ([L, -1], [0, 1]))
    grasp = Grasp([Contact(np.array(place, float), np.array(push, float)) for place, push in contacts])
    closure = grasp.closure()
    A = np.array([[n[0], n[1], p[0] * n[1] - p[1] * n[0]] for p, n in contacts], dtype=np.float64).T
    null = np.linalg.svd(A)[2][-1]
    facts = Fact("closure", int(bool(closure)), 1), Fact("null", null / null[0], [1, 1, 1, 1])
    return {"grasp": grasp, "closure": closure, "A": A}, facts


@works("3.3.1")
def box_between_fingers() -> Worked:
    """Two fingers with friction hold a box for every friction above zero."""
    pairs = {
        mu: Grasp([Contact([-1.0, 0.0], [1.0, 0.0], mu), Contact([1.0, 0.0], [-1.0, 0.0], mu)]) for mu in (0.5, 0.0)
    }
    facts = (
        Fact("with_friction", int(bool(pairs[0.5].closure())), 1),
        Fact("without", int(bool(pairs[0.0].closure())), 0),
    )
    return {"grasps": pairs}, [*facts, Fact("push", 9.81 / (2 * 0.5), unit="N")]


@works("4.1")
def planar_frames() -> Worked:
    """Three frames in the plane: r = p + P q, R = P Q."""
    T_sb, T_sc = planar.pose(pi / 6, [1.0, 2.0]), planar.pose(pi / 3, [2.0, 1.0])
    T_bc = planar.compose(planar.inverse(T_sb), T_sc)
    facts = Fact("q", T_bc[:2, 2], unit="m"), Fact("turn", float(planar.angle(T_bc[:2, :2])), unit="rad")
    return {"T_sb": T_sb, "T_bc": T_bc, "T_sc": T_sc}, facts


@works("4.3.2")
def camera_and_mobile_arm() -> Worked:
    """Camera on the ceiling, mobile base, arm, body: the pose of the body for the gripper."""
    r = 0.5**0.5
    T_db = np.array([[0, 0, -1, 250], [0, -1, 0, -150], [-1, 0, 0, 200], [0, 0, 0, 1.0]])
    T_de = np.array([[0, 0, -1, 300], [0, -1, 0, 100], [-1, 0, 0, 120], [0, 0, 0, 1.0]])
    T_ad = np.array([[0, 0, -1, 400], [0, -1, 0, 50], [-1, 0, 0, 300], [0, 0, 0, 1.0]])
    T_bc = np.array([[0, -r, -r, 30], [0, r, -r, -40], [1, 0, 0, 20], [0, 0, 0, 1.0]])
    T_ac = T_ad @ T_db @ T_bc
    T_ce = np.linalg.inv(T_ac) @ T_ad @ T_de
    facts = (
        Fact("T_ab", (T_ad @ T_db)[:3, 3], unit="mm"), Fact("height", T_ac[2, 3], 75.0, "mm"),
        Fact("T_ce_x", T_ce[0, 3], -75.0, "mm"), Fact("T_ce_z", T_ce[2, 3], 130 * r, "mm"),
    )  # fmt: skip
    return {"T_ac": T_ac, "T_ce": T_ce}, facts


@works("4.3.3.2")
def planar_logarithm() -> Worked:
    """The pole of a planar displacement and its logarithm."""
    T = planar.displacement(planar.pose(radians(30.0), [1.0, 2.0]), planar.pose(radians(60.0), [2.0, 1.0]))
    pole = planar.finite_pole(T)[0]
    S = planar.log(T)
    facts = Fact("angle", float(S[0]), pi / 6, "rad"), Fact("pole", pole, [3.0, 3.0], "m")
    return {"T": T, "log": S}, [*facts, Fact("v", S[1:] / S[0], [3.0, -3.0], "m")]


def _home(name: str, place: list[float]) -> Worked:
    """Where the tip of an arm of the library is at zero, lengths of 1 m."""
    robot = as_robot(name)
    return {"robot": robot}, [Fact("home", robot.forward_kinematics(np.zeros(robot.n))[:3, 3], place, "m")]


def _screws(name: str, printed: dict[int, list[float]], *, body: bool = False) -> Worked:
    """Linear parts of joint screws at zero beside the printed ones, by number of the joint; lengths of 1 m."""
    robot = as_robot(name)
    S = (robot.jacobian_body if body else robot.jacobian_space)(np.zeros(robot.n))
    facts = [Fact(f"v_{k}", S[3:, k - 1], value, "m") for k, value in printed.items()]
    return {"robot": robot, "screws": S}, facts


@works("5.1.4 3R")
def spatial_3r_by_dh() -> Worked:
    """Spatial 3R by Denavit-Hartenberg."""
    return _home("spatial3r", [1.0, 0.0, -1.0])


@works("5.1.4 RRRP")
def rrrp_by_dh() -> Worked:
    """RRRP by Denavit-Hartenberg."""
    return _home("rrrp", [1.0, 0.0, 0.0])


@works("5.1.4 6R")
def six_r_by_dh() -> Worked:
    """6R elbow arm by Denavit-Hartenberg."""
    return _home("elbow6r", [2.0, 0.0, 0.0])


@works("5.2.2 3R")
def spatial_3r_by_exponentials() -> Worked:
    """Spatial 3R by a product of exponentials."""
    return _screws("spatial3r", {2: [0.0, 0.0, -1.0], 3: [0.0, 1.0, 0.0]})


@works("5.2.2 6R")
def six_r_by_exponentials() -> Worked:
    """6R arm by a product of exponentials in the space frame."""
    return _screws("arm6r", {4: [0.0, 0.0, -1.0], 5: [0.0, 0.0, -2.0]})


@works("5.2.2 RRPRRR")
def rrprrr_by_exponentials() -> Worked:
    """RRPRRR arm by a product of exponentials."""
    return _screws("rrprrr", {3: [0.0, 1.0, 0.0], 5: [0.0, 0.0, -1.0]})


@works("5.2.4")
def six_r_in_the_body_frame() -> Worked:
    """6R arm by a product of exponentials in the body frame."""
    return _screws("arm6r", {1: [-3.0, 0.0, 0.0], 4: [0.0, 0.0, -2.0], 5: [0.0, 0.0, -1.0]}, body=True)


@works("6.1.1 RRRP")
def jacobian_of_rrrp() -> Worked:
    """Space Jacobian of an RRRP arm."""
    robot, q = as_robot("scara_rrrp"), np.array([0.4, 0.7, -0.3, 0.2])
    s1, c1, s12, c12 = np.sin(0.4), np.cos(0.4), np.sin(1.1), np.cos(1.1)
    J = robot.jacobian_space(q)
    facts = Fact("v_2", J[3:, 1], [s1, -c1, 0.0], "m"), Fact("v_3", J[3:, 2], [s1 + s12, -c1 - c12, 0.0], "m")
    return {"robot": robot, "q": q, "J": J}, [*facts, Fact("v_4", J[3:, 3], [0.0, 0.0, -1.0])]


@works("6.1.1 RRPRRR")
def jacobian_of_rrprrr() -> Worked:
    """Space Jacobian of an RRPRRR arm."""
    robot, q = as_robot("rrprrr_upright"), np.array([0.4, 0.3, 0.2, 0.6, -0.5, 0.1])
    J = robot.jacobian_space(q)
    facts = Fact("w_5", J[:3, 4]), Fact("length", float(np.linalg.norm(J[:3, 4])))
    return {"robot": robot, "q": q, "J": J}, [*facts, Fact("rank", int(np.linalg.matrix_rank(J)))]


@works("9.1.1 particle")
def vertical_particle() -> Worked:
    """A particle that a force lifts."""
    mass, acceleration = 2.0, 1.5
    point = Inertial(mass, np.zeros(3))
    robot = Robot.from_screws(np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 1.0]]), np.eye(4), inertials=[point])
    force = float(robot.inverse_dynamics([0.3], [0.7], [acceleration])[0])
    return {"robot": robot}, [Fact("force", force, mass * acceleration + mass * 9.81, "N")]


@works("9.1.1 2R")
def planar_2r_dynamics() -> Worked:
    """Torques of a planar 2R arm with point masses."""
    L1, L2, m1, m2 = 0.8, 0.5, 2.0, 1.5
    robot = as_robot(planar2r_point_masses((L1, L2), (m1, m2)))
    q, qd, qdd = np.array([0.4, -0.7]), np.array([1.2, -0.5]), np.array([0.9, 2.1])
    tau, h, g = robot.inverse_dynamics(q, qd, qdd), m2 * L1 * L2, 9.81
    c2, s2, c12 = np.cos(q[1]), np.sin(q[1]), np.cos(q.sum())
    first = ((m1 + m2) * L1**2 + m2 * L2**2 + 2 * h * c2) * qdd[0] + (m2 * L2**2 + h * np.cos(q[0])) * qdd[1]
    first += -h * s2 * (2 * qd[0] * qd[1] + qd[1] ** 2) + (m1 + m2) * g * L1 * np.cos(q[0]) + m2 * g * L2 * c12
    second = (m2 * L2**2 + h * c2) * qdd[0] + m2 * L2**2 * qdd[1] - h * qd[0] * qd[1] * s2 - m2 * g * L2 * c12
    facts = Fact("tau_1", float(tau[0]), float(first), "N m"), Fact("tau_2", float(tau[1]), float(second), "N m")
    return {"robot": robot, "q": q, "qd": qd, "qdd": qdd}, facts


@works("10 gear")
def gear() -> Worked:
    """Shares of motor and link in the apparent inertia, and the ratio at which they are equal."""
    direct, geared = Gear.of(1.0, 1e-3), Gear.of(100.0, 1e-3)
    ratio = float(matching_ratio(1.0, 1e-3))
    facts = (
        Fact("link_share", 100 * (1 - float(direct.motor_share(1.0))), 99.0, "%"),
        Fact("motor_share", 100 * float(geared.motor_share(1.0)), unit="%"), Fact("ratio", ratio),
        Fact("half", float(Gear.of(ratio, 1e-3).motor_share(1.0))),
    )  # fmt: skip
    return {"direct": direct, "geared": geared}, facts


@works("10 damper")
def damper() -> Worked:
    """Which velocities and forces can be prescribed against a damper."""
    B = np.array([[2.0, 1.0], [1.0, 1.0]])
    free = control.contact.selection(B, [[0, 0], [1, 0]], [[1, 0], [0, 0]], [1.0, 5.0])
    conflict = control.contact.selection(B, [[1, 0], [0, 0]], [[0, 0], [2, 1]])
    facts = (
        Fact("V_2", float(free.V[1]), 3.0, "m/s"), Fact("F_2", float(free.F[1]), 4.0, "N"),
        Fact("possible", int(bool(free)), 1), Fact("conflict", int(bool(conflict)), 0),
    )  # fmt: skip
    return {"selection": free, "conflict": conflict}, facts


def _block(*rows: int) -> tuple[np.ndarray[tuple[int, ...], np.dtype[np.float64]], list[Fact]]:
    """Constraints along axes of the task frame (0 to 2 turns, 3 to 5 motions): freedoms of force and of motion."""
    A, mass = np.eye(6)[list(rows)], 2.0 * np.eye(6) + 0.3 * np.ones((6, 6))
    metric = np.linalg.inv(mass)
    P = np.eye(6) - A.T @ np.linalg.solve(A @ metric @ A.T, A @ metric)
    force, motion = int(np.linalg.matrix_rank(A)), round(float(np.trace(P)))
    return A, [Fact("force", force, len(rows)), Fact("motion", motion, 6 - len(rows))]


@works("10 door")
def door() -> Worked:
    """A cupboard door: one turn is free."""
    A, facts = _block(0, 1, 3, 4, 5)
    return {"A": A}, facts


@works("10 chalk")
def chalk() -> Worked:
    """Chalk on a board: without friction, with friction, lifted."""
    facts: list[Fact] = []
    constraints: dict[str, object] = {}
    for name, rows in (("smooth", (5,)), ("sticking", (3, 4, 5)), ("lifted", ())):
        A, both = _block(*rows)
        constraints[name] = A
        facts += [Fact(f"{name}_{fact.name}", fact.value, fact.printed) for fact in both]
    mode = control.contact.contact_mode(10.0, [3.0, 0.0], 0.5)
    return {"constraints": constraints, "mode": mode}, facts


@works("10 eraser")
def eraser() -> Worked:
    """An eraser on a board: three constraints, natural and artificial."""
    A, facts = _block(0, 1, 5)
    names = ("phi_x", "phi_y", "phi_z", "x", "y", "z")
    table = control.constraint_table((True, True, False, False, False, True), (0.0, 0.0, 0.0, 1.0, 0.0, 2.0), names)
    return {"A": A, "table": table}, facts


@works("10 one-joint arm")
def one_joint_arm() -> Worked:
    """The arm of the chapter under PD and PID control."""
    arm = oj.JointArm.of(0.5, 1.0, 0.1, 0.1)
    loop = oj.SecondOrder.of_joint(0.5, 2.1, 2.205)
    rest = oj.steady_state_error(2.205, arm.gravity_moment, 0.0)
    facts = (
        Fact("damping_ratio", float(loop.damping_ratio), 1.0), Fact("rest", float(rest.error), unit="rad"),
        Fact("ki", float(oj.ki_limit(0.5, 2.1, 2.205)), unit="N m/(rad s)"),
    )  # fmt: skip
    return {"arm": arm, "loop": loop, "rest": rest}, facts
