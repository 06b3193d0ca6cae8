"""Inverse kinematics: all solutions, nearest solutions, redundancy, singular poses, and why a pose has none.

call      robot.ik, robot.ik_all, mf.inverse_kinematics (all solutions), mf.solve_ik (one, any task)
computed  `inverse` chooses: `structure.recognise` finds closed forms, `general.solver` eliminates,
          `redundant.intervals` covers seven joints, `numerical.solve` searches; `answers.solution_set` is what
          comes out
compiled  `general.elimination_loops`, `general.polish_loops`, `redundant.interval_loops`,
          `numerical.search_loops`
tested    tests/ik, tests/reliability/ik_complete.py, ik_round_trip.py, ik_unreachable.py
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
