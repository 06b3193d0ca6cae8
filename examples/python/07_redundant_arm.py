"""A seven-joint arm for one pose: all that it can do without moving its tool, and where the limits stop it.

Run: python examples/python/07_redundant_arm.py
"""

import numpy as np

import mafsil as mf
from mafsil.ik import redundancy

iiwa = mf.load("iiwa7")
q = np.array([0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.4])
T = iiwa.forward_kinematics(q)

# The elbow can go round: its angle is the coordinate of the self-motion, and each branch has its intervals.
form = redundancy(iiwa)
print("coordinate of the self-motion:", form.parameter)
for family in form.families(T):
    low, high = np.degrees([family.low, family.high])
    print(f"  branch {family.branch}: {low:7.1f} to {high:7.1f} deg, proven: {family.certain}")

# All solutions at a value of one's own, each on its branch.
answer = mf.inverse_kinematics(iiwa, T, free=float(form.value(q)))
print(answer.explain())
assert np.allclose(answer.nearest(q), q)

# Walk along the self-motion: the tool stays, the elbow travels.
swept = form.sweep(T, 36)
inside = swept.q[swept.within]
moved = np.abs(iiwa.forward_kinematics(inside) - T).max()
print(len(inside), "configurations within the limits; the tool moves by at most", f"{moved:.1e}")
