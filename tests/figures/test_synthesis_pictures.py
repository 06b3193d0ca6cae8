"""Pictures of syntheses are written, and show poses, pivots, curves and the linkage."""

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from mafsil.errors import InputError, MafsilError
from mafsil.figures.synthesis import draw_synthesis, plot_synthesis
from mafsil.mobility import synthesis as syn

POSES = np.array([[0, 0, 0], [1.0, 0.6, 0.3], [2.1, 0.8, 0.8], [3, 0.5, 1.3]])


def test_four_poses_are_drawn_with_burmesters_curves(tmp_path):
    found = syn.synthesise_motion(POSES, samples=40)
    plot_synthesis(found, tmp_path / "bar.png", index=3)
    assert (tmp_path / "bar.png").stat().st_size > 20_000
    axes = draw_synthesis(found).axes[0]
    assert len(axes.get_legend().get_texts()) == 3
    numbers = {text.get_text() for text in axes.texts}
    assert numbers == {"1", "2", "3", "4"}
    pivots = next(line for line in axes.lines if line.get_marker() == "^").get_xydata()
    np.testing.assert_allclose(pivots, [found[0].A, found[0].D])


def test_what_has_no_candidate_is_drawn_as_a_task(tmp_path):
    turned = syn.synthesise_motion([[1, 0, 0], [0, 1, np.pi / 2], [-1, 0, np.pi]])
    plot_synthesis(turned, tmp_path / "task.svg")
    assert "svg" in (tmp_path / "task.svg").read_text("utf-8")


def test_functions_and_slider_cranks_are_drawn(tmp_path):
    plot_synthesis(syn.synthesise_function([0.4, 1.0, 1.7], [0.6, 1.1, 1.9]), tmp_path / "function.png")
    theta = np.linspace(0.3, 2.2, 5)
    B = np.exp(1j * theta)
    C = B.real + np.sqrt(2.6**2 - (B.imag - 0.4) ** 2) + 0.4j
    u = (C - B) / 2.6
    z = B + (0.7 + 0.9j) * u
    found = syn.synthesise_motion(np.stack([z.real, z.imag, np.angle(u)], axis=1))
    index = next(k for k, one in enumerate(found) if one.grashof is None)
    plot_synthesis(found, tmp_path / "slider.png", index=index)
    assert (tmp_path / "slider.png").stat().st_size > 10_000


def test_wrong_pictures_are_refused(tmp_path):
    found = syn.synthesise_motion(POSES, samples=8)
    with pytest.raises(InputError, match="index"):
        plot_synthesis(found, tmp_path / "a.png", index=1000)
    with pytest.raises(MafsilError):
        plot_synthesis(found, tmp_path / "a.html")
