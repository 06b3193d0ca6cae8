"""Parallel robots by their legs, whatever their joints: configurations, branches, rates, forces."""

from mafsil.lazy_module import face

__all__ = face(__name__)
