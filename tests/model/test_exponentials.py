"""Screws in, mechanism out, and back."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from mafsil.errors import InputError, ModelError
from mafsil.model import Inertial, Joint, JointKind, Link, Mechanism, Mimic
from mafsil.model.dh_from_axes import screws
from mafsil.model.exponentials import chain_to_tip, kind_of_screw, mechanism_from_screws


def bracket(S):
    (x, y, z), v = S[:3], S[3:]
    return np.array([[0, -z, y, v[0]], [z, 0, -x, v[1]], [-y, x, 0, v[2]], [0, 0, 0, 0]])


def random_screw(rng, kind):
    w, p = rng.normal(size=3), rng.normal(size=3)
    w /= np.linalg.norm(w)
    if kind is JointKind.PRISMATIC:
        return np.array([0, 0, 0, *w])
    pitch = rng.uniform(0.1, 1) * rng.choice([-1, 1]) if kind is JointKind.HELICAL else 0.0
    return np.array([*w, *(-np.cross(w, p) + pitch * w)])


kinds = st.lists(st.sampled_from([JointKind.REVOLUTE, JointKind.PRISMATIC, JointKind.HELICAL]), min_size=1, max_size=7)


def poses_of(mechanism, q):
    poses = [mechanism.T_sb]
    for joint, value in zip(mechanism.joints, q, strict=True):
        poses.append(poses[-1] @ joint.T_pj @ expm(bracket(joint.screw) * value))
    return poses


@pytest.mark.capability("05-9", "05-33", "05-44", "05-46")
@settings(deadline=None, max_examples=25)
@given(kinds, st.sampled_from(["space", "body"]), st.integers(0, 2**32 - 1))
def test_product_of_exponentials_is_the_mechanism_and_comes_back(kinds, form, seed):
    rng = np.random.default_rng(seed)
    S = np.array([random_screw(rng, kind) for kind in kinds])
    home, q = expm(bracket(rng.normal(size=6))), rng.uniform(-3, 3, len(kinds))
    arm = mechanism_from_screws(S, home, form=form)
    motion = np.eye(4)
    for axis, value in zip(S, q, strict=True):
        motion = motion @ expm(bracket(axis) * value)
    expected = motion @ home if form == "space" else home @ motion
    np.testing.assert_allclose(poses_of(arm, q)[-1] @ arm.T_lt, expected, atol=1e-11)
    assert [joint.kind for joint in arm.joints] == kinds
    S_s, S_b, M = screws(arm)
    np.testing.assert_allclose(S_s if form == "space" else S_b, S, atol=1e-11)
    np.testing.assert_allclose(M, home, atol=1e-12)


@settings(deadline=None, max_examples=40)
@given(kinds, st.integers(0, 2**32 - 1))
def test_link_frames_sit_on_the_axis_nearest_to_the_frame_before(kinds, seed):
    rng = np.random.default_rng(seed)
    S = np.array([random_screw(rng, kind) for kind in kinds])
    poses = poses_of(mechanism_from_screws(S, np.eye(4)), np.zeros(len(kinds)))
    for axis, kind, before, frame in zip(S, kinds, poses[:-1], poses[1:], strict=True):
        z, origin = frame[:3, 2], frame[:3, 3]
        np.testing.assert_allclose(z, axis[3:] if kind is JointKind.PRISMATIC else axis[:3], atol=1e-12)
        step = origin - before[:3, 3]
        if kind is JointKind.PRISMATIC:
            np.testing.assert_allclose(step, 0, atol=1e-12)
        else:
            pitch = axis[:3] @ axis[3:]
            np.testing.assert_allclose(-np.cross(z, origin) + pitch * z, axis[3:], atol=1e-12)
            assert abs(step @ z) < 1e-12


def test_masses_may_be_given_in_frames_of_their_own():
    """Frames at the centres of mass, parallel to {s}, as in textbooks of dynamics."""
    S = [[0, 0, 1, 0, 0, 0], [1, 0, 0, 0, 0, -0.5]]
    T = np.eye(4)
    T[:3, 3] = 0.1, 0.6, 0.2
    tensor = np.diag([0.1, 0.2, 0.25])
    arm = mechanism_from_screws(S, np.eye(4), inertials=[None, Inertial(2.0, inertia=tensor)], inertial_frames=[T, T])
    pose = poses_of(arm, [0, 0])[-1]
    inertial = arm.links[-1].inertial
    np.testing.assert_allclose(pose[:3, :3] @ inertial.com + pose[:3, 3], T[:3, 3], atol=1e-15)
    np.testing.assert_allclose(pose[:3, :3] @ inertial.inertia @ pose[:3, :3].T, tensor, atol=1e-15)
    assert arm.links[1].inertial is None


def test_screws_pass_over_fixed_joints_and_branches():
    shift = np.eye(4)
    shift[0, 3] = 1.0
    arm = Mechanism.assemble(
        "branched",
        [Link(name) for name in ("base", "a", "b", "c", "side")],
        [
            Joint("j1", JointKind.REVOLUTE, "base", "a"),
            Joint("s1", JointKind.REVOLUTE, "a", "side", T_pj=shift),
            Joint("f1", JointKind.FIXED, "a", "b", T_pj=shift),
            Joint("j2", JointKind.HELICAL, "b", "c", pitch=0.1),
        ],
        tip="c",
    )
    S_s, _, home = screws(arm)
    np.testing.assert_allclose(S_s, [[0, 0, 1, 0, 0, 0], [0, 0, 1, 0, -1, 0.1]], atol=1e-15)
    np.testing.assert_allclose(home[:3, 3], [1, 0, 0], atol=1e-15)
    assert [joint.name for joint in chain_to_tip(arm)] == ["j1", "f1", "j2"]


def test_a_mechanism_without_joints_has_no_screws():
    S_s, S_b, home = screws(Mechanism.assemble("stone", [Link("base")], []))
    assert S_s.shape == S_b.shape == (0, 6)
    np.testing.assert_array_equal(home, np.eye(4))


def test_rounded_tables_are_accepted_and_long_screws_only_on_request():
    rounded = mechanism_from_screws([[0, 0.7071068, 0.7071068, 0, 0, 0]], np.eye(4))
    assert np.linalg.norm(screws(rounded).S_s[0, :3]) == pytest.approx(1, abs=1e-15)
    scaled = mechanism_from_screws([[0, 0, 2, 0, -2, 0]], np.eye(4), normalise=True)
    np.testing.assert_allclose(screws(scaled).S_s[0], [0, 0, 1, 0, -1, 0], atol=1e-15)


@pytest.mark.parametrize(
    ("S", "kind", "pitch"),
    [
        ([0, 0, 1, 0, -1, 0], JointKind.REVOLUTE, 0.0),
        ([0, 0, 1, 0, -1, 1e-12], JointKind.REVOLUTE, 0.0),
        ([0, 0, 1, 0, -1, -0.2], JointKind.HELICAL, -0.2),
        ([0, 0, 0, 0, 1, 0], JointKind.PRISMATIC, 0.0),
    ],
)
def test_the_kind_of_a_joint_is_read_off_its_screw(S, kind, pitch):
    found, direction, h = kind_of_screw(np.array(S, float))
    assert found is kind
    assert h == pytest.approx(pitch)
    assert np.linalg.norm(direction) == pytest.approx(1)


def mimicking():
    joints = [
        Joint("a", JointKind.REVOLUTE, "base", "l1"),
        Joint("b", JointKind.REVOLUTE, "l1", "l2", mimic=Mimic("a", 2.0)),
    ]
    return Mechanism.assemble("m", [Link("base"), Link("l1"), Link("l2")], joints, tip="l2")


@pytest.mark.parametrize(
    ("call", "key"),
    [
        (lambda: mechanism_from_screws([[0] * 6], np.eye(4)), "screws.zero"),
        (lambda: mechanism_from_screws([[0, 0, 1, 0, 0, 0], [1, 0, 1, 0, 0, 0]], np.eye(4)), "screws.unit"),
        (lambda: mechanism_from_screws([[0, 0, 0, 0, 3, 0]], np.eye(4)), "screws.unit"),
        (lambda: mechanism_from_screws(np.zeros((0, 6)), np.eye(4)), "screws.none"),
        (lambda: mechanism_from_screws([[0, 0, 1, 0, 0, 0]], np.eye(4), form="local"), "screws.form"),
        (
            lambda: mechanism_from_screws([[0, 0, 1, 0, 0, 0]], np.eye(4), inertial_frames=[]),
            "serial.length",
        ),
        (lambda: screws(mimicking()), "screws.mimic"),
    ],
)
def test_wrong_screws_are_refused_with_a_sentence_in_both_languages(call, key):
    with pytest.raises(ModelError) as caught:
        call()
    assert caught.value.key == key
    assert caught.value.message("en") != caught.value.message("ar")


def test_the_sentence_names_the_screw_and_its_length():
    with pytest.raises(ModelError, match=r"screw 2 has length 1\.41421356"):
        mechanism_from_screws([[0, 0, 1, 0, 0, 0], [1, 0, 1, 0, 0, 0]], np.eye(4))


@pytest.mark.parametrize("screws_", [[[0, 0, 1]], [[0, 0, np.nan, 0, 0, 0]], "abc", None])
def test_what_is_no_screw_is_refused(screws_):
    with pytest.raises(InputError, match="screws"):
        mechanism_from_screws(screws_, np.eye(4))
    with pytest.raises(InputError, match="home"):
        mechanism_from_screws([[0, 0, 1, 0, 0, 0]], np.eye(3))
