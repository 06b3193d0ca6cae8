"""One controlled joint in closed form: error dynamics, stability, responses, gains, drives, friction, sampled loops.

call      mf.one_joint.gain_design, root_locus, second_order ...
computed  `error_dynamics`, `gain_design`, `root_locus`, `polynomial`, `margins`, `joint_law`; `drives.motor`,
          `drives.gear`, `drives.elastic_joint`
compiled  `arm_loops`
tested    tests/control, tests/reliability/routh_roots.py
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
