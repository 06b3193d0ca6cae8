"""Pictures of frames, screws, poles and rings: what they show is where it should be, in both languages."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mafsil import messages
from mafsil.errors import InputError
from mafsil.figures import (
    plot_frame_graph,
    plot_frames,
    plot_gimbals,
    plot_motion,
    plot_pole,
    plot_rotation,
    plot_screw_motion,
)
from mafsil.figures.frames import draw_frames, draw_rotation
from mafsil.figures.gimbals import draw_gimbals
from mafsil.figures.pole import draw_pole
from mafsil.figures.screw_motion import draw_screw_motion
from mafsil.geometry import Pose, planar, pose, rotation, screw
from mafsil.geometry.frames import FrameGraph

T = pose.from_rotation_translation(rotation.from_rpy([0.1, 0.5, 0.7]), [1.0, 0.5, 0.4])
SCREW = screw.displacement(screw.from_axis([0.2, 0.1, 1.0], [0.8, 0.0, 0.0], 0.12), 2.5)


@pytest.fixture(autouse=True)
def _language(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(messages.catalogue, "_chosen", None)
    monkeypatch.delenv("MAFSIL_LANG", raising=False)


def words(figure: object) -> str:
    everything = [*figure.texts, *(text for axes in figure.axes for text in axes.texts)]  # type: ignore[attr-defined]
    return " ".join(text.get_text() for text in everything)


def lines(figure: object) -> list[np.ndarray]:
    """(k, 3) points of every line of the first axes."""
    return [np.array(line.get_data_3d()).T for line in figure.axes[0].lines]  # type: ignore[attr-defined]


@pytest.mark.capability("04-7", "04-86")
def test_frames_bear_their_letters_and_edges_their_poses() -> None:
    shown = words(draw_frames({"s": np.eye(4), "b": T}, (("s", "b"),)))
    for name in ("$x_{s}$", "$y_{b}$", "$z_{b}$", "{s}", "{b}", "$T_{sb}$"):
        assert name in shown


@pytest.mark.capability("04-63", "04-65")
def test_axes_of_a_rotation_sweep_about_its_axis() -> None:
    R = rotation.from_rpy([0.3, -0.8, 1.9])
    axis, _ = rotation.to_axis_angle(R)
    arcs = [points for points in lines(draw_rotation(R)) if len(points) == 60]
    assert len(arcs) == 3
    for k, arc in enumerate(arcs):
        np.testing.assert_allclose(arc[0], np.eye(3)[k], atol=1e-14)
        np.testing.assert_allclose(arc[-1], R[:, k], atol=1e-14)
        np.testing.assert_allclose(arc @ axis, axis[k], atol=1e-14)


@pytest.mark.capability("04-90", "04-91")
def test_the_helix_ends_at_the_pose_and_keeps_its_distance_from_the_axis() -> None:
    figure = draw_screw_motion(SCREW, T)
    helix = next(points for points in lines(figure) if len(points) == 121)
    np.testing.assert_allclose(helix[0], T[:3, 3], atol=1e-14)
    np.testing.assert_allclose(helix[-1], (SCREW @ T)[:3, 3], atol=1e-14)
    S, amount = screw.chasles(SCREW)
    along = np.diff(helix @ S[:3])
    np.testing.assert_allclose(along, 0.12 * amount / 120, atol=1e-14)
    away = np.linalg.norm(np.cross(helix - screw.nearest_point(S), S[:3]), axis=1)
    np.testing.assert_allclose(away, away[0], atol=1e-14)
    assert "0.12 m/rad" in words(figure)


@pytest.mark.capability("04-14", "04-15")
def test_the_pole_is_shown_where_it_is_or_said_to_be_at_infinity() -> None:
    turn = planar.about_pole(np.radians(60), [0.5, 2.0])
    figure = draw_pole(turn, np.eye(3))
    dots = [line.get_xydata() for line in figure.axes[0].lines if line.get_marker() == "o"]
    np.testing.assert_allclose(dots, [[[0.5, 2.0]]], atol=1e-14)
    assert "(0.5, 2)" in words(figure)
    assert "infinity" in words(draw_pole(planar.pose(0.0, [1.0, 2.0]), np.eye(3)))


@pytest.mark.capability("04-37", "04-50")
@pytest.mark.parametrize(("sequence", "middle"), [("ZYX", 90), ("ZYX", -90), ("ZYZ", 0), ("XZX", 180)])
def test_rings_are_locked_where_the_angles_are(sequence: str, middle: float) -> None:
    shown = words(draw_gimbals(np.radians([20, middle, 50]), sequence))
    assert "one turn is lost" in shown
    assert "one turn is lost" not in words(draw_gimbals(np.radians([20, middle + 30, 50]), sequence))


def _graph(path: Path) -> None:
    plot_frame_graph(FrameGraph((Pose(T, ("a", "b")), Pose(SCREW, ("b", "c")))), "a", path)


SAVERS: dict[str, Callable[[Path], None]] = {
    "frames": lambda path: plot_frames({"s": np.eye(4), "b": T}, path),
    "graph": _graph,
    "rotation": lambda path: plot_rotation(T[:3, :3], path),
    "screw": lambda path: plot_screw_motion(SCREW, path, T),
    "pole": lambda path: plot_pole(planar.pose(1.0, [1.0, 2.0]), path),
    "gimbals": lambda path: plot_gimbals([0.1, 0.2, 0.3], "xyz", path),
    "motion": lambda path: plot_motion(T, path, "pose"),
}


@pytest.mark.parametrize("language", ["en", "ar"])
@pytest.mark.parametrize("name", SAVERS)
def test_same_picture_same_bytes(name: str, language: str, tmp_path: Path) -> None:
    messages.language(language)
    for file in ("first.svg", "second.svg"):
        SAVERS[name](tmp_path / file)
    assert (tmp_path / "first.svg").read_bytes() == (tmp_path / "second.svg").read_bytes()


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_pictures_know_no_favourite_size(scale: float, tmp_path: Path) -> None:
    far = pose.from_rotation_translation(SCREW[:3, :3], scale * SCREW[:3, 3])
    plot_screw_motion(far, tmp_path / "screw.png")
    plot_frames({"s": np.eye(4), "b": far}, tmp_path / "frames.png")
    plot_pole(planar.pose(1.0, [scale, scale]), tmp_path / "pole.png")


def test_what_is_no_motion_is_refused(tmp_path: Path) -> None:
    bent = np.diag([1.0, 1.1, 1.0])
    for save in (plot_rotation, plot_pole):
        with pytest.raises(InputError):
            save(bent, tmp_path / "x.png")
    with pytest.raises(InputError):
        plot_screw_motion(2 * np.eye(4), tmp_path / "x.png")
    assert not (tmp_path / "x.png").exists()
