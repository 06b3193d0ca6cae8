"""Declared functions: lazy, cached, picklable, equal to CasADi's own evaluation at any batch; and their refusals."""

from __future__ import annotations

import copy
import inspect
import pickle
import subprocess
import sys

import numpy as np
import pytest

from mafsil.algebra.membership import function
from mafsil.errors import InputError
from mafsil.geometry import euler, membership, planar, pose, quaternion, rotation, screw, twist, wrench
from mafsil.geometry.membership import Declared
from mafsil.messages import keys, template
from tests.oracles.casadi_expression import as_casadi

MODULES = (rotation, pose, quaternion, euler, screw, twist, wrench, planar)
DECLARED = {
    f"{module.__name__.rpartition('.')[2]}.{name}": value.declared
    for module in MODULES
    for name, value in vars(module).items()
    if isinstance(getattr(value, "declared", None), Declared) and value.__module__ == module.__name__
}
MEMBERS = {
    "": lambda rng, shape: rng.standard_normal(shape),
    **{
        kind: lambda rng, shape: rng.standard_normal(shape)
        for kind in (
            "rotation_vector",
            "exponential_coordinates",
            "planar_coordinates",
            "amount",
            "duration",
            "part_turn",
        )
    },
    "axis": lambda rng, shape: rng.standard_normal(shape),
    "quaternion": lambda rng, shape: rng.standard_normal(shape),
    "rotation": lambda rng, shape: rotation.random(rng),
    "pose": lambda rng, shape: pose.exp(rng.standard_normal(6)),
    "unit_quaternion": lambda rng, shape: rotation.normalise_quaternion(rng.standard_normal(4)),
    "unit_screw": lambda rng, shape: screw.normalise(rng.standard_normal(6)),
    "axis_triple": lambda rng, shape: np.eye(3),
    "planar_rotation": lambda rng, shape: planar.rotation(rng.standard_normal()),
    "planar_pose": lambda rng, shape: planar.exp(rng.standard_normal(3)),
}


@pytest.mark.parametrize("name", DECLARED)
def test_equals_casadi_and_every_batch_is_its_rows(name: str):
    declared = DECLARED[name]
    rng = np.random.default_rng(1)
    rows = [
        [np.asarray(MEMBERS[declared.conditions.get(port, "")](rng, shape)) for port, shape in declared.inputs]
        for _ in range(6)
    ]
    written = function(declared.source, declared.inputs, declared.outputs, declared.conditions, declared.constants)
    reference = as_casadi(written)
    singles = [_tuple(declared(*row)) for row in rows]
    for row, got in zip(rows, singles, strict=True):
        want = reference(*[x.ravel() for x in row])
        for a, b in zip(got, _tuple(want), strict=True):
            b = np.array(b).ravel()
            assert np.abs(np.ravel(a) - b).max() <= 1e-13 * (1 + np.abs(b).max())
    stacked = [np.stack(columns).reshape(3, 1, 2, *columns[0].shape) for columns in zip(*rows, strict=True)]
    for k, (a, (_, shape)) in enumerate(zip(_tuple(declared(*stacked)), declared.outputs, strict=True)):
        assert a.shape == (3, 1, 2, *shape)
        assert np.array_equal(a.reshape(6, *shape), np.stack([np.asarray(single[k]) for single in singles]))


def test_importing_and_calling_from_the_cache_needs_no_expressions():
    rotation.log(rotation.exp([0.1, 0.2, 0.3]))
    script = (
        "import sys; from mafsil.geometry import rotation;"
        "heavy = ('mafsil.expression', 'scipy', 'matplotlib', 'numba');"
        "assert not any(name in sys.modules for name in heavy);"
        "rotation.log(rotation.exp([0.1, 0.2, 0.3])); assert 'mafsil.expression' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", script], check=True, timeout=120)


def test_descriptions_are_the_functions_that_people_see():
    assert len(DECLARED) > 80
    assert str(inspect.signature(screw.from_axis)).startswith("(direction: 'AxisLike', point: 'Vector3Like', pitch")
    assert screw.from_axis.__doc__.startswith("Unit screw of an axis")
    assert "def from_axis" in inspect.getsource(screw.from_axis)
    given = {"direction": [0, 0, 2.0], "point": [1.0, 0, 0]}
    assert np.array_equal(screw.from_axis(**given), screw.from_axis(*given.values(), 0.0))
    assert pickle.loads(pickle.dumps(screw.from_axis)) is screw.from_axis
    with pytest.raises(TypeError, match="point"):
        screw.from_axis([0, 0, 1.0])


def test_declared_functions_travel():
    declared = DECLARED["rotation.log"]
    R = rotation.exp([0.1, 0.2, 0.3])
    for protocol in range(2, 6):
        again = pickle.loads(pickle.dumps(declared, protocol))
        assert np.array_equal(again(R), declared(R))
    assert np.array_equal(copy.deepcopy(declared)(R), declared(R))
    T = pickle.loads(pickle.dumps(pose.exp(np.zeros(6))))
    assert np.array_equal(T, np.eye(4))


def test_every_kind_of_member_has_its_sentence_in_both_languages():
    kinds = set(membership.CORES)
    assert kinds <= keys("en", "geometry")
    assert keys("en", "geometry") == keys("ar", "geometry")
    bad = {
        "rotation": (2 * np.eye(3), "norm of R'R - I is 5.2"),
        "pose": (np.diag([2.0, 2, 2, 1]), "have the length 2"),
        "unit_quaternion": (np.array([0.5, 0, 0, 0]), "by 0.5"),
        "quaternion": (np.zeros(4), "length zero"),
        "axis": (np.zeros(3), "no direction"),
        "rotation_vector": (np.array([1e155, 0, 0]), "too long"),
        "exponential_coordinates": (np.array([1e155, 0, 0, 0, 0, 0]), "too long"),
        "planar_coordinates": (np.array([-1e155, 0, 0]), "too large"),
        "amount": (np.array(1e155), "too large"),
        "duration": (np.array(0.0), "duration is zero"),
        "part_turn": (np.array(2 * np.pi), "whole number of turns"),
        "unit_screw": (np.zeros(6), "by 1"),
        "axis_triple": (np.ones((3, 3)), "unit vectors"),
        "planar_rotation": (np.diag([2.0, 1.0]), "not a planar rotation"),
        "planar_pose": (np.diag([2.0, 1, 1]), "not a planar pose"),
    }
    assert set(bad) == kinds
    for kind, (value, words) in bad.items():
        with pytest.raises(InputError, match=words) as caught:
            membership.require(kind, "given", np.stack([value, value]))
        assert str(caught.value).startswith("given[0]: ")
        arabic = caught.value.message("ar")
        assert "given[0]" in arabic
        assert arabic != caught.value.message("en")
        assert template(caught.value.key, "ar") != template(caught.value.key, "en")
    assert membership.is_member("axis", [[0, 0, 1e-100], [0, 0, np.nan]]).tolist() == [True, False]


def _tuple(value: object) -> tuple:
    return value if isinstance(value, tuple) else (value,)
