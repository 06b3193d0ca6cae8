"""Scalar arguments of every public function over 600 decades: refused in our words, or answered by good numbers."""

from __future__ import annotations

import json
import subprocess
import sys

from tests.reliability.decade_calls import CALLS, EXCLUDED, OPEN
from tests.reliability.decades import VALUES, functions, judge, places, undriven
from tests.sizes import size


def test_every_public_function_with_a_real_argument_is_driven_or_excluded():
    assert set(undriven()) == set(EXCLUDED)
    assert len(functions()) > 180
    assert all(EXCLUDED.values())


def test_600_decades():
    """In a process of its own, whose memory is bounded; every size by `python -m tests.reliability.decades`."""
    command = [sys.executable, "-m", "tests.reliability.decades", *size(["--some"], [])]
    done = subprocess.run(command, capture_output=True, text=True, timeout=560, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    found = json.loads(done.stdout)
    assert {name: why for name, why in found["wrong"].items() if name not in OPEN} == {}
    assert set(found["wrong"]) == set(OPEN), "what is mended leaves the list of what is open"
    assert found["arguments"] > 350
    assert found["calls"] > size(4_500, 9_000)


def test_the_judge_sees_what_it_is_for():
    assert max(VALUES[3:]) == 1e300
    assert judge({"duration": -1.0}) == ".duration is negative"
    assert judge((1.0, float("nan"))) == "[1] is NaN"
    assert judge([{"speed": float("inf")}]) == "[0].speed is infinite"
    assert not judge({"duration": float("nan")}, ("duration",))
    assert not judge(None)
    text = "f(a=1.0, b=(2.0, 3), c=dict(d=-4.0), e=lambda x: 5.0)"
    assert [place.argument for place in places(text)] == ["a", "b[0]", "c.d"]
    assert len(set(CALLS)) == len(CALLS)
