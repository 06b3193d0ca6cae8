"""The strict URDF reader: finds everything wrong in one pass, says where, and changes nothing silently."""

from __future__ import annotations

from pathlib import Path

from mafsil.model.asset_path import Assets
from mafsil.model.audit import audit
from mafsil.model.faults import NAMELESS_ROBOT, WRONG_ROOT, XACRO_LEFT_OVER
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
from mafsil.model.urdf.vocabulary import URDF as VOCABULARY
from mafsil.model.urdf.vocabulary import version_of
from mafsil.model.vocabulary import Version
from mafsil.model.xacro import expanded, is_xacro, left_over
from mafsil.model.xml_tree import Element, ReadLimits


def _build(reading: Reading, assets: Assets, source: str, limits: ReadLimits) -> Mechanism | None:
    root = reading.document.root
    if root.tag != "robot":
        reading.report(WRONG_ROOT, root, found=root.tag, expected="robot")
        return None
    robot = _plain(reading, assets, limits)
    if robot is None:
        return None
    version = version_of(reading, robot)
    audit(reading, robot, VOCABULARY, version)
    name = robot.get("name").strip()
    if not name:
        reading.report(NAMELESS_ROBOT, robot)
        name = Path(source).name.split(".")[0] if source != "<text>" else "robot"
    links, joints = _read_parts(reading, robot, assets, version)
    return None if reading.failed else Mechanism.assemble(name, [declared.link for declared in links], joints)


def _read_parts(
    reading: Reading, robot: Element, assets: Assets, version: Version
) -> tuple[list[DeclaredLink], list[Joint]]:
    materials = Materials.collect(reading, robot)
    links = [
        DeclaredLink(link, element)
        for element in robot.all("link")
        if (link := read_link(reading, element, materials, assets)) is not None
    ]
    carried = frozenset(end.get("link") for joint in robot.all("joint") for end in joint.all("child")[:1])
    read = (read_joint(reading, element, carried, version) for element in robot.all("joint"))
    declared = [joint for joint in read if joint is not None]
    check_links(reading, robot, links)
    check_joints(reading, robot, links, declared)
    joints = read_transmissions(reading, robot, resolve_mimics(reading, declared))
    return links, joints


def _plain(reading: Reading, assets: Assets, limits: ReadLimits) -> Element | None:
    """The robot without any xacro: what is left over in a finished file ignored, everything else expanded."""
    root = reading.document.root
    if not is_xacro(root):
        return root
    rests = [] if reading.arguments else left_over(root)
    gone = frozenset(rests)
    for element in rests:
        reading.report(XACRO_LEFT_OVER, element, None, reading.remove(element), element=element.tag)
    if rests:
        for element in root.walk():
            element.children = [child for child in element.children if child not in gone]
        return root
    return expanded(reading, assets, limits)


URDF = Format(_build)
read, diagnose, repair, file_reader = URDF.read, URDF.diagnose, URDF.repair, URDF.reader
