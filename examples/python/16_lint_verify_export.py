"""Trust, then ship: examine a robot's file, check every quantity by a second method, and take the code elsewhere as C.

Run: python examples/python/16_lint_verify_export.py
"""

from pathlib import Path

import mafsil as mf

urdf = Path(__file__).parents[1] / "robots" / "ur5.urdf"

# What a careful reader finds in the file, with line, reason and repair.
report = mf.lint(urdf)
print(report)

# Every quantity beside an independent computation, on random states.
robot = mf.load(urdf)
checks = mf.verify(robot)
print(checks.explain())
assert checks.ok

# The gravity torques as C99 without heap or loops, with a program that proves them.
code = mf.export(robot, "gravity_torque")
print(code.name, sorted(code.files))
print("operations:", code.details["operations"])
