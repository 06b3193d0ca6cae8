"""Repositories at their commits: cloned into a cache folder, or taken from a folder of git directories.

Their ROS packages are laid out as workspaces, one for each repository: its own packages over those of the makers.
"""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from tests.corpus.manifest import Repository

NEEDED = (
    ".xml", ".urdf", ".xacro", ".sdf", ".world", ".mjcf", ".inc", ".yaml", ".yml", ".stl", ".obj", ".msh", ".dae",
    ".png", ".gazebo", "license", "license.txt", "license.md", "setup.py", "pyproject.toml", "__init__.py",
)  # fmt: skip
"""Ends of the names of files that a robot may be made of, or that say where a package begins."""
_DONE = ".complete"
_PACKAGE = re.compile(rb"<name>\s*([\w.-]+)\s*</name>")


def checked_out(repository: Repository, cache: Path, mirror: Path | None) -> Path:
    """The folder that holds the needed files of a repository at its commit.

    Args:
        repository: which.
        cache: where folders are kept.
        mirror: holds git directories named owner+name (itself, or `repo` or `repo/.git` in it); None clones from
            GitHub.
    """
    place = cache / f"{repository.folder}@{repository.commit[:12]}"
    if not (place / _DONE).exists():
        place.mkdir(parents=True, exist_ok=True)
        source = _cloned(repository, cache) if mirror is None else git_directory(mirror / repository.folder)
        for path, data in blobs(source, repository.commit):
            if path.lower().endswith(NEEDED):
                target = place / path
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(data)
        (place / _DONE).touch()
    return place


def workspace(repository: Repository, places: Mapping[Repository, Path], cache: Path) -> Path:
    """A folder with a link to each ROS package by its name, for ROS_PACKAGE_PATH: what a robot of the repository finds.

    A package of the repository itself goes before one of the same name of a maker, and that one before others.
    """
    folder = cache / "workspaces" / repository.folder
    folder.mkdir(parents=True, exist_ok=True)
    rank = sorted(places, key=lambda other: (other != repository, other.kind != "maker"))
    for other in rank:
        for name, package in _packages(places[other]):
            if not (folder / name).is_symlink():
                (folder / name).symlink_to(package)
    return folder


def _packages(place: Path) -> Iterable[tuple[str, Path]]:
    """Name and folder of every ROS package below a folder, the outermost first."""
    for path in sorted(place.rglob("package.xml"), key=lambda path: (len(path.parts), path)):
        found = _PACKAGE.search(path.read_bytes())
        if found is not None:
            yield found[1].decode(), path.parent


def git_directory(folder: Path) -> Path:
    """The git directory in a folder of a mirror."""
    return next(
        place for place in (folder / "repo" / ".git", folder / "repo", folder / ".git", folder) if place.exists()
    )


def head_of(source: Path) -> str:
    """The commit that a git directory stands at."""
    command = ["git", "-c", "safe.directory=*", f"--git-dir={source}", "rev-parse", "HEAD"]
    return subprocess.run(command, capture_output=True, check=True, text=True).stdout.strip()


def blobs(source: Path, commit: str) -> Iterator[tuple[str, bytes]]:
    """Path and bytes of every needed file of a commit; files that a partial mirror lacks are left out."""
    git = ["git", "-c", "safe.directory=*", f"--git-dir={source}"]
    listed = subprocess.run([*git, "ls-tree", "-r", "-z", commit], capture_output=True, check=True).stdout
    rows = [row.partition(b"\t") for row in listed.split(b"\0") if row]
    wanted = [(meta.split()[2], path.decode("utf-8", "replace")) for meta, _, path in rows if meta.startswith(b"100")]
    environment = {**os.environ, "GIT_NO_LAZY_FETCH": "1"}
    with subprocess.Popen(
        [*git, "cat-file", "--batch"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        for name, path in wanted:
            if not path.lower().endswith(NEEDED):
                continue
            process.stdin.write(name + b"\n")
            process.stdin.flush()
            header = process.stdout.readline().split()
            if header[1] != b"missing":
                data = process.stdout.read(int(header[2]) + 1)[:-1]
                yield path, data
        process.stdin.close()


def _cloned(repository: Repository, cache: Path) -> Path:
    folder = cache / "git" / repository.folder
    if not folder.exists():
        address = f"https://github.com/{repository.repository}"
        subprocess.run(["git", "init", "--bare", "-q", str(folder)], check=True)
        fetch = ["git", f"--git-dir={folder}", "fetch", "-q", "--depth=1", address, repository.commit]
        subprocess.run(fetch, check=True)
    return folder
