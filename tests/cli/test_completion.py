"""Completion scripts, read by the shells that they are for; long lines wrapped to the terminal."""

from __future__ import annotations

import os
import pty
import shutil
import subprocess
import sys

import pytest

from mafsil.cli.main import main
from mafsil.cli.registry import OPERATIONS


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
