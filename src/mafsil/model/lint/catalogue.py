"""The catalogue of what looks wrong in a description that can be read: code, severity, sentence key.

Letter P (plausibility): 08 bodies, 09 joints, 10 the whole robot. Faults of mass properties themselves keep the
readers' codes I05..; they are judged here for robots that came from no file.
"""

from __future__ import annotations

from mafsil.model.diagnostics import Fault, Severity

FAULTS: dict[str, Fault] = {}
"""Every fault of this catalogue by its code."""


def _fault(code: str, severity: Severity, name: str) -> Fault:
    if code in FAULTS:
        raise ValueError(code)
    FAULTS[code] = Fault(code, severity, f"lint.{name}")
    return FAULTS[code]


def _error(code: str, name: str) -> Fault:
    return _fault(code, Severity.ERROR, name)


def _warning(code: str, name: str) -> Fault:
    return _fault(code, Severity.WARNING, name)


def _info(code: str, name: str) -> Fault:
    return _fault(code, Severity.INFO, name)


# Bodies
TOO_HEAVY = _warning("P0801", "too_heavy")
TOO_LIGHT = _warning("P0802", "too_light")
GRAMS = _warning("P0803", "grams")
MILLIMETRES = _warning("P0804", "millimetres")
COM_OUTSIDE = _warning("P0810", "com_outside")
COM_MIRRORED = _warning("P0811", "com_mirrored")
ABOUT_FRAME = _warning("P0812", "about_frame")
INERTIA_TOO_LARGE = _warning("P0813", "inertia_too_large")
INERTIA_TOO_SMALL = _warning("P0814", "inertia_too_small")
INERTIA_UNIT = _warning("P0815", "inertia_unit")
PLACEHOLDER = _warning("P0820", "placeholder")
COPIED = _info("P0821", "copied")
MASS_RATIO = _info("P0822", "mass_ratio")
NO_COLLISION = _info("P0830", "no_collision")

# Joints
DEGREES = _warning("P0901", "degrees")
DEGREES_RATE = _warning("P0902", "degrees_rate")
MILLIMETRES_TRAVEL = _warning("P0903", "millimetres_travel")
ABSURD_BOUND = _info("P0904", "absurd_bound")
NO_RANGE = _info("P0905", "no_range")
ZERO_BOUND = _warning("P0906", "zero_bound")
ZERO_OUTSIDE = _info("P0907", "zero_outside")
MIMIC_RANGE = _warning("P0908", "mimic_range")
NEARLY_ALONG = _info("P0910", "nearly_along")
ANTIPARALLEL = _info("P0911", "antiparallel")
MIRRORED_RANGE = _warning("P0912", "mirrored_range")
SAME_LINE = _warning("P0913", "same_line")
LONG_LINK = _warning("P0915", "long_link")
MOVES_NOTHING = _warning("P0914", "moves_nothing")
LIMIT_REFUSED = _error("P0916", "limit_refused")
BOUND_REFUSED = _error("P0917", "bound_refused")

# The whole robot
GRAVITY_UP = _warning("P1001", "gravity_up")
GRAVITY_SIZE = _warning("P1002", "gravity_size")
NO_MASSES = _info("P1003", "no_masses")
