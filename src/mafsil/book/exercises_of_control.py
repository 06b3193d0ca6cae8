"""Families of exercises for chapters 9 and 10 and the slides: dynamics, gains, polynomials, blends, obstacles."""

from __future__ import annotations

from functools import cache, partial
from math import exp, log, pi, sqrt

import numpy as np

from mafsil.book.family import Draw, Task, asks
from mafsil.book.judging import ask
from mafsil.derivation import Derivation, derive_dynamics
from mafsil.model.library.textbook import planar2r_point_masses
from mafsil.one_joint import ForceLoop, JointArm, SecondOrder, ki_limit, steady_state_error
from mafsil.one_joint.drives import Gear, matching_ratio
from mafsil.planning import minkowski_sum
from mafsil.robot import Robot, as_robot
from mafsil.trajectory import cubic as cubic_through
from mafsil.trajectory import trapezoid

G = 9.81
ARMS = ((0.5, 0.5, 2.0, 1.0), (0.8, 0.5, 2.0, 1.5), (1.0, 0.8, 3.0, 1.0), (0.6, 1.0, 1.0, 2.0))
"""Lengths [m] and masses [kg]; few, so that few robots are compiled."""


@cache
def _arm(l1: float, l2: float, m1: float, m2: float) -> Robot:
    return as_robot(planar2r_point_masses((l1, l2), (m1, m2)))


@cache
def _derivation(*arm: float) -> Derivation:
    return derive_dynamics(_arm(*arm).mechanism)


@asks("9.1.1 torques")
def torques(draw: Draw) -> Task:
    """Torques of a planar 2R arm with point masses."""
    arm, angles = draw.choice(ARMS), np.array([draw.degrees(), draw.degrees()])
    qd, qdd = draw.numbers(2, -2, 2, 0.5), draw.numbers(2, -3, 3, 0.5)
    robot, q = _arm(*arm), np.radians(angles)
    M, g = robot.mass_matrix(q), robot.gravity_torque(q)
    tau = robot.inverse_dynamics(q, qd, qdd)
    c, (l1, l2, m1, m2) = tau - M @ qdd - g, arm
    h = m2 * l1 * l2 * np.sin(q[1])
    return Task(
        {"l1": l1, "l2": l2, "m1": m1, "m2": m2, "t1": angles[0], "t2": angles[1], "qd": qd, "qdd": qdd, "M": M, "c": c,
         "gravity": g, "tau": tau},
        [
            ask("M", M, last_mass_left_out=M - [[m2 * (l1**2 + l2**2 + 2 * l1 * l2 * np.cos(q[1])), 0], [0, 0]],
                  sine_cosine=M + m2 * l1 * l2 * (np.sin(q[1]) - np.cos(q[1])) * np.array([[2, 1], [1, 0]])),
            ask("tau", tau, "N m", no_gravity=tau - g, gravity_sign=tau - 2 * g, no_velocity_terms=tau - c,
                  velocity_sign=tau - 2 * c, half_coriolis=tau + np.array([h * qd[0] * qd[1], 0.0])),
        ],
        partial(_derivation, *arm),
    )  # fmt: skip


@asks("9.1.1 particle", unknown="m a")
def particle(draw: Draw) -> Task:
    """Force that lifts a particle, from its Lagrangian."""
    m, a = draw.number(0.5, 6.0, 0.5), draw.number(-4, 6, 0.5)
    return Task(
        {"m": m, "a": a, "weight": m * G, "f": m * (a + G)},
        [ask("force", m * (a + G), "N", no_gravity=m * a, gravity_sign=m * (a - G), weight_alone=m * G)],
    )


@asks("10.2.1.1 PD gains", unknown="settling")
def pd_gains(draw: Draw) -> Task | None:
    """Gains of a PD law from damping ratio and settling time."""
    M, b = draw.choice((0.2, 0.4, 0.5, 0.8, 1.5, 2.0)), draw.number(0.1, 1.0)
    zeta, settling = draw.choice((0.5,) if draw.level == 1 else (0.5, 0.6, 0.7, 0.8)), draw.number(0.2, 2.0)
    w = 4 / (zeta * settling)
    kp, kd = M * w * w, 2 * zeta * w * M - b
    loop = SecondOrder.of_joint(M, b + kd, kp)
    if kd <= 0 or abs(float(loop.damping_ratio) - zeta) > 1e-9:
        return None
    return Task(
        {"M": M, "b": b, "zeta": zeta, "settling": settling, "w": w, "kp": kp, "kd": kd},
        [
            ask("kp", kp, frequency_not_squared=M * w, inertia_left_out=w * w,
                  ratio_left_out=M * (4 / settling) ** 2),
            ask("kd", kd, friction_left_out=kd + b, friction_added=kd + 2 * b, no_two=zeta * w * M - b),
        ],
    )  # fmt: skip


@asks("10.2.1.1 rest error", unknown="m r kp")
def rest_error(draw: Draw) -> Task:
    """Error at rest of a PD law against gravity, and the bound of Ki."""
    M, m, r = draw.number(0.2, 0.9), draw.number(0.5, 3.0, 0.5), draw.number(0.1, 0.5)
    b, kd, kp = draw.number(0.1, 0.5), draw.number(1, 5, 0.5), draw.number(20, 80, 5.0)
    arm = JointArm.of(M, m, r, b)
    rest = steady_state_error(kp, arm.gravity_moment, 0.0)
    e, small, limit = float(rest.error), m * G * r / kp, float(ki_limit(M, b + kd, kp, 0.0, 0.0))
    return Task(
        {"M": M, "m": m, "r": r, "b": b, "kd": kd, "kp": kp, "moment": m * G * r, "e": e, "limit": limit},
        [
            ask("rest_error", abs(e), "rad", twin=np.negative, no_g=m * r / kp, kp_times=kp * small,
                  arm_left_out=m * G / kp),
            ask("ki", limit, damping_without_friction=kd * kp / M, inertia_times=(b + kd) * kp * M,
                  no_inertia=(b + kd) * kp),
        ],
    )  # fmt: skip


@asks("10.2.1.5 gear", unknown="link")
def gear(draw: Draw) -> Task:
    """Apparent inertia of a geared joint, the motor's share, the matching ratio."""
    ratio, motor, link = float(draw.choice((5, 10, 20, 50, 100))), draw.number(1, 9, 1.0) * 1e-4, draw.number(0.1, 2.0)
    train = Gear.of(ratio, motor)
    apparent, share = float(train.apparent_inertia(link)), float(train.motor_share(link))
    best = float(matching_ratio(link, motor))
    return Task(
        {"G": ratio, "motor": motor, "link": link, "reflected": ratio**2 * motor, "apparent": apparent,
         "share": share, "best": best},
        [
            ask("apparent", apparent, ratio_not_squared=link + ratio * motor, reflected_alone=ratio**2 * motor,
                  link_reflected=motor + link / ratio**2),
            ask("share", share, link_share=1 - share, quotient=ratio**2 * motor / link),
            ask("ratio", best, root_left_out=link / motor, reciprocal=sqrt(motor / link)),
        ],
    )  # fmt: skip


@asks("10.3 force loop", unknown="kfp kfi")
def force_loop(draw: Draw) -> Task:
    """Pole and remaining error of PI force control against a rigid wall."""
    kfp, kfi, t = draw.number(0.2, 3.0), draw.number(2, 20, 1.0), draw.number(0.05, 0.6, 0.05)
    constant = float(ForceLoop.of(kfp, kfi).time_constant)
    return Task(
        {"kfp": kfp, "kfi": kfi, "t": t, "pole": -1 / constant, "share": exp(-t / constant)},
        [
            ask("force_pole", -1 / constant, one_left_out=-kfi / kfp, reciprocal=-constant, integral_alone=-kfi),
            ask("remaining", exp(-t / constant), complement=1 - exp(-t / constant), one_left_out=exp(-t * kfi / kfp)),
        ],
    )  # fmt: skip


@asks("11.1 cubic", unknown="T")
def cubic(draw: Draw) -> Task:
    """Coefficients of a cubic from rest to rest, and its greatest velocity."""
    start, goal, T = draw.degrees(0, 45), draw.degrees(60, 150), draw.number(1, 5, 0.5)
    path = cubic_through(float(start), float(goal), T)
    a = np.asarray(path.coefficients).ravel()
    d, peak = goal - start, abs(float(np.asarray(path.at(T / 2).v).item()))
    return Task(
        {"start": start, "goal": goal, "T": T, "d": d, "a2": a[2], "a3": a[3], "peak": peak},
        [
            ask("cubic", a, last_sign=a * [1, 1, 1, -1], powers_of_T=[a[0], 0, 3 * d / T, -2 * d / T],
                  not_shifted=[a[0], 0, 3 * goal / T**2, -2 * goal / T**3]),
            ask("peak_velocity", peak, "°/s", twin=np.negative, mean_velocity=abs(d) / T, parabola=2 * abs(d) / T),
        ],
    )  # fmt: skip


@asks("11.2 blend")
def blend(draw: Draw) -> Task | None:
    """Blend time of a straight line with parabolic blends, and its velocity."""
    d, T = float(draw.degrees(20, 120)), draw.number(1, 4, 0.5)
    a = float(10 * np.ceil(4.4 * abs(d) / T**2 / 10) + 10 * draw.whole(0, 5))
    plan = trapezoid(0.0, d, acceleration=a, duration=T)
    root = sqrt(T * T - 4 * abs(d) / a)
    tb = (T - root) / 2
    knots = np.asarray(plan.value.knots) if bool(plan) else np.zeros(1)
    if len(knots) < 3 or abs(knots[1] - tb) > 1e-6:
        return None
    return Task(
        {"d": d, "T": T, "a": a, "root": root, "tb": tb, "v": a * tb},
        [
            ask("blend_time", tb, "s", other_root=(T + root) / 2, not_halved=T - root,
                  factor_four=(T - sqrt(max(T * T - 2 * abs(d) / a, 0.0))) / 2),
            ask("line_velocity", a * tb, "°/s", twin=np.negative, mean_velocity=abs(d) / T, half_blend=a * tb / 2),
        ],
    )  # fmt: skip


@asks("11.3 obstacle")
def obstacle(draw: Draw) -> Task:
    """The obstacle that a moving triangle makes of a rectangle in its configuration space."""
    (w, h), (a, b) = draw.numbers(2, 1, 4, 0.5), draw.numbers(2, 0.5, 2, 0.5)
    block = np.array([[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]])
    robot = np.array([[0.0, 0.0], [a, 0.0], [0.0, b]])
    grown = np.asarray(minkowski_sum(block, -robot))
    x, y = grown.T
    area = 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))
    return Task(
        {"w": w, "h": h, "a": a, "b": b, "vertices": len(grown), "area": area, "block": w * h, "half": a * b / 2,
         "strip": a * h + b * w},
        [
            ask("vertices", len(grown), parallel_edges=7),
            ask("area", area, "m²", areas_added=w * h + a * b / 2, robot_left_out=w * h + a * h + b * w,
                  box=(w + a) * (h + b)),
            ask("least", grown.min(axis=0), "m", not_reflected=[0.0, 0.0]),
        ],
    )  # fmt: skip


def overshoot_to_damping(share: float) -> float:
    """Damping ratio of a step response that overshoots by a share."""
    return -log(share) / sqrt(pi**2 + log(share) ** 2)


@asks("10.2.1.1 overshoot", unknown="peak")
def overshoot(draw: Draw) -> Task:
    """Damping ratio and natural frequency from a measured overshoot and its time."""
    share, peak = draw.choice((5, 10, 16, 20, 25, 30, 40)), draw.number(0.2, 2.0)
    zeta = overshoot_to_damping(share / 100)
    damped = pi / peak
    w = damped / sqrt(1 - zeta**2)
    loop = SecondOrder.of(w, zeta)
    return Task(
        {"share": share, "peak": peak, "zeta": zeta, "wd": damped, "w": w, "log": log(share / 100),
         "back": 100 * float(loop.overshoot)},
        [
            ask("zeta", zeta, ten_for_e=-log(share / 100) / log(10) / sqrt(pi**2 + (log(share / 100) / log(10)) ** 2),
                  pi_left_out=-log(share / 100) / pi),
            ask("natural_frequency", w, "rad/s", damped_frequency=damped, turns_a_second=w / (2 * pi),
                  whole_period=2 * w),
        ],
    )  # fmt: skip


@asks("9.1.2 energy")
def energy(draw: Draw) -> Task:
    """Kinetic energy from a mass matrix and rates."""
    a, b, c = draw.number(2, 6, 0.5), draw.number(0.2, 1), draw.number(1, 3, 0.5)
    qd = draw.numbers(2, -2, 2, 0.5)
    M = np.array([[a, b], [b, c]])
    K = float(qd @ M @ qd) / 2
    own = float(np.diag(M) @ qd**2) / 2
    return Task(
        {"M": M, "qd": qd, "own": own, "cross": K - own, "p": M @ qd},
        [
            ask("kinetic", K, "J", not_halved=2 * K, cross_left_out=own, cross_once=own + (K - own) / 2),
            ask("momentum", M @ qd, cross_left_out=np.diag(M) * qd),
        ],
    )


@asks("9.2 shifted inertia", unknown="m length r")
def shifted_inertia(draw: Draw) -> Task:
    """Inertia of a rod about its centre and about an axis away from it."""
    m, length, r = draw.number(0.5, 5, 0.5), draw.number(0.4, 2), draw.number(0.2, 1.2)
    centre = m * length**2 / 12
    return Task(
        {"m": m, "length": length, "r": r, "shift": m * r**2, "inertia": centre + m * r**2},
        [
            ask("centre_inertia", centre, about_end=m * length**2 / 3, mass_left_out=length**2 / 12),
            ask("inertia", centre + m * r**2, shift_left_out=centre, shift_not_squared=centre + m * r,
                shift_subtracted=centre - m * r**2),
        ],
    )  # fmt: skip


def _joint(draw: Draw) -> tuple[float, float, float, float, int]:
    """Inertia, moment m r, viscous friction of one joint, and an angle in degrees."""
    return draw.number(0.2, 2), draw.number(0.5, 3), draw.number(0.1, 0.5), draw.number(-2, 2, 0.5), draw.degrees()


@asks("9.5 acceleration", unknown="tau M")
def acceleration(draw: Draw) -> Task:
    """Acceleration of one joint from its torque."""
    M, moment, b, qd, theta = _joint(draw)
    tau = draw.number(-20, 20, 1.0)
    g, friction = moment * G * np.cos(np.radians(theta)), b * qd
    value = (tau - g - friction) / M
    return Task(
        {"M": M, "moment": moment, "b": b, "qd": qd, "theta": theta, "tau": tau, "g": g, "friction": friction},
        [ask("acceleration", value, no_gravity=(tau - friction) / M, gravity_sign=(tau + g - friction) / M,
               no_velocity_terms=(tau - g) / M, inertia_times=(tau - g - friction) * M,
               sine_cosine=(tau - moment * G * np.sin(np.radians(theta)) - friction) / M)],
    )  # fmt: skip


@asks("10.2.1.2 feedforward", unknown="M qdd moment")
def feedforward(draw: Draw) -> Task:
    """Torque of the model along a reference."""
    M, moment, b, qd, theta = _joint(draw)
    qdd = draw.number(-5, 5, 0.5)
    g, friction = moment * G * np.cos(np.radians(theta)), b * qd
    tau = M * qdd + friction + g
    return Task(
        {"M": M, "moment": moment, "b": b, "qd": qd, "qdd": qdd, "theta": theta, "g": g, "friction": friction},
        [ask("feedforward", tau, "N m", no_gravity=tau - g, gravity_sign=tau - 2 * g, no_velocity_terms=tau - friction,
               inertia_left_out=qdd + friction + g)],
    )  # fmt: skip


@asks("10.2.1.3 computed torque", unknown="e kp")
def computed_torque(draw: Draw) -> Task:
    """Torque of the computed-torque law for one joint."""
    M, moment, b, qd, theta = _joint(draw)
    kp, kd, e, ed = draw.number(4, 25, 1.0), draw.number(2, 10, 1.0), draw.number(-0.5, 0.5), draw.number(-1, 1, 0.2)
    g, wanted = moment * G * np.cos(np.radians(theta)), kp * e + kd * ed
    tau = M * wanted + b * qd + g
    return Task(
        {"M": M, "moment": moment, "b": b, "qd": qd, "theta": theta, "kp": kp, "kd": kd, "e": e, "ed": ed, "a": wanted,
         "g": g, "friction": b * qd},
        [ask("law_torque", tau, "N m", inertia_left_out=wanted + b * qd + g, no_gravity=tau - g, gravity_sign=tau - 2
               * g, damping_left_out=tau - M * kd * ed)],
    )  # fmt: skip


@asks("10.2.1.4 friction", unknown="b")
def friction_torque(draw: Draw) -> Task:
    """Friction at a velocity, and whether a torque starts the joint."""
    dry, static, b, rate = draw.number(0.5, 2), draw.number(2.2, 4), draw.number(0.1, 0.8), draw.number(-3, 3, 0.5)
    torque = draw.number(0.5, 5)
    value = dry * np.sign(rate) + b * rate
    return Task(
        {"dry": dry, "static": static, "b": b, "rate": rate, "torque": torque, "viscous": b * rate},
        [
            ask("friction", value, "N m", sign_left_out=dry + b * abs(rate) if rate < 0 else value + 2 * dry,
                no_velocity_terms=dry * np.sign(rate), static_for_kinetic=static * np.sign(rate) + b * rate),
            ask("starts", bool(torque > static)),
        ],
    )  # fmt: skip


@asks("10.5 impedance", unknown="k a")
def impedance(draw: Draw) -> Task:
    """The force of a mass, spring and damper, and its critical damping."""
    m, b, k = draw.number(1, 5, 0.5), draw.number(2, 20, 1.0), draw.number(50, 400, 10.0)
    x, v, a = draw.number(-0.1, 0.1, 0.01), draw.number(-0.5, 0.5), draw.number(-2, 2, 0.5)
    force, damping = m * a + b * v + k * x, 2 * sqrt(k * m)
    return Task(
        {"m": m, "b": b, "k": k, "x": x, "v": v, "a": a, "inertial": m * a, "damper": b * v, "spring": k * x},
        [
            ask("impedance_force", force, "N", inertia_left_out=force - m * a, damping_left_out=force - b * v),
            ask("critical_damping", damping, "N s/m", root_left_out=2 * k * m, not_doubled=damping / 2),
        ],
    )


@asks("10.2.1.1 stability")
def stability(draw: Draw) -> Task:
    """The bound of Ki of a PID loop, and whether a gain is below it."""
    M, b, kp, kd = draw.number(0.2, 2), draw.number(0.1, 1), draw.number(2, 20, 1.0), draw.number(1, 8, 0.5)
    bound = float(ki_limit(M, b + kd, kp, 0.0, 0.0))
    ki = round(float(bound * draw.choice((0.4, 0.7, 1.3, 1.8))), 2)
    return Task(
        {"M": M, "b": b, "kp": kp, "kd": kd, "ki": ki, "damping": b + kd},
        [
            ask("ki", bound, damping_without_friction=kd * kp / M, no_inertia=(b + kd) * kp,
                inertia_times=(b + kd) * kp * M),
            ask("stable", bool(ki < bound)),
        ],
    )  # fmt: skip


@asks("11.1 quintic", unknown="T")
def quintic(draw: Draw) -> Task:
    """A quintic from rest to rest: greatest velocity, and the velocity at a quarter of the time."""
    d, T = draw.degrees(20, 150), draw.number(1, 5, 0.5)
    s = 0.25
    quarter = d / T * (30 * s**2 - 60 * s**3 + 30 * s**4)
    return Task(
        {"d": d, "T": T, "mean": d / T, "quarter": quarter},
        [
            ask("peak_velocity", 15 * d / (8 * T), "°/s", cubic_peak=1.5 * d / T, mean_velocity=d / T),
            ask("quarter_velocity", quarter, "°/s", cubic_peak=d / T * 6 * s * (1 - s), mean_velocity=d / T),
        ],
    )
