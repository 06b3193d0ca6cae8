"""Parallel robots: platforms on legs, their poses, forces and singularities.

call      mf.parallel.StewartPlatform, Delta, FiveBar, CableRobot, ClosedChain; mafsil parallel
computed  `platforms.stewart`, `platforms.assembly_modes` (all poses, with `platforms.certificate`),
          `closed_chain` (any loops), `cables.cable_tensions`, `legs.leg_configurations`
compiled  `platforms.path_lane_loops`, `closed_dynamics_loops`, `cables.cable_loops`
tested    tests/parallel, tests/reliability/platforms.py, over_constrained.py
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
