"""Worked examples of chapters 2 to 4: mobility, grasps, displacements."""

from __future__ import annotations

from math import pi, radians

import numpy as np

import mafsil.mobility as mo
import mafsil.parallel as pa
from mafsil.book.entry import Fact
from mafsil.book.example import Worked, works
from mafsil.geometry import planar
from mafsil.grasp import Contact, Grasp
from mafsil.performance.singularities import rank
from mafsil.robot import as_robot


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
    first_order = radial.instantaneous.rates.shape[1]
    return {**objects, "radial": radial}, [*facts, Fact("at_home", first_order)]


@works("2.7")
def scara_task() -> Worked:
    """Task space of a SCARA: place and heading."""
    robot = as_robot("scara_rrrp")
    J = robot.jacobian_space([0.3, 0.7, -0.4, 0.1])
    return {"robot": robot}, [Fact("task", int(np.linalg.matrix_rank(J)), 4), Fact("joints", robot.n, 4)]


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
