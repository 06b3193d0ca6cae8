"""A plan driven: its stretches simulated one after the other under the law of the job, and what happened as arrays.

The door is `plan_simulation.simulate_plan`: a job and its plan in, a `run.Run` out.
"""
