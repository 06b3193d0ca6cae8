"""What a joint, a link and their numbers may not be: refused when they are made, with a sentence."""

import dataclasses

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import MafsilError

LINKS = (mf.model.Link("a"), mf.model.Link("b"))


def joint(**changes: object) -> mf.model.Joint:
    return mf.model.Joint(**{"name": "j", "kind": mf.model.JointKind.REVOLUTE, "parent": "a", "child": "b", **changes})


def reflected() -> np.ndarray:
    return np.diag([1.0, 1.0, -1.0, 1.0])


@pytest.mark.parametrize(
    ("make", "key"),
    [
        (lambda: joint(axis=[0.0, 0.0, 2.0]), "model.axis"),
        (lambda: joint(axis=[0.0, 0.0, 0.0]), "model.axis"),
        (lambda: joint(axis=[0.0, 0.0, np.nan]), "input.finite"),
        (lambda: joint(axis=[0.0, 1.0]), "input.shape"),
        (lambda: joint(T_pj=2 * np.eye(4)), "geometry.last_row"),
        (lambda: joint(T_pj=reflected()), "geometry.improper"),
        (lambda: joint(T_pj=np.eye(3)), "input.shape"),
        (lambda: joint(kind=mf.model.JointKind.HELICAL, pitch=np.inf), "model.finite"),
        (lambda: mf.model.Inertial(-1.0), "model.magnitude"),
        (lambda: mf.model.Inertial(np.nan), "model.magnitude"),
        (lambda: mf.model.Inertial(1.0, [0, 0]), "input.shape"),
        (lambda: mf.model.Inertial(1.0, [0, 0, np.inf]), "input.finite"),
        (lambda: mf.model.Inertial(1.0, [0, 0, 0], [[1, 1, 0], [0, 1, 0], [0, 0, 1]]), "model.asymmetric"),
        (lambda: mf.model.Limits(lower=1.0, upper=-1.0), "model.limits_swapped"),
        (lambda: mf.model.Limits(velocity=-1.0), "model.limit"),
        (lambda: mf.model.Limits(upper=np.nan), "model.limit"),
        (lambda: mf.model.Actuator(armature=-1.0), "model.magnitude"),
        (lambda: mf.model.Actuator(gear_ratio=np.nan), "model.finite"),
        (lambda: mf.model.Friction(viscous=-0.1), "model.magnitude"),
        (lambda: mf.Mechanism.assemble("x", LINKS, [joint()], gravity=[0, 0]), "input.shape"),
        (lambda: mf.Mechanism.assemble("x", LINKS, [joint()], T_sb=reflected()), "geometry.improper"),
        (lambda: mf.Mechanism.assemble("x", LINKS, [joint()]).with_tip("b", np.eye(3)), "input.shape"),
        (lambda: mf.Mechanism.assemble("x", LINKS, [joint()]).with_gravity([0, 0, np.nan]), "input.finite"),
    ],
)
def test_impossible_parts_are_refused(make, key: str) -> None:
    with pytest.raises(MafsilError) as caught:
        make()
    assert caught.value.key == key
    assert caught.value.message("ar") != caught.value.message("en")


def test_lists_are_welcome_and_arrays_are_copied() -> None:
    axis, pose = np.array([0.0, 1.0, 0.0]), np.eye(4)
    made = joint(axis=axis, T_pj=pose)
    axis[:], pose[:] = np.nan, np.nan
    assert (made.axis == [0, 1, 0]).all()
    assert (made.T_pj == np.eye(4)).all()
    assert (joint(axis=[0, 1, 0]).axis == made.axis).all()
    with pytest.raises(ValueError, match="read-only"):
        made.axis[0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        made.pitch = 1.0
