"""The first question to a robot: where is its tip? For one configuration, for a hundred thousand, for any link.

Run: python examples/python/01_first_pose.py
"""

import numpy as np

import mafsil as mf

robot = mf.load("panda")
print(robot)

# Joint angles in radians; the answer is the pose of the tip frame in the space frame, a 4 x 4 matrix.
q = np.radians([0, -17, 0, -115, 0, 97, 45])
T = robot.forward_kinematics(q)
print(np.round(T, 4))
print("position of the tip [m]:", np.round(T[:3, 3], 4))

# The same call takes any number of configurations, with leading dimensions as they come.
many = np.random.default_rng(0).uniform(-1.0, 1.0, (100_000, robot.n))
points = robot.forward_kinematics(many)[:, :3, 3]
print("100,000 poses: the tip gets as far as", round(float(np.linalg.norm(points, axis=1).max()), 3), "m from the base")

# Another link's frame, by its name.
elbow = robot.forward_kinematics(q, frame="link4")
print("link4 at [m]:", np.round(elbow[:3, 3], 4))

# What is wrong is said with the argument's name and what to do.
try:
    robot.forward_kinematics(q[:3])
except mf.InputError as error:
    print("refused:", error)
