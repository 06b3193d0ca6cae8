"""Batches on NVIDIA devices: the driver, arrays that lie there, and kernels launched over them."""

from mafsil.lazy_module import face

__all__ = face(__name__)
