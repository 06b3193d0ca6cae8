"""Figures of chapter 10: numbers of the runs against independent ones, and the curves that are drawn."""

import numpy as np
import pytest

import mafsil as mf
from tests.book.artists import artist_points


@pytest.mark.capability("12-98")
def test_figure_10_1() -> None:
    figure = mf.book.figure("10.1")
    full, simple = (set(figure.panels[name].names) for name in "ab")
    assert {"amplifier", "actuator", "arm", "sensors", "actuator > amplifier", "sensors > term 1"} <= full
    assert {"sum > arm", "arm > sensors"} <= simple
    assert "amplifier" not in simple
    start, end = artist_points(figure, "a", "sum > amplifier")
    assert start[0] == pytest.approx(artist_points(figure, "a", "sum")[:, 0].max())
    assert end[0] == pytest.approx(artist_points(figure, "a", "amplifier")[:, 0].min())


@pytest.mark.capability("12-99")
def test_figure_10_2() -> None:
    for theta in (-1.2, 0.6):
        figure = mf.book.figure("10.2", theta=theta)
        assert figure["gravity_torque"] == pytest.approx(0.981 * np.cos(theta))
        (centre,) = artist_points(figure, "a", "mass centre")
        assert centre == pytest.approx([0.1 * np.cos(theta), 0.1 * np.sin(theta)])
        tail, tip = artist_points(figure, "a", "gravity")
        assert tail == pytest.approx(centre)
        assert (tip - tail)[0] == pytest.approx(0.0)


@pytest.mark.capability("12-100")
def test_figure_10_3() -> None:
    figure = mf.book.figure("10.3")
    assert figure["terms"] == 3
    assert {f"term {k} > sum" for k in (1, 2, 3)} <= set(figure.panels["a"].names)
    assert [term.text for term in figure.objects["diagram"].terms] == ["Kp (u - q)", "Kd (v - q̇)", "Ki ∫(u - q) dt"]


@pytest.mark.capability("12-101")
def test_figure_10_4() -> None:
    for zeta in (0.2, 0.5):
        figure = mf.book.figure("10.4", damping_ratio=zeta)
        assert figure["overshoot"] == pytest.approx(100 * np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2)), rel=1e-4)
        t, error = artist_points(figure, "a", "error").T
        after = np.abs(error - 0.1) > 0.02 * 0.9
        assert figure["settling"] == pytest.approx(t[after].max(), abs=2 * (t[1] - t[0]))
        assert artist_points(figure, "a", "overshoot")[1, 1] == pytest.approx(error.min())
        assert artist_points(figure, "a", "settling")[:, 0] == pytest.approx(figure["settling"])


@pytest.mark.capability("12-102")
def test_figure_10_5() -> None:
    figure = mf.book.figure("10.5")
    assert figure["kp"] == pytest.approx([22.6689, 51.005, 204.02], abs=1e-4)
    assert figure["settling"] == pytest.approx([1.58238, 0.577616, 0.399819], rel=1e-5)
    assert figure["rule"] == pytest.approx([1.55527, 0.396040, 0.396040], rel=1e-5)
    assert figure["overshoot"] == pytest.approx(16.3034, abs=1e-4)
    roots = artist_points(figure, "a", "roots 204.02")
    assert sorted(roots[:, 1]) == pytest.approx([-17.4937, 17.4937], abs=1e-4)
    assert roots[:, 0] == pytest.approx(-10.1)


@pytest.mark.capability("12-103")
def test_figure_10_6() -> None:
    figure = mf.book.figure("10.6")
    rest = figure["pd_error"]
    assert rest == pytest.approx(0.408322, abs=1e-6)
    assert 2.205 * rest == pytest.approx(0.981 * np.cos(-rest))
    t, error = artist_points(figure, "a", "PID").T
    assert np.interp([1.0, 2.0, 5.0], t, error) == pytest.approx([0.534232, 0.00720, -0.064832], abs=1e-5)
    assert artist_points(figure, "b", "PID")[-1, 1] == pytest.approx(0.981, abs=2e-3)
    assert artist_points(figure, "c", "start")[1] == pytest.approx([0.0, -1.0], abs=1e-12)


@pytest.mark.capability("12-104")
def test_figure_10_7() -> None:
    figure = mf.book.figure("10.7")
    assert (figure["limit"], figure["meeting"]) == (pytest.approx(9.261), pytest.approx(0.686))
    drawn = artist_points(figure, "a", f"roots {figure['limit']:g}") @ [1, 1j]
    assert np.sort_complex(drawn) == pytest.approx(np.sort_complex([-4.2, -2.1j, 2.1j]), abs=1e-6)
    one = artist_points(figure, "a", "roots 1") @ [1, 1j]
    assert np.sort_complex(one) == pytest.approx(np.sort_complex(np.roots([0.5, 2.1, 2.205, 1.0])))


@pytest.mark.capability("12-105")
def test_figure_10_8() -> None:
    figure = mf.book.figure("10.8")
    assert [figure[f"error_{k}"] for k in (1, 2, 5)] == pytest.approx([0.525624, 0.008484, -0.064879], abs=1e-5)
    (text,) = [element.text for element in figure.panels["a"].elements if element.style == "code"]
    assert text.index("integral = integral + e * dt") < text.index("command(")
    assert "qd = (q - q_last) / dt" in text
    assert artist_points(figure, "b", "error")[100, 1] == pytest.approx(figure["error_1"])


@pytest.mark.capability("12-106")
def test_figure_10_9() -> None:
    figure = mf.book.figure("10.9")
    assert figure["largest"] < 2e-3
    (text,) = [element.text for element in figure.panels["a"].elements if element.style == "code"]
    assert "sense" not in text
    assert "model.torque(q_d, qd_d, qdd_d)" in text


@pytest.mark.capability("12-107", "12-1")
def test_figure_10_10() -> None:
    figure = mf.book.figure("10.10")
    assert figure["left_out"] == pytest.approx(9.81 * 0.02)
    assert (figure["task_1"], figure["task_2"]) == (pytest.approx(0.2098, abs=1e-4), pytest.approx(3.065, abs=1e-3))
    for panel, middle in (("a", -np.pi / 2), ("b", np.pi / 2)):
        t, wanted = artist_points(figure, panel, "wanted").T
        assert wanted == pytest.approx(middle - np.cos(t))
    assert mf.book.remark("1").words("caption", "en") in figure.explain("en")
    assert mf.book.remark("1").words("caption", "ar") in figure.explain("ar")
    assert (mf.book.remark("1")["down"], mf.book.remark("1")["up"]) == (pytest.approx(-0.1962), pytest.approx(0.1962))


@pytest.mark.capability("12-108")
def test_figure_10_11() -> None:
    figure = mf.book.figure("10.11")
    assert figure["terms"] == 2
    texts = [term.text for term in figure.objects["diagram"].terms]
    assert texts == ["M(q) [a + Kp (u - q) + Kd (v - q̇)]", "c(q, q̇) + g(q)"]
    assert {"trajectory > term 1", "sensors > term 2", "sum > arm"} <= set(figure.panels["a"].names)
    assert "trajectory > term 2" not in figure.panels["a"].names


@pytest.mark.capability("12-109")
def test_figure_10_12() -> None:
    figure = mf.book.figure("10.12")
    assert figure["rms"] == pytest.approx([1.1245, 0.27709, 0.062948], rel=1e-4)
    assert figure["effort"] == pytest.approx([2.2442, 3.8875, 2.9399], rel=1e-4)
    ends = [artist_points(figure, "b", name)[-1, 1] for name in ("feedforward", "PID", "computed torque")]
    assert ends == pytest.approx(figure["effort"])


@pytest.mark.capability("12-110")
def test_figure_10_13() -> None:
    assert mf.book.figure("10.13", period=0.001)["rms"] == pytest.approx(0.062948, rel=5e-3)
    figure = mf.book.figure("10.13")
    (text,) = [element.text for element in figure.panels["a"].elements if element.style == "code"]
    assert "model.torque(q, qd, qdd_d + K @ [e, integral, ed])" in text


@pytest.mark.capability("12-111")
def test_figure_10_14() -> None:
    figure = mf.book.figure("10.14")
    laws = {
        "a": lambda w: 0.5 * w, "b": lambda w: 0.6 + 0 * w, "c": lambda w: 0.6 + 0.3 * w, "d": lambda w: 0.6 + 0 * w,
        "e": lambda w: 0.6 + 0.3 * w,
    }  # fmt: skip
    for name, law in laws.items():
        w, torque = artist_points(figure, name, "moving +1").T
        assert torque == pytest.approx(law(w))
        assert artist_points(figure, name, "moving -1")[:, 1] == pytest.approx(-torque)
    assert figure["breakaway"] == pytest.approx([0.0, 0.6, 0.6, 0.9, 0.9, 0.9])
    w, torque = artist_points(figure, "f", "moving +1").T
    assert torque[0] == pytest.approx(0.9, abs=1e-4)
    assert torque.min() < torque[-1] < torque[0]
    for name, high in zip("abcdef", figure["breakaway"], strict=True):
        assert artist_points(figure, name, "rest")[:, 1] == pytest.approx([-high, high])


@pytest.mark.capability("12-112")
def test_figure_10_15() -> None:
    figure = mf.book.figure("10.15")
    assert figure["felt"] == pytest.approx([0.0, 0.18 * 2.0, 0.0, 2.0, 0.0, 1.0])
    assert figure["felt"][:3] == pytest.approx(np.cross(figure.objects["lever"], figure.objects["force"]))
    assert figure["felt"][3:] == pytest.approx(figure.objects["force"] + figure.objects["weight"])
    assert figure.status.name == "SCHEMATIC"
    start, end = figure.panels["a"]["force"]
    assert start == pytest.approx([0.0, 0.0, 0.18])
    assert np.cross(end - start, [2.0, 0.0, 5.0]) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.capability("12-113")
def test_figure_10_16() -> None:
    heading = -0.9
    figure = mf.book.figure("10.16", heading=heading)
    tail, tip = figure.panels["a"]["b.x"]
    assert (tip - tail) / np.linalg.norm(tip - tail) == pytest.approx([np.cos(heading), np.sin(heading), 0.0])
    assert (figure["constraints"], figure["freedoms"]) == (3, 3)
    natural = [row.natural for row in figure.objects["table"]]
    assert natural == ["dphi_x/dt = 0", "dphi_y/dt = 0", "F_phi_z = 0", "F_x = 0", "F_y = 0", "dz/dt = 0"]
    axes = [[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]]
    assert figure.objects["T_sb"][:2, :2] == pytest.approx(np.array(axes))
    sole = figure.panels["a"]["eraser -1"]
    assert sole[:, 2] == pytest.approx(0.0)


@pytest.mark.capability("12-114")
def test_figure_10_17() -> None:
    for stiffness in (20.0, 90.0):
        figure = mf.book.figure("10.17", stiffness=stiffness)
        assert figure["rest"] == pytest.approx(5.0 / stiffness)
        t, x = artist_points(figure, "b", "motion").T
        wd = np.sqrt(stiffness - 4.0)
        exact = 5 / stiffness * (1 - np.exp(-2 * t) * (np.cos(wd * t) + 2 / wd * np.sin(wd * t)))
        assert x == pytest.approx(exact, abs=1e-9)
