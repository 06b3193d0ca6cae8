"""Control in contact: environments, constraints, impedance, admittance, force and hybrid control, force sensors."""

from mafsil.lazy_module import face

__all__ = face(__name__)
