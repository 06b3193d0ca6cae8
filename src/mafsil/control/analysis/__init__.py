"""Judging control laws: gains, stability, linear models, coupling, worst cases, diagrams, which law suits, sources."""

from mafsil.lazy_module import face

__all__ = face(__name__)
