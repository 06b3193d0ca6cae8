"""Derivations in numbered steps with symbols, every line compared with the compiled robot.

call      robot.derive('jacobian'), mafsil derive, mafsil check-homework
computed  `fk`, `jacobian`, `lagrange`, `dynamics`, `ik` write the steps; `formula_text`, `latex`, `html` show
          them; `review` judges a student's table
tested    tests/derivation: every line is compared with the compiled robot (`verification`)
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
