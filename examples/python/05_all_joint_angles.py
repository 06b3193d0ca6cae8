"""From the URDF of an arm to answers: where the tip is, which joint angles bring it elsewhere, what that costs.

Run: python examples/python/05_all_joint_angles.py
"""

from pathlib import Path

import numpy as np

import mafsil as mf

robot = mf.load(Path(__file__).parents[1] / "robots" / "ur5.urdf")
print(robot.mechanism.name, "with", robot.n, "joints:", ", ".join(robot.joint_names))

# Where is the tip? Angles are radians.
q = np.radians([0, -90, 90, 0, 90, 0])
T = robot.forward_kinematics(q)
print("position of the tip [m]:", np.round(T[:3, 3], 4))

# Which joint angles bring it 0.1 m lower? All of them, each with the name of its branch.
goal = T.copy()
goal[2, 3] -= 0.1
answer = mf.inverse_kinematics(robot, goal)
print(answer.explain())
for branch, angles in zip(answer.branches, answer.q, strict=True):
    print(f"  {branch.label():45}", np.round(np.degrees(angles), 1))

# How near to a singular configuration is each, and which torques hold the arm there?
for angles in answer.q[answer.within]:
    conditioning = mf.performance.singular_values(robot, angles)
    print(f"  smallest singular value {conditioning[-1]:.3f}, torques [N m]", np.round(robot.gravity_torque(angles), 2))

# A pose that cannot be reached is an answer too, with its reason.
far = goal.copy()
far[0, 3] += 2.0
refused = mf.inverse_kinematics(robot, far)
assert not refused
print(refused.explain())
