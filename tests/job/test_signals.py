"""Signals of a job: outputs that are set, inputs that are waited for, and what never comes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.cli.main import main
from mafsil.errors import JobError
from mafsil.job import Refusal, parse_job, solve
from mafsil.job.judging.judgement import summary
from mafsil.job.planning.cell_signals import CellSignals, holds
from mafsil.job.solve import prepare
from mafsil.report.contents import page as page_of
from mafsil.report.results import as_data

CELL = """
robot = "planar2r"
[output]
close = false
[input.part_present]
changes = [[2.0, true]]
every = 5.0
[input.closed]
follows = "close"
after = 0.2
"""
MOVES = """
[[move]]
joints = [0.3, 0.4]
[[move]]
name = "part"
wait = { part_present = true }
timeout = 10
[[move]]
set = { close = true }
[[move]]
wait = { closed = true }
[[move]]
joints = [0.0, 0.4]
"""


def planned(text):
    return prepare(parse_job(text, "job.toml"), text, Path())


def solved(text):
    return solve(parse_job(text, "job.toml"), text, Path())


@pytest.fixture(scope="module")
def run():
    found = solved(CELL + MOVES)
    assert found, found.explain("en")
    return found


def test_a_wait_ends_when_its_signal_comes_and_an_output_is_set_in_one_tick(run):
    legs, starts = run.plan.legs, run.plan.starts
    assert [leg.kind for leg in legs] == ["joint", "wait", "set", "wait", "joint", "settle"]
    assert starts[2] == pytest.approx(2.0, abs=1e-9)
    assert starts[3] == pytest.approx(2.001, abs=1e-9)
    assert starts[4] == pytest.approx(2.201, abs=1e-9)
    row = np.searchsorted(run.recording.t, 1.9)
    assert np.abs(run.recording.qd_ref[row]).max() == 0.0


def test_a_signal_that_is_there_costs_one_tick():
    _, plan = planned(CELL + MOVES.replace("wait = { part_present = true }", "wait = { part_present = false }"))
    assert 1e-3 <= plan.legs[1].trajectory.duration < 2e-3


def test_results_and_report_say_when_signals_change(run):
    data = as_data(run, summary(run))
    found = [(each["signal"], each["value"], round(each["time"], 6)) for each in data["signals"]["changes"]]
    assert found == [("part_present", True, 2.0), ("close", True, 2.001), ("closed", True, 2.201)]
    assert data["signals"]["start"] == {"close": False, "part_present": False, "closed": False}
    assert json.loads(json.dumps(data["signals"])) == data["signals"]
    for language in ("en", "ar"):
        page = page_of(run, summary(run), language)
        plot = next(each for each in page.plots if each.column == "signals")
        assert plot.names == ("close", "part_present", "closed")
        edges = page.times[1:][np.diff(plot.values[:, 0]) > 0]
        assert edges == pytest.approx([2.001], abs=1e-9)
        assert page.steps[1].text == "part_present = true"
    assert any(remark.key == "job.waited" for remark in run.remarks)


def test_time_that_a_wait_takes_back_is_not_called_saved(run):
    free = solved(CELL + MOVES.replace("wait = { part_present = true }\ntimeout = 10", "pause = 1.3"))
    saved, without = ({each[:2]: each.saved for each in one.limits} for one in (run, free))
    assert saved["acceleration", 1] == 0.0
    assert without["acceleration", 1] > 0.01
    assert saved["acceleration", 0] == pytest.approx(without["acceleration", 0])


NEVER = {
    "wait = { closed = true }": ("job.wait_never", "closed is false all the time"),
    "wait = { part_present = true }\ntimeout = 0.5": ("job.wait_late", "after 2 s, later than"),
    "wait = { part_present = true, closed = true }": ("job.wait_never", "repeats its table every 5 s"),
    "wait = { close = true }\ntimeout = 2": ("job.wait_never", "close is false"),
}


@pytest.mark.parametrize("move", NEVER)
@pytest.mark.parametrize("language", ["en", "ar"])
def test_a_signal_that_never_comes_is_refused_by_name(move, language):
    key, words = NEVER[move]
    no = planned(f"{CELL}[[move]]\n{move}\n")
    assert isinstance(no, Refusal)
    assert no.key == key
    assert "11" in no.explain(language), "the line"
    assert words in no.explain("en")
    assert "{" not in no.explain(language)


def test_a_pulse_shorter_than_a_tick_is_not_seen():
    cell = 'robot = "planar2r"\n[controller]\nrate = 100\n[input.a]\nchanges = [[0.501, true], [0.508, false]]\n'
    no = planned(cell + "[[move]]\nwait = { a = true }\n")
    assert no.key == "job.wait_never"
    _, plan = planned(cell.replace("0.508", "0.511") + "[[move]]\nwait = { a = true }\n")
    assert plan.starts[1] == pytest.approx(0.51, abs=1e-12)


def test_numbers_have_bounds():
    cell = 'robot = "planar2r"\n[input.pressure]\nstart = 0\nchanges = [[0.5, 3], [1.0, 8.5], [1.5, 5]]\n'
    for wanted, time in (
        ("{ above = 3 }", 1.0),
        ("{ above = 3, below = 8 }", 1.5),
        ("5", 1.5),
        ("{ below = 1 }", 0.001),
    ):
        _, plan = planned(f"{cell}[[move]]\nwait = {{ pressure = {wanted} }}\n")
        assert plan.starts[1] == pytest.approx(time, abs=1e-9)


WRONG = {
    "wait = { part_present = 1 }": "job.signal_digital",
    "wait = { part_presnt = true }": "job.signal_unknown",
    "wait = { part_present = { above = 1 } }": "job.signal_digital",
    "wait = { part_present = { abov = 1 } }": "job.unknown_key_close",
    "wait = { part_present = 'yes' }": "job.type",
    "wait = {}": "job.move_empty",
    "wait = { part_present = true }\nhold = 1": "job.no_effect",
    "wait = { part_present = true }\npause = 1": "job.move_many",
    "wait = { part_present = true }\ntimeout = -1": "job.bound",
    "set = { part_present = true }": "job.signal_input",
    "set = { close = 2.0 }": "job.signal_digital",
    "set = { close = true }\ntimeout = 1": "job.no_effect",
    "set = { close = true }\ntolerance = { position = 1 }": "job.no_tolerance",
    "do = [{ wait = { part_present = 'x' } }]\nrepeat = 2": "job.type",
    "do = [{ path = 'curve', joints = [0, 0] }]\nrepeat = 2": "job.choice",
}


TABLES = {
    "[input.a]\nfollows = 'b'": "job.signal_follows",
    "[input.a]\nevery = 2.0": "job.signal_every",
    "[input.a]\nchanges = [[2, true], [1, false]]": "job.signal_order",
    "[input.a]\nchanges = [[3, true]]\nevery = 2": "job.signal_order",
    "[input.a]\nchanges = [[2, 1.5]]": "job.signal_start",
    "[input.a]\nafter = 1.0": "job.signal_after",
    "[output]\na = 1\n[input.a]\nstart = 1": "job.signal_twice",
    "[output]\nb = 1\n[input.a]\nfollows = 'b'\nchanges = [[1, true]]": "job.signal_answer",
    "[input]\na = true": "job.type",
    "[input.a]\nchanges = [[-2, true]]": "job.bound",
    "[output]\na = nan": "job.not_finite",
    "[input.a]\nevery = 1e-6\nchanges = [[0, true]]": "job.bound",
}


TEXTS = {f"{CELL}[[move]]\n{move}\n": key for move, key in WRONG.items()}
TEXTS |= {f'robot = "planar2r"\n{table}\n[[move]]\njoints = [0, 0]\n': key for table, key in TABLES.items()}


@pytest.mark.parametrize("text", TEXTS, ids=[*WRONG, *TABLES])
@pytest.mark.parametrize("language", ["en", "ar"])
def test_wrong_moves_and_tables_are_named_with_their_line(text, language):
    with pytest.raises(JobError) as caught:
        parse_job(text, "job.toml")
    assert caught.value.key == TEXTS[text]
    assert "job.toml:" in caught.value.message(language)
    assert "{" not in caught.value.message(language).replace("{ above", "")


TIMES = st.lists(st.floats(0.0, 1.9), min_size=1, max_size=4, unique_by=lambda t: round(t, 3)).map(sorted)

SETS = TIMES.map(lambda times: [time + 0.01 for time in times])


@settings(max_examples=60)
@given(a=TIMES, b=TIMES, repeats=st.booleans(), sets=SETS, begin=st.floats(0.0, 2.0), wanted=st.integers(0, 7))
def test_the_end_of_a_wait_is_the_first_tick_at_which_everything_holds(a, b, repeats, sets, begin, wanted):
    """Against looking at every tick, with values from their definition."""
    a, b, sets = ([round(t, 3) for t in times] for times in (a, b, sets))
    text = f'robot = "planar2r"\n[output]\no = false\n[input.f]\nfollows = "o"\nafter = 0.3\n[input.a]\n{_table(a)}\n'
    text += f"[input.b]\n{_table(b)}\n" + ("every = 2.0\n" if repeats else "")
    conditions = ", ".join(f"{name} = {_said(bool(wanted >> k & 1))}" for k, name in enumerate("abf"))
    job = parse_job(f"{text}[[move]]\nwait = {{ {conditions} }}\ntimeout = 8\n")
    signals = CellSignals(job, 0.01)
    for k, time in enumerate(sets):
        signals.put(time, {"o": k % 2 == 0})

    def value(name, t):
        if name == "f":
            return sum(time + 0.3 <= t + 1e-9 for time in sets) % 2 == 1
        if name == "b" and repeats:
            t = (t + 1e-9) % 2.0 - 1e-9
        return sum(time <= t + 1e-9 for time in (a if name == "a" else b)) % 2 == 1

    first = signals.tick_after(begin)
    ticks = 0.01 * np.arange(round(first / 0.01), 1200)
    named = job.move[0].wait
    right = [
        t for t in ticks if t <= max(begin + 8.0, first) + 1e-9 and all(value(n, t) == w for n, w in named.items())
    ]
    found = signals.end_of_wait(begin, job.move[0].wait, job.move[0].timeout)
    assert found == (pytest.approx(right[0], abs=1e-9) if right else None)
    assert all(holds(value(name, t), signals.value(name, t)) for name in "abf" for t in ticks[::7])


def _table(times):
    return "changes = [" + ", ".join(f"[{t}, {_said(k % 2 == 0)}]" for k, t in enumerate(times)) + "]"


def _said(value):
    return "true" if value else "false"


def test_the_check_of_a_job_shows_signals(tmp_path, capsys):
    path = tmp_path / "cell.toml"
    path.write_text(CELL + MOVES, encoding="utf-8")
    assert main(["check-job", str(path)]) == 0
    words = capsys.readouterr().out
    assert "wait for signals" in words
    assert "close = true" in words
    assert main(["check-job", str(path), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert [each["signal"] for each in data["signals"]["changes"]] == ["part_present", "close", "closed"]


def test_a_job_may_end_with_a_signal_and_no_rest():
    end = "[[move]]\npick = { mass = 0.1 }\n[[move]]\nset = { close = false }\n[simulation]\nsettle = 0\n"
    run = solved(CELL + MOVES + end)
    assert run.plan.legs[-1].kind == "set"
    assert run.recording.t[-1] == pytest.approx(run.plan.duration)


def test_the_conveyor_of_the_examples_waits_for_each_part():
    path = Path(__file__).parents[2] / "examples" / "jobs" / "conveyor_panda.toml"
    text = path.read_text(encoding="utf-8")
    _, plan = prepare(parse_job(text, path.name), text, path.parent)
    for leg, end in zip(plan.legs, plan.starts[1:], strict=True):
        if leg.kind == "wait" and leg.name.startswith("part"):
            assert plan.signals.value("part_present", end) is True
    assert sum(leg.kind == "wait" for leg in plan.legs) == 9
