"""Expressions in, machine code out: functions compiled to SIMD kernels that know nothing of robots.

call      mf.kernels.compile(function) gives a Kernel; @compiled of `loops.loop` for loops
computed  `lower` makes a tape, `fusion` and `schedule` order it, `emitter` writes LLVM, `call` and `rows` run
          batches; `export`, `ptx` write it for others
compiled  `llvm` makes machine code, `elf` links it; `loops` is the compiler of loops
tested    tests/kernels, tests/export
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
