"""Forces at rest: tip wrenches and joint efforts, loads on links, reactions, capacities, work."""

from mafsil.lazy_module import face

__all__ = face(__name__)
