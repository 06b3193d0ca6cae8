"""Pictures of linkages and of curves on a torus are written, and show what they should."""

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from mafsil import mobility as mo
from mafsil.cli.main import main
from mafsil.errors import InputError
from mafsil.figures import linkage_motion
from mafsil.figures.configuration_surface import draw_surface, in_space, over_square, plot_surface
from mafsil.figures.linkage import draw_linkage, is_flat, lift_off_torus, save_linkage, save_torus
from mafsil.figures.linkage_motion import motion_frames, save_linkage_motion
from mafsil.mobility.linkages.loop_closure import largest_gap
from tests.sizes import few


@pytest.mark.parametrize("name", ["four_bar", "bennett", "six_sps", "truss", "chain"])
def test_linkages_are_drawn(name, tmp_path):
    linkage = mo.library.linkage(name)
    path = tmp_path / "linkage.png"
    save_linkage(linkage, path)
    assert path.stat().st_size > 5000
    assert is_flat(linkage) == (name in ("four_bar", "truss", "chain"))


def test_idle_joints_are_shown_apart():
    linkage = mo.library.six_sps()
    figure = draw_linkage(linkage, mo.mobility(linkage))
    colours = [line.get_markeredgecolor() for line in figure.axes[0].lines]
    assert colours.count("#d9902a") >= 12


@pytest.mark.capability("02-57", "02-60")
def test_surface_of_configurations_is_drawn_in_space_and_over_two_joints(tmp_path):
    arm = mo.trace_surface(mo.library.chain(2))
    corners, sense = over_square(arm, (0, 1))
    assert abs(sense.sum()) == len(sense) == len(arm.triangles)  # a torus lies flat over its square
    assert np.ptp(corners, axis=1).max() < 90  # no triangle spans the square where it crosses a seam
    five = mo.trace_surface(mo.library.five_bar())
    _, sense = over_square(five, (0, 4))
    assert 0.3 < (sense > 0).mean() < 0.7  # both assembly modes, folded where they meet
    assert in_space(five, five.theta).shape == (len(five.theta), 3)
    plot_surface(five, tmp_path / "five.png", joints=("O", "D"))
    assert (tmp_path / "five.png").stat().st_size > 20_000
    table = mo.Linkage.of(
        [mo.joint("X", "P", ["ground", "a"], axis=[1, 0]), mo.joint("Y", "P", ["a", "b"], axis=[0, 1])]
    )
    axes = draw_surface(mo.trace_surface(table, points=60)).axes[1]
    assert axes.get_xlabel() == "X [m]"
    assert len(axes.collections) == 1
    assert len(draw_surface(five).axes[1].collections) == 9


@pytest.mark.capability("02-57")
def test_curves_on_the_torus(tmp_path):
    curves = [curve[:, :2] for curve in mo.FourBar(2, 4, 3.5, 4.5).curves()]
    save_torus(curves, tmp_path / "torus.svg", names=("theta 1", "theta 2"))
    assert "theta 1" in (tmp_path / "torus.svg").read_text("utf-8") or (tmp_path / "torus.svg").stat().st_size > 5000
    up = lift_off_torus(curves[0], 0.05)
    np.testing.assert_allclose(np.linalg.norm(up - mo.torus.embed_in_space(curves[0]), axis=1), 0.05, atol=1e-9)
    out = np.hypot(np.hypot(up[:, 0], up[:, 1]) - 2.0, up[:, 2])
    assert (out > 0.7).all()


@pytest.mark.parametrize("name", few(mo.library.names(), 9))
def test_motions_that_are_shown_close_all_loops(name):
    linkage = mo.library.linkage(name)
    found = mo.mobility(linkage)
    if not found.finite.mobility:
        with pytest.raises(InputError, match=linkage.name):
            motion_frames(linkage, found)
        return
    frames = motion_frames(linkage, found)
    assert 20 < len(frames) < 200
    assert largest_gap(linkage, frames).max() < 1e-9
    assert np.ptp(frames, axis=0).max() > 0.1


@pytest.mark.parametrize("name", ["four_bar", "door"])
def test_moving_pictures(name, tmp_path, monkeypatch):
    monkeypatch.setattr(linkage_motion, "FRAMES", 16)  # to draw more takes seconds
    image = pytest.importorskip("PIL.Image")
    path = tmp_path / "linkage.gif"
    save_linkage_motion(mo.library.linkage(name), path)
    with image.open(path) as moving:
        assert moving.n_frames > 10


def test_the_command_draws(tmp_path, capsys):
    assert main(["mobility", "bennett", "--picture", str(tmp_path / "bennett.png")]) == 0
    assert "bennett.png" in capsys.readouterr().out
    assert (tmp_path / "bennett.png").exists()
    assert main(["mobility", "truss"]) == 1
    assert "structure" in capsys.readouterr().err


def test_joints_at_one_place_share_a_label():
    bodies, places = ("ground a", "a b", "a c", "b ground", "c ground"), ((0, 0), (1, 0), (1, 0), (1, 1), (2, 0.5))
    named = zip("ABCDE", bodies, places, strict=True)
    linkage = mo.Linkage.of([mo.joint(name, "R", pair.split(), at) for name, pair, at in named], planar=True)
    axes = draw_linkage(linkage, mo.mobility(linkage)).axes[0]
    assert sorted(text.get_text() for text in axes.texts) == ["A", "B, C", "D", "E"]


def test_dead_points_are_not_drawn_as_idle_joints():
    joints = [mo.joint("A", "R", ["ground", "crank"]), mo.joint("B", "R", ["crank", "rod"], [1, 0])]
    joints += [mo.joint("C", "R", ["rod", "slider"], [3, 0]), mo.joint("S", "P", ["ground", "slider"], [3, 0], [1, 0])]
    linkage = mo.Linkage.of(joints, planar=True, output="slider")
    colours = [line.get_markeredgecolor() for line in draw_linkage(linkage, mo.mobility(linkage)).axes[0].lines]
    assert "#d9902a" not in colours
