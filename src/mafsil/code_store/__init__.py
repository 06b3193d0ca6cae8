"""Compiled code on disk: which folder, that nobody else can write to it, and entries that are whole or absent.

call      no public face: FileStore of `store`, asked by `mafsil.kernels`
computed  `folder` chooses the place and who may write there, `store` writes entries whole or not at all,
          and says who compiles what
tested    tests/kernels, tests/reliability/corrupt_cache.py, kill_cache.py, stampede.py
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
