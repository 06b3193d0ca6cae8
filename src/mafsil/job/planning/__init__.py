"""From a checked job to the motion that it asks for: moves one after the other, within limits, past what stands around.

The door is `plan_moves`: a job, its robot with each of its tools and the robots beside it in, a `Plan` or a
refusal out. What a plan is as a program of a controller, and what limits its cycle, is told here too.
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
