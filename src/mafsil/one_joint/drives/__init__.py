"""Drives of a joint: motors, gears, brakes, sensors, friction, backlash, elastic and variable transmissions."""

from mafsil.lazy_module import face

__all__ = face(__name__)
