"""Description and machine code together: load a robot, call its quantities.

call      mf.load(...) gives a Robot: robot.fk, robot.inverse_dynamics ...
computed  `robot` is description and code, `compiled_robot` asks `mafsil.mechanics` for a quantity and compiles
          it, `routines` is the list of them, `degrees` converts angles
compiled  `compiling`, `compiled_robot`
tested    tests/robot, tests/laws, tests/test_whole_tables.py
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
