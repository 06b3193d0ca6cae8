"""ROS's own xacro in another interpreter, as the peer of our expander."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Mapping
from pathlib import Path

PROGRAM = Path(__file__).parent / "expand_xacro.py"


class Xacro:
    """A process that expands one file after the other.

    Args:
        python: an interpreter that has xacro (2.1.1 was used; it stands in PyPI).
    """

    def __init__(self, python: str) -> None:
        self.process = subprocess.Popen(
            [python, str(PROGRAM)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )

    def expanded(self, path: Path, workspace: Path, arguments: Mapping[str, str]) -> tuple[str | None, str]:
        """The URDF that a file stands for, or None and what xacro said."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(json.dumps([str(path), str(workspace), dict(arguments)]) + "\n")
        self.process.stdin.flush()
        document, reason = json.loads(self.process.stdout.readline())
        return document, reason

    def close(self) -> None:
        """End the process."""
        if self.process.stdin is not None:
            self.process.stdin.close()
        self.process.wait(10)
        if self.process.stdout is not None:
            self.process.stdout.close()
