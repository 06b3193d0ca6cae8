# What mafsil.figures uses of matplotlib, whose own types leave the keywords of most methods open.
from contextlib import AbstractContextManager

__version__: str

def rc_context(rc: dict[str, str] | dict[str, str | float]) -> AbstractContextManager[None]: ...
