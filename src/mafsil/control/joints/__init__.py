"""Control of real joints: elastic transmissions, motor current, encoders, delay, friction, estimated motion."""

from mafsil.lazy_module import face

__all__ = face(__name__)
