"""The thresholds of verification, from the rounding of both methods."""

LIMIT = 1e-11
"""Largest error relative to the natural size: 45,000 roundings of 2^-52, as many as the complex step through a hundred
joints may take; a wrong sign or term is larger by many orders."""
SINGULAR = LIMIT
"""Smallest eigenvalue of a mass matrix of unit diagonal below which a refusal to invert it is right: its inverse would
have no digit within the limit."""
ROUNDING = 1e-19
"""Square of the share, some 3e-10, of the largest root of a moment below which a moment of a matrix is rounding."""
CONDITION = 1e-6
"""Smallest margin of task-space inertia at which two inversions are compared: five digits of the limit are left."""
