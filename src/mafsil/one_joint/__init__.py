"""One controlled joint in closed form: error dynamics, stability, responses, gains, drives, friction, sampled loops."""

from mafsil.lazy_module import face

__all__ = face(__name__)
