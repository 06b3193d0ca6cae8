"""Calls that once ended in an error of Python or NumPy: now in a sentence that names the argument."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import mafsil as mf
from mafsil import performance
from mafsil.derivation import derive_fk, to_text
from mafsil.geometry.logarithms import logarithms

SIX = np.ones((3, 6))
CALLS: dict[str, tuple[Callable[[], object], str]] = {
    "endless angles": (lambda: logarithms(np.eye(3), 0, np.inf), "high: inf"),
    "work of unequal rows": (lambda: performance.work(SIX, np.ones((4, 6)), [0, 1, 2]), "twists"),
    "work of unequal times": (lambda: performance.work(SIX, SIX, [0, 1]), "times"),
    "samples that are no whole number": (lambda: performance.workspace_map("planar2r", 1e4), "samples"),
    "derivation in an unknown language": (lambda: to_text(derive_fk("planar2r"), "fr"), "'fr' is not known"),
    "answer in an unknown language": (lambda: mf.inverse_kinematics("planar2r", np.eye(4)).explain("fr"), "'fr'"),
}


@pytest.mark.parametrize(("call", "words"), CALLS.values(), ids=CALLS.keys())
def test_the_argument_is_named(call: Callable[[], object], words: str) -> None:
    with pytest.raises(ValueError, match=words) as caught:
        call()
    assert type(caught.value) is not ValueError or "choose one of" in str(caught.value)


def test_work_of_a_constant_power() -> None:
    assert performance.work(SIX, SIX, [0, 1, 2]) == 12.0
