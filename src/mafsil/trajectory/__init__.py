"""Motions in time: polynomials, trapezoids, Cartesian lines, sequences, and their checks.

call      mf.trajectory.joint_motion, time_optimal, jerk_limited, cartesian_line; mafsil trajectory
computed  `profiles.laws`, `splines.linear_blends`, `paths.cartesian_path` make motions; `timing.time_optimal`,
          `jerk.via_points` time them; `checks.limit_check`, `checks.limit_proof` judge; `files.exporting`
          writes
compiled  `timing.lane_timing_loops`, `timing.jerk_timing_loops`, `jerk.coordinate_loops`
tested    tests/trajectory, tests/reliability/jerk_limited.py, time_optimal_paths.py, planted_jumps.py
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
