"""From a log of motion and torques to a better model: masses, friction, and how much the prediction improves.

The log comes from a simulated arm that differs from its description; a file from your controller stands in its place.
Run: python examples/python/14_log_to_model.py
"""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import mafsil as mf

described = mf.load("planar2r")

# A motion that shows every parameter, inside all limits.
motion = mf.identification.excitation_trajectory(described, period=8.0, repetitions=2, improvements=20)
t = np.arange(0.0, motion.duration, 0.002)
q, qd, qdd = motion.at(t)

# The true arm: friction that the description does not know, and links a fifth heavier.
joints = tuple(replace(j, friction=mf.model.Friction(0.4, 0.8)) if j.moves else j for j in described.mechanism.joints)
links = tuple(
    link
    if link.inertial is None
    else replace(
        link, inertial=mf.model.Inertial(1.2 * link.inertial.mass, link.inertial.com, 1.2 * link.inertial.inertia)
    )
    for link in described.mechanism.links
)
truth = mf.Robot(replace(described.mechanism, joints=joints, links=links))
tau = truth.inverse_dynamics(q, qd, qdd) + truth.friction_torque(qd)
noise = 0.02 * tau.std(axis=0) * np.random.default_rng(0).normal(size=tau.shape)

with TemporaryDirectory() as folder:
    log = Path(folder) / "log.csv"
    head = ",".join(["t", *(f"{name}[{joint}]" for name in ("q", "tau") for joint in described.joint_names)])
    np.savetxt(log, np.column_stack([t, q, tau + noise]), delimiter=",", header=head, comments="")
    better = mf.identify(described, str(log))

print(better.explain())
viscous = better.parameter("joint1.viscous")
print(f"viscous friction of joint 1: {viscous.value:.3f} +- {viscous.standard_error:.3f} N m s/rad (true: 0.4)")
assert abs(viscous.value - 0.4) < 5 * viscous.standard_error + 0.02
assert better.validation.after.max() < better.validation.before.max()
