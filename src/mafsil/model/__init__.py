"""The robot as immutable data, and what makes it: readers and writers of files, tables, mass properties, lint.

call      mf.load(path or name), robot.save(path); mafsil convert, mafsil lint
computed  `loading` chooses the reader: `urdf.reader`, `mjcf.reader`, `sdf.reader`, `table.reading`,
          `xacro.expansion`; all make the `mechanism`; `lint.linting` looks it over, `saving` writes
tested    tests/model, tests/lint, tests/corpus, tests/reliability/hostile_doors.py
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
