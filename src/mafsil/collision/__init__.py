"""Collision of arms with what stands around them and with themselves; `mf.collision.Checker(robot, scene).check(q)`.

call      mf.collision.Checker(robot, scene): free, check, distance, segment
computed  `checker` holds `arm_in_scene`; `layout` packs shapes for the loops, `shapes` and `scene`
          are what users write
compiled  `meeting_loops` (states), `segment_loops` (proofs of motions), `distance_loops`, `gjk_loops`,
          `depth_loops`, `feature_loops`
tested    tests/collision, tests/reliability/coal_verdicts.py, coal_paths.py
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
