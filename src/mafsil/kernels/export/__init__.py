"""The same tape for other machines: C sources, object files, kernels for graphics processors, each with its proof."""

from mafsil.lazy_module import face

__all__ = face(__name__)
