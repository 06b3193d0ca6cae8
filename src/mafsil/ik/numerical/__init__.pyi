from mafsil.ik.numerical.solve import solve_ik as solve_ik
from mafsil.ik.numerical.task import TaskKind as TaskKind
