"""The check of annotated shapes finds a wrong one: in an argument, in a result, and between them."""

from typing import Any

import numpy as np
import pytest

from mafsil.arrays import JointMatrix, JointVector, PoseMatrix, Scalar, Vector3

shapes = pytest.importorskip("tests.house.shapes", reason="jaxtyping and beartype check shapes")


def matrix(q: JointVector, size: int) -> JointMatrix:
    return np.zeros((*q.shape[:-1], size, size))


def parted(T: PoseMatrix | None, wrong: Any = None) -> tuple[Vector3, Scalar]:
    return (np.zeros(3) if T is None else T[..., :3, 3]), np.float64(0.0) if wrong is None else wrong


def test_names_have_one_value_in_a_call() -> None:
    checked = shapes._checked(matrix)
    assert checked(np.zeros((5, 3)), 3).shape == (5, 3, 3)
    with pytest.raises(TypeError, match=r"batch n n"):
        checked(np.zeros((5, 3)), 4)
    with pytest.raises(TypeError):
        checked(np.zeros(3, dtype=int), 3)


def test_unions_and_tuples_are_seen_through() -> None:
    checked = shapes._checked(parted)
    assert len(checked(None)) == 2
    assert checked(np.zeros((2, 4, 4)), np.zeros(2))[0].shape == (2, 3)
    for T, wrong in ((np.zeros((2, 3, 4)), None), (np.zeros((2, 4, 4)), np.zeros(3))):
        with pytest.raises(TypeError):
            checked(T, wrong)


def test_what_has_no_shape_stays_itself() -> None:
    def plain(q: Any, name: str) -> str:
        return name

    assert shapes._checked(plain) is plain
