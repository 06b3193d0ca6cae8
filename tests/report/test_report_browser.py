"""The page in a real browser, where there is one: its script runs under its own policy and draws everything."""

import re
import subprocess
from pathlib import Path

import pytest

from mafsil.job import Run
from mafsil.job.judging.judgement import summary
from mafsil.report import contents
from mafsil.report.page import render
from mafsil.report.run_tables import limit_plot
from tests.page.node import needed

FLAGS = (
    "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--virtual-time-budget=2000", "--enable-logging=stderr", "--window-size=1200,900",
)  # fmt: skip


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
