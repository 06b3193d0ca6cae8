"""Figures of chapter 4: poles, angles, adjoint maps and powers recomputed; frames and arcs drawn where they are."""

import numpy as np
import pytest
from scipy.linalg import expm

import mafsil as mf
from tests.book.artists import drawn, lines


def hat(w: np.ndarray) -> np.ndarray:
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def adjoint(T: np.ndarray) -> np.ndarray:
    return np.block([[T[:3, :3], np.zeros((3, 3))], [hat(T[:3, 3]) @ T[:3, :3], T[:3, :3]]])


def some_line(figure: mf.book.Figure, start: np.ndarray, end: np.ndarray) -> bool:
    """Whether a line is drawn between two points."""
    ends = [(points[0], points[-1]) for points in lines(figure)]
    return any(np.allclose(a, start, atol=1e-9) and np.allclose(b, end, atol=1e-9) for a, b in ends)


@pytest.mark.capability("12-43")
def test_figure_4_1() -> None:
    figure = mf.book.figure("4.1")
    assert figure["pole"] == pytest.approx([1.5 + (2 + np.sqrt(3)) / 2] * 2)
    assert figure["angle"] == pytest.approx(np.pi / 6)
    (fact,) = [each for each in figure.facts if each.name == "pole"]
    assert not fact.agrees
    assert figure.erratum
    for angle in (np.pi / 3, 2.0):
        figure = mf.book.figure("4.1", angle=angle)
        b, c, T = figure.objects["T_sb"][:2, 2], figure.objects["T_sc"][:2, 2], figure.objects["T"]
        pole = np.linalg.solve(np.eye(2) - T[:2, :2], T[:2, 2])
        assert figure["pole"] == pytest.approx(pole)
        assert some_line(figure, pole, b)
        assert some_line(figure, pole, c)
        assert some_line(figure, b, c)  # the arc


@pytest.mark.capability("12-44")
def test_figure_4_2() -> None:
    roll, pitch, yaw = 0.3, -0.7, 1.9
    figure = mf.book.figure("4.2", roll=roll, pitch=pitch, yaw=yaw)
    R = expm(hat(np.array([0, 0, yaw]))) @ expm(hat(np.array([0, pitch, 0]))) @ expm(hat(np.array([roll, 0, 0])))
    points = drawn(figure)
    origin = points("frames", "p")[1]
    for k, letter in enumerate("xyz"):
        tail, tip = points("frames", f"b.{letter}")
        assert tail == pytest.approx(origin)
        assert tip - tail == pytest.approx(0.8 * R[:, k])
    assert figure["determinant"] == pytest.approx(1.0)


@pytest.mark.capability("12-45")
def test_figure_4_3() -> None:
    angles = 0.4, 0.6, -0.5
    figure = mf.book.figure("4.3", **dict(zip(("alpha", "beta", "gamma"), angles, strict=True)))
    a, b, g = (expm(angle * hat(np.eye(3)[k])) for angle, k in zip(angles, (2, 1, 0), strict=True))
    assert figure.objects["R"] == pytest.approx(a @ b @ g)
    assert figure["rank"] == 3
    assert figure["sense"] == pytest.approx(-np.sin(0.6))
    normals = _ring_normals(figure)
    carried = (a @ np.eye(3)[0], a @ b @ np.eye(3)[2])  # normal to z and y_1, and to y_1 and x_2
    for normal, expected in zip(normals, carried, strict=False):
        assert abs(normal @ expected) == pytest.approx(1.0)


def _ring_normals(figure: mf.book.Figure) -> list[np.ndarray]:
    """Of the circles drawn on the second panel."""
    rings = [points for points in lines(figure, 1) if len(points) == 121]
    return [np.linalg.svd(ring[:-1])[2][-1] for ring in rings]


@pytest.mark.capability("12-46")
def test_figure_4_4() -> None:
    figure = mf.book.figure("4.4", alpha=0.9, gamma=0.1)
    assert (figure["rank"], figure["sense"]) == (2, pytest.approx(-1.0))
    R = expm(0.9 * hat(np.eye(3)[2])) @ expm(np.pi / 2 * hat(np.eye(3)[1])) @ expm(0.1 * hat(np.eye(3)[0]))
    assert figure.objects["R"] == pytest.approx(R)
    assert R == pytest.approx(mf.book.figure("4.4", alpha=1.2, gamma=0.4).objects["R"])
    first, second, *_ = _ring_normals(figure)
    a = expm(0.9 * hat(np.eye(3)[2]))
    assert abs(first @ a @ np.eye(3)[0]) == pytest.approx(1.0)
    assert abs(second @ a @ np.eye(3)[0]) == pytest.approx(1.0)  # the second ring has turned into the first


@pytest.mark.capability("12-47", "12-10")
def test_figure_4_5() -> None:
    angles = 0.3, -0.8, 1.1
    figure = mf.book.figure("4.5", **dict(zip(("roll", "pitch", "yaw"), angles, strict=True)))
    R = np.eye(3)
    points = drawn(figure)
    for k, (name, angle) in enumerate(zip(figure.panels, angles, strict=True)):
        before, R = R, expm(angle * hat(np.eye(3)[k])) @ R
        for column, letter in enumerate("xyz"):
            assert points(name, f"b.{letter}")[1] == pytest.approx(R[:, column])
            sweep = points(name, f"sweep {column}")
            assert (sweep[0], sweep[-1]) == (pytest.approx(before[:, column]), pytest.approx(R[:, column]))
            assert sweep[:, k] == pytest.approx(sweep[0, k])  # about the fixed axis
    assert figure["same"] < 1e-12


@pytest.mark.capability("12-48")
def test_figure_4_6() -> None:
    figure = mf.book.figure("4.6", theta=2.3)
    omega, p = figure.objects["omega"], figure.objects["p"]
    points = drawn(figure)
    assert points("rotation", "after")[1] == pytest.approx(expm(2.3 * hat(omega)) @ p)
    path = points("rotation", "path")
    assert path @ omega == pytest.approx(figure["height"])
    assert np.linalg.norm(path, axis=1) == pytest.approx(np.linalg.norm(p))
    assert figure["length"] == pytest.approx(np.linalg.norm(p))


@pytest.mark.capability("12-49")
def test_figure_4_7() -> None:
    figure = mf.book.figure("4.7")
    r, other = figure.objects["points"]
    assert r == pytest.approx(-other)
    assert figure["radius"] == pytest.approx(np.pi)
    assert expm(hat(r)) == pytest.approx(expm(hat(other)))
    assert some_line(figure, r, other)
    inside = mf.book.figure("4.7", angle=2.0)
    assert (inside["names"], inside["radius"]) == (1, pytest.approx(2.0))
    assert expm(hat(inside.objects["points"][0])) == pytest.approx(inside.objects["R"])


@pytest.mark.capability("12-50")
def test_figure_4_8() -> None:
    figure = mf.book.figure("4.8", yaw=-0.4)
    T_ab, T_bc, q_c = (figure.objects[name] for name in ("T_ab", "T_bc", "q_c"))
    q_b = T_bc[:3, :3] @ q_c + T_bc[:3, 3]
    q_a = T_ab[:3, :3] @ q_b + T_ab[:3, 3]
    points = drawn(figure)
    assert points("frames", "q")[0] == pytest.approx(q_a)
    assert figure["q_a"] == pytest.approx(q_a)
    sides = [np.diff(points("frames", f"p_{{{pair}}}"), axis=0)[0] for pair in ("ab", "bc", "ac")]
    assert sides[0] + sides[1] == pytest.approx(sides[2])
    assert sides[2] == pytest.approx(figure["p_ac"])


@pytest.mark.capability("12-51")
def test_figure_4_9() -> None:
    figure = mf.book.figure("4.9")
    assert figure["p_ce"] == pytest.approx([-70, -260 / np.sqrt(2), 160 / np.sqrt(2)])
    assert not figure.facts[0].agrees
    T = figure.objects
    assert T["T_ac"] @ T["T_ce"] == pytest.approx(T["T_ae"])
    points = drawn(figure)
    places = {"b": (200, 200, 50), "c": (230, 160, 70), "d": (400, 50, 300), "e": (280, -50, 0)}
    for name, place in places.items():
        assert points("scene", f"{name}.x")[0] == pytest.approx(place)
    arm = points("scene", "arm")
    assert (arm[0], arm[-1]) == (pytest.approx(places["b"]), pytest.approx(places["c"]))


@pytest.mark.capability("12-52")
def test_figure_4_10() -> None:
    figure = mf.book.figure("4.10")
    T = figure.objects["T_ba"]
    assert (T @ [1, 2, 3, 1])[:3] == pytest.approx([1, -14.464466, 0.707107], abs=1e-6)
    point = figure["point"]
    assert (T @ np.append(point, 1.0))[:3] == pytest.approx(point)  # on the axis, no advance
    assert figure["theta"] == pytest.approx(np.pi / 4)
    before, after = figure.objects["X_ai"], figure.objects["X_af"]
    assert after == pytest.approx(T @ before)
    assert some_line(figure, np.zeros(3), after[:3, 3])
    b = np.linalg.inv(T)[:3, 3]
    assert some_line(figure, b, before[:3, 3])


@pytest.mark.capability("12-53")
def test_figure_4_11() -> None:
    figure = mf.book.figure("4.11", pitch=0.2, theta=9.0)
    points = drawn(figure)
    turned, helix, straight = (points(name, "path") for name in figure.panels)
    assert np.ptp(turned[:, 2]) < 1e-12
    assert np.linalg.norm(helix[:, :2], axis=1) == pytest.approx(0.8)
    assert helix[-1, 2] == pytest.approx(0.2 * 9.0)
    assert helix[-1, :2] == pytest.approx(0.8 * np.array([np.cos(9.0), np.sin(9.0)]))
    assert np.ptp(straight[:, :2], axis=0) == pytest.approx([0, 0])
    assert figure["advance"] == pytest.approx(figure["expected"])


@pytest.mark.capability("12-54")
def test_figure_4_12() -> None:
    figure = mf.book.figure("4.12", pitch=-0.3)
    T, S_a, S_b = (figure.objects[name] for name in ("T_ab", "S_a", "S_b"))
    assert S_a == pytest.approx(adjoint(T) @ S_b)
    assert (figure["pitch_a"], figure["pitch_b"]) == (pytest.approx(-0.3), pytest.approx(-0.3))
    segments = [points for points in lines(figure) if len(points) == 2]
    axis = max(segments, key=lambda ends: abs((ends[1] - ends[0]) @ S_a[:3]))
    advance = [np.cross(S_a[:3], end) + S_a[3:] for end in axis]
    assert np.array(advance) == pytest.approx(np.array([-0.3 * S_a[:3]] * 2))  # the drawn line is the axis


@pytest.mark.capability("12-55", "12-9")
def test_figure_4_13() -> None:
    figure = mf.book.figure("4.13", rate=0.4)
    omega, R = figure.objects["omega"], figure.objects["R"]
    points = drawn(figure)
    x, tip = points("b", "velocity")
    step = 1e-6
    difference = (expm(step * hat(omega)) @ R[:, 0] - R[:, 0]) / step
    assert x == pytest.approx(R[:, 0])
    assert tip - x == pytest.approx(difference, abs=1e-5)
    assert figure["along"] == pytest.approx(0.0, abs=1e-12)
    assert figure["speed"] == pytest.approx(np.linalg.norm(difference), abs=1e-5)
    after = expm(hat(omega)) @ R
    assert points("a", ".x")[1] == pytest.approx(after[:, 0])


@pytest.mark.capability("12-56")
def test_figure_4_14() -> None:
    figure = mf.book.figure("4.14", omega=-0.7)
    V = figure.objects["V_s"]
    xi = np.block([[hat(V[:3]), V[3:, None]], [np.zeros((1, 4))]])
    assert (xi @ [0, 0, 0, 1])[:3] == pytest.approx(figure["v_s"])  # the point at the origin of {s}
    assert figure["by_origin"] == pytest.approx(V[3:])
    assert some_line(figure, np.zeros(3), figure.objects["T_sb"][:3, 3])
    arrow = figure.draw().axes[0].collections
    ends = [np.array(each._segments3d[0]) for each in arrow if hasattr(each, "_segments3d")]
    assert any(
        np.linalg.norm(np.cross(a - b, V[3:])) < 1e-9 and min(np.abs(a).max(), np.abs(b).max()) < 1e-12 for a, b in ends
    )


@pytest.mark.capability("12-57")
def test_figure_4_15() -> None:
    figure = mf.book.figure("4.15", force=7.0)
    T, F_a, F_b = (figure.objects[name] for name in ("T_ab", "F_a", "F_b"))
    assert adjoint(T).T @ F_a == pytest.approx(F_b)
    assert figure["power_a"] == pytest.approx(figure["power_b"])
    direction = F_a[3:] / np.linalg.norm(F_a[3:])
    axis = next(
        points for points in lines(figure)
        if len(points) == 2 and np.linalg.norm(np.cross(points[1] - points[0], direction)) < 1e-9
    )  # fmt: skip
    moment = F_a[:3] - np.cross(axis[0], F_a[3:])  # about a point of the line of action: along the force only
    assert np.linalg.norm(np.cross(moment, direction)) < 1e-9
