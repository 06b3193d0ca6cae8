"""R4: every real file loads or gets a coded diagnostic with its place; the numbers are pinocchio's."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from mafsil.model import Joint, JointKind, Mechanism, urdf
from mafsil.model.diagnostics import Severity
from mafsil.model.inertia_check import NOTHING, inertia_fault
from mafsil.model.limits import UNBOUNDED
from mafsil.model.link import moved_inertial
from tests.model.urdf.real_files import XACRO, all_files, robots
from tests.sizes import few

pin = pytest.importorskip("pinocchio")
pytestmark = pytest.mark.row("R4")
EPS = 2.0**-52


def named(path: Path) -> str:
    return path.stem


def test_the_set_is_whole() -> None:
    assert len(all_files()) == 69


@pytest.mark.parametrize("path", all_files(), ids=named)
def test_loads_or_says_why(path: Path) -> None:
    report = urdf.diagnose(path)
    assert report.ok == (path.name != XACRO)
    assert all(d.line > 0 and d.column > 0 for d in report)
    assert all(b.line >= a.line for a, b in pairwise(report))
    if path.name == XACRO:
        assert [d.code for d in report.errors] == ["S0310"]


@pytest.mark.parametrize("path", few(robots(), 14), ids=named)
def test_repairs_leave_no_offer_and_no_impossible_inertia(path: Path) -> None:
    text, changes = urdf.repair(path)
    report = urdf.diagnose(text)
    assert not [d for d in report if d.repair is not None]
    assert report.mechanism is not None
    for link in report.mechanism.links:
        if link.inertial is not None:
            fault = inertia_fault(link.inertial.mass, link.inertial.inertia)
            assert fault is None or fault.severity is Severity.WARNING
            assert np.linalg.eigvalsh(link.inertial.inertia)[0] >= -1e-6 * abs(link.inertial.inertia).max() - NOTHING
    assert len(changes) == len([d for d in urdf.diagnose(path) if d.repair is not None])


@pytest.mark.parametrize("path", few(robots(), 14), ids=named)
def test_equal_to_pinocchio(path: Path) -> None:
    mechanism, model = urdf.read(path), pin.buildModelFromUrdf(str(path))
    moving = {joint.name: joint for joint in mechanism.joints if joint.moves}
    assert set(moving) == set(list(model.names)[1:])
    placements = carried_placements(mechanism)
    merged = merged_inertias(mechanism)
    for joint in moving.values():
        k = model.getJointId(joint.name)
        parent, T = placements[joint.name]
        assert model.names[model.parents[k]] == parent
        size = 1.0 + np.abs(T).max()
        np.testing.assert_allclose(model.jointPlacements[k].homogeneous, T, rtol=0, atol=16 * EPS * size)
        np.testing.assert_allclose(axis_of(model.joints[k]), joint.axis, rtol=0, atol=4 * EPS)
        compare_inertia(model.inertias[k], merged[joint.name])
        compare_limits(model, k, joint)
    total = sum(link.inertial.mass for link in mechanism.links if link.inertial is not None)
    np.testing.assert_allclose(pin.computeTotalMass(model), total_moving(merged), rtol=1e-13)
    assert total >= total_moving(merged) - 1e-12


def carried_placements(mechanism: Mechanism) -> dict[str, tuple[str, np.ndarray]]:
    """For each moving joint the moving joint before it (or `universe`) and its placement there."""
    at: dict[str, tuple[str, np.ndarray]] = {mechanism.links[0].name: ("universe", np.eye(4))}
    placements: dict[str, tuple[str, np.ndarray]] = {}
    for joint in mechanism.joints:
        before, T = at[joint.parent]
        if joint.moves:
            placements[joint.name] = (before, T @ joint.T_pj)
            at[joint.child] = (joint.name, np.eye(4))
        else:
            at[joint.child] = (before, T @ joint.T_pj)
    return placements


def merged_inertias(mechanism: Mechanism) -> dict[str, tuple[float, np.ndarray, np.ndarray]]:
    """Mass, first moment and inertia about the joint frame of all links that move with each joint."""
    at: dict[str, tuple[str, np.ndarray]] = {mechanism.links[0].name: ("universe", np.eye(4))}
    for joint in mechanism.joints:
        before, T = at[joint.parent]
        at[joint.child] = (joint.name, np.eye(4)) if joint.moves else (before, T @ joint.T_pj)
    sums: dict[str, list] = {}
    for link in mechanism.links:
        owner, T = at[link.name]
        mass, moment, inertia = sums.get(owner, [0.0, np.zeros(3), np.zeros((3, 3))])
        if link.inertial is not None:
            moved = moved_inertial(link.inertial, T)
            m, c = moved.mass, moved.com
            mass, moment = mass + m, moment + m * c
            inertia = inertia + moved.inertia + m * (c @ c * np.eye(3) - np.outer(c, c))
        sums[owner] = [mass, moment, inertia]
    return {name: tuple(value) for name, value in sums.items()}


def total_moving(merged: dict[str, tuple[float, np.ndarray, np.ndarray]]) -> float:
    return sum(mass for name, (mass, _, _) in merged.items() if name != "universe")


def compare_inertia(theirs: object, ours: tuple[float, np.ndarray, np.ndarray]) -> None:
    mass, moment, inertia = ours
    np.testing.assert_allclose(theirs.mass, mass, rtol=1e-13, atol=1e-300)
    scale = np.abs(inertia).max() + 1e-12
    if mass > 0.0:
        np.testing.assert_allclose(
            theirs.mass * theirs.lever, moment, rtol=0, atol=1e-13 * (np.abs(moment).max() + 1e-3)
        )
    c = theirs.lever
    about_origin = theirs.inertia + theirs.mass * (c @ c * np.eye(3) - np.outer(c, c))
    np.testing.assert_allclose(about_origin, inertia, rtol=0, atol=1e-12 * scale)


def axis_of(joint: object) -> np.ndarray:
    name = joint.shortname()
    for k, letter in enumerate("XYZ"):
        if name.endswith(letter):
            return np.eye(3)[k]
    return np.array(joint.extract().axis if hasattr(joint, "extract") else joint.axis)


def compare_limits(model: object, k: int, joint: Joint) -> None:
    """Bounds that the file gives; what we read as unknown is infinite here."""
    if joint.kind is JointKind.REVOLUTE and joint.wraps:
        return
    i, v = model.idx_qs[k], model.idx_vs[k]
    pairs = (
        (joint.limits.lower, model.lowerPositionLimit[i]),
        (joint.limits.upper, model.upperPositionLimit[i]),
        (joint.limits.velocity, model.velocityLimit[v]),
        (joint.limits.effort, model.effortLimit[v]),
    )
    for ours, theirs in pairs:
        assert ours == theirs or (np.isinf(ours) and (theirs == 0.0 or abs(theirs) >= UNBOUNDED)), (
            joint.name,
            ours,
            theirs,
        )
