"""Second order over all equilibria: what curvature holds, in the plane and in space, and what pictures may show."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mafsil.cli.registry import operation
from mafsil.errors import InputError
from mafsil.figures.grasp import save_free_motions
from mafsil.grasp import Contact, Grasp
from mafsil.grasp.body import ellipsoid_contact
from mafsil.grasp.displacement import displaced_pose, free_twists
from mafsil.grasp.second_order import ImmobilityStatus, second_order
from mafsil.grasp.synthesis import polygon_contacts

TRIANGLE = polygon_contacts([(0, 0), (1, 0), (0.5, np.sqrt(3) / 2)], 1)
MIDDLES = [Contact(p, n) for p, n in (((0, 1), (0, -1)), ((2, 0), (-1, 0)), ((0, -1), (0, 1)), ((-2, 0), (1, 0)))]
TETRAHEDRON = [
    Contact(-np.array(v) / 3, v) for v in ((1.0, 1, 1), (1.0, -1, -1), (-1.0, 1, -1), (-1.0, -1, 1))
]  # fmt: skip
EXAMPLES = Path(__file__).parents[2] / "examples" / "grasps"


def turned(grasp: Grasp, angle: float, shift=(0.0, 0.0)) -> Grasp:
    T = np.eye(3)
    T[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    T[:2, 2] = shift
    return grasp.in_frame(T)


def proof_holds(grasp: Grasp, found) -> bool:
    """The certificate of a yes, from its own numbers: equilibrium, and a negative definite form."""
    A = grasp.normals_matrix
    rates = A.T @ found.motions.T
    form = found.form + rates.T @ found.products @ rates
    balanced = np.abs(A @ found.pushes).max() <= 1e-8 * np.abs(A).max()
    return bool(balanced and found.pushes.min() >= 0 and np.linalg.eigvalsh(form).max() < 0)


def test_bodies_of_which_the_answer_is_known() -> None:
    assert second_order(Grasp(TRIANGLE)).status is ImmobilityStatus.SECOND_ORDER
    angles = np.radians([0, 120, 240])
    rim = np.column_stack([np.cos(angles), np.sin(angles)])
    disc = second_order(Grasp([Contact(p, -p, curvature=1.0) for p in rim]))
    assert (disc.status, disc.motion) == (ImmobilityStatus.NOT_SHOWN, None)
    flatter = Grasp([Contact(p, -p, curvature=0.5) for p in rim])
    assert second_order(flatter).status is ImmobilityStatus.SECOND_ORDER
    rounder = second_order(Grasp([Contact(p, -p, curvature=1.5) for p in rim]))
    assert rounder.status is ImmobilityStatus.NOT_SHOWN
    assert np.abs(rounder.motion) == pytest.approx([1, 0, 0])
    hollow = Grasp([Contact(p, -p, curvature=0.5, finger_curvature=-0.2) for p in rim])
    assert second_order(hollow).form.shape == (1, 1)
    assert second_order(Grasp(TRIANGLE[:1])).status is ImmobilityStatus.NO_EQUILIBRIUM
    with pytest.raises(InputError, match="overlap"):
        second_order(Grasp([Contact(p, -p, curvature=-1.0, finger_curvature=0.5) for p in rim]))


@pytest.mark.parametrize("place", [0.25, 0.4, 0.9])
def test_one_more_contact_frees_nothing(place: float) -> None:
    for extra in (
        [Contact((place, 0), (0, 1))],
        [Contact((place, 0), (0, 1)), Contact((1 - place / 2, 0.1), (-1, 0.2))],
    ):
        grasp = Grasp([*TRIANGLE, *extra])
        found = second_order(grasp)
        assert found.immobile
        assert found.status is ImmobilityStatus.FIRST_ORDER or proof_holds(grasp, found)


def test_random_contacts_more_free_nothing_in_the_plane_and_in_space() -> None:
    rng = np.random.default_rng(7)
    for base in (TRIANGLE, MIDDLES, TETRAHEDRON):
        for _ in range(12):
            d = base[0].dimension
            more = [Contact(rng.normal(size=d), rng.normal(size=d)) for _ in range(int(rng.integers(1, 4)))]
            grasp = Grasp([*base, *more])
            found = second_order(grasp)
            assert found.immobile, grasp
            assert found.status is ImmobilityStatus.FIRST_ORDER or proof_holds(grasp, found)


def test_the_answer_does_not_depend_on_frame_rounding_or_size() -> None:
    for k in range(30):
        for grasp in (Grasp(TRIANGLE), Grasp(MIDDLES)):
            assert second_order(turned(grasp, 0.1 + 0.2 * k, (0.3 * k, 0.2))).status is ImmobilityStatus.SECOND_ORDER
    for size in (1e-4, 1e4):
        scaled = Grasp([Contact(size * c.point, c.normal) for c in MIDDLES])
        assert second_order(scaled).status is ImmobilityStatus.SECOND_ORDER
    for digits in (10, 12, 14):
        typed = [Contact(np.round(c.point, digits), np.round(c.normal, digits)) for c in TRIANGLE]
        assert second_order(Grasp(typed)).status is ImmobilityStatus.SECOND_ORDER


def test_an_ellipse_typed_with_rounding_is_in_equilibrium() -> None:
    minor = Grasp([ellipsoid_contact((2, 1), (2 * np.cos(t), np.sin(t))) for t in (np.pi / 2, -np.pi / 2)])
    found = second_order(minor)
    assert found.status is ImmobilityStatus.NOT_SHOWN
    assert found.motion == pytest.approx([0, 1, 0], abs=0.02) or found.motion == pytest.approx([0, -1, 0], abs=0.02)
    assert "0" in found.explain("en")
    waist = Grasp([Contact((0, s), (0, -s), curvature=-2.0) for s in (1.0, -1.0)])
    assert second_order(waist).status is ImmobilityStatus.SECOND_ORDER


def test_curvature_decides_in_space() -> None:
    """Six fingers on the axes: flat faces hold the turns, a sphere lets them, a body that bulges more slips away."""
    expected = {0.0: True, 0.5: True, 1.0: False, 2.0: False}
    for bend, held in expected.items():
        ring = [Contact(s * e, -s * e, curvature=bend) for e in np.eye(3) for s in (1.0, -1.0)]
        found = second_order(Grasp(ring))
        assert found.immobile is held
        assert len(found.motions) == 3
        assert np.linalg.eigvalsh(found.form) == pytest.approx(3 * [(bend - 1) * 2 / 3], abs=1e-12)
        assert (found.motion is not None) == (bend > 1)
    egg = Grasp(
        [ellipsoid_contact((3, 2, 1), s * e * a) for e, a in zip(np.eye(3), (3, 2, 1), strict=True) for s in (1, -1)]
    )
    found = second_order(egg)
    # A turn about x: the fingers on y see curvature b/c^2 = 2, those on z 1/4, at distances 2 and 1.
    rate = np.zeros(6)
    rate[0] = 1.0
    coordinates = found.motions @ rate
    by_hand = found.pushes[2:4].sum() * (2.0**2 * 2.0 - 2.0) + found.pushes[4:].sum() * (1 / 4 - 1.0)
    assert coordinates @ found.form @ coordinates == pytest.approx(by_hand)


def test_curvature_in_space_turns_with_the_body_and_survives_a_file() -> None:
    contact = ellipsoid_contact((3, 2, 1), (0, 2, 0))
    assert np.linalg.eigvalsh(contact.shape) == pytest.approx([2 / 9, 2.0])
    T = np.eye(4)
    T[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    assert np.linalg.eigvalsh(contact.in_frame(T).shape) == pytest.approx([2 / 9, 2.0])
    again = Grasp.from_dict(Grasp([contact]).to_dict()).contacts[0]
    assert again.curvature == pytest.approx(contact.curvature)
    with pytest.raises(InputError, match="along the normal"):
        Contact((0, 0, 1), (0, 0, -1), curvature=np.eye(3))
    with pytest.raises(InputError, match="on the surface"):
        ellipsoid_contact((1, 1), (1, 1))


def test_small_steps_of_the_true_bodies_agree() -> None:
    """The opening predicted by second order against the distance of a moved ellipsoid from its pointed finger."""
    from mafsil.grasp.second_order import opening

    rng = np.random.default_rng(3)
    axes = np.array([3.0, 2.0, 1.0])
    for _ in range(10):
        u = rng.normal(size=3)
        contact = ellipsoid_contact(axes, axes * u / np.linalg.norm(u))
        y = rng.normal(size=6)
        w = contact.basis[:, 0]
        y -= w * (w @ y) / (w @ w)
        predicted = opening(contact, y[None])[0, 0]
        from scipy.linalg import expm

        S = np.zeros((4, 4))
        S[:3, :3] = np.cross(np.eye(3), y[:3]).T * -1.0
        S[:3, :3] = [[0, -y[2], y[1]], [y[2], 0, -y[0]], [-y[1], y[0], 0]]
        S[:3, 3] = y[3:]

        def gap(t: float, S=S, contact=contact) -> float:
            finger = np.linalg.inv(expm(t * S)) @ np.append(contact.point, 1.0)
            level = ((finger[:3] / axes) ** 2).sum() - 1.0
            return level / float(np.linalg.norm(2 * contact.point / axes**2))

        h = 1e-3
        assert (gap(h) + gap(-h)) / h**2 == pytest.approx(predicted, rel=1e-4, abs=1e-4)


@pytest.mark.capability("03-3", "03-54")
def test_the_verdict_names_its_order(tmp_path: Path) -> None:
    picture = tmp_path / "middles.png"
    answer = operation("grasp")(file=str(EXAMPLES / "midpoints.toml"), facets=None, steps=False, picture=str(picture))
    text = "\n".join(answer.lines)
    assert "no first-order form closure" in text
    assert "immobile to second order" in text
    assert "if the body is flat" not in text
    assert answer.data["second_order"]["status"] == "second_order"
    unknown = Grasp(MIDDLES).explain("en")
    assert any(line.startswith("if the body is flat") for line in unknown.splitlines())


@pytest.mark.capability("03-3")
def test_pictures_never_move_a_body_into_a_finger(tmp_path: Path) -> None:
    from PIL import Image

    assert free_twists(Grasp(MIDDLES)) == []
    with pytest.raises(InputError, match="immobile to second order"):
        save_free_motions(Grasp(MIDDLES), tmp_path / "held.gif")
    three = Grasp(MIDDLES[:3])
    assert free_twists(three)
    for twist, both in free_twists(three):
        for sign in (1.0, -1.0) if both else (1.0,):
            pose = displaced_pose(three, sign * twist, 0.2)
            assert pose is not None
            for c in three.contacts:
                seen = pose[:2, :2].T @ (c.point - pose[:2, 2])
                assert (seen - c.point) @ c.normal <= 1e-8
    save_free_motions(three, tmp_path / "three.gif", outline=np.array([(-2, -1), (2, -1), (2, 1), (-2, 1.0)]))
    with Image.open(tmp_path / "three.gif") as moving:
        assert moving.n_frames > 10
