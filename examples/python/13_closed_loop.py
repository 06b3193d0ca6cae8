"""A controlled arm in simulation: computed torque on the arm it knows, and on one that carries more than it knows.

Run: python examples/python/13_closed_loop.py
"""

import numpy as np

import mafsil as mf

robot = mf.load("puma560")
start, goal = np.zeros(robot.n), np.array([0.5, -0.3, 0.4, 0.2, 0.3, -0.2])
motion = mf.trajectory.sequence(
    mf.trajectory.quintic(start, goal, duration=1.0), mf.trajectory.profiles.rest(goal, duration=0.5)
)
law = mf.control.computed_torque(robot, natural_frequency=20.0, damping_ratio=1.0)

# Without friction the law knows the arm exactly: what is left is the error of sampling.
plant = mf.simulation.Plant(robot, friction=False)
known = mf.simulate(mf.Scenario(robot=robot, trajectory=motion, law=law, plant=plant))
print(known.explain())
print("largest error [rad]:", f"{np.abs(known.q - known.q_ref).max():.1e}")

# Two kilograms at the tip that nobody has told the law about.
loaded = mf.simulate(mf.Scenario(robot=robot, trajectory=motion, law=law, plant=plant.with_payload(2.0)))
error = np.abs(loaded.q - loaded.q_ref)
print("with 2 kg more, largest error [rad]:", np.round(error.max(axis=0), 4))

# The error that stays at rest is the payload's gravity torque over M Kp.
left = loaded.q_ref[-1] - loaded.q[-1]
print("error at rest [rad]:", np.round(left, 4))
assert np.abs(left).max() > 10 * np.abs(known.q[-1] - known.q_ref[-1]).max()
