"""Rotations and poses in the representations of the books, with frames that are checked, and as motions of a screw.

Run: python examples/python/02_rotations_and_poses.py
"""

import numpy as np

import mafsil as mf

# One rotation as a matrix, a quaternion, an axis with an angle.
R = mf.Rotation.from_euler([30, -20, 75], "ZYX", degrees=True)
print("quaternion (w, x, y, z):", np.round(R.quaternion(), 4))
axis, angle = R.axis_angle()
print("axis", np.round(axis, 4), "angle [deg]", round(float(np.degrees(angle)), 3))
assert mf.Rotation.from_axis_angle(axis, angle).close_to(R)

# Poses know their frames: neighbouring letters must agree, and a slip is refused.
T_sb = mf.Pose.of(R, [0.4, 0.0, 0.3], frames=("s", "b"))
T_bc = mf.Pose.of(np.eye(3), [0.0, 0.0, 0.1], frames=("b", "c"))
print("origin of {c} in {s} [m]:", np.round((T_sb @ T_bc).origin, 4))
try:
    T_bc @ T_sb
except mf.InputError as error:
    print("refused:", error)

# Every rigid motion is a turn about an axis and a travel along it.
screw, amount = mf.ScrewAxis.of_displacement(T_sb)
print("axis through", np.round(screw.point, 4), "pitch [m/rad]", round(float(screw.pitch), 4))
print("angle [rad]", round(float(amount), 4))
halfway = screw.displacement(amount / 2)
assert np.allclose(np.asarray(halfway) @ np.asarray(halfway), np.asarray(T_sb))
