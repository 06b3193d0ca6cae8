"""Loops to convergence in a small part of Python, compiled by LLVM alone: ready in a tenth of a second.

Numba needs seconds for what it is asked for the first time, most of them to infer types and to compile its own library
anew. Loops around kernels need neither: their functions say the types of their arguments, and their arrays are rows of
numbers of one type. The same functions run as ordinary Python over NumPy arrays, which is how they are tested.

What the language has: `int`, `float`, `bool`, arrays `Floats`, `Whole` and `Singles` of one axis; assignments, `if`,
`while`, `for` over `range`, `return`, `break`, `continue`; arithmetic, comparisons, `and`, `or`, `not`, conditional
expressions; elements `x[i]` and views `x[i:]`; `np.empty(12)` with a fixed size; `abs`, `min`, `max`, `int`, `float`,
`np.sqrt`, `np.rint`, `np.float32`; other functions of the program; constants of its modules; `address`, `run_kernel`;
records of its modules: fields `x.name`, read and written, and members `x[i]` of rows (`records`).
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
