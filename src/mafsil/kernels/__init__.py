"""Expressions in, machine code out: functions compiled to SIMD kernels that know nothing of robots."""

from mafsil.lazy_module import face

__all__ = face(__name__)
