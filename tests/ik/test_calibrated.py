"""Almost ideal arms: all solutions of the measured arm, and which branch of the ideal one each continues."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.ik import closed_form, continued_branches, inverse_kinematics
from mafsil.ik.chain import chain_of
from mafsil.ik.structure import elimination
from tests import sizes

TURN = 2 * np.pi


def apart(found, q):
    """Largest difference of angles up to whole turns."""
    return np.abs((found - q + np.pi) % TURN - np.pi).max(axis=-1)


def measured(robot, size, seed):
    """The arm with every axis turned and moved at random by some size [rad, m]."""
    rng, chain = np.random.default_rng(seed), chain_of(robot.mechanism)
    w = chain.axes + size * rng.normal(size=(6, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    r = chain.points + size * rng.normal(size=(6, 3))
    prismatic = np.array(chain.prismatic)[:, None]
    screws = np.concatenate([np.where(prismatic, 0, w), np.where(prismatic, w, np.cross(r, w))], axis=1)
    return mf.Robot.from_screws(screws, chain.home)


def questions(robot, count, seed):
    q = np.random.default_rng(seed).uniform(-3, 3, (count, 6))
    if robot.mechanism.coordinates[2].kind.value == "prismatic":
        q[:, 2] = 0.2 + 0.05 * q[:, 2]
    return q, robot.forward_kinematics(q)


@pytest.mark.capability("07-42", "07-43", "07-2")
@pytest.mark.parametrize(
    ("name", "size"), [("puma560", 1e-6), ("puma560", 1e-2), ("ur5e", 1e-3), ("stanford_arm", 1e-4)]
)
def test_all_solutions_of_a_measured_arm(name, size):
    """As many as elimination finds, the planted one among them."""
    robot = measured(mf.load(name), size, 1)
    q, T = questions(robot, sizes.size(3, 6), 2)
    general = elimination(robot).solve_all(T)
    for k in range(len(q)):
        answer = inverse_kinematics(robot, T[k])
        assert len(answer) == general.count[k]
        assert answer.residual.max() < 1e-9
        assert apart(answer.q, q[k]).min() < 1e-6
        assert answer.complete == general.complete[k]


@pytest.mark.capability("07-42", "07-5", "07-56")
@pytest.mark.parametrize(("name", "size"), [("puma560", 1e-4), ("ur5e", 1e-3)])
def test_branches_go_on_and_keep_their_places(name, size):
    ideal, lost = mf.load(name), 0
    robot = measured(ideal, size, 3)
    _, T = questions(robot, sizes.size(2, 5), 4)
    for X in T:
        one = continued_branches(robot, X)
        on = np.flatnonzero(one.solution >= 0)
        assert len(np.unique(one.solution[on])) == len(on)
        assert sorted([*one.solution[on], *one.gained]) == list(range(len(one.answer)))
        # Away from folds a branch moves by as much as the arm is off, over the conditioning.
        bound = 30 * size / one.answer.conditioning[one.solution[on]]
        assert (one.moved[on] <= bound + 1e-9).all()
        lost += len(one.lost)
        assert ("lost" in one.explain("en")) == bool(one.lost)
    assert lost <= 4


@pytest.mark.capability("07-42", "07-3")
def test_at_a_fold_a_pair_is_lost_or_gained():
    """An elbow almost stretched: where the upper arm is a little shorter than the ideal one, pairs end on the way."""
    ideal = mf.load("puma560")
    robot = measured(ideal, 1e-3, 5)
    q = np.array([0.3, 0.4, 0.0, 0.5, 0.9, 0.2])
    elbow = np.linspace(-np.pi, np.pi, 4001)
    rows = np.repeat(q[None], len(elbow), axis=0)
    rows[:, 2] = elbow
    sign = np.sign(np.linalg.det(ideal.jacobian_space(rows)))
    folds = elbow[np.flatnonzero(sign[1:] != sign[:-1])]
    events = {"lost": 0, "gained": 0}
    for source in (ideal, robot):
        for fold in sizes.size(folds[:2], folds):
            for beside in (-0.02, 0.005, 0.02):
                q[2] = fold + beside
                one = continued_branches(robot, source.forward_kinematics(q))
                assert one.answer.residual.max(initial=0.0) < 1e-9
                events["lost"] += len(one.lost)
                events["gained"] += len(one.gained)
                assert ("appeared" in one.explain("en")) == bool(one.gained)
    assert min(events.values()) >= 2


@pytest.mark.capability("07-42")
def test_an_ideal_arm_continues_itself():
    robot = mf.load("puma560")
    q = np.array([0.3, -0.4, 0.5, 0.6, 0.7, 0.8])
    one = continued_branches(robot, robot.forward_kinematics(q))
    assert (one.solution >= 0).sum() == len(one.answer) == 8
    assert np.nanmax(one.moved) < 1e-9
    assert one.lost == one.gained == ()
    assert one.explain("ar") != one.explain("en")


def test_wrong_questions_are_refused_by_name():
    rng = np.random.default_rng(0)
    w, r = rng.normal(size=(2, 6, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    general = mf.Robot.from_screws(np.concatenate([w, np.cross(r, w)], axis=1), pose.exp(rng.normal(size=6)))
    assert closed_form(general) is None
    with pytest.raises(InputError, match="closed form"):
        continued_branches(general, general.forward_kinematics(np.zeros(6)))
    with pytest.raises(InputError, match="closed form"):
        continued_branches(mf.load("panda"), np.eye(4))
    puma = mf.load("puma560")
    for T in (np.full((4, 4), np.nan), np.zeros((4, 4)), np.eye(3), np.tile(np.eye(4), (2, 1, 1))):
        with pytest.raises(InputError):
            continued_branches(puma, T)
