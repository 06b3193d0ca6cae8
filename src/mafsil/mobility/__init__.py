"""Mobility of mechanisms, closed chains and configuration spaces; `mf.mobility(mechanism).explain()`.

call      mf.mobility(file or linkage), mafsil mobility; trace_motion, assembly_modes, synthesise_motion
computed  `report` asks `gruebler`, `instantaneous`, `finite`; `tracing` and `surface` follow configurations,
          `linkages.linkage` holds the mechanism, `synthesis.motion` designs
compiled  `rank_loops`
tested    tests/mobility, tests/reliability/mechanisms.py, shaky_parts.py
"""

import sys
from typing import Any

from mafsil.lazy_module import Package, face


class CallablePackage(Package):
    """The package can be called: `mf.mobility(mechanism)` is `mf.mobility.mobility(mechanism)`."""

    def __call__(self, *arguments: Any, **details: Any) -> Any:
        """Arguments as `mafsil.mobility.report.mobility`."""
        return self.mobility(*arguments, **details)


__all__ = face(__name__)
sys.modules[__name__].__class__ = CallablePackage
