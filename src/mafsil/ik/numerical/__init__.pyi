from mafsil.ik.numerical.problem import TaskKind as TaskKind
from mafsil.ik.numerical.solve import solve_ik as solve_ik
