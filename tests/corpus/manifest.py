"""Which files, of which commit of which repository, with digest and licence; none of them is copied into this one.

`manifest.jsonl` holds a line for each repository and, below it, a line for each of its robot files. Facts decide what
counts as a robot: a xacro file is one if ROS's xacro expands it without an error, with the arguments that its maker's
launch files give, into a document with links; parts of which a joint hangs on a link that they do not hold are none.
Files that are no XML, and worlds without a robot, stay in the count.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from xml.etree import ElementTree

MANIFEST = Path(__file__).parent / "manifest.jsonl"
FORMATS = ("urdf", "xacro", "mjcf", "sdf")
_ROOTS = {b"robot": "urdf", b"mujoco": "mjcf", b"sdf": "sdf"}
_DIRECTIVES = ("include", "macro", "property", "arg", "if", "unless", "insert_block", "element", "attribute")
_FIND = re.compile(r"\$\(find ([\w.-]+)\)")
_ROOT = re.compile(rb"<([A-Za-z_][\w.:-]*)[\s/>]")
_COMMENT = re.compile(rb"<!--.*?-->|<\?.*?\?>|<!DOCTYPE[^>]*>", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Repository:
    """A public repository at one commit.

    Attributes:
        repository: owner/name at GitHub.
        commit: full hash.
        licence: kind, as its licence file says.
        kind: `maker` of the robots, `peer` (another toolkit) or `collection`.
    """

    repository: str
    commit: str
    licence: str
    kind: str

    @property
    def folder(self) -> str:
        """Its name as a folder."""
        return self.repository.replace("/", "+")


@dataclass(frozen=True, slots=True)
class RobotFile:
    """A robot file of a repository.

    Attributes:
        path: in the repository.
        sha256: of its bytes.
        format: one of FORMATS.
        arguments: that a xacro file needs; `$(find package)` in them is a folder of the workspace.
        no_robot: why it is no robot by itself, or empty.
    """

    path: str
    sha256: str
    format: str
    arguments: dict[str, str] = field(default_factory=dict[str, str])
    no_robot: str = ""

    def arguments_in(self, workspace: Path) -> dict[str, str]:
        """The arguments with the folders of their packages."""
        return {
            name: _FIND.sub(lambda found: str((workspace / found[1]).resolve()), text)
            for name, text in self.arguments.items()
        }

    def line(self) -> str:
        """For the manifest; what is empty is left out."""
        return json.dumps({name: value for name, value in asdict(self).items() if value})


def read(path: Path = MANIFEST) -> Iterator[tuple[Repository, RobotFile]]:
    """All files with their repositories."""
    repository: Repository | None = None
    for line in path.read_text("utf-8").splitlines():
        row = json.loads(line)
        if "repository" in row:
            repository = Repository(**row)
        elif repository is not None:
            yield repository, RobotFile(**row)


def write(rows: Iterable[tuple[Repository, list[RobotFile]]], path: Path = MANIFEST) -> None:
    """A manifest of repositories with their files."""
    lines: list[str] = []
    for repository, files in rows:
        lines.append(json.dumps(asdict(repository)))
        lines += [file.line() for file in sorted(files, key=lambda file: file.path)]
    path.write_text("\n".join(lines) + "\n", "utf-8")


def missing_link(document: str | bytes) -> str:
    """Why a URDF document is only a part of a robot: a joint connects a link that it does not hold; or nothing."""
    try:
        root = ElementTree.fromstring(document)
    except ElementTree.ParseError:
        return ""
    for element in root.iter():
        element.tag = str(element.tag).rpartition("}")[2]
    if root.find("include") is not None:
        return ""
    links = {link.get("name") for link in root.findall("link")}
    if not links:
        return "holds no links"
    ends = [end.get("link") for joint in root.findall("joint") for end in (*joint.iter("parent"), *joint.iter("child"))]
    return next((f"a part: link {end} is elsewhere" for end in ends if end not in links), "")


def digest(data: bytes) -> str:
    """SHA-256 in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


def _is_robot(data: bytes) -> bool:
    """Whether a xacro file makes links outside of its macros."""
    try:
        root = ElementTree.fromstring(data)
    except ElementTree.ParseError:
        return False
    waiting = [root]
    while waiting:
        for child in waiting.pop():
            name = str(child.tag).rpartition("}")[2]
            if name == "link" or (child.tag != name and name not in _DIRECTIVES):
                return "name" in root.attrib
            if name in ("if", "unless"):
                waiting.append(child)
    return False


def format_of(path: str, data: bytes) -> str | None:
    """The robot format of a file by its name and its root element, or None if it describes no robot.

    Xacro files count when they stand for a robot: a named root that holds links or calls macros itself; files that only
    define macros are parts. MJCF files count when they hold bodies or include files that may. A thousand random
    objects of Bullet are left out.
    """
    root = _ROOT.search(_COMMENT.sub(b"", data[:20_000]))
    kind = None if root is None else _ROOTS.get(root[1])
    if "random_urdfs/" in path:
        return None
    if path.lower().endswith(".xacro"):
        return "xacro" if kind == "urdf" and _is_robot(data) else None
    if kind == "urdf":
        return "urdf" if b"<link" in data else None
    if kind == "mjcf":
        return "mjcf" if b"<worldbody" in data or b"<include" in data else None
    return kind
