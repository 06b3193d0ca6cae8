"""Design of arms: parametric arms, accuracy from tolerances, answers for a set of tasks, choice of drives, search.

call      mafsil design; mf.design.ParametricArm, evaluate, accuracy, pick_drives, payload_map, reach_map, optimise
computed  `arm`, `family`, `elastic`, `accuracy`, `allocation`, `tasks`, `slices`, `parts`, `drives`, `search`
tested    tests/design
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
