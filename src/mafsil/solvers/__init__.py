"""Numbers only: iterations, integrators and their honest outcomes; no robot.

call      no public face: others ask
computed  `least_squares`, `linear_program`, `integrate`, `solution`, and
          `adaptive` over `embedded`; `local_dimension` decides what a point of a mechanism belongs to
compiled  `hull_growth_loops`, `horizon_loops`, `disc_loops`, `positive_span_loops`, `cholesky_loops`
tested    tests/solvers
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
