"""Pictures of linkages and of curves on a torus are written, and show what they should."""

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from mafsil import mobility as mo
from mafsil.cli.main import main
from mafsil.figures.linkage import draw_linkage, is_flat, lifted, save_linkage, save_torus


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


@pytest.mark.capability("02-57")
def test_curves_on_the_torus(tmp_path):
    curves = [curve[:, :2] for curve in mo.FourBar(2, 4, 3.5, 4.5).curves()]
    save_torus(curves, tmp_path / "torus.svg", names=("theta 1", "theta 2"))
    assert "theta 1" in (tmp_path / "torus.svg").read_text("utf-8") or (tmp_path / "torus.svg").stat().st_size > 5000
    up = lifted(curves[0], 0.05)
    np.testing.assert_allclose(np.linalg.norm(up - mo.torus.embedded(curves[0]), axis=1), 0.05, atol=1e-9)
    out = np.hypot(np.hypot(up[:, 0], up[:, 1]) - 2.0, up[:, 2])
    assert (out > 0.7).all()


def test_the_command_draws(tmp_path, capsys):
    assert main(["mobility", "bennett", "--picture", str(tmp_path / "bennett.png")]) == 0
    assert "bennett.png" in capsys.readouterr().out
    assert (tmp_path / "bennett.png").exists()
    assert main(["mobility", "truss"]) == 1
    assert "structure" in capsys.readouterr().err
