"""Pictures of chapter 7: the offset shoulder from above, and the constructions of two subproblems."""

import numpy as np
import pytest

import mafsil as mf
from mafsil import figures
from mafsil.errors import InputError
from mafsil.figures import ik_constructions as ic


def markers(figure, marker):
    axes = figure.axes[0]
    lines = [line for line in axes.lines if line.get_marker() == marker and line.get_markersize() == 7]
    data = [line.get_data_3d() if hasattr(line, "get_data_3d") else line.get_data() for line in lines]
    return np.concatenate([np.array(each).T.reshape(-1, len(each)) for each in data])


@pytest.mark.capability("07-59", "07-58")
@pytest.mark.parametrize("d", [0.15, -0.2, 0.0])
def test_both_arms_of_the_plan_lead_to_the_wrist(tmp_path, monkeypatch, d):
    drawn = []
    monkeypatch.setattr(ic, "save", lambda figure, path: drawn.append(figure))
    p = np.array([-0.3, 0.5])
    theta = figures.plot_shoulder_plan(p, d, tmp_path / "plan.png")
    assert len(theta) == 2
    arms = [line.get_xydata() for line in drawn[0].axes[0].lines if len(line.get_xydata()) == 3]
    for arm, angle in zip(arms, theta, strict=True):
        np.testing.assert_allclose(arm[-1], p, atol=1e-12)
        left = [-np.sin(angle), np.cos(angle)]
        np.testing.assert_allclose(arm[1], d * np.array(left), atol=1e-12)
        assert abs((arm[2] - arm[1]) @ left) < 1e-12


@pytest.mark.capability("07-59")
def test_the_plan_has_the_angles_of_the_arm_itself(tmp_path):
    """The library's PUMA with offset: both turns of joint 1 of its closed form, from its wrist centre."""
    robot = mf.load("offset_puma")
    q = np.array([0.4, 0.3, -0.5, 0.2, 0.6, 0.1])
    T = robot.forward_kinematics(q)
    wrist = T[:3, 3] - 0.1 * T[:3, 0]
    plan = figures.plot_shoulder_plan(wrist[:2], 0.15, tmp_path / "plan.png")
    turns = {round(float(angle), 9) for angle in mf.inverse_kinematics(robot, T).q[:, 0]}
    np.testing.assert_allclose(sorted(plan), sorted(turns), atol=1e-8)


@pytest.mark.capability("07-59")
def test_inside_the_circle_no_arm_and_on_it_one(tmp_path):
    assert len(figures.plot_shoulder_plan([0.05, 0.05], 0.15, tmp_path / "a.png")) == 0
    (theta,) = figures.plot_shoulder_plan([0.0, 0.15], 0.15, tmp_path / "b.svg")
    assert theta == pytest.approx(0.0, abs=1e-12)
    assert (tmp_path / "a.png").stat().st_size > 5000
    with pytest.raises(InputError, match="axis 1"):
        figures.plot_shoulder_plan([0, 0], 0.0, tmp_path / "c.png")


@pytest.mark.capability("07-59")
def test_the_circles_meet_where_the_distance_is_right(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(ic, "save", lambda figure, path: drawn.append(figure))
    w, r, p = np.array([0.6, 0.0, 0.8]), np.array([0.3, 0.5, 0.1]), np.array([0.7, -0.2, 0.4])
    found = figures.plot_distance_construction(w, r, p, 1.1, tmp_path / "a.png")
    assert len(found.solutions()) == 2
    met = markers(drawn[0], "o")
    height = w @ p
    np.testing.assert_allclose(np.hypot(*met.T) ** 2 + height**2, 1.21, atol=1e-12)
    figures.plot_distance_construction(w, r, p, 9.0, tmp_path / "a.png")
    assert len(markers(drawn[1], "o")) == 0


@pytest.mark.capability("07-59")
def test_circles_on_the_sphere_meet_on_both(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(ic.space, "save", lambda draw, path: drawn.append(draw()))
    w1, w2 = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    p, z = np.array([0.6, 0.3, 0.2]), np.array([0.2, 0.6, 0.3])
    found = figures.plot_sphere_construction(w1, w2, p, z, tmp_path / "a.png")
    met = markers(drawn[0], "D")
    assert len(met) == len(found.solutions()) == 2
    np.testing.assert_allclose(met @ w2, p @ w2, atol=1e-12)
    np.testing.assert_allclose(met @ w1, z @ w1, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(met, axis=1), 0.7, atol=1e-12)
    with pytest.raises(InputError, match="crossing"):
        figures.plot_sphere_construction(w1, w2, [0, 0, 0], z, tmp_path / "a.png")
