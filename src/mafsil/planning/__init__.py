"""Planning: collision-free paths of arms, among polygons, in any number of coordinates; several robots in time.

call      mf.plan(robot, obstacles, start, goal), mf.optimal_base_placement; mafsil plan
computed  `arm_planning` asks `arm_search`, then `pipeline`; `path_constraints` keep a tool upright,
          `waiting_places` and `prioritized` lead several arms; `polygons` and `quadtree` are the plane of the
          textbook
compiled  `arm_search_loops` (RRT-Connect; every motion of its path is proved by `mafsil.collision`),
          `roadmap_loops`, `arm_question_loops`
tested    tests/planning, tests/reliability/planning_scenes.py, coal_paths.py, several_arms.py
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
