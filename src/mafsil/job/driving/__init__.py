"""A plan driven: its stretches simulated one after the other under the law of the job, and what happened as arrays.

The door is `simulate_plan`: a job and its plan in, a `Run` out.
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
