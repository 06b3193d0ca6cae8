"""Rigid motion as expressions: written once, compiled by `mafsil.kernels`; knows no robot and no arrays.

call      se3, so3, screw, euler and so on, on expressions
computed  `so3`, `se3`, `screw`, `spatial` (motions), `euler`, `quaternion`, `subproblems` (angles that
          bring points or lines together), `inertia`
compiled  everything by `mafsil.kernels`, nothing here
tested    tests/algebra, tests/reliability/lie_groups.py
"""

__all__ = ()
