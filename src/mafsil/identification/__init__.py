"""Identification of dynamic parameters: exciting motions, logs, payloads, and the estimates with their errors.

call      mf.identify(robot, log), mafsil identify
computed  `excitation` moves, `log` and `examination` read and doubt, `regression` estimates and keeps masses
          possible, `result` says how sure it is
tested    tests/identification
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
