"""Where a kernel comes from: what was compiled, for which machine, from which expression, and how long it took."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace


@dataclass(frozen=True)
class KernelRecord:
    """The record that travels with compiled code, also through the cache.

    Attributes:
        name: of the kernel.
        key: of the cache entry of the tape; in the record of a piece of code, of that piece; hexadecimal.
        expression: BLAKE2b hash of the operations that were compiled, hexadecimal.
        operations: how many of each operation one evaluation takes.
        target: processor as LLVM names it.
        lanes: rows evaluated together.
        object_bytes: size of the object code that is loaded.
        seconds: time of each stage: build, lower, compile (of the run that compiled it).
        cached: whether this process found all code that it has loaded in the cache.
    """

    name: str
    key: str
    expression: str = ""
    operations: Mapping[str, int] = field(default_factory=dict[str, int])
    target: str = ""
    lanes: int = 0
    object_bytes: int = 0
    seconds: Mapping[str, float] = field(default_factory=dict[str, float])
    cached: bool = False

    @property
    def total(self) -> int:
        """Operations of one evaluation."""
        return sum(self.operations.values())

    def as_json(self) -> bytes:
        """The record as text, for the cache."""
        return json.dumps(asdict(self)).encode()

    def __str__(self) -> str:
        most = sorted(self.operations.items(), key=lambda item: -item[1])
        counts = ", ".join(f"{count} {name}" for name, count in most)
        took = ", ".join(f"{stage} {seconds:.3f} s" for stage, seconds in self.seconds.items())
        return "\n".join(
            (
                f"{self.name}: {self.total} operations ({counts})",
                f"  expression {self.expression[:16]}, key {self.key[:16]}",
                f"  {self.target}, {self.lanes} lanes, {self.object_bytes} bytes of object code",
                f"  {took}{', from the cache' if self.cached else ''}",
            )
        )


def from_json(text: bytes, *, cached: bool) -> KernelRecord:
    """The record written by `KernelRecord.as_json`."""
    return replace(KernelRecord(**json.loads(text)), cached=cached)
