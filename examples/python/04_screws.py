"""An arm from its screw axes and home pose alone, as a product of exponentials; and its table of Denavit-Hartenberg.

Run: python examples/python/04_screws.py
"""

import numpy as np

import mafsil as mf
from mafsil.model.dh_from_axes import dh_from_mechanism

# Three joints, each a screw (omega, v) in the space frame: a base that turns, and two parallel axes at height 0.4 m.
screws = [
    [0, 0, 1, 0, 0, 0],
    [0, -1, 0, 0.4, 0, 0],
    [0, -1, 0, 0.4, 0, -0.5],
]
home = np.eye(4)
home[:3, 3] = [0.9, 0.0, 0.4]
arm = mf.Robot.from_screws(screws, home, name="three joints")
print(arm)

# The tip is where exp([S1] q1) exp([S2] q2) exp([S3] q3) M puts it.
q = np.array([0.3, 0.5, -0.8])
T = np.eye(4)
for S, angle in zip(screws, q, strict=True):
    T = T @ np.asarray(mf.ScrewAxis(np.array(S, dtype=float)).displacement(angle))
assert np.allclose(T @ home, arm.forward_kinematics(q))
print("tip at [m]:", np.round(arm.forward_kinematics(q)[:3, 3], 4))

# The same arm in modified Denavit-Hartenberg parameters; what the rules leave free has been chosen, and is said.
table = dh_from_mechanism(arm.mechanism, "modified")
for row in table.rows:
    print(f"a = {row.a:6.3f}  alpha = {row.alpha:7.3f}  d = {row.d:6.3f}  theta = {row.theta:7.3f}")
print("largest difference of both descriptions:", table.residual)
