"""Expressions: symbols, matrices of them, functions and derivatives; what every algorithm is written in.

`from mafsil import expression as ex`, then `q = ex.symbol("q", 6)`, `ex.cos(q[0])`, `ex.jacobian(f, q)`.

call      mf.expression.symbol, Function, gradient, jacobian
computed  `node` and `graph` hold the terms once each, `derivatives` differentiates, `arithmetic` and `elementary`
          simplify what is always true
tested    tests/expression
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
