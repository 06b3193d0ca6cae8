"""Jobs driven many times with drawn numbers: what fails how often, by what, and the same wherever it runs."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import fields, replace
from functools import cache
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from mafsil.cli.main import main
from mafsil.errors import InputError, JobError
from mafsil.job import Run, parse_job, solve
from mafsil.job.driving.arrival import arrival, goal_of
from mafsil.job.driving.run import CAUSES, SHARES
from mafsil.job.language.driving_tables import SPREADS
from mafsil.job.solve import vary
from mafsil.simulation import Normal, Variation

JOB = """
robot = "planar2r"
[simulation]
settle = 0.05
noise = { position = 1e-5, velocity = 1e-4 }
[controller]
kind = "pd_gravity"
[variation]
runs = 12
seed = 4
bound = 0.02
payload = [0.0, 0.6]
payload_offset = { mean = 0.0, deviation = 0.02 }
inertia = [0.9, 1.1]
gains = [0.6, 1.4]
noise = [0.0, 3.0]
[[move]]
name = "there"
joints = [0.4, 0.3]
tolerance = { joints = 0.1 }
[[move]]
name = "take"
pick = { mass = 0.3, size = [0.05, 0.05, 0.05] }
tolerance = { position = 0.3, orientation = 3 }
[[move]]
name = "back"
joints = [0.1, 0.1]
tolerance = { joints = 0.0011 }
"""


@cache
def driven(text=JOB) -> Run:
    run = solve(parse_job(text), text, Path())
    assert isinstance(run, Run)
    return run


def test_each_run_is_judged_as_the_job_itself_is():
    run = driven()
    found = run.variation
    assert found.runs == 12
    assert len(run.driven) == 2
    judged = [k for k, leg in enumerate(run.plan.legs) if goal_of(leg) is not None]
    assert 0 < found.done < 12
    for k in range(12):
        tape = found.drawn.again(k)
        missed = [leg for leg in judged if not arrival(run.job, run.plan, leg, tape).reached]
        assert found.missed[k] == (missed[0] if missed else -1)
        assert tape.tip_position_error.max() == found.drawn.outcomes.tip_error[k]
        assert len(tape.t) == len(run.recording.t)
    assert list(found) == np.flatnonzero(found.missed >= 0).tolist()
    assert "there" in found.explain("en") or "back" in found.explain("en")
    # A job of which nothing differs is the run of the job, to the last bit, in each of its runs but for noise.
    text = JOB.replace("noise = { position = 1e-5, velocity = 1e-4 }\n", "")
    text = text[: text.index("payload =")] + "gains = [1.0, 1.0]\n" + text[text.index("[[move]]") :]
    same = driven(text)
    assert np.ptp(same.variation.drawn.outcomes.tip_error) == 0.0
    assert same.variation.drawn.outcomes.tip_error[0] == pytest.approx(
        same.recording.tip_position_error.max(), rel=1e-9
    )


def test_failures_are_told_apart_by_their_cause():
    heavy = """
robot = "puma560"
[variation]
runs = 16
payload = [0.0, 40.0]
gains = [0.5, 3.0]
[[move]]
name = "swing"
joints = [0.4, -0.7, 0.7, 0.2, 0.5, 0.4]
"""
    found = driven(heavy).variation
    causes, clipped = found.causes, found.drawn.outcomes.saturated
    assert sum(which.sum() for which in causes.values()) == len(found)
    assert causes["saturated"].any()
    assert causes["not_reached"].any()
    assert clipped[causes["saturated"]].min() > clipped[causes["not_reached"]].max()
    wild = JOB.replace('kind = "pd_gravity"', 'kind = "computed_torque"\nfrequency = 900')
    wild = wild.replace("[0.6, 1.4]", "[0.001, 6.0]").replace("[simulation]", "[simulation]\nfriction = false")
    ran = driven(wild).variation
    assert ran.causes["blown_up"].any()
    assert ran.causes["blown_up"].sum() == (~ran.drawn.outcomes.finished).sum()
    for each in (found, ran):
        for language in ("en", "ar"):
            for name in CAUSES:
                assert (str(int(each.causes[name].sum())) in each.explain(language)) or not each.causes[name].any()


def test_the_table_has_the_quantiles_of_the_runs():
    found = driven().variation
    errors = np.sort(found.drawn.outcomes.tip_error)
    for share, value in zip(SHARES, found.quantiles()["tip_error"], strict=True):
        assert np.mean(errors <= value) >= share
        assert np.mean(errors < value) < share
    data = found.to_dict()
    json.dumps(data, allow_nan=False)
    assert data["done"] + sum(data["failed_by"].values()) == data["runs"]
    assert len(data["each"]["tip_error"]) == 12
    assert "payload" in data["each"]["drawn"]
    assert data["each"]["failed_by"].count(None) == data["done"]


def test_chunks_and_executors_change_nothing(monkeypatch):
    here = driven().variation

    @contextmanager
    def threads(where):
        with ThreadPoolExecutor(2) as pool:
            yield pool if where == "2" else None

    monkeypatch.setattr(import_module("mafsil.job.solve"), "cluster_executor", threads)
    monkeypatch.setattr("mafsil.simulation.chunk_runs.MOST_IN_CHUNK", 5)
    there = vary(driven(), cluster="2")
    for name, array in here.drawn.outcomes.arrays().items():
        assert np.array_equal(array, there.drawn.outcomes.arrays()[name], equal_nan=True), name
    assert here.explain("ar") == there.explain("ar")
    part = vary(driven(), progress=lambda share: False)
    assert part.runs == 5
    assert part.to_dict()["asked"] == 12


def test_laws_in_python_delays_and_walls_are_varied_too():
    text = """
robot = "planar2r"
[controller]
kind = "impedance"
[simulation]
method = "semi_implicit_euler"
settle = 0
[variation]
runs = 4
payload = [0.0, 0.2]
delay = [0.0, 0.003]
[[surface]]
point = [0, -5, 0]
normal = [0, 1, 0]
stiffness = 2000
[start]
joints = [0.3, 0.9]
[[move]]
joints = [0.4, 1.1]
duration = 0.7
tolerance = { joints = 0.5 }
"""
    run = driven(text)
    assert run.variation.runs == 4
    tape = run.variation.drawn.again(2)
    assert tape.tip_position_error.max() == run.variation.drawn.outcomes.tip_error[2]


def test_a_job_that_stops_is_not_varied():
    text = JOB.replace('kind = "pd_gravity"', 'kind = "computed_torque"\nfrequency = 3e4\ndelay = 0.004')
    run = driven(text)
    assert run.stopped is not None
    assert run.variation is None
    assert any(remark.key == "job.not_varied" for remark in run.remarks)


@pytest.mark.parametrize(
    ("table", "line", "word"),
    [
        ("runs = 0", 3, "runs"),
        ("runs = 3", 2, "nothing is varied"),
        ("payload = [1, 0]", 3, "wrong order"),
        ("payload = [-1, 0]", 3, "below zero"),
        ("payload = [1]", 3, "payload"),
        ("payload = 2", 3, "payload"),
        ("payload = { mean = 1 }", 3, "deviation"),
        ("payload = { mean = 1, deviation = -1 }", 3, "deviation"),
        ("payload = { mean = 1, sigma = 1 }", 3, "sigma"),
        ("payload = [0, nan]", 3, "nan"),
        ("payload_offset = [0, 0.1]", 3, "payload"),
        ("noise = [0, 1]", 3, "noise"),
        ("paylod = [0, 1]", 3, "payload"),
        ("seed = -1\npayload = [0, 1]", 3, "seed"),
    ],
)
def test_wrong_tables_are_refused_with_their_line(table, line, word):
    text = f'robot = "planar2r"\n[variation]\n{table}\n[[move]]\njoints = [0.1, 0.1]\n'
    with pytest.raises(JobError, match=word) as caught:
        parse_job(text)
    assert f"{line}" in str(caught.value)


def test_negative_draws_are_refused():
    text = JOB.replace("payload = [0.0, 0.6]", "payload = { mean = 0.1, deviation = 1.0 }")
    with pytest.raises(InputError, match="payload"):
        solve(parse_job(text), text, Path())


def test_millimetres_are_converted():
    text = JOB.replace('robot = "planar2r"', 'robot = "planar2r"\nlengths = "millimetres"')
    asked = parse_job(text).variation
    assert asked.bound == pytest.approx(2e-5)
    assert asked.payload_offset == replace_mean(0.0, 2e-5)
    assert asked.payload == (0.0, 0.6)


def replace_mean(mean, deviation):
    from mafsil.job.language.driving_tables import Normal as Said

    assert replace(Normal(1.0, 2.0), mean=mean).mean == mean
    return Said(mean=mean, deviation=deviation)


def test_the_command_writes_report_and_results(tmp_path, capsys):
    (tmp_path / "job.toml").write_text(JOB)
    main(["run", str(tmp_path / "job.toml"), "--runs", "5", "--out", str(tmp_path / "out")])
    shown = capsys.readouterr().out
    assert "5 varied runs" in shown
    results = json.loads((tmp_path / "out" / "results.json").read_text())
    assert results["variation"]["runs"] == 5
    assert results["variation"]["seed"] == 4
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Monte Carlo runs" in page
    assert results["variation"]["sentence"]["en"].split("\n")[0].split(":")[0] in page
    main(["run", str(tmp_path / "job.toml"), "--runs", "0", "--out", str(tmp_path / "out")])
    assert json.loads((tmp_path / "out" / "results.json").read_text())["variation"] is None
    assert '<section id="variation" hidden>' in (tmp_path / "out" / "report.html").read_text()
    capsys.readouterr()
    (tmp_path / "plain.toml").write_text('robot = "planar2r"\n[[move]]\njoints = [0.1, 0.1]\n')
    for words in (["--runs", "5"], ["--cluster", "2"]):
        assert main(["run", str(tmp_path / "plain.toml"), *words, "--out", str(tmp_path / "none")]) != 0
        assert "[variation]" in capsys.readouterr().err
    for words in (["--runs", "many"], ["--runs", "-3"], ["--runs", "1e9"]):
        assert main(["run", str(tmp_path / "job.toml"), *words, "--out", str(tmp_path / "none")]) != 0


def test_what_a_job_draws_is_what_a_simulation_can_draw():
    """One list of names: a job has them all but the start, which its moves decide."""
    assert [*SPREADS, "start"] == [field.name for field in fields(Variation)]
