"""Commands as people and machines use them: answers, exit codes, one sentence on error, two languages."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from mafsil import messages
from mafsil.cli.main import main
from mafsil.cli.registry import OPERATIONS
from mafsil.cli.state import number
from mafsil.errors import InputError
from mafsil.mechanics.catalogue import CATALOGUE
from mafsil.robot import load

ROOT = Path(__file__).parents[2]
HOME = ["0", "-0.3", "0", "-2.2", "0", "2.0", "pi/4"]
ARABIC = re.compile(r"[\u0600-\u06ff]")


@pytest.fixture(autouse=True)
def _language(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(messages.catalogue, "_chosen", None)
    monkeypatch.delenv("MAFSIL_LANG", raising=False)


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    code = main(list(words))
    out, err = capsys.readouterr()
    return code, out, err


def test_fk_is_forward_kinematics(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "fk", "panda", *HOME, "--json")
    data = json.loads(out)
    robot = load("panda")
    T = robot.forward_kinematics(np.array([0, -0.3, 0, -2.2, 0, 2.0, np.pi / 4]))
    assert (code, err) == (0, "")
    np.testing.assert_allclose(data["pose"], T, atol=1e-14)
    w, x, y, z = data["quaternion_wxyz"]
    np.testing.assert_allclose(
        [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], np.asarray(T)[:3, 0], atol=1e-12
    )


def test_degrees_units_and_negative_numbers_mean_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    forms = [
        ["-0.3", "-1e-1", "0.2"],
        ["-0.3rad", "-.1", "2e-1"],
        [str(np.degrees(-0.3)) + "deg", "-0.1", "0.2"],
    ]
    answers = [json.loads(run(capsys, "fk", "planar3r", *q, "--json")[1])["pose"] for q in forms]
    degrees = [str(np.degrees(x)) for x in (-0.3, -0.1)]
    answers.append(json.loads(run(capsys, "fk", "planar3r", *degrees, "0.2rad", "--degrees", "--json")[1])["pose"])
    for answer in answers[1:]:
        np.testing.assert_allclose(answer, answers[0], atol=1e-13)


def test_fk_of_a_link(capsys: pytest.CaptureFixture[str]) -> None:
    _, out, _ = run(capsys, "fk", "panda", *HOME, "--frame", "link4", "--json")
    T = load("panda").forward_kinematics(np.array(json.loads(out)["q"]), frame="link4")
    np.testing.assert_allclose(json.loads(out)["pose"], T, atol=1e-14)


def test_dynamics_gives_every_quantity_of_the_catalogue(capsys: pytest.CaptureFixture[str]) -> None:
    q, qd = ["0.1", "0.2"], ["1", "-0.5"]
    _, out, _ = run(capsys, "dynamics", "planar2r", "--q", *q, "--qd", *qd, "--quantities", *CATALOGUE, "--json")
    found, arm = json.loads(out)["quantities"], load("planar2r")
    state = {name: json.loads(out)[name] for name in ("q", "qd", "qdd", "tau")}
    assert list(found) == list(CATALOGUE)
    for name, row in CATALOGUE.items():
        expected = getattr(arm, name)(*(state[each] for each in row.inputs))
        np.testing.assert_allclose(found[name], expected, rtol=1e-12, atol=1e-12)
    _, out, _ = run(capsys, "dynamics", "planar2r", "--q", *q, "--quantities", "center_of_mass", "christoffel_symbols")
    assert "center_of_mass" in out
    assert "[1]" in out
    code, _, words = run(capsys, "dynamics", "planar2r", "--q", *q, "--quantities", "center_of_mas")
    assert code == 2
    assert "center_of_mass" in words
    assert run(capsys, "dynamics", "planar2r", "--q", *q, "--duration", "1", "--quantities", "mass_matrix")[0] == 2


def test_dynamics_there_and_back(capsys: pytest.CaptureFixture[str]) -> None:
    qdd = ["0.5", "-1", "0.25", "2", "-3", "1", "-0.5"]
    _, out, _ = run(capsys, "dynamics", "panda", "--q", *HOME, "--qd", *["0.2"] * 7, "--qdd", *qdd, "--json")
    inverse = json.loads(out)
    tau = np.array(inverse["mass_matrix"]) @ np.array(qdd, float)
    tau += np.array(inverse["velocity_torque"]) + np.array(inverse["gravity_torque"])
    np.testing.assert_allclose(inverse["tau"], tau, atol=1e-10)
    efforts = [repr(x) for x in inverse["tau"]]
    _, out, _ = run(capsys, "dynamics", "panda", "--q", *HOME, "--qd", *["0.2"] * 7, "--tau", *efforts, "--json")
    np.testing.assert_allclose(json.loads(out)["qdd"], np.array(qdd, float), atol=1e-9)


@pytest.mark.parametrize("robot", ["panda", "puma560", "cobra600", str(ROOT / "examples/robots/ur5.urdf")])
def test_show_prints_joints_masses_screws_and_source(capsys: pytest.CaptureFixture[str], robot: str) -> None:
    code, out, _ = run(capsys, "show", robot)
    assert code == 0
    data = json.loads(run(capsys, "show", robot, "--json")[1])
    for joint in data["joints"]:
        assert joint["name"] in out
    assert data["provenance"]["source"] in out
    for screw in data["space_screws"].values():
        assert np.isclose(np.linalg.norm(screw[:3]), 1.0) or np.isclose(np.linalg.norm(screw[3:]), 1.0)


def test_screws_of_show_move_the_tip(capsys: pytest.CaptureFixture[str]) -> None:
    robot = load("panda")
    screws = json.loads(run(capsys, "show", "panda", "--json")[1])["space_screws"]
    J = robot.jacobian_space(np.zeros(7))
    np.testing.assert_allclose(np.array(list(screws.values())).T, J, atol=1e-12)


def test_the_urdf_of_the_examples_is_the_library_robot() -> None:
    ours, file = load("ur5"), load(ROOT / "examples/robots/ur5.urdf")
    q = np.random.default_rng(0).uniform(-3, 3, (50, 6))
    np.testing.assert_allclose(file.forward_kinematics(q), ours.forward_kinematics(q), atol=1e-12)
    np.testing.assert_allclose(file.mass_matrix(q), ours.mass_matrix(q), atol=1e-9)
    np.testing.assert_allclose(file.gravity_torque(q), ours.gravity_torque(q), atol=1e-9)


def test_pictures(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    for suffix, start in ((".html", b"<!doctype html>"), (".png", b"\x89PNG"), (".svg", b"<?xml")):
        path = tmp_path / f"robot{suffix}"
        assert run(capsys, "show", "puma560", "--picture", str(path))[0] == 0
        assert path.read_bytes().startswith(start)
    assert len(list(tmp_path.iterdir())) == 3


def test_doctor_finds_itself_healthy(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "info", "--json")
    data = json.loads(out)
    assert (code, err) == (0, ""), data["checks"]
    assert data["ok"]
    assert len(data["checks"]) == 3


@pytest.mark.parametrize(
    ("words", "code", "mentions"),
    [
        (["fk", "panda", "0", "0"], 2, ["7", "2", "joint7"]),
        (["fk", "panda", *HOME[:6], "x"], 2, ["joint7", "'x'", "30deg"]),
        (["fk", "panda", *HOME[:6], "3parsec"], 2, ["3parsec", "rad"]),
        (["fk", "panda", *HOME[:6], "nan"], 2, ["nan", "joint7"]),
        (["fk", "panda", *HOME, "--frame", "hand"], 2, ["hand", "link4"]),
        (["fk", "panda", *HOME, "--tip", "hand"], 2, ["hand", "link4"]),
        (["fk", "pandda", *HOME], 2, ["pandda", "panda"]),
        (["fk", "absent.urdf", *HOME], 2, ["absent.urdf"]),
        (["fk", "robot.step", *HOME], 2, ["robot.step"]),
        (["fk"], 2, ["ROBOT", "mafsil fk --help"]),
        (["fly"], 2, ["fly", "fk", "mafsil --help"]),
        (["fk", "panda", "--wrong"], 2, ["--wrong"]),
        (["fk", "panda", "--frame"], 2, ["--frame"]),
        (["dynamics", "panda"], 2, ["--q"]),
        (["dynamics", "panda", "--q", "1"], 2, ["q", "7"]),
        (["dynamics", "panda", "--q", *HOME, "--qdd", *HOME, "--tau", *HOME], 2, ["--qdd", "--tau"]),
        (["show", "panda", "--picture", "x.bmp"], 2, ["x.bmp", ".png"]),
        (["show", "panda", "--picture", "/nowhere/at/all.html"], 2, ["/nowhere/at/all.html"]),
        (["run", "absent.toml"], 2, ["absent.toml"]),
        (["run", "."], 2, ["."]),
        (["--lang", "fr", "show", "panda"], 2, ["fr", "en"]),
    ],
)
@pytest.mark.parametrize("language", ["en", "ar"])
def test_errors_are_one_sentence_and_an_exit_code(
    capsys: pytest.CaptureFixture[str], words: list[str], code: int, mentions: list[str], language: str
) -> None:
    given, out, err = run(capsys, *words, "--lang", language) if "--lang" not in words else run(capsys, *words)
    assert given == code
    assert out == ""
    assert err.startswith("mafsil: ")
    assert err.count("\n") == 1
    assert "Traceback" not in err
    for word in mentions:
        assert word in err
    if language == "ar" and "--lang" not in words and code == 2:
        assert ARABIC.search(err)


def test_debug_shows_the_traceback() -> None:
    with pytest.raises(InputError):
        main(["fk", "panda", "0", "--debug"])


@pytest.mark.parametrize("language", ["en", "ar"])
@pytest.mark.parametrize("command", [None, *(operation.name for operation in OPERATIONS)])
def test_help_is_whole_in_both_languages(
    capsys: pytest.CaptureFixture[str], command: str | None, language: str
) -> None:
    code, out, _ = run(capsys, *([command] if command else []), "--help", "--lang", language)
    assert code == 0
    if language == "ar":
        prose = [line for line in out.splitlines() if not line.strip().startswith(("mafsil", "-", "{"))]
        latin = [word for line in prose for word in re.findall(r"\b(?:the|and|of|options|usage|with)\b", line)]
        assert not latin, out
        assert ARABIC.search(out)


def test_environment_chooses_the_language(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MAFSIL_LANG", "ar_EG.UTF-8")
    assert ARABIC.search(run(capsys, "fk", "panda", "0")[2])


def test_every_operation_has_a_function_that_takes_its_parameters() -> None:
    import inspect

    for operation in OPERATIONS:
        names = set(inspect.signature(operation.function()).parameters)
        assert names == {parameter.name for parameter in operation.parameters}, operation.name


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1.0), ("-0.2", -0.2), ("1e-3", 1e-3), (".5", 0.5), ("30deg", np.pi / 6), ("-90°", -np.pi / 2),
        ("pi", np.pi), ("-pi/2", -np.pi / 2), ("2pi/3", 2 * np.pi / 3), ("2*pi", 2 * np.pi), ("120mm", 0.12),
    ],
)  # fmt: skip
def test_numbers_as_people_type_them(text: str, value: float) -> None:
    assert number("q", text) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["", "one", "1,5", "0x10", "1 2", "--1", "1e", "pi/0", "5 N m"])
def test_what_is_no_number(text: str) -> None:
    with pytest.raises(InputError):
        number("q", text)
