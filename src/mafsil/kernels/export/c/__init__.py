"""The tape as portable C99, with a program that proves it."""

__all__ = ()
