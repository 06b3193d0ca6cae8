"""Numbers for people: three digits, never an exponent, in the unit that one would say them in."""

from __future__ import annotations

from math import isfinite, log10, pi

_DEGREES = 180.0 / pi
_SMALLEST = 5e-7
"""Shown as zero below this, in the unit that is shown."""
_SCALES = {
    "m": ((1.0, 1.0, "m"), (1e-4, 1e3, "mm"), (0.0, 1e6, "µm")),
    "m/s": ((1.0, 1.0, "m/s"), (0.0, 1e3, "mm/s")),
    "s": ((1.0, 1.0, "s"), (0.0, 1e3, "ms")),
    "rad": ((0.0, _DEGREES, "°"),),
    "rad/s": ((0.0, _DEGREES, "°/s"),),
    "rad/s²": ((0.0, _DEGREES, "°/s²"),),
    "share": ((0.0, 100.0, "%"),),
}
"""Of each unit: from which magnitude on, times what, called what."""


def quantity(value: float, unit: str) -> str:
    """A number with its unit, as one says it: 0.27 m is `270 mm`, 0.5 rad is `28.6°`, a share of 0.25 is `25 %`.

    Args:
        value: in SI units.
        unit: `m`, `rad`, `s`, their rates, `share`; any other is shown as it is.
    """
    if not isfinite(value):
        return f"{value} {unit}".replace("share", "").strip()
    for least, factor, shown in _SCALES.get(unit, ((0.0, 1.0, unit),)):
        if abs(value) >= least:
            space = "" if shown.startswith("°") else " "
            return f"{digits(value * factor)}{space}{shown}".strip()
    raise AssertionError("every scale ends with zero")


def digits(value: float) -> str:
    """Three significant digits without an exponent: 119213268 is `119,000,000`, 2.7e-4 is `0.00027`."""
    if abs(value) < _SMALLEST:
        return "0"
    places = 2 - int(log10(abs(value)) // 1)
    rounded = round(value, places)
    text = f"{rounded:,.{max(places, 0)}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text
