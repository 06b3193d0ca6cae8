"""Commands about robots with loops: numbers of the closed chain, or a sentence, never the open tree's."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.parallel import ClosedChain

PALLETISER = str(Path(__file__).parents[2] / "examples" / "robots" / "palletiser.xml")
CLOSED = ["0.2", "-0.3", "-0.1", "0.3"]
pytestmark = pytest.mark.filterwarnings("ignore::mafsil.errors.ModelWarning")


def said(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str]:
    status = main([*words])
    printed = capsys.readouterr()
    return status, printed.out + printed.err


def test_efforts_are_those_of_the_driven_joints(capsys: pytest.CaptureFixture[str]) -> None:
    chain, q, still = ClosedChain(mf.load(PALLETISER)), np.array(CLOSED, dtype=float), np.zeros(4)
    status, text = said(capsys, "dynamics", PALLETISER, "--json", "--q", *CLOSED)
    found = json.loads(text[text.index("{") :])
    assert status == 0
    assert found["driven"] == ["shoulder", "lever"]
    np.testing.assert_allclose(found["tau"], chain.inverse_dynamics(q, still, still).tau, atol=1e-9)
    rates = chain.rates(q, np.array([0.3, 0.0, -0.2, 0.0]), hold=chain.actuated)
    words = ["--qd", *map(repr, rates.tolist()), "--tau", "0", "0", "1", "0"]
    status, text = said(capsys, "dynamics", PALLETISER, "--json", "--q", *CLOSED, *words)
    moved = chain.forward_dynamics(q, rates, np.array([0.0, 1.0]))
    np.testing.assert_allclose(json.loads(text[text.index("{") :])["qdd"], moved.qdd, atol=1e-6)
    assert status == 0


def test_rounded_coordinates_are_closed_and_open_ones_refused(capsys: pytest.CaptureFixture[str]) -> None:
    status, text = said(capsys, "dynamics", PALLETISER, "--json", "--q", "0.2", "-0.300001", "-0.1", "0.3")
    q = np.array(json.loads(text[text.index("{") :])["q"])
    assert status == 0
    assert ClosedChain(mf.load(PALLETISER)).error(q) < 1e-12
    for words in (
        ["dynamics", PALLETISER, "--q", "0.2", "0", "-0.1", "0"],
        ["fk", PALLETISER, "0.2", "0", "-0.1", "0"],
    ):
        status, text = said(capsys, *words)
        assert status
        assert "leave a gap" in text
        assert "0.2 -0.3 -0.1 0.3" in text  # and so it can be typed
    status, text = said(capsys, "dynamics", PALLETISER, "--q", *CLOSED, "--qd", "1", "0", "0", "0")
    assert status
    assert "velocities violate one" in text


@pytest.mark.parametrize(
    "words",
    [
        ["singularity", PALLETISER, *CLOSED],
        ["statics", PALLETISER, *CLOSED],
        ["workspace", PALLETISER],
        ["derive", "jacobian", PALLETISER],
        ["derive", "ik", PALLETISER],
        ["dynamics", PALLETISER, "--q", *CLOSED, "--duration", "1"],
        ["dynamics", PALLETISER, "--q", *CLOSED, "--quantities", "mass_matrix"],
    ],
    ids=lambda words: " ".join(words[:1] + words[-2:]).replace(PALLETISER, ""),
)
def test_what_is_of_open_chains_says_so(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    status, text = said(capsys, *words)
    assert status
    assert "closed loops" in text
    status, text = said(capsys, *words, "--lang", "ar")
    assert "حلقات مغلقة" in text
