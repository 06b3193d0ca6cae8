"""Numerical inverse kinematics: compiled searches over batches of poses, tasks of many kinds, null-space goals."""

from mafsil.ik.numerical.solve import solve_ik as solve_ik
from mafsil.ik.numerical.task import TaskKind as TaskKind
