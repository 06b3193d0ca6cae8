"""The equations of motion, term by term, and a fall that keeps its energy.

Run: python examples/python/11_dynamics.py
"""

import numpy as np

import mafsil as mf

robot = mf.load("puma560")
rng = np.random.default_rng(0)
q, qd, qdd = rng.uniform(-1.0, 1.0, (3, robot.n))

# tau = M qdd + c + g
M, c, g = robot.mass_matrix(q), robot.velocity_torque(q, qd), robot.gravity_torque(q)
tau = robot.inverse_dynamics(q, qd, qdd)
assert np.allclose(tau, M @ qdd + c + g)
print("inertia, velocity, gravity of joint 2 [N m]:", np.round([(M @ qdd)[1], c[1], g[1]], 3))

# And back: which accelerations do these torques make?
assert np.allclose(robot.forward_dynamics(q, qd, tau), qdd)

# dM/dt - 2 C is skew: the velocity terms do no work of their own.
C = robot.coriolis_matrix(q, qd)
assert np.allclose(C @ qd, c)

# A free fall without friction: kinetic and potential energy change into each other, their sum does not.
fall = mf.simulation.forward_dynamics_trajectory(robot, q, duration=1.0, friction=False)
print(fall.explain())
print("relative change of the energy:", f"{fall.energy_drift:.1e}")

# Exact derivatives, for optimisation and control.
by_q, by_qd, by_qdd = robot.inverse_dynamics_derivatives(q, qd, qdd)
assert np.allclose(by_qdd, M)
print("how the torque of joint 2 changes with each angle [N m/rad]:", np.round(by_q[1], 2))
