"""Hyperbolic functions, their inverses and the hypotenuse on all lanes."""

from __future__ import annotations

import math

from mafsil.kernels import coefficients as table
from mafsil.kernels.emitter import Lanes
from mafsil.kernels.exponential import exp_scaled, log, log1p
from mafsil.kernels.polynomial import polynomial


def sinh(lanes: Lanes, x: str) -> str:
    """Hyperbolic sine: a polynomial up to 1, exponentials beyond."""
    z = lanes.mul(x, x)
    near = lanes.fma(lanes.mul(x, z), polynomial(lanes, table.SINH, z, lanes.mul(z, z)), x)
    half = exp_scaled(lanes, lanes.fabs(x), -1)
    far = lanes.sub(half, lanes.div(lanes.const(0.25), half))
    small = lanes.compare("olt", lanes.fabs(x), lanes.const(1.0))
    return lanes.copysign(lanes.select(small, near, far), x)


def cosh(lanes: Lanes, x: str) -> str:
    """Hyperbolic cosine."""
    half = exp_scaled(lanes, lanes.fabs(x), -1)
    return lanes.add(half, lanes.div(lanes.const(0.25), half))


def tanh(lanes: Lanes, x: str) -> str:
    """Hyperbolic tangent: a polynomial up to 0.55, 1 - 2/(e^2x + 1) beyond."""
    size = lanes.fabs(x)
    z = lanes.mul(x, x)
    near = lanes.fma(lanes.mul(x, z), polynomial(lanes, table.TANH, z, lanes.mul(z, z)), x)
    doubled = exp_scaled(lanes, lanes.add(size, size), 0)
    far = lanes.sub(lanes.const(1.0), lanes.div(lanes.const(2.0), lanes.add(doubled, lanes.const(1.0))))
    small = lanes.compare("olt", size, lanes.const(0.55))
    return lanes.copysign(lanes.select(small, near, far), x)


def asinh(lanes: Lanes, x: str) -> str:
    """log(|x| + sqrt(1 + x^2)), signed."""
    size = lanes.fabs(x)
    large = lanes.compare("ogt", size, lanes.const(2.0**28))
    held = lanes.select(large, lanes.const(1.0), size)
    square = lanes.mul(held, held)
    root = lanes.sqrt(lanes.add(lanes.const(1.0), square))
    inner = lanes.add(held, lanes.div(square, lanes.add(lanes.const(1.0), root)))
    far = lanes.add(log(lanes, size), lanes.const(math.log(2)))
    return lanes.copysign(lanes.select(large, far, log1p(lanes, inner)), x)


def acosh(lanes: Lanes, x: str) -> str:
    """log(x + sqrt(x^2 - 1)); NaN below 1."""
    large = lanes.compare("ogt", x, lanes.const(2.0**28))
    above = lanes.sub(lanes.select(large, lanes.const(1.0), x), lanes.const(1.0))
    root = lanes.sqrt(lanes.mul(above, lanes.add(above, lanes.const(2.0))))
    far = lanes.add(log(lanes, x), lanes.const(math.log(2)))
    near = log1p(lanes, lanes.add(above, root))
    result = lanes.select(large, far, near)
    return lanes.select(lanes.compare("olt", x, lanes.const(1.0)), lanes.const(math.nan), result)


def atanh(lanes: Lanes, x: str) -> str:
    """log1p(2|x| / (1 - |x|)) / 2, signed."""
    size = lanes.fabs(x)
    ratio = lanes.div(lanes.add(size, size), lanes.sub(lanes.const(1.0), size))
    result = lanes.mul(lanes.const(0.5), log1p(lanes, ratio))
    result = lanes.select(lanes.compare("ogt", size, lanes.const(1.0)), lanes.const(math.nan), result)
    return lanes.copysign(result, x)


def hypot(lanes: Lanes, x: str, y: str) -> str:
    """sqrt(x^2 + y^2) without overflow; an infinity wins over NaN, as in C."""
    a, b = lanes.fabs(x), lanes.fabs(y)
    steep = lanes.compare("ogt", b, a)
    large, small = lanes.select(steep, b, a), lanes.select(steep, a, b)
    up = lanes.compare("olt", large, lanes.const(2.0**-500))
    down = lanes.compare("ogt", large, lanes.const(2.0**500))
    scale = lanes.select(up, lanes.const(2.0**600), lanes.select(down, lanes.const(2.0**-600), lanes.const(1.0)))
    back = lanes.select(up, lanes.const(2.0**-600), lanes.select(down, lanes.const(2.0**600), lanes.const(1.0)))
    large, small = lanes.mul(large, scale), lanes.mul(small, scale)
    root = lanes.mul(lanes.sqrt(lanes.fma(large, large, lanes.mul(small, small))), back)
    endless = lanes.mask_op(
        "or",
        lanes.compare("oeq", a, lanes.const(math.inf)),
        lanes.compare("oeq", b, lanes.const(math.inf)),
    )
    return lanes.select(endless, lanes.const(math.inf), root)
