"""Named mechanisms by parameters, each drawn in a configuration that closes; `linkage("bennett")`, `names()`."""

from mafsil.lazy_module import face

__all__ = face(__name__)
