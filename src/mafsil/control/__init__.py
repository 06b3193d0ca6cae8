"""Control laws: time, measured state and reference in, joint efforts out."""

from mafsil.lazy_module import face

__all__ = face(__name__)
