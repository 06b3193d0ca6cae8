"""Completion scripts and manual page, read by their programs; colours, wrapping, the status line."""

from __future__ import annotations

import os
import pty
import shutil
import subprocess
import sys
from contextlib import suppress

import pytest

from mafsil.cli.main import main
from mafsil.cli.registry import OPERATIONS
from mafsil.cli.status_line import StatusLine
from mafsil.cli.table import table, width


def completed(shell: str, script: str, *words: str) -> set[str]:
    """What bash offers behind these words."""
    line = " ".join(f"'{word}'" for word in words)
    ask = f"COMP_WORDS=(mafsil {line}); COMP_CWORD={len(words)}; _mafsil; printf '%s\\n' \"${{COMPREPLY[@]}}\""
    done = subprocess.run([shell, "-c", f"{script}\n{ask}"], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_bash_completes_commands_options_choices_and_robots(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pantry.urdf").write_text("")
    assert main(["completion", "bash"]) == 0
    script = capsys.readouterr().out
    assert completed("bash", script, "ver") == {"verify"}
    assert completed("bash", script, "") >= {operation.name for operation in OPERATIONS}
    assert completed("bash", script, "plan", "pan") == {"panda", "pantry.urdf"}
    assert completed("bash", script, "verify", "panda", "--against", "mu") == {"mujoco"}
    assert completed("bash", script, "plan", "panda", "--shor") == completed("bash", script, "plan", "panda", "--shor")
    assert {"--goal", "--gravity"} <= completed("bash", script, "plan", "panda", "--g")
    assert completed("bash", script, "fk", "--lang", "a") == {"ar"}


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_accept_their_script(shell, capsys):
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert "verify" in script
    if found := shutil.which(shell):
        subprocess.run([found, "-n", "-c", script], check=True)


def test_lines_are_wrapped_between_words_on_a_narrow_terminal():
    """A terminal of 50 columns, as tmux makes it; a pipe gets whole lines."""
    command = [sys.executable, "-m", "mafsil.cli.main", "ik", "panda", "--pose", "9", "0", "0"]
    whole = subprocess.run(command, capture_output=True, text=True, check=False).stdout
    assert max(map(len, whole.splitlines())) > 50
    leader, follower = pty.openpty()
    environment = {**os.environ, "COLUMNS": "50", "TERM": "dumb"}
    subprocess.run(command, stdout=follower, stderr=subprocess.DEVNULL, env=environment, check=False)
    os.close(follower)
    shown = os.read(leader, 100_000).decode()
    assert max(len(line) for line in shown.splitlines()) <= 50
    assert "".join(shown.split()) == "".join(whole.split())


def on_a_terminal(*words: str, **environment: str) -> str:
    """All that a command prints, standard error too, on a terminal of 80 columns."""
    leader, follower = pty.openpty()
    command = [sys.executable, "-m", "mafsil.cli.main", *words]
    surroundings = {name: value for name, value in os.environ.items() if name != "NO_COLOR"}
    surroundings |= {"COLUMNS": "80", "TERM": "xterm", **environment}
    subprocess.run(command, stdout=follower, stderr=follower, env=surroundings, check=False)
    os.close(follower)
    pieces: list[bytes] = []
    with suppress(OSError):
        while piece := os.read(leader, 65536):
            pieces.append(piece)
    return b"".join(pieces).decode().replace("\r\x1b[K", "")


def test_verdicts_have_a_colour_on_a_terminal_only():
    wrong = ("check-homework", "planar2r", "--dh", "0 0 0 0", "2 0 0 90", "--degrees")
    assert "\x1b[31mmafsil:\x1b[0m" in on_a_terminal(*wrong)
    assert "\x1b[32m" in on_a_terminal("check-homework", "planar2r", "--dh", "0 0 0 0", "1 0 0 90", "--degrees")
    assert "\x1b[1m  robot" in on_a_terminal("list")
    for quiet in (on_a_terminal(*wrong, "--no-color"), on_a_terminal(*wrong, NO_COLOR="1")):
        assert "\x1b" not in quiet
    piped = subprocess.run([sys.executable, "-m", "mafsil.cli.main", *wrong], capture_output=True, check=False)
    assert b"\x1b" not in piped.stdout + piped.stderr


def test_seconds_are_counted_where_nothing_else_is_said(monkeypatch, capsys):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    monkeypatch.setattr("mafsil.cli.status_line.QUIET", 0.01)
    line = StatusLine()
    with line.counting():
        line.text = "planning"
        while "planning  working, 0 s" not in (shown := capsys.readouterr().err):
            assert "Traceback" not in shown
    assert capsys.readouterr().err.endswith("\r\x1b[K")


def test_words_of_a_wide_table_are_wrapped(monkeypatch):
    monkeypatch.setattr("mafsil.cli.table.columns", lambda: 70)
    lines = table(("robot", "joints", "what"), [("a", "R", "seven words " * 8), ("b", "P", "one")], words=(2,))
    assert max(map(width, lines)) <= 70
    assert lines[1].split()[:2] == ["a", "R"]
    assert lines[2].startswith(" " * lines[1].index("seven"))
    assert lines[-1].split() == ["b", "P", "one"]


@pytest.mark.parametrize("code", ["en", "ar"])
def test_the_manual_has_every_command_and_option(code, capsys):
    assert main(["man", "--lang", code]) == 0
    page = capsys.readouterr().out.replace("\\-", "-")
    for operation in OPERATIONS:
        assert f".SS {operation.name}" in page
        for parameter in operation.parameters:
            assert parameter.positional or f".B {parameter.option}" in page
    if groff := shutil.which("groff"):
        done = subprocess.run(
            [groff, "-Kutf8", "-man", "-Tutf8", "-ww", "-z"], input=page, capture_output=True, text=True, check=True
        )
        assert not done.stderr
