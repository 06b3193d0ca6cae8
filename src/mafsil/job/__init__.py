"""A job file, solved end to end: reading, planning the moves, driving the robot through them."""

from mafsil.job.description import Job as Job
from mafsil.job.law_bench import LawBench as LawBench
from mafsil.job.law_bench import LawResult as LawResult
from mafsil.job.law_bench import bench_laws as bench_laws
from mafsil.job.reading import parse as parse
from mafsil.job.reading import read as read
from mafsil.job.remark import Refusal as Refusal
from mafsil.job.run import Run as Run
from mafsil.job.schema import schema as schema
from mafsil.job.solve import solve as solve
from mafsil.job.solve import solve_file as solve_file
from mafsil.job.status import JobStatus as JobStatus
