from collections.abc import Callable
from typing import Any

def quad(func: Callable[[float], float], a: float, b: float, **options: Any) -> Any: ...
