"""From point to point in time: polynomials, via points, a straight line of the tool, and whether the limits allow it.

Run: python examples/python/12_trajectories.py
"""

import numpy as np

import mafsil as mf

robot = mf.load("ur5e")
start = np.array([0.0, -1.2, 1.4, -1.7, -1.6, 0.0])
goal = start + np.array([0.8, 0.3, -0.4, 0.2, 0.0, 0.5])

# Quintic: at rest at both ends, with no jump of the acceleration.
motion = mf.trajectory.quintic(start, goal, duration=2.0)
t = np.linspace(0.0, motion.duration, 5)
u, v, a = motion.at(t)
print("rates of joint 1 over time [rad/s]:", np.round(v[:, 0], 3))

# Does the robot allow it? The extremes of a polynomial are found exactly, not on a grid.
verdict = mf.trajectory.check(motion, robot.limits, robot.joint_names)
print(verdict.explain())
hasty = mf.trajectory.check(mf.trajectory.quintic(start, goal, duration=0.3), robot.limits, robot.joint_names)
assert not hasty
print(hasty.explain())

# Through via points, with continuous accelerations.
through = mf.trajectory.cubic_through([start, start + 0.2, goal], [1.0, 1.5])
print("passes the via point to", f"{np.abs(through.at(1.0).u - start - 0.2).max():.1e}", "rad")

# The tool on a straight line, branch kept.
T = robot.forward_kinematics(start)
T[2, 3] -= 0.15
line = mf.trajectory.cartesian_line(robot, start, T)
print(line.explain())
assert line.succeeded
