"""One page that runs a robot in a browser: its kernels as WebAssembly, everything that is done as lines of Python.

call      robot.show(), mafsil show
computed  `arm` and `content` gather what the page needs, `assemble` makes one file, `session` runs its lines in
          Python
compiled  kernels as WebAssembly by `mafsil.kernels`
tested    tests/page
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
