"""All answers of inverse kinematics have one shape: truth, iteration, status, sentences, plain data, notebooks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import mafsil as mf
from mafsil.answer import Answer
from mafsil.ik import track

ARM = mf.load("ur5e")
Q = np.array([0.3, -1.2, 1.1, 0.2, 0.9, -0.4])
NEAR = ARM.forward_kinematics(Q)
FAR = NEAR.copy()
FAR[:3, 3] *= 10.0
PATH = ARM.forward_kinematics(Q + np.linspace(0.0, 0.2, 5)[:, None])

SOLVED: dict[str, Any] = {
    "one pose": lambda: mf.inverse_kinematics(ARM, NEAR),
    "many poses": lambda: mf.inverse_kinematics(ARM, np.stack([NEAR, NEAR])),
    "search": lambda: mf.solve_ik(ARM, NEAR),
    "searches": lambda: mf.solve_ik(ARM, np.stack([NEAR, NEAR])),
    "path": lambda: track(ARM, PATH, Q),
}
UNSOLVED: dict[str, Any] = {
    "one pose": lambda: mf.inverse_kinematics(ARM, FAR),
    "many poses": lambda: mf.inverse_kinematics(ARM, np.stack([NEAR, FAR])),
    "search": lambda: mf.solve_ik(ARM, FAR),
    "searches": lambda: mf.solve_ik(ARM, np.stack([FAR, NEAR])),
    "path": lambda: track(ARM, np.concatenate([PATH, FAR[None]]), Q),
}


@pytest.mark.parametrize("kind", SOLVED)
def test_answers_share_one_shape(kind: str) -> None:
    for answer, good in ((SOLVED[kind](), True), (UNSOLVED[kind](), False)):
        assert isinstance(answer, Answer)
        assert bool(answer) is good
        assert len(list(answer)) == len(answer)
        data = answer.to_dict()
        assert data["status"]
        np.testing.assert_array_equal(data["q"], answer.nearest if kind.startswith("search") else answer.q)
        sentences = answer.explain().split("\n")
        assert all(sentences)
        assert answer._repr_html_().count("<div") == len(sentences)


@pytest.mark.parametrize("kind", ["many poses", "searches"])
def test_statuses_of_batches_are_named_in_order(kind: str) -> None:
    answer = UNSOLVED[kind]()
    names = [status.name.lower() for status in answer.status]
    assert answer.to_dict()["status"] == names
    assert {"solved", "out_of_reach"} == set(names)


def test_what_is_not_plain_text_does_not_reach_a_notebook_as_markup() -> None:
    class Odd(Answer):
        def __bool__(self) -> bool:
            return False

        def __len__(self) -> int:
            return 0

        def __iter__(self) -> Any:
            return iter(())

        def to_dict(self) -> dict[str, Any]:
            return {}

        def explain(self) -> str:
            return "<script>"

    assert Odd()._repr_html_() == '<div dir="auto">&lt;script&gt;</div>'
