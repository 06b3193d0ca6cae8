"""One page that runs a robot in a browser: its kernels as WebAssembly, everything that is done as lines of Python."""

from mafsil.lazy_module import face

__all__ = face(__name__)
