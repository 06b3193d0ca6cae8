"""Loops to convergence in a small part of Python, compiled by LLVM alone: ready in a tenth of a second.

`docs/loops.md` says what the language has. A loop is translated for the kinds of its arguments (`kinds`), statement by
statement (`statements`, `expressions`), into LLVM IR (`block`, `numbers`, `arrays`, `functions`); short loops become
part of their callers, long ones are compiled once and called (`specialisation`). Code is kept on disk under its meaning
(`meaning`). Python calls a loop through a builtin in machine code (`entry`, `dispatch`).
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
