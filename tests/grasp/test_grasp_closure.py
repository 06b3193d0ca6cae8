"""Closure: every route, exact arithmetic, the batch and the theorems agree, and every answer carries its proof."""

from __future__ import annotations

from fractions import Fraction
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest

from mafsil.errors import InputError
from mafsil.grasp import Contact, Grasp, closure, eliminate, rank_grasps, three_fingers, two_fingers
from mafsil.grasp.clearance import point_velocity
from mafsil.grasp.closure import ClosureStatus
from mafsil.grasp.contact_batch import wrench_closures
from mafsil.grasp.friction import angle_to_normal
from mafsil.solvers.rational import Location, locate_origin
from tests.sizes import size

_spec = spec_from_file_location("random_sets", Path(__file__).with_name("random_sets.py"))
random_sets = module_from_spec(_spec)
_spec.loader.exec_module(random_sets)


def pinwheel(a=0.5, shift=(0.0, 0.0)):
    places = (((a, 1), (0, -1)), ((2, a), (-1, 0)), ((-a, -1), (0, 1)), ((-2, -a), (1, 0)))
    return Grasp([Contact(np.add(p, shift), n) for p, n in places])


@pytest.mark.row("R12")
@pytest.mark.capability("03-38", "03-40", "03-42", "03-46", "03-47", "03-48", "03-50")
@pytest.mark.parametrize("seed", range(size(2, 4)))
def test_all_methods_agree(seed):
    rng = np.random.default_rng(seed)
    closed = sum(random_sets.check(random_sets.wrench_set(rng)) for _ in range(500))
    assert 100 < closed < 400


@pytest.mark.row("R12")
@pytest.mark.capability("03-61", "03-62", "03-63", "03-57")
def test_nguyen_agrees_with_exact_arithmetic():
    rng = np.random.default_rng(5)
    middle, half = rng.uniform(-0.6, 0.6, (2000, 2)), rng.uniform(0.02, 1.0, (2000, 2))
    middle[1000:] += np.pi
    theta = np.stack([half + middle, half - middle], axis=2).reshape(-1, 4)
    assert 500 < sum(random_sets.check_nguyen(t) for t in theta) < 1900


@pytest.mark.capability("03-5", "03-61", "03-59")
def test_two_fingers_of_contacts_agree_with_closure():
    rng = np.random.default_rng(6)
    for _ in range(200):
        a, b = (Contact(rng.normal(size=2), rng.normal(size=2), rng.uniform(0.1, 1.5)) for _ in range(2))
        assert two_fingers(a, b).force_closure == Grasp([a, b]).closure(margins=False).force_closure


@pytest.mark.capability("03-68", "03-29")
def test_three_finger_theorem_agrees_with_round_cones():
    rng = np.random.default_rng(8)
    assert 30 < sum(random_sets.check_three(rng) for _ in range(200)) < 170


@pytest.mark.capability("03-29", "03-60")
def test_round_cones_carry_their_proofs():
    rng = np.random.default_rng(8)
    for _ in range(60):
        points, normals = rng.normal(size=(2, 3, 3))
        contacts = [Contact(p, n, rng.uniform(0.3, 1.0)) for p, n in zip(points, normals - points, strict=True)]
        cones = Grasp(contacts).closure(margins=False)
        if cones.certificate is not None:
            assert (Grasp(contacts).matrix(64).T @ cones.certificate).min() >= -1e-6
        else:
            assert np.abs(cones.columns @ cones.combination).max() < 1e-7
            assert cones.combination.min() > 0


@pytest.mark.row("R12")
@pytest.mark.capability("03-40")
@pytest.mark.parametrize("mu", [0.1, 0.3, 0.5, 0.7])
def test_line_on_the_edge_of_a_cone_is_marginal(mu):
    tilted = Grasp([Contact((-1, 0), (1, mu), mu), Contact((1, 0), (-1, 0), mu)])
    found = tilted.closure()
    assert (found.status, found.exact) == (ClosureStatus.MARGINAL, Location.BOUNDARY)
    assert (tilted.matrix().T @ found.certificate).min() >= -1e-12
    assert Grasp([Contact((-1, 0), (1, mu - 1e-6), mu), tilted.contacts[1]]).closure().status is ClosureStatus.CLOSED
    assert Grasp([Contact((-1, 0), (1, mu + 1e-6), mu), tilted.contacts[1]]).closure().verdict == "no"


@pytest.mark.capability("03-2")
def test_frame_changes_the_radius_and_not_the_verdict():
    moved = pinwheel(shift=(3.0, 0.0))
    assert pinwheel().closure().margin == pytest.approx(0.353553390593, abs=1e-9)
    assert moved.closure().margin == pytest.approx(0.121268, abs=1e-6)
    assert moved.quality(about=(3, 0)).epsilon == pytest.approx(0.353553390593, abs=1e-9)
    assert moved.volume() == pytest.approx(pinwheel().volume())
    T = np.array([[0.6, -0.8, 3], [0.8, 0.6, -7], [0, 0, 1]])
    assert pinwheel().in_frame(T).closure().force_closure
    assert rank_grasps([pinwheel(0.1), pinwheel(0.5)])[0][0].contacts[0].point[0] == 0.5


@pytest.mark.capability("03-34")
def test_printed_signs_of_the_rectangle():
    rng = np.random.default_rng(0)
    for _ in range(100):
        l1, l2, l3, l4 = rng.integers(1, 5, 4).astype(float)
        A = np.array([[0, -1, 0, 1], [-1, 0, 1, 0], [-l1, l2, l3, -l4]])
        assert closure(A).force_closure == ((l3 - l1) * (l2 - l4) < 0)


@pytest.mark.capability("03-44", "03-50")
def test_elimination_keeps_the_solutions():
    A = [[-1, 0, 1, 0], [0, -1, 0, 1], [0, 0, Fraction(-2), Fraction(2)]]
    reduced = eliminate(A)
    assert reduced.S.ravel().tolist() == [-1, -1, -1]
    assert [str(s) for s in reduced.steps][:2] == ["R1 := -1 R1", "R2 := -1 R2"]
    x, b = np.array([4.5, 0, 3.5, 2]), np.array([-1.0, 2, -3])
    rows = np.array([[float(v) for v in row] for row in reduced.rows])
    assert rows @ x == pytest.approx(reduced.right_side(b))
    assert eliminate(np.array(A, float), jordan=False).rank == 3


@pytest.mark.capability("03-41", "03-43")
def test_batch_agrees_and_keeps_its_proofs():
    rng = np.random.default_rng(2)
    for m, n in ((3, 4), (3, 12), (6, 7), (6, 40)):
        A = rng.normal(size=(300, m, n)) - 0.15
        found = wrench_closures(A)
        for k in range(0, 300, 10):
            assert found.force_closure[k] == (locate_origin(A[k].T.tolist()).place is Location.INSIDE)
        x, y = found.combination[found.force_closure], found.certificate[~found.force_closure]
        assert (x > 0).all()
        assert np.abs(np.einsum("bmn,bn->bm", A[found.force_closure], x)).max(initial=0) < 1e-8
        assert np.einsum("bmn,bm->bn", A[~found.force_closure], y).min(initial=0) > -1e-8
    assert wrench_closures(np.zeros((0, 3, 4))).force_closure.shape == (0,)


@pytest.mark.capability("03-6", "03-53", "03-55", "03-56")
def test_free_motions_are_what_the_contacts_allow():
    rng = np.random.default_rng(3)
    for _ in range(40):
        grasp = Grasp([Contact(rng.normal(size=3), rng.normal(size=3)) for _ in range(8)])
        free, found = grasp.free_motions(), grasp.form_closure()
        assert free.form_closure == found.force_closure
        for y in free.rays:
            assert (grasp.normals_matrix.T @ y).min() > -1e-8
            assert (
                "PENETRATING" not in {motion.name for motion in grasp.contact_motions(y)}
                or np.abs(grasp.normals_matrix.T @ y).min() < 1e-8
            )


@pytest.mark.capability("03-25")
def test_degenerate_input_is_named():
    cases = [
        (lambda: Contact((0, 0), (0, 0)), "normal is zero"),
        (lambda: Contact((0, 0), (1, 0), -0.1), "mu: -0.1"),
        (lambda: Contact((0, 0), (1, 0), float("nan")), "mu: nan"),
        (lambda: Contact((0, 0), (1, 0), 0.5, 0.1), "gamma needs space"),
        (lambda: Contact((0,), (1,)), "1 coordinates"),
        (lambda: Contact((0, float("inf")), (1, 0)), "inf"),
        (lambda: Grasp([]), "none given"),
        (lambda: Grasp([Contact((0, 0), (1, 0)), Contact((0, 0, 0), (1, 0, 0))]), "contact 1"),
        (lambda: two_fingers(Contact((0, 0), (1, 0)), Contact((0, 0), (1, 0))), "one point"),
        (lambda: wrench_closures(np.ones((3, 4))), "expected shape"),
        (lambda: pinwheel().motion_within_clearance(0.0), "positive"),
    ]
    for call, words in cases:
        with pytest.raises(InputError, match=words):
            call()


@pytest.mark.capability("03-65", "03-12")
def test_collinear_contacts_are_refused():
    line = [Contact((x, 0, 0), (0, 0, (-1) ** x), 0.5) for x in range(3)]
    found = three_fingers(line)
    assert found.collinear
    assert "one line" in found.explain("en")
    spatial = Grasp(line).closure()
    assert (spatial.force_closure, spatial.rank) == (False, 5)


@pytest.mark.capability("03-23", "03-24", "03-28", "03-51", "03-52")
def test_cone_edges_and_contact_velocities():
    push = Contact((1, 2), (0, -2), 0.5)
    assert push.wrenches() == pytest.approx(np.array([[-1 - 2 * -0.5, -1 - 2 * 0.5], [-0.5, 0.5], [-1, -1]]))
    assert np.linalg.norm(push.wrenches(unit=True)[1:], axis=0) == pytest.approx([1, 1])
    assert angle_to_normal((0.5, -1), push.normal) == pytest.approx(push.alpha)
    twist = np.array([0.3, -0.7, 0.2])
    v = point_velocity(twist, push.point)
    assert v == pytest.approx([-0.7 - 2 * 0.3, 0.2 + 0.3])
    assert v @ push.normal == pytest.approx(twist @ Grasp([push]).normals_matrix[:, 0])
    assert not Grasp([Contact((0, 0), (1, 0))]).closure()


@pytest.mark.capability("03-38", "03-41")
def test_read_only_strided_and_one_dimensional_wrenches():
    A = np.random.default_rng(0).normal(size=(40, 6, 24))
    want = [locate_origin(W.T.tolist()).place is Location.INSIDE for W in A[:, :, ::2]]
    A.setflags(write=False)
    assert wrench_closures(A[:, :, ::2]).force_closure.tolist() == want
    assert [closure(W, margins=False).force_closure for W in A[:, :, ::2]] == want
    assert [closure(np.asfortranarray(W)).force_closure for W in A[:, :, ::2]] == want
    assert wrench_closures([[[1, -1]], [[1, 2]]]).force_closure.tolist() == [True, False]
    assert closure([[1, -1]], margins=False).force_closure
    with pytest.raises(InputError, match="nan"):
        wrench_closures(np.full((2, 3, 5), np.nan))
