from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

class PillowWriter:
    def __init__(self, fps: int = ...) -> None: ...

class FuncAnimation:
    def __init__(
        self, fig: Any, func: Callable[[int], Iterable[Any]], frames: int = ..., *, blit: bool = ..., **options: Any
    ) -> None: ...
    def save(self, filename: str | Path, writer: PillowWriter, dpi: float | None = ...) -> None: ...
