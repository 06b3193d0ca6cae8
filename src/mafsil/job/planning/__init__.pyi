from mafsil.job.planning.move_planner import plan_moves as plan_moves
