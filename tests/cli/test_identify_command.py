"""`mafsil identify`: tables, JSON, both languages, files written, and one clear sentence on error."""

import json
from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.identification.torque_model import with_load
from mafsil.mechanics.inertial_parameters import parameters_of
from mafsil.model import Inertial
from tests.identification.simulated import different, noisy_log, write_csv


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("identify")
    described, truth = different("planar2r", 1)
    write_csv(noisy_log(truth, 1, duration=12.0, step=2e-3), described, place / "log.csv")
    loaded = mf.Robot(with_load(described.mechanism, parameters_of(Inertial(1.5, [0.05, 0.0, 0.0]))))
    write_csv(noisy_log(loaded, 2, duration=12.0, step=2e-3), described, place / "loaded.csv")
    write_csv(noisy_log(described, 3, duration=12.0, step=2e-3), described, place / "empty.csv")
    return place


def test_a_table_for_people_and_a_better_robot(folder, capsys):
    out = folder / "better.urdf"
    assert main(["identify", str(folder / "log.csv"), "planar2r", "--out", str(out)]) == 0
    text = capsys.readouterr().out
    for words in ("joint1.viscous", "std. error", "described [%]", "never show in the efforts", "written:", "offsets"):
        assert words in text
    assert mf.load(out).n == 2


def test_json_and_arabic(folder, capsys):
    assert (
        main(["identify", str(folder / "log.csv"), "planar2r", "--json", "--rotor-inertia", "--held-out", "0.3"]) == 0
    )
    data = json.loads(capsys.readouterr().out)
    assert data["validation"]["held_out"]
    assert max(data["validation"]["after_percent"]) < 3
    assert {"label", "value", "standard_error", "before", "after"} == set(data["parameters"][0])
    words = ["--lang", "ar", "identify", str(folder / "log.csv"), "planar2r", "--validation", str(folder / "log.csv")]
    assert main(words) == 0
    assert "أخطاء العزم" in capsys.readouterr().out


def test_loads(folder, capsys):
    out = folder / "carrying.toml"
    assert main(["identify", str(folder / "loaded.csv"), "planar2r", "--payload", "--json", "--out", str(out)]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["mass"] == pytest.approx(1.5, rel=0.02)
    assert data["com"][0] == pytest.approx(0.05, abs=0.01)
    assert mf.load(out).n == 2
    assert main(["identify", str(folder / "loaded.csv"), "planar2r", "--payload"]) == 0
    assert "load of 1." in capsys.readouterr().out
    assert main(["identify", str(folder / "empty.csv"), "planar2r", "--payload"]) == 1
    assert "no payload is identifiable" in capsys.readouterr().err


def test_a_log_that_makes_nothing_better_is_an_honest_no(folder, tmp_path, capsys):
    """Somebody exchanged the sign of the torques halfway."""
    described, _ = different("planar2r", 1)
    log = noisy_log(described, 3, duration=12.0, step=2e-3)
    sign = np.where(log.times < 9.0, -1.0, 1.0)[:, None]
    write_csv(replace(log, tau=sign * log.signals()["tau"]), described, tmp_path / "wrong.csv")
    assert main(["identify", str(tmp_path / "wrong.csv"), "planar2r"]) == 1
    assert "no improvement" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["nothing.csv", "planar2r"], "no such file"),
        (["LOG", "planar2r", "--out", "x.xml"], ".urdf or .toml"),
        (["LOG", "planar2r", "--at-rest"], "--payload"),
        (["LOG", "panda"], "no column"),
        (["LOG", "planar2r", "--held-out", "2"], "held_out"),
        (["LOG", "planar2r", "--bandwidth", "-1"], "bandwidth"),
    ],
)
def test_errors(folder, capsys, words, sentence):
    words = [str(folder / "log.csv") if word == "LOG" else word for word in words]
    assert main(["identify", *words]) == 2
    error = capsys.readouterr().err
    assert sentence in error
    assert error.count("\n") == 1
