"""Links drawn apart: put together, proven impossible, or not found."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil import mobility as mo
from tests.parallel.closed_chains import four_bar


def drawn_apart(crank, coupler, rocker, ground):
    """All links drawn along x from where they begin."""
    return mo.Linkage.of(
        [
            mo.joint("A", "R", ["ground", "crank"], [0, 0]),
            mo.joint("B", "R", ["crank", "coupler"], [crank, 0], child_at=[0, 1]),
            mo.joint("C", "R", ["coupler", "rocker"], [coupler, 1], child_at=[0, 2]),
            mo.joint("D", "R", ["rocker", "ground"], [rocker, 2], child_at=[ground, 0]),
        ],
        planar=True,
        name="apart",
    )


@pytest.mark.capability("02-53")
@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(0.3, 4), min_size=4, max_size=4))
def test_four_links_of_given_lengths(lengths):
    excess = 2 * max(lengths) - sum(lengths)
    if abs(excess) < 0.02:
        return
    found = mo.can_assemble(drawn_apart(*lengths))
    if excess > 0:
        assert found.status is mo.assembly_existence.ExistenceStatus.IMPOSSIBLE
        assert found.excess == pytest.approx(excess)
        assert found.loop == ("A", "B", "C", "D")
        with pytest.raises(mf.ModelError, match="m longer than the others together"):
            mf.mobility(drawn_apart(*lengths))
    else:
        assert found
        together = mo.close_drawing(drawn_apart(*lengths))
        places = {each.name: each.point for each in together.joints}
        sides = [np.linalg.norm(places[a] - places[b]) for a, b in ("AB", "BC", "CD", "DA")]
        assert sides == pytest.approx(lengths, abs=1e-8)
        assert mf.mobility(drawn_apart(*lengths)).count.mobility == 1


def test_mobility_of_links_drawn_apart(tmp_path):
    found = mf.mobility(drawn_apart(2, 4, 3.5, 4.5))
    assert (found.mobility, found.finite.status) == (1, mo.finite.FiniteStatus.REGULAR)
    theta = mo.can_assemble(drawn_apart(2, 4, 3.5, 4.5)).theta
    assert int(mo.batch_mobility(drawn_apart(2, 4, 3.5, 4.5), theta)) == 1
    path = tmp_path / "apart.toml"
    path.write_text(
        'planar = true\n[[joint]]\nkind = "R"\nbodies = ["ground", "a"]\n'
        '[[joint]]\nkind = "R"\nbodies = ["a", "b"]\nat = [1, 0]\nchild_at = [0, 1]\n'
        '[[joint]]\nkind = "R"\nbodies = ["b", "ground"]\nat = [1.2, 1]\nchild_at = [1.7, 0]\n'
    )
    assert mf.mobility(path).status is mo.report.MobilityStatus.RIGID
    path.write_text(path.read_text().replace("1.7", "2.9"))
    with pytest.raises(mf.ModelError, match=r"0\.7 m longer"):
        mf.mobility(path)


def test_a_search_never_says_no():
    stiff = mo.Linkage.of(
        [
            mo.joint("P", "P", ["ground", "a"], [0, 0], [1, 0]),
            mo.joint("Q", "P", ["a", "b"], [0, 0], [1, 0]),
            mo.joint("R", "P", ["b", "ground"], [0, 0], [1, 0], child_at=[0, 1]),
        ]
    )
    found = mo.can_assemble(stiff, starts=16)
    assert found.status is mo.assembly_existence.ExistenceStatus.NOT_FOUND
    assert "were found" in found.explain("en")
    assert found.gap > 0.1


def test_what_needs_the_links_together_says_so():
    for task in (mo.linkages.split_joints, mo.mechanism_of, lambda linkage: mo.linkages.lock_joints(linkage, ["A"])):
        with pytest.raises(mf.ModelError, match=r"assembled|gape"):
            task(drawn_apart(2, 4, 3.5, 4.5))
    assert mo.mechanism_of(mo.close_drawing(drawn_apart(2, 4, 3.5, 4.5))).n == 3


def test_loops_that_no_proof_forbids_say_how_near_they_come():
    """A slider is 0.3 m farther off than the crank reaches, and sliders are in no polygon's proof."""
    joints = [
        mo.joint("O", "R", ["ground", "crank"]), mo.joint("A", "R", ["crank", "slider"], [1, 0], child_at=[0, 1.3]),
        mo.joint("S", "P", ["ground", "slider"], [0, 1.3], [1, 0]),
    ]  # fmt: skip
    found = mo.can_assemble(mo.Linkage.of(joints, planar=True))
    assert found.status is mo.assembly_existence.ExistenceStatus.NOT_FOUND
    assert (found.joint, found.distance) == ("A", pytest.approx(0.3, abs=1e-6))
    assert "0.3 m" in found.explain("en")


def test_loops_of_mechanisms_are_closed_from_where_newton_stands_still():
    """All bars on one line at zero: the rank is lost there, and Newton's method cannot leave the line."""
    assert mf.mobility(four_bar(1.0, 0.4, 1.1, 0.8)).mobility == 1
    with pytest.raises(mf.ModelError, match=r"joint C open by 2\.7 m and"):
        mf.mobility(four_bar(5.0, 0.4, 1.1, 0.8))
