"""One link transform: four motions, the test for four parameters, the reason why not."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mafsil.errors import ModelError
from mafsil.model.denavit_hartenberg import DHRow
from mafsil.model.dh_frames import LinkStatus, four_motions, link_fit
from mafsil.model.placement import rotation_y, rotation_z, translation

numbers = st.floats(-2, 2)
rows = st.builds(DHRow, a=numbers, alpha=numbers, d=numbers, theta=numbers, kind=st.sampled_from("RP"), offset=numbers)
conventions = st.sampled_from(["modified", "classic"])


@pytest.mark.capability("05-24", "05-25")
@given(rows, conventions, numbers)
def test_four_motions_make_the_link_and_neighbours_commute(row, convention, q):
    motions = four_motions(row, convention, q)
    product = np.eye(4)
    for motion in motions:
        product = product @ motion.T
        np.testing.assert_allclose(motion.frame, product, atol=1e-14)
    from mafsil.model.denavit_hartenberg import Convention

    np.testing.assert_allclose(product, row.transform(Convention(convention), q), atol=1e-13)
    one, two, three, four = (motion.T for motion in motions)
    np.testing.assert_allclose(two @ one @ four @ three, product, atol=1e-13)
    assert [m.name[:3] for m in motions].count("Rot") == 2


@pytest.mark.capability("05-20", "05-21", "05-22")
@given(rows, conventions)
def test_links_give_their_parameters_back(row, convention):
    product = four_motions(row, convention)[-1].frame
    fit = link_fit(product, convention)
    assert fit
    assert fit.status is LinkStatus.LINK
    np.testing.assert_allclose(four_motions(fit.row, convention)[-1].frame, product, atol=1e-12)
    np.testing.assert_allclose(fit.missing, np.eye(4), atol=1e-9)


@pytest.mark.capability("05-19", "05-20")
@given(st.integers(0, 2**32 - 1), conventions)
def test_any_pose_is_a_link_and_what_is_missing(seed, convention):
    rng = np.random.default_rng(seed)
    T = np.eye(4)
    T[:3, :3] = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
    T[:3, 3] = rng.normal(size=3)
    fit = link_fit(T, convention)
    link = four_motions(fit.row, convention)[-1].frame
    product = link @ fit.missing if convention == "modified" else fit.missing @ link
    np.testing.assert_allclose(product, T, atol=1e-9)


@pytest.mark.capability("05-20")
@pytest.mark.parametrize(
    ("T", "status"),
    [
        (translation(0, 1, 0), LinkStatus.TRANSLATION_LEFT),
        (rotation_y(0.5), LinkStatus.ROTATION_LEFT),
        (translation(0, 0, 1), LinkStatus.LINK),
        (rotation_y(0.5) @ translation(0, 1, 0), LinkStatus.BOTH_LEFT),
        (rotation_y(np.pi / 2), LinkStatus.ROTATION_LEFT),
        (rotation_z(0.4) @ translation(1, 0, 0), LinkStatus.TRANSLATION_LEFT),
    ],
)
def test_figure_5_4_says_what_is_in_the_way(T, status):
    fit = link_fit(T)
    assert fit.status is status
    assert fit.explain("en") != fit.explain("ar")
    np.testing.assert_allclose(four_motions(fit.row, "modified")[-1].frame @ fit.missing, T, atol=1e-12)


def test_what_is_no_pose_is_refused():
    with pytest.raises(ModelError, match="T"):
        link_fit(2 * np.eye(4))
