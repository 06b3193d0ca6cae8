"""Every line of the command line's page runs; every command stands there; every page stands in the index."""

import re
import shlex
from pathlib import Path

import pytest

from mafsil import messages
from mafsil.cli.main import main
from mafsil.cli.registry import OPERATIONS

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
LINES = list(
    dict.fromkeys(
        line
        for page in ("command_line.md", "command_line.ar.md")
        for block in re.findall(r"```sh\n(.*?)```", (DOCS / page).read_text("utf-8"), flags=re.S)
        for line in block.strip().splitlines()
    )
)
ELSEWHERE = {"demo", "identify", "check-homework", "studio", "diff", "sweep"}
"""Commands that need a log or results, or run for long: their pages or tests have them."""


@pytest.mark.parametrize("line", LINES)
def test_line_runs(line, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(messages.catalogue, "_chosen", None)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    name, *words = shlex.split(line)
    assert name == "mafsil"
    assert main(words) == 0, capsys.readouterr().err
    assert capsys.readouterr().out.strip()


def test_every_command_stands_on_the_page():
    shown = {line.split()[1] for line in LINES}
    assert {operation.name for operation in OPERATIONS} - shown <= ELSEWHERE


def test_every_page_stands_in_the_index():
    linked = set(re.findall(r"\]\(([^)#]+\.md)\)", (DOCS / "index.md").read_text("utf-8")))
    assert {page.name for page in DOCS.glob("*.md")} - {"index.md"} <= linked


def test_readme_names_only_files_that_exist_or_are_yours():
    text = (ROOT / "README.md").read_text("utf-8")
    for block in re.findall(r"```sh\n(.*?)```", text, flags=re.S):
        for line in block.strip().splitlines():
            command, _, remark = line.partition("#")
            for word in command.split():
                if re.search(r"\.(toml|urdf|csv|stl|xml|json|py)$", word) and not (ROOT / word).exists():
                    assert "your" in remark, f"{word} does not exist, and the line does not say that it is yours"
