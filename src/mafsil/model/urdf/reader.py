"""The strict URDF reader: finds everything wrong in one pass, says where, and changes nothing silently."""

from __future__ import annotations

from pathlib import Path

from mafsil.model.asset_path import Assets
from mafsil.model.faults import IGNORED_ELEMENT, NAMELESS_ROBOT, UNEXPANDED_XACRO, WRONG_ROOT
from mafsil.model.file_reader import Format
from mafsil.model.joint import Joint
from mafsil.model.mechanism import Mechanism
from mafsil.model.mimics import resolve_mimics
from mafsil.model.reading import Reading
from mafsil.model.urdf.joint import read_joint
from mafsil.model.urdf.link import read_link
from mafsil.model.urdf.shape import Materials
from mafsil.model.urdf.structure import DeclaredLink, check_joints, check_links
from mafsil.model.urdf.transmission import read_transmissions
from mafsil.model.xml_tree import ReadLimits

_PARTS = ("link", "joint", "material", "transmission")
_IGNORED = ("gazebo", "ros2_control", "sensor", "verbose", "loop_joint")


def _build(reading: Reading, assets: Assets, source: str, _limits: ReadLimits) -> Mechanism | None:
    robot = reading.document.root
    if _is_foreign(reading):
        return None
    for child in robot.children:
        if child.tag not in (*_PARTS, *_IGNORED):
            reading.report(IGNORED_ELEMENT, child, element=child.tag)
    name = robot.get("name").strip()
    if not name:
        reading.report(NAMELESS_ROBOT, robot)
        name = Path(source).stem if source != "<text>" else "robot"
    links, joints = _read_parts(reading, assets)
    return None if reading.failed else Mechanism.assemble(name, [declared.link for declared in links], joints)


def _read_parts(reading: Reading, assets: Assets) -> tuple[list[DeclaredLink], list[Joint]]:
    robot = reading.document.root
    materials = Materials.collect(reading, robot)
    links = [
        DeclaredLink(link, element)
        for element in robot.all("link")
        if (link := read_link(reading, element, materials, assets)) is not None
    ]
    declared = [read for element in robot.all("joint") if (read := read_joint(reading, element)) is not None]
    check_links(reading, robot, links)
    check_joints(reading, robot, links, declared)
    joints = read_transmissions(reading, robot, resolve_mimics(reading, declared))
    return links, joints


def _is_foreign(reading: Reading) -> bool:
    """Whether the document is no finished URDF: another root, or a xacro that was not expanded."""
    root = reading.document.root
    if root.tag != "robot":
        reading.report(WRONG_ROOT, root, found=root.tag, expected="robot")
        return True
    for element in root.walk():
        macro = element.tag.startswith("xacro:")
        if macro or any("${" in value or "$(" in value for value in element.attributes.values()):
            if macro or element.tag != "plugin":
                reading.report(UNEXPANDED_XACRO, element)
                return True
    return False


URDF = Format(_build)
read, diagnose, repair, file_reader = URDF.read, URDF.diagnose, URDF.repair, URDF.reader
