"""Simulation in closed loop: plant, control law, disturbances, recordings.

call      mf.simulate(robot, law, ...), mf.simulation.monte_carlo
computed  `loop` drives `plant` by a law, `fused` in one compiled loop; `rigid_run` meets surfaces, `closed_plant`
          closes loops; `recording` is what is left
compiled  `tally_loops`, `friction_loops`, and the fused loops of `fused`
tested    tests/simulation, tests/reliability/conservation.py, falling_arm.py
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
