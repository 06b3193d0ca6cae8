"""The URDF files of example-robot-data, if it is installed."""

from __future__ import annotations

import sysconfig
from pathlib import Path

FOLDER = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
XACRO = "ur3.urdf"
"""The one file that is a xacro expanded to nothing."""


def all_files() -> list[Path]:
    """All 69, or none where the package is missing."""
    return sorted(FOLDER.rglob("*.urdf"))


def robots() -> list[Path]:
    """Those that describe a robot."""
    return [path for path in all_files() if path.name != XACRO]
