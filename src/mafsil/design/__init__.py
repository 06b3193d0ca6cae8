"""Design of arms and platforms: parametric robots, accuracy from tolerances, answers for tasks, drives, search.

call      mafsil design; mf.design.ParametricArm, evaluate, accuracy, pick_drives, payload_map, reach_map, optimise
computed  `arm`, `family`, `elastic`, `accuracy`, `allocation`, `tasks`, `platform`, `slices`, `drives`, `search`
tested    tests/design
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
