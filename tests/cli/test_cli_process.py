"""The command as a process: jobs end to end, signals, pipes, no network, start-up time."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mafsil.cli.main import main

ROOT = Path(__file__).parents[2]
JOBS = sorted((ROOT / "examples" / "jobs").glob("*.toml"))
MAFSIL = [sys.executable, "-m", "mafsil.cli"]


def call(*words: str, **options: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*MAFSIL, *words], capture_output=True, text=True, timeout=120, check=False, **options)  # type: ignore[call-overload]


@pytest.mark.parametrize("job", JOBS, ids=lambda path: path.stem)
def test_examples_run_from_file_to_report(job: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In this process: what a process of its own adds is proved by the demo below, which is one of them."""
    assert main(["run", str(job), "--out", str(tmp_path / "out"), "--json"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    data = json.loads(printed.out)
    assert data["complete"]
    assert data == json.loads((tmp_path / "out" / "results.json").read_text("utf-8")) | {"report": data["report"]}
    assert Path(data["report"]).read_text("utf-8").startswith("<!doctype html>")


def test_the_demo_is_the_first_example(tmp_path: Path) -> None:
    done = call("demo", "--lang", "ar", "--progress", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert 'lang="ar" dir="rtl"' in (tmp_path / "mafsil-results" / "demo" / "report.html").read_text("utf-8")
    # The four stages; on a machine that is new, also a notice that loops are compiled.
    assert len([line for line in done.stderr.splitlines() if not line.startswith("mafsil: ")]) == 4
    shipped = (ROOT / "src" / "mafsil" / "cli" / "demo.toml").read_text("utf-8")
    assert shipped == (ROOT / "examples" / "jobs" / "pick_and_place_panda.toml").read_text("utf-8")


@pytest.mark.parametrize(
    ("old", "new", "code", "word"),
    [
        ('robot = "panda"', "", 2, "robot"),
        ("position = [0.48, -0.30, 0.32]", "position = [4.8, -0.30, 0.32]", 1, "above the part"),
        ("position = [0.48, -0.30, 0.32]", "position = [nan, -0.30, 0.32]", 2, "nan"),
        ('robot = "panda"', 'robot = "absent.urdf"', 2, "absent.urdf"),
    ],
)
def test_a_wrong_job_writes_nothing(tmp_path: Path, old: str, new: str, code: int, word: str) -> None:
    text = (ROOT / "examples" / "jobs" / "pick_and_place_panda.toml").read_text("utf-8")
    job = tmp_path / "job.toml"
    job.write_text(text.replace(old, new, 1), "utf-8")
    done = call("run", str(job), "--out", str(tmp_path / "out"))
    assert done.returncode == code, done.stderr
    assert word in done.stderr
    assert done.stderr.count("\n") == 1
    assert [item.name for item in tmp_path.iterdir()] == ["job.toml"]


BLOWS_UP = """
robot = "planar3r"
[controller]
kind = "pd_gravity"
kp = 1e9
kd = 1e6
[simulation]
step = 0.02
[[move]]
joints = [1.0, 0.5, -0.5]
"""


def test_a_run_that_blows_up_is_reported_and_is_a_no(tmp_path: Path) -> None:
    (tmp_path / "wild.toml").write_text(BLOWS_UP, "utf-8")
    done = call("run", str(tmp_path / "wild.toml"), "--out", str(tmp_path / "out"), "--json")
    assert done.returncode == 1
    assert "smaller step" in done.stderr
    data = json.loads(done.stdout)
    assert (data["complete"], data["verdict"]) == (False, "failure")
    assert (tmp_path / "out" / "report.html").exists()


@pytest.mark.row("K5")
def test_kill_9_in_the_middle_of_a_run(tmp_path: Path) -> None:
    out, job = tmp_path / "out", str(next(path for path in JOBS if path.stem == "pick_and_place_puma560"))
    for delay in (0.3, 0.8, 1.3, 1.8):
        child = subprocess.Popen([*MAFSIL, "run", job, "--out", str(out)], stdout=subprocess.DEVNULL)
        time.sleep(delay)
        child.send_signal(signal.SIGKILL)
        child.wait()
        if out.exists():
            json.loads((out / "results.json").read_text("utf-8"))
    assert call("run", job, "--out", str(out)).returncode == 0
    assert len(list(out.iterdir())) == 6


def test_ctrl_c_is_one_line(tmp_path: Path) -> None:
    """On a busy machine a run may be over before the signal comes, and says so; then another is tried."""
    for attempt in range(5):
        out = tmp_path / f"out{attempt}"
        # Jobs in the background are born with interrupts ignored, and so would be their children.
        inherited = signal.signal(signal.SIGINT, signal.SIG_DFL)
        child = subprocess.Popen(
            [*MAFSIL, "run", str(JOBS[0]), "--out", str(out), "--progress"],
            stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        signal.signal(signal.SIGINT, inherited)
        assert child.stderr is not None
        assert child.stderr.readline().strip()  # the first stage
        child.send_signal(signal.SIGINT)
        rest = child.stderr.read()
        child.wait(20)
        if "stopped" in rest:
            break
        # Python hands interrupts back to the system at the very end of its exit.
        assert (out / "results.json").exists(), "a run that ends well leaves its results"
    # Python remembers an interrupt that came while it ran the text of a class, and ends by it: to a shell both are 130.
    assert child.returncode in (130, -signal.SIGINT)
    assert rest.splitlines()[-1] == "mafsil: stopped by the user"
    assert "Traceback" not in rest
    assert not out.exists()


def test_a_reader_that_leaves_is_no_error() -> None:
    shell = f"set -o pipefail; '{sys.executable}' -m mafsil.cli show panda --json | head -c 10"
    done = subprocess.run(["bash", "-c", shell], capture_output=True, text=True, timeout=60, check=False)
    assert done.stderr == ""
    assert done.returncode == 0


def test_a_full_disk_is_one_sentence(tmp_path: Path) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full")
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [*MAFSIL, "fk", "planar2r", "0", "0"], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert done.returncode == 1
    assert done.stderr.startswith("mafsil: ")
    assert "Traceback" not in done.stderr


def test_ascii_terminals_get_something(tmp_path: Path) -> None:
    environment = os.environ | {"PYTHONIOENCODING": "ascii", "LC_ALL": "C"}
    done = call("fk", "panda", "0", "--lang", "ar", env=environment)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr


@pytest.mark.row("N2")
def test_everything_works_without_a_network(tmp_path: Path) -> None:
    unshare = shutil.which("unshare")
    if unshare is None or subprocess.run([unshare, "-rn", "true"], capture_output=True, check=False).returncode:
        pytest.skip("no network namespaces here")
    words = [unshare, "-rn", *MAFSIL, "demo", "--out", str(tmp_path / "out")]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr


def test_help_loads_nothing_heavy() -> None:
    code = "import sys; from mafsil.cli.main import main; main(['--help']); print([m for m in ('numpy', 'mafsil.expression', 'llvmlite', 'scipy', 'msgspec', 'matplotlib') if m in sys.modules])"  # noqa: E501
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize(
    "words",
    [
        "fk panda 0 -0.5 0 -2 0 1.5 0.7",
        "ik panda --pose 0.4 0 0.5 pi 0 0",
        "plan panda --start 0 -0.5 0 -2 0 1.5 0.7 --goal 0.6 0.2 0.1 -1.5 0.2 1.8 0.7",
    ],
)
def test_a_command_loads_only_what_it_uses(words: str) -> None:
    """Once the store holds what it needs: no compiler, no readers of robot files, no jobs, nothing of SciPy."""
    heavy = ["llvmlite.binding", "scipy", "msgspec", "matplotlib", "mafsil.job", "mafsil.model.file_reader"]
    code = f"""
import sys
from mafsil.cli.main import main
main(sys.argv[1:])
print([m for m in {heavy} if m in sys.modules])
"""
    for _ in range(2):
        done = subprocess.run([sys.executable, "-c", code, *words.split()], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_the_process_ends_after_what_was_left_to_do(tmp_path: Path) -> None:
    """Streams are flushed, threads waited for, functions that were to run at the end run; the code is the command's."""
    code = """
import atexit, sys, threading, time
from mafsil.cli import __main__ as program
atexit.register(lambda: print("the end"))
threading.Thread(target=lambda: (time.sleep(0.3), print("thread"))).start()
sys.stdout.write("begin ")
program.program()
"""
    done = subprocess.run([sys.executable, "-c", code, "fk", "nothing"], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stdout.split("\n") == ["begin thread", "the end", ""]
    assert done.stderr.startswith("mafsil: nothing")
