"""Double precision in two numbers, for whatever compares or divides."""

EPS = 2.0**-52
"""The spacing of numbers at 1. A value that went through n operations with condition c is wrong by n c EPS at most."""
LEAST_DIVISOR = 1e-300
"""In place of a zero to divide by: 1e8 times the least normal number, so that its quotients do not overflow at once."""
