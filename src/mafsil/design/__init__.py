"""Design of arms: parametric arms, accuracy from tolerances, answers for a set of tasks, choice of drives, search.

call      mf.design.ParametricArm, accuracy, allocate, FlexibleArm
computed  `arm`, `family`, `elastic`, `accuracy`, `allocation`
tested    tests/design
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
