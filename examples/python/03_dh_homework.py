"""Homework on a two-link arm: a Denavit-Hartenberg table, its frames, its formulas, and a check of one's own table.

Run: python examples/python/03_dh_homework.py
"""

from math import pi

import numpy as np

import mafsil as mf
from mafsil.derivation import check_dh, derive_fk, to_text

# The table, in the classic convention: one row per joint, angles in radians, lengths in metres.
rows = [mf.DHRow(a=0.5, alpha=0.0, d=0.2), mf.DHRow(a=0.3, alpha=pi, d=0.0)]
robot = mf.Robot.from_dh(rows, "classic", name="homework")

# The pose of the tip, by the program and by hand.
q = np.array([0.4, -0.7])
x = 0.5 * np.cos(q[0]) + 0.3 * np.cos(q.sum())
y = 0.5 * np.sin(q[0]) + 0.3 * np.sin(q.sum())
T = robot.forward_kinematics(q)
assert np.allclose(T[:3, 3], [x, y, 0.2])
print("tip at", np.round(T[:3, 3], 4))

# The same as formulas, step by step; every line is compared with the compiled robot.
print(to_text(derive_fk(robot)))

# And back: both elbow configurations of that point.
back = mf.inverse_kinematics(robot, T, task="position")
for angles in back.q:
    print("joint angles [deg]:", np.round(np.degrees(angles), 3))
assert any(np.allclose(angles, q) for angles in back.q)

# Somebody else's table of that arm, with one length wrong: the check says where.
print(check_dh(rows, robot, "classic").message())
slip = [mf.DHRow(a=0.4, alpha=0.0, d=0.2), rows[1]]
found = check_dh(slip, robot, "classic")
assert not found.correct
assert "row 1 a" in found.message()
print(found.message())
