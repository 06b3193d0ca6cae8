"""Grasp statics: contacts, force and form closure with certificates, contact forces, quality and synthesis."""

from mafsil.lazy_module import face

__all__ = face(__name__)
