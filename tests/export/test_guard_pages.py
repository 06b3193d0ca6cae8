"""No code of ours reads or writes a byte beyond its arrays: forbidden pages lie at both ends of each."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.row("F3")
@pytest.mark.skipif(sys.platform != "linux", reason="mprotect of Linux")
def test_forbidden_pages_stay_untouched() -> None:
    words = [sys.executable, "-m", "tests.export.guarded", "40"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "untouched"


@pytest.mark.skipif(sys.platform != "linux", reason="mprotect of Linux")
def test_the_pages_are_really_forbidden() -> None:
    code = (
        "from tests.export.guarded import guarded; import numpy as np, ctypes; x = guarded(np.zeros(3), at_end=True); "
    )
    code += "ctypes.c_double.from_address(x.ctypes.data + 24).value"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, check=False)
    assert done.returncode == -11
    assert np.zeros(3).nbytes == 24
