"""Simulated robots that differ from their descriptions, and the noisy logs that they leave."""

from dataclasses import replace

import numpy as np

from mafsil.identification import MotionLog
from mafsil.identification.regression import BodyParameterisation, physically_consistent
from mafsil.mechanics.inertial_parameters import inertial_of, inertial_parameters
from mafsil.model import Actuator, Friction
from mafsil.robot import Robot, load

ENCODER = 2 * np.pi / 2**17
"""Resolution of the simulated encoders [rad]."""


def different(name, seed, *, rotors=False, offset=0.02):
    """The robot of the library, and one with other masses, inertias and friction (and rotors) of the same shape."""
    described, rng = load(name), np.random.default_rng(seed)
    links = []
    for link, parameters in zip(described.mechanism.links, inertial_parameters(described.mechanism), strict=True):
        if parameters[0] > 0 and physically_consistent(parameters):
            changed, _ = BodyParameterisation.around(parameters).at(rng.normal(0, 0.12, 10))
            link = replace(link, inertial=inertial_of(changed))
        links.append(link)
    n = described.n
    inertia = described.mass_matrix(np.zeros(n)).diagonal()
    size = np.abs(described.gravity_torque(rng.uniform(-1, 1, (50, n)))).mean(axis=0) + 2 * inertia
    joints, k = [], 0
    for joint in described.mechanism.joints:
        if joint.moves:
            viscous, coulomb = rng.uniform(0.02, 0.1, 2) * size[k]
            motor = Actuator(armature=0.3 * inertia[k] + 0.01) if rotors else joint.actuator
            joint = replace(
                joint, friction=Friction(viscous, coulomb, None, offset * rng.normal() * size[k]), actuator=motor
            )
            k += 1
        joints.append(joint)
    return described, Robot(replace(described.mechanism, links=tuple(links), joints=tuple(joints)))


def fourier(robot, rng, duration, step, slowest=0.1, harmonics=5):
    """Times and a random motion inside the limits, rich enough to show everything."""
    t = np.arange(0.0, duration, step)
    lower, upper = np.maximum(robot.limits.lower, -2.5), np.minimum(robot.limits.upper, 2.5)
    a, b = rng.normal(size=(2, robot.n, harmonics))
    w = 2 * np.pi * slowest * np.arange(1, harmonics + 1)
    s, c = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
    q, qd, qdd = s @ (a / w).T - c @ (b / w).T, c @ a.T + s @ b.T, (c * w) @ b.T - (s * w) @ a.T
    q = q - q.mean(axis=0)
    scale = np.minimum(
        0.45 * (upper - lower) / np.abs(q).max(axis=0), np.minimum(robot.limits.velocity, 2.0) / np.abs(qd).max(axis=0)
    )
    return t, q * scale + (upper + lower) / 2, qd * scale, qdd * scale


def effort(robot, q, qd, qdd):
    """What the motors give, without noise."""
    return robot.inverse_dynamics(q, qd, qdd) + robot.friction_torque(qd)


def noisy_log(robot, seed, *, duration=30.0, step=1e-3, torque_noise=0.015, encoder=ENCODER, still=()):
    """A log with torque noise (a share of each joint's torque) and positions rounded to the encoder's counts."""
    rng = np.random.default_rng(seed)
    t, q, qd, qdd = fourier(robot, rng, duration, step)
    for joint in still:
        q[:, joint], qd[:, joint], qdd[:, joint] = 0.3, 0.0, 0.0
    tau = effort(robot, q, qd, qdd)
    tau = tau + torque_noise * np.sqrt((tau**2).mean(axis=0)) * rng.normal(size=tau.shape)
    return MotionLog(t=t, q=np.round(q / encoder) * encoder if encoder else q, tau=tau)


def torque_errors(model, truth, seed):
    """(n,) errors on a motion that nobody has seen, against the true torque without noise [%]."""
    _, q, qd, qdd = fourier(truth, np.random.default_rng(1000 + seed), 10.0, 5e-3, slowest=0.15)
    tau = effort(truth, q, qd, qdd)
    error = effort(model, q, qd, qdd) - tau
    return 100 * np.sqrt((error**2).mean(axis=0) / (tau**2).mean(axis=0))


def write_csv(log, robot, path, names=True):
    """The log as a file."""
    joints = robot.joint_names if names else range(1, robot.n + 1)
    mark = "{}[{}]" if names else "{}{}"
    signals = log.signals()
    heads = ["t", *(mark.format(name, joint) for name in signals for joint in joints)]
    table = np.column_stack([log.times, *signals.values()])
    np.savetxt(path, table, delimiter=",", header=",".join(heads), comments="")
