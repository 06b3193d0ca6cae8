"""`mafsil info --build`: afterwards no first question waits for a loop that knows no robot."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from mafsil.cli import info
from mafsil.cli.build import families
from mafsil.cli.main import main

OTHER_QUESTIONS = """
import logging, numpy as np, mafsil as mf
said = []
handler = logging.Handler()
handler.emit = lambda record: said.append(record.getMessage())
logging.getLogger("mafsil").addHandler(handler)
logging.getLogger("mafsil").setLevel(logging.INFO)
ur = mf.load("ur5e")
T = ur.forward_kinematics(np.full(6, 0.3))
assert mf.solve_ik(ur, T)
assert mf.solve_ik(ur, np.stack([T] * 5)).solved.all()
corners = [(0.5, 0, 0), (-0.5, 0.1, 0), (0, 0.7, 0.1), (0, -0.7, 0)]
mf.Grasp([mf.Contact(p, [-x for x in p], 0.7) for p in corners]).closure()
print(said)
"""


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_other_robots_and_grasps_find_their_loops_built(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", "--build", "--json"]) == 0
    out, err = capsys.readouterr()
    data = json.loads(out)
    assert [one["name"] for one in data["built"]] == [name for questions in families().values() for name in questions]
    assert all(one["name"] in err for one in data["built"])
    assert data["cache"]["loops"] > 0
    done = subprocess.run([sys.executable, "-c", OTHER_QUESTIONS], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_cache_is_counted_by_kind(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    from mafsil.kernels import cache

    monkeypatch.setattr(cache, "default", lambda: cache.Store(tmp_path))
    assert info._cache()["entries"] == 0
    for name in ("a.kernel", "b.kernel", "c.tape", "d.loop", "e.sources", "f.lock", "g.tmp"):
        (tmp_path / name).write_bytes(bytes(500_000))
    found = info._cache()
    assert [found[kind] for kind in ("entries", "kernels", "tapes", "loops", "sources")] == [5, 2, 1, 1, 1]
    assert found["size"] == "2.5 MB"
    monkeypatch.setattr(cache, "default", lambda: cache.Store(None))
    assert info._cache() == {"place": None}
