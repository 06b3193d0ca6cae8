"""The MJCF reader: bodies, hinges, slides, geometry, inertia, couplings; what it cannot keep it says."""

from __future__ import annotations

from dataclasses import replace
from pathlib import PurePosixPath

from mafsil.arrays import frozen
from mafsil.model.asset_path import Assets
from mafsil.model.faults import IGNORED_ELEMENT, NO_LINKS, NOT_KEPT, UNSUPPORTED, WRONG_ROOT
from mafsil.model.file_reader import Format
from mafsil.model.link import Link
from mafsil.model.mechanism import Mechanism
from mafsil.model.mimics import resolve_mimics
from mafsil.model.mjcf.body import read_tree
from mafsil.model.mjcf.coupling import read_actuators, read_couplings
from mafsil.model.mjcf.geom import Library
from mafsil.model.mjcf.include import Inclusion
from mafsil.model.mjcf.settings import Settings, read_settings
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Element, ReadLimits

_READ = ("compiler", "option", "default", "asset", "worldbody", "equality", "actuator")
_HARMLESS = ("size", "visual", "statistic", "sensor", "keyframe", "contact", "custom", "extension")


def _build(reading: Reading, assets: Assets, _source: str, limits: ReadLimits) -> Mechanism | None:
    root = reading.document.root
    if root.tag != "mujoco":
        reading.report(WRONG_ROOT, root, found=root.tag, expected="mujoco")
        return None
    Inclusion(reading, assets, limits).expand(root)
    _report_sections(reading, root)
    settings = read_settings(reading, root)
    worldbody = _worldbody(reading, root)
    if worldbody is None:
        return None
    tree = read_tree(reading, worldbody, _library(reading, root, settings, assets))
    declared, loops = read_couplings(reading, root, settings, tree)
    joints = read_actuators(reading, root, settings, resolve_mimics(reading, declared))
    if reading.failed:
        return None
    name = root.get("model").strip() or "mujoco"
    links = _scaled(tree.links, settings.total_mass)
    return Mechanism.assemble(name, links, joints, loops=loops, gravity=settings.gravity)


def _report_sections(reading: Reading, root: Element) -> None:
    for child in root.children:
        if child.tag == "deformable":
            reading.report(UNSUPPORTED, child, None, reading.remove(child), element=child.tag)
        elif child.tag == "tendon":
            reading.report(NOT_KEPT, child, element="mujoco", what="tendon")
        elif child.tag not in (*_READ, *_HARMLESS):
            reading.report(IGNORED_ELEMENT, child, element=child.tag)


def _worldbody(reading: Reading, root: Element) -> Element | None:
    """All `worldbody` sections as one."""
    found = root.all("worldbody")
    if not found or not any(section.children for section in found):
        reading.report(NO_LINKS, root)
        return None
    first = found[0]
    first.children = [child for section in found for child in section.children]
    return first


def _library(reading: Reading, root: Element, settings: Settings, assets: Assets) -> Library:
    meshes: dict[str, Element] = {}
    materials: dict[str, Element] = {}
    for section in root.all("asset"):
        for child in section.children:
            element = settings.styled(reading, child, "")
            if child.tag == "mesh":
                meshes[element.get("name") or PurePosixPath(element.get("file")).stem] = element
            elif child.tag == "material":
                materials[element.get("name")] = element
    return Library(settings, assets, meshes, materials)


def _scaled(links: list[Link], total: float) -> list[Link]:
    """The links with masses and inertias scaled so that the masses add up to `total`, if that is positive."""
    mass = sum(link.inertial.mass for link in links if link.inertial is not None)
    if total <= 0.0 or mass <= 0.0:
        return links
    factor = total / mass
    return [
        link
        if link.inertial is None
        else replace(
            link,
            inertial=replace(
                link.inertial, mass=link.inertial.mass * factor, inertia=frozen(link.inertial.inertia * factor)
            ),
        )
        for link in links
    ]


MJCF = Format(_build)
read, diagnose, repair, file_reader = MJCF.read, MJCF.diagnose, MJCF.repair, MJCF.reader
