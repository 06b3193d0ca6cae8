"""How far an arm gets: its workspace as a map, with holes, boundary and the part that is reached in every direction.

Run: python examples/python/10_workspace.py
"""

import numpy as np

import mafsil as mf
from mafsil import performance

# Exactly, for arms in the plane: an annulus.
ring = performance.reachable_annulus([0.5, 0.3])
print("two links:", ring, "area [m^2]", round(float(ring.area), 4))

# By a million samples for any arm; the volume comes with how far it has settled.
robot = mf.load("cobra600")
found = performance.workspace_map(robot, 200_000)
print(found.explain())

# Is a place inside?
places = np.array([[0.5, 0.0, 0.3], [1.5, 0.0, 0.3]])
print("reached:", found.contains(places))
