"""Identification of dynamic parameters: exciting motions, logs, payloads, and the estimates with their errors."""

from mafsil.lazy_module import face

__all__ = face(__name__)
