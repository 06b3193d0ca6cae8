"""What an arm can do in an instant, and what it can hold: Jacobians, ellipsoids, torques for a load at the tip.

Run: python examples/python/08_velocities_and_forces.py
"""

import numpy as np

import mafsil as mf
from mafsil import performance

robot = mf.load("puma560")
q = np.array([0.3, -0.4, 0.25, 0.7, -0.5, 0.6])
qd = np.array([0.1, 0.2, -0.1, 0.3, 0.0, 0.4])

# Joint rates to the twist (omega, v) of the tip, in its own frame.
J = robot.jacobian_body(q)
print("twist of the tip:", np.round(J @ qd, 4))

# The same matrix transposed: a wrench (m, f) that the tip exerts, and the torques that it costs.
F = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 50.0])
extra = robot.inverse_dynamics(q, 0 * q, 0 * q, tip_wrench=F) - robot.gravity_torque(q)
assert np.allclose(extra, J.T @ F)
print("torques for 50 N along z of the tool [N m]:", np.round(extra, 2))

# Which directions are fast, which are strong.
fast = performance.velocity_ellipsoid(robot, q)
strong = performance.force_ellipsoid(robot, q)
print(fast.explain())
print(strong.explain())

# What the motors can hold here, gravity counted.
strength = performance.largest_force(robot, q, [0.0, 0.0, 1.0])
print("largest force upwards [N]:", strength)
print("manipulability (Yoshikawa):", round(float(performance.manipulability(robot, q)), 4))
