"""Compiled loops on disk: kept for exactly the sources they were made from, checked, and announced once."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[2] / "src" / "mafsil"

CALLEE = """
from mafsil.kernels.loops.loop import compiled

@compiled
def scaled(x):
    return {factor} * x
"""
CALLER = """
from mafsil.kernels.loops.loop import compiled
from callee_loops import scaled

@compiled
def total(n):
    s = 0.0
    for k in range(n):
        s += scaled(k)
    return s
"""
USE = """
import logging, sys
from pathlib import Path
logging.basicConfig(format="%(name)s: %(message)s")
logging.getLogger("mafsil").setLevel(logging.DEBUG)
sys.path.insert(0, sys.argv[1])
from caller_loops import total
if "edited" in sys.argv:
    Path(sys.argv[1], "callee_loops.py").write_text("edited while a process runs")
print(total(4))
"""


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """Two modules, of which one calls the other."""
    folder = tmp_path / "package"
    folder.mkdir()
    (folder / "callee_loops.py").write_text(CALLEE.format(factor=2.0))
    (folder / "caller_loops.py").write_text(CALLER)
    return folder


def run(package: Path, place: Path | str, *words: str) -> tuple[float, str]:
    """Sum of the loops in a fresh process, and what it told."""
    environment = dict(os.environ) | {"MAFSIL_CACHE": str(place), "PYTHONDONTWRITEBYTECODE": "1", "MAFSIL_LANG": "en"}
    done = subprocess.run(
        [sys.executable, "-c", USE, str(package), *words], env=environment, capture_output=True, text=True, check=True
    )
    return float(done.stdout), done.stderr


def entries(place: Path) -> list[Path]:
    return sorted(place.rglob("*.loop"))


def test_the_second_process_compiles_nothing_and_an_edited_callee_counts(package: Path, tmp_path: Path) -> None:
    place = tmp_path / "cache"
    value, told = run(package, place)
    assert value == 12.0
    assert "compiling total" in told
    first = entries(place)
    assert len(first) == 2, "the loop, and how Python calls it"
    assert run(package, place) == (12.0, "")
    assert entries(place) == first

    (package / "callee_loops.py").write_text(CALLEE.format(factor=5.0))
    value, told = run(package, place)
    assert value == 30.0
    assert "compiling total" in told
    assert len(entries(place)) == 3, "how Python calls it has not changed"

    (package / "callee_loops.py").write_text(CALLEE.format(factor=2.0))
    assert run(package, place) == (12.0, ""), "the entries of the first sources are still good"


@pytest.mark.parametrize("edit", [
    lambda text: "# a comment\n\n" + text,
    lambda text: text.replace("(x):\n", '(x):\n    """A docstring."""\n'),
    lambda text: text + "\n@compiled\ndef other(x):\n    return x + UNUSED\n\nUNUSED = 3\n",
])  # fmt: skip
def test_what_does_not_change_the_meaning_compiles_nothing(package: Path, tmp_path: Path, edit) -> None:
    place = tmp_path / "cache"
    run(package, place)
    path = package / "callee_loops.py"
    path.write_text(edit(path.read_text()))
    assert run(package, place) == (12.0, "")


def test_a_number_of_the_module_counts_where_it_is_used(package: Path, tmp_path: Path) -> None:
    place = tmp_path / "cache"
    body = CALLEE.format(factor="FACTOR") + "\nFACTOR, OTHER = {}, {}\n"
    for numbers, value, compiled in (((2.0, 1), 12.0, True), ((2.0, 7), 12.0, False), ((3.0, 7), 18.0, True)):
        (package / "callee_loops.py").write_text(body.format(*numbers))
        found, told = run(package, place)
        assert found == value
        assert ("compiling" in told) == compiled


def test_what_is_edited_after_its_import_runs_as_python_and_is_not_kept(package: Path, tmp_path: Path) -> None:
    """Nobody knows the source of what is in memory."""
    assert run(package, tmp_path / "cache", "edited")[0] == 12.0
    assert not entries(tmp_path)


def test_damaged_entries_are_compiled_again_and_mended(package: Path, tmp_path: Path) -> None:
    place = tmp_path / "cache"
    run(package, place)
    for path, cut in zip(entries(place), (None, 0), strict=True):
        data = bytearray(path.read_bytes())
        data[len(data) // 2] ^= 1
        path.write_bytes(data[:cut])
    assert run(package, place)[0] == 12.0
    assert run(package, place) == (12.0, "")


def test_exchanged_entries_are_refused_and_healed(package: Path, tmp_path: Path) -> None:
    """Each is whole, but answers for another loop: the name and the types are part of the key."""
    place = tmp_path / "cache"
    run(package, place)
    one, other = entries(place)
    first, second = one.read_bytes(), other.read_bytes()
    one.write_bytes(second)
    other.write_bytes(first)
    value, told = run(package, place)
    assert value == 12.0
    assert "damaged" in told
    assert (one.read_bytes(), other.read_bytes()) == (first, second)
    assert run(package, place) == (12.0, "")


def test_an_entry_that_says_something_else_is_compiled_again(package: Path, tmp_path: Path) -> None:
    """Sealed for this key, but no loop: healed, not told for ever."""
    from mafsil.kernels.loops.specialisation import LOOP

    place = tmp_path / "cache"
    run(package, place)
    for path in entries(place):
        path.write_bytes(LOOP.seal(bytes.fromhex(path.stem), b"\0" * 40))
    assert run(package, place)[0] == 12.0
    assert run(package, place) == (12.0, "")


def test_nothing_of_the_package_unpickles_files() -> None:
    for path in SOURCE.rglob("*.py"):
        assert not re.search(
            r"^\s*(import pickle|from pickle|import marshal|import dill)", path.read_text("utf-8"), re.M
        ), path


def test_without_a_usable_folder_code_stays_in_memory(package: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    for place in ("off", str(tmp_path / "file" / "below")):
        assert run(package, place)[0] == 12.0
    assert not entries(tmp_path)


def test_a_disk_that_refuses_costs_only_time(package: Path, tmp_path: Path) -> None:
    """Folders in the place of the entries: neither can be written, even by root."""
    place = tmp_path / "cache"
    run(package, place)
    for path in entries(place):
        path.unlink()
        path.mkdir()
        (path / "in the way").touch()
    assert run(package, place)[0] == 12.0
    assert all(path.is_dir() for path in entries(place))


def test_processes_that_start_together_agree(package: Path, tmp_path: Path) -> None:
    place = tmp_path / "cache"
    command = [sys.executable, "-c", USE, str(package)]
    environment = dict(os.environ) | {"MAFSIL_CACHE": str(place), "PYTHONDONTWRITEBYTECODE": "1"}
    started = [
        subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) for _ in range(2)
    ]
    assert [float(process.communicate()[0]) for process in started] == [12.0] * 2
    assert len(entries(place)) == 2
    assert not list(place.rglob("*.tmp"))


LEAVE = {
    "kernel": "import mafsil as mf; r = mf.load('panda'); work = lambda: r.forward_dynamics(*[np.zeros(7)] * 3)",
    "loop": "from mafsil.solvers.positive_span_loops import *; import mafsil as mf; "
    "work = lambda: mf.solve_ik(mf.load('planar2r'), np.eye(4))",
}


@pytest.mark.parametrize("what", LEAVE)
@pytest.mark.parametrize("after", [0.3, 0.6, 0.9, 1.2])
def test_leaving_while_a_thread_compiles_is_no_crash(what: str, after: float) -> None:
    program = (
        f"import threading, time, numpy as np; {LEAVE[what]}; "
        f"threading.Thread(target=work, daemon=True).start(); time.sleep({after})"
    )
    environment = dict(os.environ) | {"MAFSIL_CACHE": "off"}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_the_command_line_tells_on_a_terminal_and_keeps_quiet_elsewhere(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import logging

    from mafsil.cli import main as cli
    from mafsil.messages import language, say

    def work(words: list[str]) -> int:
        logging.getLogger("mafsil").info(say("derivation.slow", robot="bench", joints=9))
        return 0

    monkeypatch.setattr(cli, "_run", work)
    assert cli.main(["demo"]) == 0
    assert capsys.readouterr().err == ""
    for code, word in (("en", "seconds"), ("ar", "ثوانٍ")):
        language(code)
        assert cli.main(["demo", "--progress"]) == 0
        told = capsys.readouterr().err
        assert told.count("\n") == 1
        assert word in told
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert cli.main(["demo"]) == 0
    assert capsys.readouterr().err.startswith("\r\x1b[Kmafsil: ")
    assert not logging.getLogger("mafsil").handlers


def test_a_terminal_shows_what_is_being_compiled_until_the_answer_comes(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from mafsil.cli import main as cli
    from mafsil.code_store import compilation

    def work(words: list[str]) -> int:
        with compilation("mass_matrix"):
            return 0

    monkeypatch.setattr(cli, "_run", work)
    assert cli.main(["demo", "--progress"]) == 0
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert cli.main(["demo"]) == 0
    told = capsys.readouterr().err
    assert "mass_matrix" in told
    assert told.endswith("\r\x1b[K")
    assert "\n" not in told


NAMED = """
import logging
from mafsil.solvers.hull_growth_loops import make_polytope
logging.basicConfig(format="%(name)s: %(message)s")
logging.getLogger("mafsil").setLevel(logging.DEBUG)
made = make_polytope(3, 8, 16)
print(type(made).__name__, *(f"{name}:{x.shape}:{x.dtype}" for name, x in zip(made._fields, made, strict=True)))
"""


def test_loops_that_return_named_tuples_are_kept_too(tmp_path: Path) -> None:
    """They were compiled anew in every process: a second of each first question about a grasp."""
    done = [
        subprocess.run(
            [sys.executable, "-c", NAMED],
            env={**os.environ, "MAFSIL_CACHE": str(tmp_path)},
            capture_output=True, text=True, check=True, timeout=120,
        )
        for _ in range(2)
    ]  # fmt: skip
    assert done[0].stdout == done[1].stdout
    assert done[0].stdout.startswith("Polytope points:(8, 3):float64")
    assert "compiling make_polytope" in done[0].stderr
    assert done[1].stderr == ""


def test_a_named_tuple_of_strangers_is_not_looked_up() -> None:
    from mafsil.kernels.loops.kinds import named_kind

    for text in ("os:stat_result(float64)", "mafsil.solvers.hull_growth_loops:Ridges(float64)", "float65", "(int64"):
        with pytest.raises((KeyError, ValueError)):
            named_kind(text, {})
