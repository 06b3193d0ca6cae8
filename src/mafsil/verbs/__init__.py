"""The verbs of a robot: what people type first, as methods of `Robot`. The stub is the table of them.

`mafsil.Robot` takes them from here when its class is made; the packages that compute are imported at the first call.

call      robot.fk, robot.ik, robot.plan, robot.save ...
computed  the stub __init__.pyi is the table; `short_forms` holds those with a body of their own
tested    tests/verbs
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
