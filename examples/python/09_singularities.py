"""Why an arm is stuck: the rank of the Jacobian, the axes that depend on one another, and all singular configurations.

Run: python examples/python/09_singularities.py
"""

import numpy as np

import mafsil as mf
from mafsil import performance

robot = mf.load("puma560")

# The fifth joint straight: two axes of the wrist on one line.
q = np.array([0.1, 0.4, 0.3, 0.5, 0.0, -0.2])
found = performance.singularity(robot, q)
assert found.singular
print(found.explain())

# All of them at once: the determinant in factors, each with its geometric meaning ...
factors = performance.determinant_factors(robot)
print(factors.explain())
assert np.isclose(factors.evaluate(q), np.linalg.det(robot.jacobian_space(q)), atol=1e-12)

# ... and as conditions on the joints, every one verified by rank on samples.
locus = performance.singularity_locus(mf.load("ur5e"))
print(locus.explain())
assert locus.verified

# How near to singular are a hundred thousand configurations?
many = np.random.default_rng(0).uniform(-np.pi, np.pi, (100_000, robot.n))
smallest = performance.singular_values(robot, many)[:, -1]
print("share with a smallest singular value below 0.01:", float((smallest < 0.01).mean()))
