"""Analysis of control laws: gains, stability, linearisation, coupling, robustness, block diagrams, choice of a law."""

from mafsil.lazy_module import face

__all__ = face(__name__)
