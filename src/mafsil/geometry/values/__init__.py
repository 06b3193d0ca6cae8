"""Values people hold: frozen, any batch, with frame letters where given."""

from mafsil.lazy_module import face

__all__ = face(__name__)
