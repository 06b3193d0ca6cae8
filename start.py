"""Everything from a bare Python: makes .venv, installs mafsil into it, then runs the main job or the tests.

    python3 start.py run [arguments of `mafsil`]     the demo, or any command
    python3 start.py test [arguments of pytest]      all tests

Works on a fresh Debian machine where only python3 is installed: pip is found, or brought in by apt or from the package
index that pip is configured for.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent
HOME = ROOT / ".venv"
PYTHON = HOME / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
EXTRAS = {"run": "plots", "test": "plots,test"}
PROGRAMS = {"node": ("node", "nodejs"), "chromium": ("chromium", "chromium-browser", "google-chrome")}
"""What the tests of pages run, and the names under which it is found."""
PACKAGES = {"node": "nodejs", "chromium": "chromium"}
"""Debian's packages of them."""


def main(arguments: list[str]) -> int:
    """Set up for the wanted verb and hand over to it."""
    if not arguments or arguments[0] not in EXTRAS:
        print(__doc__)
        return 2
    if sys.version_info < (3, 11):  # noqa: UP036 - this file alone may meet an older Python
        print(f"mafsil needs Python 3.11 or newer; {sys.executable} is {sys.version.split()[0]}", file=sys.stderr)
        return 1
    verb, rest = arguments[0], arguments[1:]
    set_up(EXTRAS[verb])
    if verb == "test":
        bring_programs()
    command = ["-m", "mafsil.cli.main", *(rest or ["demo"])] if verb == "run" else ["-m", "pytest", *rest]
    return subprocess.run([str(PYTHON), *command], cwd=None if verb == "run" else ROOT, check=False).returncode


def set_up(extras: str) -> None:
    """An environment with mafsil and the given extras; does nothing when it already stands as asked."""
    stamp = HOME / f"ready-{extras.replace(',', '-')}"
    wanted = hashlib.sha256((ROOT / "pyproject.toml").read_bytes()).hexdigest()
    if stamp.exists() and stamp.read_text() == wanted and PYTHON.exists():
        return
    print("setting up .venv (once; a few minutes)", file=sys.stderr, flush=True)
    if not PYTHON.exists():
        venv.EnvBuilder(with_pip=False, symlinks=os.name != "nt").create(HOME)
    bring_pip()
    run([str(PYTHON), "-m", "pip", "install", "--quiet", "--editable", f"{ROOT}[{extras}]"])
    print("compiling what knows no robot (once; about a minute)", file=sys.stderr, flush=True)
    works([str(PYTHON), "-m", "mafsil.cli.main", "doctor", "--build"])  # without it, a first question takes longer
    stamp.write_text(wanted)


def bring_programs() -> None:
    """Node.js and Chromium from Debian where they are missing and this may install; else their tests say what lacks."""
    missing = [PACKAGES[name] for name, known in PROGRAMS.items() if not any(map(shutil.which, known))]
    if not missing or not shutil.which("apt-get") or os.geteuid() != 0:
        return
    print(f"installing {' and '.join(missing)} (once; the tests of pages run in them)", file=sys.stderr, flush=True)
    works(["apt-get", "update", "-qq"])
    works(["apt-get", "install", "-y", "-qq", "--no-install-recommends", *missing])


def bring_pip() -> None:
    """Pip for the environment: Python's own copy, the system's pip, apt's packages, or the wheel from the index."""
    if works([str(PYTHON), "-m", "pip", "--version"]):
        return
    if works([str(PYTHON), "-m", "ensurepip", "--default-pip"]):
        return
    if works([sys.executable, "-m", "pip", "--python", str(PYTHON), "install", "--quiet", "pip"]):
        return
    if shutil.which("apt-get") and os.geteuid() == 0:
        works(["apt-get", "update", "-qq"])
        works(["apt-get", "install", "-y", "-qq", "python3-venv"])
        if works([str(PYTHON), "-m", "ensurepip", "--default-pip"]):
            return
    pip_from_index()


def pip_from_index() -> None:
    """Install pip by running its own wheel, fetched from the package index."""
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
        raise SystemExit(
            f"{sys.executable} has no pip, and it could not be fetched from {index} ({error}); "
            "install pip (on Debian: apt install python3-venv) or connect to the network, then try again"
        ) from None
    if hashlib.sha256(content).hexdigest() != wheel["digests"]["sha256"]:
        raise SystemExit("the pip wheel from the package index does not match its checksum; try again")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / wheel["filename"]
        path.write_bytes(content)
        run([str(PYTHON), str(path / "pip"), "install", "--quiet", str(path)])


def works(command: list[str]) -> bool:
    """Whether the command could be run and succeeded; its output is not shown."""
    try:
        return subprocess.run(command, capture_output=True, check=False).returncode == 0
    except OSError:
        return False


def run(command: list[str]) -> None:
    """Run the command or stop with its exit code; pip has already said why."""
    code = subprocess.run(command, check=False).returncode
    if code:
        raise SystemExit(code)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
