"""The files of a run: whole or not there, readable by others, never in the place of something else."""

import csv
import json
import os
import platform
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from mafsil.errors import InputError
from mafsil.job import Run
from mafsil.job.judging.judgement import summary
from mafsil.job.planning.limiting import DECIDES
from mafsil.report import contents, results, write_results
from mafsil.report.results import as_data
from mafsil.report.run_tables import limit_plot
from mafsil.simulation import Recording

REPEATEDLY = """
import sys
from pathlib import Path
import pickle
from mafsil.job import parse_job, solve
from mafsil.report import write_results
text = Path(sys.argv[1]).read_text(encoding="utf-8")
run = solve(parse_job(text), text, Path())
print("ready", flush=True)
while True:
    write_results(run, Path(sys.argv[2]))
"""


def whole(directory: Path) -> bool:
    """Every file is there and can be read to its end."""
    if sorted(item.name for item in directory.iterdir()) != sorted(results.FILES):
        return False
    data = json.loads((directory / "results.json").read_text(encoding="utf-8"))
    tape = Recording.load(directory / "recording")
    rows = sum(1 for _ in (directory / "recording.csv").open(encoding="utf-8"))
    page = (directory / "report.html").read_text(encoding="utf-8")
    return data["format"] == results.FORMAT and rows == len(tape.t) + 1 and page.rstrip().endswith("</html>")


def test_all_files_agree(small_run: Run, tmp_path: Path) -> None:
    report = write_results(small_run, tmp_path / "out")
    assert report == tmp_path / "out" / "report.html"
    assert whole(tmp_path / "out")
    tape = small_run.recording
    with (tmp_path / "out" / "recording.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert float(rows[-1]["q[joint4]"]) == tape.q[-1, 3]
    data = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))
    assert data["numbers"]["tip_error"] == pytest.approx(tape.tip_position_error.max())
    assert [joint["name"] for joint in data["joints"]] == list(small_run.robot.joint_names)
    assert np.allclose([joint["peak_effort"] for joint in data["joints"]], np.abs(tape.tau).max(axis=0))
    assert not list(tmp_path.glob(".out*"))


def test_earlier_results_are_replaced_and_nothing_else_is(small_run: Run, tmp_path: Path) -> None:
    out = tmp_path / "out"
    write_results(small_run, out)
    write_results(small_run, out)
    assert whole(out)
    (out / "thesis.tex").write_text("precious", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        write_results(small_run, out)
    assert caught.value.key == "report.not_ours"
    assert (out / "thesis.tex").read_text(encoding="utf-8") == "precious"
    with pytest.raises(InputError) as caught:
        write_results(small_run, out / "thesis.tex")
    assert caught.value.key == "report.no_directory"


def test_a_failed_write_leaves_the_old_results(small_run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out"
    write_results(small_run, out)
    before = {item.name: item.read_bytes() for item in out.iterdir()}

    def full(self: Recording, path: Path, **options: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Recording, "save", full)
    with pytest.raises(OSError, match="No space left"):
        write_results(small_run, out)
    assert {item.name: item.read_bytes() for item in out.iterdir()} == before
    assert not list(tmp_path.glob(".out*"))


def test_without_exchange_two_renames_do(small_run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(results, "_exchange", lambda first, second: False)
    for _ in range(2):
        write_results(small_run, tmp_path / "out")
    assert whole(tmp_path / "out")
    assert not list(tmp_path.glob(".out*"))


def test_orphans_of_killed_runs_are_swept(small_run: Run, tmp_path: Path) -> None:
    old, young = tmp_path / ".out.partial-old", tmp_path / ".out.partial-young"
    for orphan in (old, young):
        orphan.mkdir()
    os.utime(old, (0, 0))
    finished = subprocess.Popen([sys.executable, "-c", ""])
    finished.wait()
    killed = tmp_path / f".out.partial-{platform.node()}-{finished.pid}-x"
    running = tmp_path / f".out.partial-{platform.node()}-{os.getpid()}-x"
    elsewhere = tmp_path / f".out.partial-another-machine-{finished.pid}-x"
    for partial in (killed, running, elsewhere):
        partial.mkdir()
    write_results(small_run, tmp_path / "out")
    assert not old.exists()
    assert not killed.exists()
    assert young.exists()
    assert running.exists()
    assert elsewhere.exists()


@pytest.mark.row("K5")
def test_kill_9_leaves_whole_results(small_run: Run, tmp_path: Path) -> None:
    out, job = tmp_path / "out", tmp_path / "job.toml"
    job.write_text(small_run.text, encoding="utf-8")
    rng = np.random.default_rng(0)
    seen = 0
    for _ in range(4):
        child = subprocess.Popen([sys.executable, "-c", REPEATEDLY, str(job), str(out)], stdout=subprocess.PIPE)
        assert child.stdout is not None
        assert child.stdout.readline() == b"ready\n"
        until = time.monotonic() + 60.0
        while not out.exists() and time.monotonic() < until:
            time.sleep(0.01)  # the first results, on a machine that is busy
        time.sleep(float(rng.uniform(0.0, 1.2)))
        child.send_signal(signal.SIGKILL)
        child.wait()
        child.stdout.close()
        if out.exists():
            seen += 1
            assert whole(out)
    assert seen
    write_results(small_run, out)
    assert whole(out)


def test_a_long_recording_is_thinned_to_the_size_that_the_job_allows(small_run: Run, tmp_path: Path) -> None:
    tape = small_run.recording
    numbers = sum(array.size for array in tape.arrays().values())
    thin = tape.thinned(numbers // 3)
    assert thin.metadata["every_tick"] in (3, 4)
    assert sum(array.size for array in thin.arrays().values()) <= numbers // 3 + 2 * numbers // len(tape.t)
    assert (thin.t[0], thin.t[-1]) == (tape.t[0], tape.t[-1])
    thin.save(tmp_path / "thin", table_numbers=numbers // 6)
    again = Recording.load(tmp_path / "thin")
    np.testing.assert_array_equal(again.q, thin.q)
    note = json.loads((tmp_path / "thin.json").read_text(encoding="utf-8"))
    assert note["csv_every_tick"] >= 2 * thin.metadata["every_tick"]
    assert tape.thinned(numbers) is tape


@pytest.mark.capability("11-47")
@pytest.mark.parametrize("language", ["en", "ar"])
def test_every_limit_has_its_row_and_what_it_would_save(small_run: Run, language: str) -> None:
    numbers = summary(small_run)
    page = contents.page(small_run, numbers, language)
    assert len(page.limit_table.rows) == len(small_run.limits) > 0
    best, row = small_run.limits[0], page.limit_table.rows[0]
    assert small_run.robot.joint_names[best.joint] in row[0]
    assert f"({100 * best.saved / numbers.cycle:.3g} %)" in row[2]
    other = contents.page(small_run, numbers, "ar" if language == "en" else "en")
    assert other.limit_table.head != page.limit_table.head


@pytest.mark.capability("11-47")
def test_the_plot_shows_which_limit_is_used_most(small_run: Run) -> None:
    t = np.linspace(0.0, small_run.plan.duration, 2001)
    (plot,) = limit_plot(small_run, t, "en")
    assert len(plot.names) == len(plot.keys) == plot.values.shape[1]
    assert plot.names[-1] == "other limits"
    assert np.nanmax(plot.values) <= 100.0 + 1e-3
    assert (np.nanmax(plot.values, axis=0)[:-1] >= 100.0 * DECIDES).all()
    # At every moment at most one curve goes on, and one more ends.
    assert np.isfinite(plot.values).sum(axis=1).max() <= 2


def test_results_hold_them_as_plain_data(small_run: Run) -> None:
    data = json.loads(json.dumps(as_data(small_run, summary(small_run)), allow_nan=False))["limits"]
    assert [one["quantity"] for one in data] == [one.quantity for one in small_run.limits]
    assert data[0]["joint"] in small_run.robot.joint_names
    assert data[0]["more"] == 0.1
