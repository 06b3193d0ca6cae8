"""Every routine of a robot compared with independent methods for the same numbers, in one call.

call      robot.verify(), mafsil verify
computed  `verify` compares each routine with a second method of `verification` and `closed`, and with
          `pinocchio_peer`, `mujoco_peer` where they are installed
tested    tests/verification
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
