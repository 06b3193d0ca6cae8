"""`mafsil convert`: a motion comes back from every representation it printed; singular cases and refusals speak."""

import json
import re
from math import pi
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest

from mafsil import messages
from mafsil.cli.main import main
from mafsil.geometry import euler, pose, rotation, screw

ARABIC = re.compile(r"[\u0600-\u06ff]")


@pytest.fixture(autouse=True)
def _language(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(messages.catalogue, "_chosen", None)
    monkeypatch.delenv("MAFSIL_LANG", raising=False)


def run(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[int, str, str]:
    code = main(["convert", *map(_word, words)])
    out, err = capsys.readouterr()
    return code, out, err


def data(capsys: pytest.CaptureFixture[str], *words: object) -> dict:
    code, out, err = run(capsys, *words, "--json")
    assert (code, err) == (0, "")
    return json.loads(out, parse_constant=pytest.fail)  # JSON has no infinity


def _word(value: object) -> str:
    return value if isinstance(value, str) else repr(float(value))  # type: ignore[arg-type]


def _spoken(found: dict) -> list[list[object]]:
    """Every representation of the answer as the words that give it back."""
    turns = [x for x in found["axis_angle"] if x["axis"] is not None]
    words: list[list[object]] = [
        ["--matrix", *np.ravel(found["matrix"])],
        *(["--quaternion", *q] for q in found["quaternion_wxyz"]),
        *(["--axis-angle", *x["axis"], x["angle"]] for x in turns),
        *(["--rotation-vector", *r] for r in found["rotation_vector"]),
        *(["--euler", name, *t] for name, x in found["angle_sequences"].items() for t in x["triples"]),
        *(["--rpy", *t] for t in found["angle_sequences"]["xyz"]["triples"]),
    ]
    if found["gibbs"] is not None:
        words.append(["--gibbs", *found["gibbs"]])
    return words


ROTATIONS: list[list[object]] = [
    ["--rpy", 0.1, -0.4, 2.0],
    ["--axis-angle", 1, 2, -2, 3.0],
    ["--euler", "YXY", 0.3, 1e-4, -0.2],
    ["--rotation-vector", 1e-9, 0, -2e-9],
    ["--axis-angle", 1, 2, -2, pi],
    ["--rpy", 0.3, pi / 2, 0.5],
    ["--matrix", 1, 0, 0, 0, 1, 0, 0, 0, 1],
]


@pytest.mark.capability("04-77", "04-18", "04-36", "04-69")
@pytest.mark.parametrize("words", ROTATIONS, ids=lambda w: " ".join(map(str, w)))
def test_every_representation_gives_the_rotation_back(capsys: pytest.CaptureFixture[str], words: list[object]) -> None:
    found = data(capsys, *words, "--all-sequences")
    assert len(found["angle_sequences"]) == 24
    spoken = _spoken(found)
    assert len(spoken) > 24
    for other in spoken:
        np.testing.assert_allclose(data(capsys, *other)["matrix"], found["matrix"], atol=4e-15, err_msg=str(other[0]))


@pytest.mark.capability("04-80", "04-92", "04-97")
@pytest.mark.parametrize(
    "words",
    [
        ["--screw", 0, 0, 1, 1, -2, 0.2, 1.2],
        ["--screw", 0, 0, 2, 1, 0.5, 0, -0.3, "70deg"],
        ["--screw", 1, 1, 0, 9, 9, 9, "inf", "120mm"],
        ["--rpy", 0.4, 0.2, -1, "--position", 1, 2, 3],
        ["--pose", *np.eye(3, 4).ravel()],
    ],
    ids=lambda w: " ".join(map(str, w)),
)
def test_every_form_gives_the_pose_back(capsys: pytest.CaptureFixture[str], words: list[object]) -> None:
    found = data(capsys, *words)
    T = np.array(found["pose"])
    forms = [["--pose", *T.ravel()], ["--pose", *T[:3].ravel()], ["--exponential", *found["exponential"]]]
    axis = found["screw"]
    if axis["axis"] is not None:
        forms.append(["--screw", *axis["axis"], axis["amount"]])
    if axis["turns"]:
        forms.append(["--screw", *axis["direction"], *axis["point"], axis["pitch"], axis["amount"]])
    for form in forms:
        np.testing.assert_allclose(data(capsys, *form)["pose"], T, atol=4e-15, err_msg=str(form[0]))


@pytest.mark.capability("04-92")
def test_screws_are_what_geometry_says(capsys: pytest.CaptureFixture[str]) -> None:
    T = screw.displacement(screw.from_axis([0, 0, 2], [1, 0.5, 0], -0.3), np.radians(70))
    found = data(capsys, "--screw", 0, 0, 2, 1, 0.5, 0, -0.3, 70, "--degrees")
    np.testing.assert_allclose(found["pose"], T, atol=1e-15)
    moved = data(capsys, "--screw", 1, 1, 0, 9, 9, 9, "inf", "120mm")
    np.testing.assert_allclose(moved["pose"], pose.from_translation(0.12 * np.array([1, 1, 0]) / 2**0.5), atol=1e-16)


@pytest.mark.capability("04-63")
def test_axis_and_angle_against_fifty_digits(capsys: pytest.CaptureFixture[str]) -> None:
    with mp.workdps(50):
        x, y, z = (mp.mpf(k) / 3 for k in (1, 2, -2))
        W = mp.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        angle = mp.radians(mp.mpf(40))
        R = mp.eye(3) + mp.sin(angle) * W + (1 - mp.cos(angle)) * W * W
        exact = [[float(R[i, j]) for j in range(3)] for i in range(3)]
    found = data(capsys, "--axis-angle", 1, 2, -2, 40, "--degrees")
    np.testing.assert_allclose(found["matrix"], exact, atol=4e-16)


@pytest.mark.capability("04-37")
@pytest.mark.parametrize(("middle", "fixed"), [("90", "a - c"), ("-90", "a + c")])
def test_gimbal_lock_shows_the_family(capsys: pytest.CaptureFixture[str], middle: str, fixed: str) -> None:
    words = ["--euler", "ZYX", "20", middle, "50", "--degrees"]
    found = data(capsys, *words)
    locked = found["angle_sequences"]["ZYX"]
    assert locked["locked"]
    for t in (-2.0, 0.3, 1.7):
        member = np.array(locked["triples"][0]) + t * np.array(locked["family"])
        np.testing.assert_allclose(rotation.from_euler(member, "ZYX"), found["matrix"], atol=1e-15)
    assert not found["angle_sequences"]["ZYZ"]["locked"]
    _, out, _ = run(capsys, *words)
    assert re.search(rf"ZYX: only {re.escape(fixed)} is fixed", out)


@pytest.mark.capability("04-67", "04-70", "04-75")
def test_half_turn_and_double_cover_show_both_names(capsys: pytest.CaptureFixture[str]) -> None:
    found = data(capsys, "--axis-angle", 0, 3, 4, "180deg")
    assert found["gibbs"] is None
    np.testing.assert_allclose([x["axis"] for x in found["axis_angle"]], [[0, 0.6, 0.8], [0, -0.6, -0.8]], atol=1e-15)
    np.testing.assert_allclose(np.sum(found["rotation_vector"], axis=0), 0, atol=1e-15)
    q, other = np.array(found["quaternion_wxyz"])
    np.testing.assert_array_equal(q, -other)
    assert "half turn" in run(capsys, "--axis-angle", 0, 3, 4, "180deg")[1]


@pytest.mark.capability("04-66", "04-91")
def test_identity_and_translation_have_no_axis(capsys: pytest.CaptureFixture[str]) -> None:
    found = data(capsys, "--quaternion", 1, 0, 0, 0)
    assert {x["axis"] for x in found["axis_angle"]} == {None}
    assert "every axis serves" in run(capsys, "--quaternion", 1, 0, 0, 0)[1]
    assert "no motion" in run(capsys, "--pose", *np.eye(4).ravel())[1]
    assert "pure translation" in run(capsys, "--rpy", 0, 0, 0, "--position", 1, 0, 0)[1]


@pytest.mark.capability("04-14", "04-15", "04-98")
def test_planar_poles_at_hand_and_at_infinity(capsys: pytest.CaptureFixture[str]) -> None:
    found = data(capsys, "--planar", 30, 1, 2, "--degrees")["planar"]
    pole = np.array([*found["pole"], 0])
    T = pose.from_rotation_translation(rotation.rot_z(pi / 6), [1, 2, 0])
    np.testing.assert_allclose(pose.act(T, pole), pole, atol=1e-14)
    away = data(capsys, "--planar", 0, 1, 2)["planar"]
    assert away["pole"] is None
    x, y, w = away["homogeneous_pole"]
    assert w == 0
    assert abs(x * 1 + y * 2) < 1e-15
    assert "infinity" in run(capsys, "--planar", 0, 1, 2)[1]


@pytest.mark.capability("04-22")
def test_projection_only_when_asked(capsys: pytest.CaptureFixture[str]) -> None:
    bent = ["--matrix", 1, 0.01, 0, 0, 1, 0, 0, 0, 1]
    printed = ["--matrix", 0.866, -0.5, 0, 0.5, 0.866, 0, 0, 0, 1]
    assert "the nearest rotation is taken" in run(capsys, *printed)[1]
    code, _, err = run(capsys, *bent)
    assert code == 2
    for word in ("0.0141", "0.003", "tolerance.PRINTED", "--project"):
        assert word in err
    found = data(capsys, *bent, "--project")
    M = np.array(bent[1:], float).reshape(3, 3)
    np.testing.assert_allclose(found["matrix"], rotation.project(M), atol=1e-15)
    assert found["projected_by"] == pytest.approx(np.linalg.norm(rotation.project(M) - M))
    assert "the nearest rotation is taken" in run(capsys, *bent, "--project")[1]
    assert data(capsys, "--quaternion", 1, 2, 3, 4, "--project")["projected_by"] == pytest.approx(30**0.5 - 1)
    assert data(capsys, "--rpy", 0, 0, 1, "--project")["projected_by"] is None
    np.testing.assert_allclose(np.linalg.det(data(capsys, "--matrix", *_mirror(), "--project")["matrix"]), 1.0)


def _mirror() -> list[float]:
    return [-1, 0, 0, 0, 1, 0, 0, 0, 1]


REFUSED: list[tuple[list[object], list[str]]] = [
    ([], ["--rpy", "--screw"]),
    (["--rpy", 1, 2, 3, "--gibbs", 1, 2, 3], ["--rpy, --gibbs"]),
    (["--rpy", 1, 2], ["--rpy", "3", "2"]),
    (["--euler", "ZZX", 1, 2, 3], ["ZZX", "ZYX"]),
    (["--euler", 1, 2, 3], ["--euler", "4"]),
    (["--screw", 1, 2, 3], ["7 | 8"]),
    (["--screw", 0, 0, 2, 0, 0, 0, 1], ["--screw", "1"]),
    (["--pose", 1, 2, 3], ["12 | 16"]),
    (["--pose", *np.eye(4).ravel()[:-1], 2], ["--pose", "2.0"]),
    (["--pose", *np.eye(4).ravel()[:-1], 2, "--project"], ["--pose", "2.0"]),
    (["--matrix", *_mirror()], ["-1", "--project"]),
    (["--quaternion", 1, 2, 3, 4], ["4.48", "0.001", "--project"]),
    (["--quaternion", 0, 0, 0, 0, "--project"], ["--quaternion"]),
    (["--axis-angle", 0, 0, 0, 1], ["axis"]),
    (["--rpy", 1, "nan", 2], ["nan", "--rpy"]),
    (["--rpy", 1, "one", 2], ["--rpy[1]", "'one'"]),
    (["--pose", *np.eye(4).ravel(), "--position", 1, 2, 3], ["--position", "--pose"]),
    (["--rpy", 0, 0, 0, "--picture", "x.bmp"], ["x.bmp", ".png"]),
    (["--rpy", 0, 0, 0, "--picture", "/nowhere/at/all.png"], ["/nowhere/at/all.png"]),
]


@pytest.mark.parametrize("language", ["en", "ar"])
@pytest.mark.parametrize(("words", "mentions"), REFUSED, ids=lambda x: " ".join(map(str, x))[:40])
def test_refusals_are_one_sentence(
    capsys: pytest.CaptureFixture[str], words: list[object], mentions: list[str], language: str
) -> None:
    code, out, err = run(capsys, *words, "--lang", language)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    for word in mentions:
        assert word in re.sub("[\u2066-\u2069]", "", err)
    assert bool(ARABIC.search(err)) == (language == "ar")


@pytest.mark.parametrize("columns", [80, 200])
@pytest.mark.parametrize("language", ["en", "ar"])
@pytest.mark.parametrize("words", [["--rpy", 0, "90deg", 1], ["--planar", 1, 2, 3], ["--planar", 0, 2, 3]])
def test_numbers_are_aligned_in_both_languages(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    words: list[object],
    language: str,
    columns: int,
) -> None:
    from mafsil.cli.table import width

    monkeypatch.setenv("COLUMNS", str(columns))
    _, out, _ = run(capsys, *words, "--degrees", "--lang", language)
    _, _, table = out.partition("\n\n")
    rows = [line for line in table.partition("\n\n")[0].splitlines() if re.search(r"-?\d\.\d{6}", line)]
    ends = {width(line[: re.search(r"\d\.\d{6}", line).end()]) for line in rows}
    assert len(ends) == 1, out
    assert all(width(line) <= columns for line in rows)
    assert bool(ARABIC.search(out)) == (language == "ar")


def test_sequences_of_the_answer_are_those_of_geometry(capsys: pytest.CaptureFixture[str]) -> None:
    found = data(capsys, "--rpy", 0.1, 0.2, 0.3, "--all-sequences")["angle_sequences"]
    assert set(found) == set(euler.SEQUENCES)


@pytest.mark.parametrize(
    "words",
    [
        ["--rpy", 0.1, 0.2, 1.3],
        ["--rpy", 0.1, pi / 2, 1.3],
        ["--euler", "ZYZ", 1, 0, 2],
        ["--screw", 0, 0, 1, 1, 0, 0.2, 2],
        ["--rpy", 0, 0, 0, "--position", 1, 0, 0],
        ["--pose", *np.eye(4).ravel()],
        ["--planar", 1, 2, 3],
        ["--planar", 0, 2, 3],
        ["--planar", 0, 0, 0],
        ["--quaternion", 1, 0, 0, 0],
    ],
    ids=lambda w: " ".join(map(str, w))[:30],
)
def test_every_motion_has_its_picture(capsys: pytest.CaptureFixture[str], words: list[object], tmp_path: Path) -> None:
    path = tmp_path / "motion.png"
    found = data(capsys, *words, "--picture", str(path))
    assert found["picture"] == str(path)
    assert path.stat().st_size > 8_000
