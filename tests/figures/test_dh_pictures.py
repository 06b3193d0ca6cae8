"""Drawings of tables: they exist, hold the frames they should, and are the same every time."""

import pytest

from mafsil.derivation.arm import best_table
from mafsil.figures import plot_dh_frames, plot_link_motions
from mafsil.figures.dh_frames import draw_dh_frames
from mafsil.model import library
from mafsil.model.denavit_hartenberg import DHRow


@pytest.mark.capability("05-23")
@pytest.mark.parametrize("name", ["puma560", "scara_rrrp", "spatial3r", "rrrp"])
def test_every_frame_and_length_of_the_table_is_named(name):
    mechanism = library.load(name)
    table = best_table(mechanism)
    axes = draw_dh_frames(mechanism, table).axes[0]
    words = " ".join(text.get_text() for text in axes.texts)
    for i, row in enumerate(table.rows, start=1):
        named = words.replace("{", "").replace("}", "")
        assert any(f"z_{i}" in w or f",{i}" in w for w in named.split())
        if abs(row.a) > 1e-6:
            assert f"$a_{i - 1}$" in words
        if row.kind == "P" or abs(row.d) > 1e-6:
            assert f"$d_{i}$" in words


@pytest.mark.capability("05-25")
def test_files(tmp_path):
    mechanism = library.load("rrrp")
    for ending in ("png", "svg", "pdf"):
        plot_dh_frames(mechanism, best_table(mechanism), tmp_path / f"frames.{ending}")
        assert (tmp_path / f"frames.{ending}").stat().st_size > 2000
    plot_dh_frames(mechanism, best_table(mechanism), tmp_path / "again.svg")
    assert (tmp_path / "again.svg").read_bytes() == (tmp_path / "frames.svg").read_bytes()
    plot_link_motions(DHRow(a=0.5, alpha=0.7, d=0.4, theta=0.9), tmp_path / "motions.png")
    assert (tmp_path / "motions.png").stat().st_size > 5000
