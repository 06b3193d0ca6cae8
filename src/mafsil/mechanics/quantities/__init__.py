"""The quantities of a robot: each file holds the builders of one family and their rows (`mechanics.quantity`)."""

__all__ = ()
