from mafsil.job.driving.plan_simulation import simulate_plan as simulate_plan
from mafsil.job.driving.run import Run as Run
