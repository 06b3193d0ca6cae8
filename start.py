"""Everything from a bare Python: makes .venv, installs mafsil into it, then runs the main job or the tests.

    python3 start.py run [arguments of `mafsil`]     the demo, or any command
    python3 start.py test [arguments of pytest]      all tests

Works on a fresh Debian machine where only python3 is installed: pip is found, or fetched from the package index, or
brought in by apt. What a command needs is compiled at its first use; `start.py run info --build` compiles all ahead.
"""

from __future__ import annotations

import hashlib
import io
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import threading
import time
import venv
from pathlib import Path
from zipfile import ZipFile

ROOT = Path(__file__).resolve().parent
HOME = ROOT / ".venv"
PYTHON = HOME / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
ALL_TESTS = ["-n", "auto", "--maxprocesses", "8", "--dist", "loadfile", "--no-loadscope-reorder"]
"""On all cores, in the order of the files: else the files of few tests would come last, and among them the longest."""
PROGRAMS = {"node": ("node", "nodejs"), "chromium": ("chromium", "chromium-browser", "google-chrome")}
"""What the tests of pages run, and the names under which it is found."""
PACKAGES = {"node": "nodejs", "chromium": "chromium"}
"""Debian's packages of them."""


def main(arguments: list[str]) -> int:
    """Set up for the wanted verb and hand over to it."""
    if not arguments or arguments[0] not in ("run", "test"):
        print(__doc__)
        return 2
    if sys.version_info < (3, 11):  # noqa: UP036 - this file alone may meet an older Python
        print(f"mafsil needs Python 3.11 or newer; {sys.executable} is {sys.version.split()[0]}", file=sys.stderr)
        return 1
    verb, rest = arguments[0], arguments[1:]
    set_up(extras(verb, rest))
    if verb == "test":
        bring_programs()
        command, folder = ["-m", "pytest", *(rest or ALL_TESTS)], ROOT
    else:
        command, folder = ["-m", "mafsil.cli.main", *(rest or ["demo"])], None
    return subprocess.run([str(PYTHON), *command], cwd=folder, check=False).returncode


def extras(verb: str, rest: list[str]) -> str:
    """The optional dependencies that a command needs: Matplotlib only where a picture is asked for."""
    if verb == "test":
        return "plots,test"
    return "plots" if any(word.startswith("--pic") for word in rest) else ""


def set_up(extras: str) -> None:
    """An environment with mafsil and the given extras; does nothing when it already stands as asked."""
    stamp = HOME / f"ready-{extras.replace(',', '-') or 'run'}"
    wanted = hashlib.sha256((ROOT / "pyproject.toml").read_bytes()).hexdigest()
    if stamp.exists() and stamp.read_text() == wanted and PYTHON.exists():
        return
    if not PYTHON.exists():
        venv.EnvBuilder(with_pip=False, symlinks=os.name != "nt").create(HOME)
    install(f"{ROOT}[{extras}]" if extras else str(ROOT))
    stamp.write_text(wanted)


def install(project: str) -> None:
    """Install the project, editable, with what it needs; stops with pip's exit code and output where that fails."""
    # Packages are compiled to bytecode as they are imported: most of their modules never are.
    lazily = [] if sys.dont_write_bytecode else ["--no-compile"]
    options = [*lazily, "--prefer-binary", "--progress-bar=off", "--disable-pip-version-check", "--no-input"]
    process = subprocess.Popen(
        [*pip(), "install", *options, "pip", "--editable", project],
        env=os.environ | {"PIP_COMPILE": str(int(sys.dont_write_bytecode))},  # of the environment that builds, too
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
    )
    output: list[str] = []
    reader = threading.Thread(target=read, args=(process.stdout, output))
    reader.start()
    follow(reader, output)
    code = process.wait()
    if code:
        print("".join(output), file=sys.stderr)
        raise SystemExit(code)


def read(stream: io.TextIOBase, lines: list[str]) -> None:
    """Collect the lines of a stream until it ends."""
    for line in stream:
        lines.append(line)


def follow(reader: threading.Thread, output: list[str]) -> None:
    """Show on one line what pip does, how far it is and the seconds; without a terminal, one line before and after."""
    began, watched = time.monotonic(), sys.stderr.isatty()
    if not watched:
        print("setting up .venv (once)", file=sys.stderr, flush=True)
    while reader.is_alive():
        reader.join(0.5)
        if watched:
            text = f"setting up .venv: {step(output)}, {time.monotonic() - began:.0f} s"
            print(f"\r\x1b[K{text[: shutil.get_terminal_size().columns - 1]}", end="", file=sys.stderr, flush=True)
    end = "\r\x1b[K" if watched else ""
    print(f"{end}set up .venv in {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)


def step(output: list[str]) -> str:
    """What pip's output says that it does."""
    line = output[-1].strip() if output else ""
    if found := re.match(r"Installing collected packages: (.*)", line):
        wanted = len(found[1].split(","))
        done = sum(1 for _ in site_packages().glob("*.dist-info"))
        return f"unpacking, {min(done, wanted)} of {wanted} packages"
    if found := re.match(r"(?:Downloading|Using cached) (?:\S*/)?([^-\s]+)\S*( \(.*\))?", line):
        return f"downloading {found[1]}{found[2] or ''}"
    if found := re.match(r"Collecting ([\w.-]+)", line):
        return f"looking up {found[1]}"
    return "preparing mafsil"


def site_packages() -> Path:
    """Where the environment keeps its packages."""
    return Path(sysconfig.get_path("purelib", "venv", {"base": str(HOME), "platbase": str(HOME)}))


def bring_programs() -> None:
    """Node.js and Chromium from Debian where they are missing and this may install; else their tests say what lacks."""
    missing = [PACKAGES[name] for name, known in PROGRAMS.items() if not any(map(shutil.which, known))]
    if not missing or not may_use_apt():
        return
    print(f"installing {' and '.join(missing)} (once; the tests of pages run in them)", file=sys.stderr, flush=True)
    works(["apt-get", "update", "-qq"])
    works(["apt-get", "install", "-y", "-qq", "--no-install-recommends", *missing])


def may_use_apt() -> bool:
    """Whether this is a Debian on which we may install packages."""
    return bool(shutil.which("apt-get")) and os.geteuid() == 0


def pip() -> list[str]:
    """A pip for the environment: its own, the system's, one from the package index, or Debian's."""
    own = [str(PYTHON), "-m", "pip"]
    system = [sys.executable, "-m", "pip", "--python", str(PYTHON)]
    for known in (own, system):
        if works([*known, "--version"]):
            return known
    reason = fetch_pip()
    if not reason or works([str(PYTHON), "-m", "ensurepip", "--default-pip"]):
        return own
    if may_use_apt():
        works(["apt-get", "update", "-qq"])
        works(["apt-get", "install", "-y", "-qq", "python3-venv"])
        if works([str(PYTHON), "-m", "ensurepip", "--default-pip"]):
            return own
    raise SystemExit(
        f"{sys.executable} has no pip, and it could not be fetched ({reason}); "
        "install pip (on Debian: apt install python3-venv) or connect to the network, then try again"
    )


def fetch_pip() -> str:
    """Unpack pip's wheel from the package index into the environment; otherwise why that was not possible."""
    import json
    import urllib.parse
    import urllib.request

    index = "https://pypi.org/pypi/pip/json"
    try:
        with urllib.request.urlopen(index, timeout=60) as answer:
            files = json.load(answer)["urls"]
        wheel = next(file for file in files if file["packagetype"] == "bdist_wheel")
        with urllib.request.urlopen(urllib.parse.urljoin(index, wheel["url"]), timeout=60) as answer:
            content = answer.read()
    except (OSError, ValueError, LookupError, StopIteration) as error:
        return f"{index}: {error}"
    if hashlib.sha256(content).hexdigest() != wheel["digests"]["sha256"]:
        return f"{wheel['url']} does not match its checksum"
    ZipFile(io.BytesIO(content)).extractall(site_packages())
    return ""


def works(command: list[str]) -> bool:
    """Whether the command could be run and succeeded; its output is not shown."""
    try:
        return subprocess.run(command, capture_output=True, check=False).returncode == 0
    except OSError:
        return False


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
