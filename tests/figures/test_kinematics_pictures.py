"""Pictures of motions, velocities and forces show the numbers that they are given."""

import numpy as np
import pytest
from PIL import Image

import mafsil as mf
from mafsil.derivation.arm import best_table
from mafsil.errors import InputError
from mafsil.figures import (
    animate_dh_row,
    animate_exponentials,
    animation,
    plot_displaced_body,
    plot_free_bodies,
    plot_joint_screws,
    plot_rotation_vector_ball,
    plot_space_velocity,
    plot_two_frames,
    plot_unreachable_frame,
)
from mafsil.figures.animation import PER_MOTION, exponential_frames, motion_frames
from mafsil.figures.dh_frames import draw_dh_frames
from mafsil.figures.moving_body import draw_displaced_body, draw_solid_ball, draw_two_frames
from mafsil.figures.velocity_and_force import draw_free_bodies, draw_joint_screws
from mafsil.geometry import pose, rotation, twist
from mafsil.model.denavit_hartenberg import DHRow
from mafsil.model.dh_frames import frame_poses
from mafsil.model.dh_from_axes import classic_from_modified
from mafsil.performance.statics import LinkLoad

T_AB = pose.exp([0.3, -0.2, 0.5, 1.0, 0.4, -0.3])


def words(figure):
    return [text.get_text() for axes in figure.axes for text in axes.texts] + [t.get_text() for t in figure.texts]


@pytest.mark.capability("05-23")
@pytest.mark.parametrize("name", ["puma560", "scara_rrrp", "elbow6r"])
def test_a_classic_table_is_drawn_in_its_own_letters(name):
    mechanism = mf.model.library.load(name)
    table = classic_from_modified(best_table(mechanism))
    q = np.full(len(table.rows), 0.3)
    figure = draw_dh_frames(mechanism, table, q)
    cells = figure.axes[1].tables[0].get_celld()
    assert [cells[0, k].get_text().get_text() for k in range(5)] == [
        "$i$", r"$\theta_i$", "$d_i$", "$a_i$", r"$\alpha_i$"
    ]  # fmt: skip
    frames = frame_poses(table, q)
    drawn = {}
    for text in figure.axes[0].texts:
        drawn[text.get_text()] = np.array(text.get_position_3d() if hasattr(text, "get_position_3d") else (0, 0, 0))
    lines = [np.array(line.get_data_3d()).T for line in figure.axes[0].lines if line.get_linewidth() == 3.2]
    for i, row in enumerate(table.rows, 1):
        before, after = frames[i - 1], frames[i]
        if abs(row.a) > 1e-6:
            assert f"$a_{i}$" in drawn
            normal = np.stack([after[:3, 3] - row.a * after[:3, 0], after[:3, 3]])
            assert any(np.abs(line - normal).max() < 1e-9 for line in lines), "a_i lies along x of {i}"
            cell = cells[i, 3].get_text().get_text()
            assert float(cell) == pytest.approx(row.a, abs=1e-4)
        offset = row.d + (q[i - 1] if row.kind == "P" else 0.0)
        if abs(offset) > 1e-6:
            along = np.stack([before[:3, 3], before[:3, 3] + offset * before[:3, 2]])
            assert any(np.abs(line - along).max() < 1e-9 for line in lines), "d_i lies along z of {i-1}"


@pytest.mark.capability("05-25")
@pytest.mark.parametrize("convention", ["modified", "classic"])
def test_the_four_motions_move_one_after_the_other(convention, tmp_path, monkeypatch):
    row = DHRow(a=0.5, alpha=0.7, d=0.4, theta=0.9)
    frames = motion_frames(row, convention)
    np.testing.assert_allclose(frames[0], np.eye(4))
    np.testing.assert_allclose(frames[-1], row.transform(convention), atol=1e-12)
    for k in range(4):
        part = frames[k * PER_MOTION : (k + 1) * PER_MOTION + 1]
        steps = pose.error(part[:-1], part[1:])
        np.testing.assert_allclose(steps, np.broadcast_to(steps[0], steps.shape), atol=1e-12)
        assert (np.abs(steps[0]) > 1e-9).sum() == 1, "one elementary motion at a time"
    monkeypatch.setattr(animation, "PER_MOTION", 3)  # to draw them takes seconds
    animate_dh_row(row, tmp_path / "row.gif", convention)
    with Image.open(tmp_path / "row.gif") as film:
        assert film.n_frames > 2 * 3


@pytest.mark.capability("05-25")
def test_an_arm_gets_its_exponentials_one_by_one(tmp_path, monkeypatch):
    arm, q = mf.load("planar2r"), np.array([0.5, -0.7])
    rows = exponential_frames(arm, q)
    np.testing.assert_allclose(rows[-1], q)
    assert (rows[: PER_MOTION + 1, 0] == 0).all(), "the last joint moves first"
    monkeypatch.setattr(animation, "PER_MOTION", 3)
    animate_exponentials(arm, q, tmp_path / "arm.gif")
    with Image.open(tmp_path / "arm.gif") as film:
        assert film.n_frames > 3


@pytest.mark.capability("04-128", "04-66")
def test_pictures_of_motions(tmp_path):
    half = rotation.from_axis_angle([0, 0, 1], np.pi)
    assert {"$r$", "$-r$"} <= set(words(draw_solid_ball(half)))
    assert "$-r$" not in words(draw_solid_ball(rotation.rot_x(0.4)))
    X_ai, X_af = pose.exp([0, 0, 0.4, 1, 0, 0]), pose.exp([0.2, 0, 0.9, 1, 1, 0])
    seen = words(draw_displaced_body(X_ai, X_af))
    assert {"{a}", "{b}", "{i}", "{f}"} <= set(seen)
    S_b = np.array([0, 0, 1, 0.5, 0, 0.1])
    title = words(draw_two_frames(T_AB, S_b, is_wrench=False))[-1]
    assert f"{twist.transform(T_AB, S_b)[3]:.3g}" in title
    plot_rotation_vector_ball(half, tmp_path / "ball.png")
    plot_displaced_body(X_ai, X_af, tmp_path / "body.png")
    plot_two_frames(T_AB, tmp_path / "screw.png", S_b=S_b)
    plot_two_frames(T_AB, tmp_path / "wrench.png", F_b=[0, 0, 1, 1, 2, 3])
    plot_space_velocity(T_AB, [0, 0, 1, 0.5, 0.2, 0], tmp_path / "v.png")
    with pytest.raises(InputError, match="exactly one"):
        plot_two_frames(T_AB, tmp_path / "x.png")
    assert all(file.stat().st_size > 5000 for file in tmp_path.iterdir())


@pytest.mark.capability("05-89")
def test_pictures_of_velocities_and_forces(tmp_path):
    arm, q = mf.load("scara_rrrp"), [0.3, 0.5, -0.2, 0.1]
    seen = words(draw_joint_screws(arm, np.array(q)))
    assert {"$S_1$", "$S_2$", "$S_3$", "$S_4$", r"$\dot q_1$", r"$\dot q_4$"} <= set(seen)
    flat = mf.load("planar3r")
    load = LinkLoad(flat.mechanism.link_names[2], [3.0, -40.0, 0], point=[0.2, 0, 0])
    assert {"$f_1$", "$r_1$"} <= set(words(draw_free_bodies(flat, np.array([0.3, 0.4, 0.5]), [load])))
    plot_joint_screws(arm, q, tmp_path / "screws.png")
    plot_free_bodies(flat, [0.3, 0.4, 0.5], tmp_path / "forces.png", [load])
    plot_unreachable_frame(pose.exp([0, 0.5, 0, 0.2, 0.3, 0.1]), tmp_path / "no_row.png")
    assert all(file.stat().st_size > 5000 for file in tmp_path.iterdir())
