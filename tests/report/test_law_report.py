"""Laws side by side on a page: complete in itself, in both languages, with the numbers that prove stability."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from mafsil.cli.main import main
from mafsil.errors import InputError
from mafsil.job import Run, bench_laws, parse_job
from mafsil.job.judging.judgement import summary
from mafsil.job.judging.law_bench import CONDITIONS, PIECES
from mafsil.messages import say
from mafsil.report import contents, write_law_report
from mafsil.report.law_report import law_page, render_laws
from mafsil.report.page import render
from mafsil.report.run_tables import limit_plot
from tests.job.test_job_planning import planned
from tests.page.node import needed

FLAGS = (
    "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--virtual-time-budget=2000", "--enable-logging=stderr", "--window-size=1200,900",
)  # fmt: skip

TEXT = """
title = "Press </script><script>alert(1)</script> & 'lift'"
robot = "puma560"
[start]
pose = { position = [0.5, 0.1, 0.01], rpy = [3.14159265358979, 0, 0] }
[tolerance]
position = 0.01
[controller]
kind = "pid"
integral = 300000
[simulation]
friction = false
noise = { force = 0.05 }
settle = 0.1
[[surface]]
point = [0, 0, 0]
normal = [0, 0, 1]
stiffness = 2e4
damping = 150
[[move]]
path = "line"
pose = { position = [0.5, 0.1, -0.001], rpy = [3.14159265358979, 0, 0] }
"""
NAMES = {
    "pid": {"sampled", "integral"},
    "sliding_mode": {"sampled", "bound"},
    "min_max": {"sampled", "error_bound"},
    "hybrid": {"sampled", "error_equation", "force_loop"},
    "impedance": {"sampled", "virtual_motion"},
    "admittance": {"sampled", "virtual_motion", "virtual_step"},
    "linear_quadratic": {"sampled", "about_pose"},
    "computed_torque": {"sampled", "error_equation"},
}


@pytest.fixture(scope="module")
def bench():
    job, (robot, plan) = parse_job(TEXT), planned(TEXT)
    return bench_laws(job, TEXT, robot, plan, tuple(NAMES))


@pytest.mark.capability("10-41", "10-23", "10-33")
def test_each_law_has_its_conditions_and_the_one_that_does_not_hold_is_named(bench):
    by_law = {each.kind: each for each in bench}
    assert {kind: {one.name for one in each.conditions} for kind, each in by_law.items()} == NAMES
    broken = [one for one in by_law["pid"].conditions if not one.holds]
    assert [one.name for one in broken] == ["integral"]
    assert broken[0].value > 1.0
    assert not by_law["pid"].stable
    assert all(each.stable for kind, each in by_law.items() if kind != "pid")
    loop = next(one for one in by_law["hybrid"].conditions if one.name == "force_loop")
    assert loop.value == pytest.approx(1.0 - 10.0 * 0.001), "without a proportional part one root stays: 1 - Ki dt"
    for one in (each for law in bench for each in law.conditions):
        assert one.explain(language="en") != one.explain(language="ar")
        assert re.search(r"\d", one.explain(language="en"))


def test_curves_hold_the_peaks_of_the_run(bench):
    for each in bench:
        curves, numbers = each.curves, each.numbers
        assert 1 < len(curves.t) < PIECES
        assert np.nanmax(curves.tip_error) == numbers.tip_error
        assert np.nanmax(curves.force) == numbers.touching.peak
        assert np.nanmax(curves.joint_error) == numbers.joint_error.max()


@pytest.mark.capability("10-41", "10-115")
@pytest.mark.parametrize("language", ["en", "ar"])
def test_the_page_has_a_row_for_each_law_and_says_what_does_not_hold(bench, language):
    page = law_page(bench, parse_job(TEXT), TEXT, language)
    assert len(page.compared.rows) == len(page.borne.rows) == len(bench)
    assert all(len(row) == len(page.compared.head) for row in page.compared.rows)
    assert len(page.borne.head) == 2 + len(CONDITIONS)
    assert len(page.stability.rows) == sum(len(each.conditions) for each in bench)
    assert sum(row[2] == say("report.laws_no", language=language) for row in page.stability.rows) == 1
    assert [plot.column for plot in page.plots] == ["joint_error", "tip_error", "effort", "contact_force"]
    assert all(plot.values.shape == (len(page.times), len(bench)) for plot in page.plots)
    assert all(np.isfinite(plot.values).all() for plot in page.plots), "no gaps, though it has fewer ticks than PIECES"
    for finding, law in zip(page.findings, page.names, strict=True):
        assert finding.text.startswith(f"{law}:")
    assert page.figures[0].value == f"{len(bench) - 1} / {len(bench)}"
    assert page.figures[0].level == "warning"


def test_the_page_asks_nobody_for_anything_and_carries_both_languages(bench):
    pages = [law_page(bench, parse_job(TEXT), TEXT, code) for code in ("en", "ar")]
    html = render_laws(*pages)
    assert "default-src 'none'" in html
    assert not re.search(r"""(?:src|href)\s*=\s*["']?(?:https?:)?//""", html)
    assert "<script>alert(1)" not in html
    data = json.loads(re.search(r'id="data">(.*?)</script>', html, re.DOTALL).group(1))
    assert set(data["languages"]) == {"en", "ar"}
    assert data["joints"] == [each.kind for each in bench]
    for page in pages:
        assert data["texts"][page.language]["laws"] == list(page.names)
    assert 'data-language="ar"' in html


@pytest.mark.parametrize("language", ["en", "ar"])
def test_the_script_draws_a_curve_for_each_law(bench, language, tmp_path):
    file = tmp_path / "laws.html"
    pages = {code: law_page(bench, parse_job(TEXT), TEXT, code) for code in ("en", "ar")}
    other = "ar" if language == "en" else "en"
    file.write_text(render_laws(pages[language], pages[other]), encoding="utf-8")
    browser = needed("chromium", "chromium-browser", "google-chrome")
    words = [browser, *FLAGS, f"--user-data-dir={tmp_path / 'profile'}", "--dump-dom", file.as_uri()]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=True)
    assert not re.findall(r"CONSOLE.*(?:[Rr]efused|Uncaught|Error)", done.stderr)
    assert done.stdout.count('class="curve"') == 4 * len(bench)
    legend = done.stdout.partition('id="legend"')[2].partition('id="plots"')[0]
    assert [name for name in pages[language].names if f">{name}</span>" not in legend] == []
    assert f'dir="{"ltr" if language == "en" else "rtl"}"' in done.stdout.split("<head>")[0]


def test_the_files_are_whole_and_nothing_of_others_is_replaced(bench, tmp_path):
    folder = tmp_path / "laws"
    report = write_law_report(bench, parse_job(TEXT), TEXT, folder)
    assert report.read_text("utf-8").startswith("<!doctype html>")
    data = json.loads((folder / "results.json").read_text("utf-8"))
    assert {law["kind"] for law in data["laws"]} == set(NAMES)
    assert (folder / "job.toml").read_text("utf-8") == TEXT
    write_law_report(bench, parse_job(TEXT), TEXT, folder)
    (folder / "mine.txt").write_text("precious")
    with pytest.raises(InputError, match="mine"):
        write_law_report(bench, parse_job(TEXT), TEXT, folder)


def test_the_command_writes_the_page(tmp_path, capsys):
    job, out = tmp_path / "press.toml", tmp_path / "out"
    job.write_text(TEXT)
    assert main(["compare", "control", str(job), "--laws", "pid", "--out", str(out)]) == 0
    assert str(out / "report.html") in capsys.readouterr().out
    assert (out / "report.html").exists()
    assert main(["compare", "control", str(job), "--laws", "pid", "--out", str(Path(__file__).parent)]) != 0
    assert main(["compare", "planners", str(job), "--out", str(out)]) != 0


@pytest.mark.parametrize("language", ["en", "ar"])
def test_the_script_draws_everything(small_run: Run, language: str, tmp_path: Path) -> None:
    page = tmp_path / "report.html"
    page.write_text(render(contents.page(small_run, summary(small_run), language)), encoding="utf-8")
    browser = needed("chromium", "chromium-browser", "google-chrome")
    words = [browser, *FLAGS, f"--user-data-dir={tmp_path / 'profile'}", "--dump-dom", f"{page.as_uri()}#t=0.5"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=True)
    dom = done.stdout
    assert not re.findall(r"CONSOLE.*(?:[Rr]efused|Uncaught|Error)", done.stderr)
    (used,) = limit_plot(small_run, small_run.recording.t[contents.plot_rows(small_run)], language)
    # One more is the distance of the robot from itself.
    assert dom.count('class="curve"') == 4 * small_run.robot.n + len(used.names) + 1
    assert re.search(r'<output id="clock"[^>]*>0\.50 s</output>', dom)
    assert re.search(r'<p id="status" role="status" hidden', dom), "the page did not start"
    assert dom.count("<i ") >= len(small_run.plan.legs)
    assert "onerror=alert(2)>" not in re.sub(r"&lt;|&gt;|&quot;", "", dom.split('id="data"')[0])
