"""A job file, solved end to end: reading, planning the moves, driving the robot through them, judging the run.

call      mafsil run JOB, mafsil check-job JOB; mf.job.solve_file
computed  `solve` goes through four rooms: `language` makes a job of a file, `planning` a plan of the job, `driving` a
          run of the plan, `judging` numbers, sentences and causes of the run; each imports only those before it
tested    tests/job, tests/reliability/job_verdicts.py
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
