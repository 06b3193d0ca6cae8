"""The commands of `mafsil`: one module a command, in the table of `main`."""

__all__ = ()
