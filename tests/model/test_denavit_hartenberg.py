"""Laws of Denavit-Hartenberg tables: table = mechanism = screws, in both conventions."""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from mafsil.errors import InputError, ModelError
from mafsil.model.denavit_hartenberg import Convention, DHRow, dh_parameters, frames_in_links, mechanism_from_dh
from mafsil.model.dh_from_axes import screws
from mafsil.model.limits import Limits
from mafsil.model.link import Inertial

lengths = st.floats(-2, 2)
angles = st.one_of(st.floats(-pi, pi), st.sampled_from([0.0, pi / 2, -pi / 2, pi, -pi]))
rows = st.builds(DHRow, a=lengths, alpha=angles, d=lengths, theta=angles, kind=st.sampled_from("RP"), offset=angles)
tables = st.lists(rows, min_size=1, max_size=7)
conventions = st.sampled_from(list(Convention))


def link_transform(row, convention, q):
    """The four elementary motions, written out."""
    turn = row.theta + (row.offset + q if row.kind == "R" else 0)
    d = row.d + (row.offset + q if row.kind == "P" else 0)
    ca, sa, ct, st_ = cos(row.alpha), sin(row.alpha), cos(turn), sin(turn)
    if convention is Convention.MODIFIED:
        return np.array(
            [
                [ct, -st_, 0, row.a],
                [st_ * ca, ct * ca, -sa, -d * sa],
                [st_ * sa, ct * sa, ca, d * ca],
                [0, 0, 0, 1],
            ]
        )
    return np.array(
        [
            [ct, -st_ * ca, st_ * sa, row.a * ct],
            [st_, ct * ca, -ct * sa, row.a * st_],
            [0, sa, ca, d],
            [0, 0, 0, 1],
        ]
    )


def bracket(S):
    (x, y, z), v = S[:3], S[3:]
    return np.array([[0, -z, y, v[0]], [z, 0, -x, v[1]], [-y, x, 0, v[2]], [0, 0, 0, 0]])


def link_poses(mechanism, q):
    """Pose of every link, joint by joint, with SciPy's matrix exponential."""
    poses = {mechanism.links[0].name: mechanism.T_sb}
    values = dict(zip(mechanism.joint_names, q, strict=True))
    for joint in mechanism.joints:
        motion = expm(bracket(joint.screw) * values.get(joint.name, 0.0))
        poses[joint.child] = poses[joint.parent] @ joint.T_pj @ motion
    return poses


def tip_pose(mechanism, q):
    return link_poses(mechanism, q)[mechanism.tip] @ mechanism.T_lt


def adjoint(T):
    R, p = T[:3, :3], T[:3, 3]
    return np.block([[R, np.zeros((3, 3))], [bracket([*p, 0, 0, 0])[:3, :3] @ R, R]])


@pytest.mark.capability("05-10", "05-26", "05-40", "05-46")
@settings(deadline=None, max_examples=25)
@given(tables, conventions, st.integers(0, 2**32 - 1))
def test_table_product_is_the_mechanism_and_both_forms_of_exponentials(table, convention, seed):
    rng = np.random.default_rng(seed)
    q = rng.uniform(-pi, pi, len(table))
    base, tool = (expm(bracket(rng.normal(size=6))) for _ in range(2))
    arm = mechanism_from_dh(table, convention, base=base, tool=tool)
    product = base
    for row, value in zip(table, q, strict=True):
        product = product @ link_transform(row, convention, value)
    product = product @ tool
    np.testing.assert_allclose(tip_pose(arm, q), product, atol=2e-12)
    S_s, S_b, home = screws(arm)
    space, body = np.eye(4), home
    for S, B, value in zip(S_s, S_b, q, strict=True):
        space = space @ expm(bracket(S) * value)
        body = body @ expm(bracket(B) * value)
    np.testing.assert_allclose(space @ home, product, atol=1e-11)
    np.testing.assert_allclose(body, product, atol=1e-11)
    np.testing.assert_allclose(S_s, S_b @ adjoint(home).T, atol=1e-11)


@pytest.mark.capability("05-22")
@settings(deadline=None, max_examples=20)
@given(tables, conventions, st.integers(0, 2**32 - 1))
def test_frames_of_the_table_are_where_the_convention_puts_them(table, convention, seed):
    q = np.random.default_rng(seed).uniform(-pi, pi, len(table))
    arm = mechanism_from_dh(table, convention)
    poses = link_poses(arm, q)
    frame = np.eye(4)
    for row, value, link, T_li in zip(table, q, arm.links[1:], frames_in_links(table, convention), strict=True):
        frame = frame @ link_transform(row, convention, value)
        np.testing.assert_allclose(poses[link.name] @ T_li, frame, atol=2e-12)


@settings(deadline=None, max_examples=20)
@given(tables, conventions, st.integers(0, 2**32 - 1))
def test_mass_properties_are_given_in_the_frames_of_the_table(table, convention, seed):
    rng = np.random.default_rng(seed)
    tensors = [A @ A.T for A in rng.normal(size=(len(table), 3, 3))]
    inertials = [Inertial(rng.uniform(1, 2), rng.normal(size=3), tensor) for tensor in tensors]
    arm = mechanism_from_dh(table, convention, inertials=inertials)
    poses = link_poses(arm, np.zeros(len(table)))
    frame = np.eye(4)
    for row, link, given_ in zip(table, arm.links[1:], inertials, strict=True):
        frame = frame @ link_transform(row, convention, 0.0)
        R = poses[link.name][:3, :3]
        np.testing.assert_allclose(
            (poses[link.name] @ [*link.inertial.com, 1])[:3], (frame @ [*given_.com, 1])[:3], atol=1e-11
        )
        np.testing.assert_allclose(
            R @ link.inertial.inertia @ R.T, frame[:3, :3] @ given_.inertia @ frame[:3, :3].T, atol=1e-10
        )


@pytest.mark.capability("05-20")
@given(rows)
def test_every_link_transform_gives_its_parameters_back(row):
    T = link_transform(row, Convention.MODIFIED, 0.0)
    found = dh_parameters(T)
    assert found is not None
    np.testing.assert_allclose(found.transform(Convention.MODIFIED), T, atol=1e-12)


@pytest.mark.capability("05-20")
@given(st.floats(0.01, 2), st.floats(0.01, 1.5))
def test_poses_that_no_row_describes_are_refused(length, angle):
    along_y = np.eye(4)
    along_y[1, 3] = length
    about_y = expm(bracket([0, angle, 0, 0, 0, 0]))
    assert dh_parameters(along_y) is None
    assert dh_parameters(about_y) is None


@pytest.mark.parametrize("quarters", range(-5, 6))
def test_quarter_turns_leave_no_roundoff(quarters):
    T = DHRow(alpha=quarters * pi / 2, theta=-quarters * pi / 2).transform(Convention.MODIFIED)
    assert set(np.abs(T).ravel()) <= {0.0, 1.0}


def test_default_names():
    arm = mechanism_from_dh([DHRow(), DHRow(a=1.0)], "modified")
    assert arm.joint_names == ("joint1", "joint2")
    assert arm.link_names == ("base", "link1", "link2")
    assert arm.tip == "link2"


@pytest.mark.parametrize(
    ("call", "key"),
    [
        (lambda: mechanism_from_dh([], "modified"), "dh.no_rows"),
        (lambda: mechanism_from_dh([DHRow()], "craig"), "dh.convention"),
        (lambda: mechanism_from_dh([DHRow(kind="H")], "classic"), "dh.kind"),
        (lambda: mechanism_from_dh([DHRow()], "classic", limits=[Limits()] * 2), "serial.length"),
        (lambda: mechanism_from_dh([DHRow()] * 2, "classic", link_names=["a", "b"]), "serial.length"),
        (lambda: mechanism_from_dh([DHRow()] * 2, "classic", joint_names=["a", "a"]), "model.duplicate_joint"),
    ],
)
def test_wrong_tables_are_refused_with_a_sentence_in_both_languages(call, key):
    with pytest.raises(ModelError) as caught:
        call()
    assert caught.value.key == key
    assert caught.value.message("en") != caught.value.message("ar")


def test_numbers_that_are_none_are_named_by_their_row():
    with pytest.raises(InputError, match=r"rows\[1\]\.d"):
        mechanism_from_dh([[0, 0, 0, 0], [0, 0, np.nan, 0]], "classic")


@pytest.mark.parametrize("name", ["base", "tool"])
def test_wrong_poses_are_refused(name):
    with pytest.raises(InputError, match=name):
        mechanism_from_dh([DHRow()], "modified", **{name: np.eye(3)})
    with pytest.raises(InputError, match=name):
        mechanism_from_dh([DHRow()], "modified", **{name: np.full((4, 4), np.nan)})


def test_an_unknown_keyword_is_not_swallowed():
    with pytest.raises(TypeError, match="limit"):
        mechanism_from_dh([DHRow()], "modified", limit=[Limits()])
