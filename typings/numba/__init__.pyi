# What mafsil.solvers uses of numba, which carries no types: the decorator keeps a function's signature.
from collections.abc import Callable
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])

__version__: str

def njit(*signatures: Any, **options: Any) -> Callable[[F], F]: ...
def __getattr__(name: str) -> Any: ...
