"""Mobility of mechanisms, closed chains and configuration spaces; `mf.mobility(mechanism).explain()`."""

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
