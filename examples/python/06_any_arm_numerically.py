"""Inverse kinematics by iteration: any arm, many poses at once, limits respected, a reason where nothing is found.

Run: python examples/python/06_any_arm_numerically.py
"""

import numpy as np

import mafsil as mf

robot = mf.load("panda")
rng = np.random.default_rng(1)
q = rng.uniform(robot.limits.lower, robot.limits.upper, (2000, robot.n))
poses = robot.forward_kinematics(q)

# All poses in one call; every answer is checked afresh by forward kinematics.
answer = mf.solve_ik(robot, poses)
print("solved:", int(answer.solved.sum()), "of", len(poses))
print("largest residual:", answer.residual.max())
assert answer

# From where one already is: the solution near an initial guess.
here = q[0] + 0.05
near = mf.solve_ik(robot, poses[0], here)
print("joints move by at most [rad]:", round(float(np.abs(near.q - here).max()), 3))

# Only a point to reach, or only a direction to hold: the rest is free.
point = mf.solve_ik(robot, poses[0], here, task="position")
print("to the point alone [rad]:", round(float(np.abs(point.q - here).max()), 3))

# Out of reach is an answer with its reason; a search that fails says that it did not find, never that there is none.
far = poses[0].copy()
far[:3, 3] = [2.0, 0.0, 0.5]
refused = mf.solve_ik(robot, far)
assert not refused
print(refused.explain())
