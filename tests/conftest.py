"""Makes `tests.oracles` and its neighbours importable, and keeps compiled code away from the user's own cache."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

# Shared by the workers of one run and by later runs: a cold cache is what its own tests make for themselves.
os.environ.setdefault("MAFSIL_CACHE", str(Path(tempfile.gettempdir()) / f"mafsil-tests-{os.getuid()}"))
