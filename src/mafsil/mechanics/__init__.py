"""Every algorithm of a mechanism once, as an expression; `quantities` holds the table of them."""

__all__ = ()
