"""A job file, solved end to end: reading, planning the moves, driving the robot through them.

call      mafsil run JOB, mafsil check-job JOB; mf.job.solve_file
computed  `reading` makes a `description` by `language.statements`; `solve` walks the moves (`walk`,
          `move_planner`) to a `plan`; `plan_simulation` drives it; `judgement` and `causes` judge;
          `controller_program` writes for controllers
tested    tests/job, tests/reliability/job_verdicts.py
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
