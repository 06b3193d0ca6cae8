"""The page on a server of one's own machine: several windows share one robot, heavy work is done in Python.

call      mafsil studio
computed  `server` speaks `protocol` with windows, `opening` loads, `job_runner` runs, `broadcast` tells all
          windows
tested    tests/studio
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
