from typing import Any

class Circle:
    def __init__(self, xy: Any, radius: float = ..., **options: Any) -> None: ...
