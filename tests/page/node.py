"""Node.js for tests of the page's modules, which know no document."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[2] / "src" / "mafsil"
REQUIRED = "MAFSIL_REQUIRE_BROWSER"
"""Environment variable: what is missing is a failure, not a reason to skip."""


def needed(*names: str) -> str:
    """The first program of these names; without any the test is skipped, or fails where that is required."""
    for name in names:
        path = shutil.which(name)
        if path is not None:
            return path
    if os.environ.get(REQUIRED):
        pytest.fail(f"none of {', '.join(names)} is installed; `python3 start.py test` installs them as root on Debian")
    pytest.skip(f"none of {', '.join(names)} is installed")


def run_module(script: str, folder: Path, *arguments: str) -> str:
    """Run an ES module in a folder where `page/`, `scene/` and `report/` are the package's own; what it prints."""
    for name in ("page", "scene", "report"):
        if not (folder / name).exists():
            shutil.copytree(SOURCE / name, folder / name, ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    (folder / "package.json").write_text('{"type": "module"}')
    (folder / "script.js").write_text(script)
    words = [needed("node", "nodejs"), "script.js", *arguments]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout
