"""Does this grasp hold? A verdict with its proof, how well, and against which push it is weakest.

Run: python examples/python/15_grasp.py
"""

import numpy as np

import mafsil as mf

# A rectangle of 4 x 2 held at four points, without friction. The normal points into the body.
pinwheel = mf.Grasp(
    [
        mf.Contact((0.5, 1), (0, -1)),
        mf.Contact((2, 0.5), (-1, 0)),
        mf.Contact((-0.5, -1), (0, 1)),
        mf.Contact((-2, -0.5), (1, 0)),
    ]
)
found = pinwheel.closure()
print(found.explain())
assert found.force_closure

# The same at the middles of the sides: a no, and the wrench that nothing resists.
middles = mf.Grasp(
    [mf.Contact(p, n) for p, n in [((0, 1), (0, -1)), ((2, 0), (-1, 0)), ((0, -1), (0, 1)), ((-2, 0), (1, 0))]]
)
answer = middles.closure()
assert not answer
print(answer.explain())
print("cannot be resisted (m, fx, fy):", np.round(answer.certificate, 3))

# Friction mends it.
print("with friction 0.3:", bool(middles.with_friction(0.3).closure()))

# A thousand grasps of a ball by five fingers, in one call.
points = np.random.default_rng(0).normal(size=(1000, 5, 3))
points /= np.linalg.norm(points, axis=-1, keepdims=True)
many = mf.grasp.contact_closures(points, -points, mu=0.5)
print("hold:", int(many.force_closure.sum()), "of", len(points))
