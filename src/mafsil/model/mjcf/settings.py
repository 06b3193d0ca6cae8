"""What an MJCF file says once for all, how it writes rotations, and every element and attribute of the format.

Said once: compiler settings, default classes, gravity. The vocabulary (`vocabulary.toml`) is the rule of the reader:
what stands in it as read is read, what it does not know is an error.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import pi

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, frozen
from mafsil.model.faults import (
    MISSING_ATTRIBUTE,
    NO_ROTATION,
    NOT_KEPT,
    UNKNOWN_ATTRIBUTE,
    UNKNOWN_CHOICE,
    UNKNOWN_CLASS,
    UNKNOWN_PART,
    UNSUPPORTED,
)
from mafsil.model.inertia_check import STAND_IN
from mafsil.model.mechanism import STANDARD_GRAVITY
from mafsil.model.placement import (
    frame_along,
    rotation_from_quaternion,
    rotation_x,
    rotation_y,
    rotation_z,
    screw_motion,
)
from mafsil.model.reading import Reading
from mafsil.model.tolerances import NO_LENGTH
from mafsil.model.vocabulary import Row, Vocabulary, read_rows
from mafsil.model.xml_tree import Element

_TURN = "quat axisangle euler xyaxes zaxis"
ROWS = read_rows(__file__)
"""What becomes of everything that a file may hold, by the element and, where a tag means several things, its parent."""
MOTORS = tuple(ROWS["actuator"].children.split())
"""Elements of `actuator`; all have the row of `motor`."""
NUMBERS = frozenset(
    f"{_TURN} pos size fromto rgba mass density diaginertia fullinertia axis range ref armature damping frictionloss "
    "actuatorfrcrange group contype conaffinity fitscale shellinertia scale refpos refquat gear forcerange ctrlrange "
    "polycoef anchor relpose coef gravity count offset sep boundmass boundinertia settotalmass inertiagrouprange "
    "vertex face".split()
)
"""Attributes of numbers that are read: MuJoCo takes an empty one as not given."""
_CLASS_ROWS = {
    "joint": "body/joint",
    "geom": "body/geom",
    "mesh": "asset/mesh",
    "material": "asset/material",
    "equality": "default/equality",
    "tendon": "default/tendon",
    "site": "body/site",
}
MAIN = "main"
_LISTS = frozenset({"size", "damping", "gear", "stiffness"})
"""Attributes of which a file may give only the first numbers."""
_STYLED = ("joint", "geom", "mesh", "material", "equality", "tendon", "site")


@dataclass(slots=True)
class Settings:
    """Compiler settings that bear on the mechanism.

    Attributes:
        degree: factor from the file's angles to radians.
        eulerseq: axes of `euler`, lower case intrinsic, upper case extrinsic.
        autolimits: a range alone limits.
        inertiafromgeom: `auto`, `true` or `false`.
        groups: lowest and highest geometry group that gives mass.
        bound_mass, bound_inertia: least mass [kg] and moment [kg m^2] of a body.
        balance: make moments that violate the triangle inequality equal.
        total_mass: scale all masses to this sum [kg] if positive.
        mesh_folder: where mesh files lie, relative to the model.
        strip_path: mesh files are named without their folders.
        fit_box: shapes fitted to a mesh take its bounding box, not its inertia.
        gravity: [m/s^2].
        off: the flags that the file disables, such as `damper`.
        classes: attributes of each tag in each default class.
    """

    degree: float = pi / 180
    eulerseq: str = "xyz"
    autolimits: bool = True
    inertiafromgeom: str = "auto"
    groups: tuple[float, float] = (0, 5)
    bound_mass: float = 0.0
    bound_inertia: float = 0.0
    balance: bool = False
    total_mass: float = -1.0
    mesh_folder: str = ""
    strip_path: bool = False
    fit_box: bool = False
    off: frozenset[str] = frozenset()
    gravity: tuple[float, float, float] = STANDARD_GRAVITY
    classes: dict[str, dict[str, dict[str, str]]] = field(default_factory=dict[str, dict[str, dict[str, str]]])

    def apply_defaults(self, reading: Reading, element: Element, childclass: str, style: str = "") -> Element:
        """The element with the attributes of its default class filled in; its own ones win.

        Args:
            reading, element: where it stands.
            childclass: the class in force there if the element names none.
            style: the defaults it takes, if those are not named like itself.
        """
        name = element.get("class") or childclass or MAIN
        if name not in self.classes and name != MAIN:
            reading.report(UNKNOWN_CLASS, element, "class", name=name)
            return element
        inherited = self.classes.get(name, {}).get(style or _style(element.tag), {})
        return replace(element, attributes=overlay(inherited, element.attributes)) if inherited else element


def read_settings(reading: Reading, root: Element) -> Settings:
    """Settings of all `compiler`, `option` and `default` elements, later ones over earlier ones."""
    settings = Settings()
    for element in root.all("compiler"):
        _read_compiler(reading, element, settings)
    for element in root.all("option"):
        gravity = reading.vector(element, "gravity", 3, settings.gravity)
        if gravity is not None:
            settings.gravity = (gravity[0], gravity[1], gravity[2])
        for flags in element.all("flag"):
            _read_flags(reading, flags, settings)
    if "gravity" in settings.off:
        settings.gravity = (0.0, 0.0, 0.0)
    for element in root.all("default"):
        _read_class(reading, element, {}, settings, element.get("class", MAIN))
    return settings


def overlay(inherited: Mapping[str, str], own: Mapping[str, str]) -> dict[str, str]:
    """Attributes over those of a class; of a list that may be shorter, the rest stays as the class has it."""
    merged = {**inherited, **own}
    for name in _LISTS.intersection(inherited).intersection(own):
        words = own[name].split()
        merged[name] = " ".join(words + inherited[name].split()[len(words) :])
    return merged


def choice(reading: Reading, element: Element, attribute: str, known: tuple[str, ...], default: str) -> str:
    """One of a few words."""
    word = element.get(attribute, default)
    if word in known:
        return word
    repair = reading.set_attribute(element, attribute, default)
    reading.report(
        UNKNOWN_CHOICE, element, attribute, repair,
        element=element.tag, attribute=attribute, text=word, known=", ".join(known),
    )  # fmt: skip
    return default


def _read_flags(reading: Reading, element: Element, settings: Settings) -> None:
    """The flags that take something out of the mechanism; without constraints no couplings, no dry friction."""
    for flag in ("gravity", "damper", "frictionloss", "equality", "limit", "constraint"):
        if choice(reading, element, flag, ("enable", "disable"), "enable") == "disable":
            settings.off |= {flag}
            if flag == "limit":
                reading.report(NOT_KEPT, element, flag, element="flag", what='limit="disable"')
        elif flag in element.attributes:
            settings.off -= {flag}
    if "constraint" in settings.off:
        settings.off |= {"equality", "frictionloss"}


def _read_compiler(reading: Reading, element: Element, settings: Settings) -> None:
    now = "radian" if settings.degree == 1.0 else "degree"
    settings.degree = 1.0 if choice(reading, element, "angle", ("degree", "radian"), now) == "radian" else pi / 180
    flags = ("true", "false")
    settings.autolimits = choice(reading, element, "autolimits", flags, str(settings.autolimits).lower()) == "true"
    settings.balance = choice(reading, element, "balanceinertia", flags, str(settings.balance).lower()) == "true"
    settings.inertiafromgeom = choice(reading, element, "inertiafromgeom", (*flags, "auto"), settings.inertiafromgeom)
    sequence = element.get("eulerseq", settings.eulerseq)
    if len(sequence) == 3 and set(sequence) <= set("xyzXYZ"):
        settings.eulerseq = sequence
    else:
        reading.report(
            UNKNOWN_CHOICE,
            element,
            "eulerseq",
            element="compiler",
            attribute="eulerseq",
            text=sequence,
            known="xyz, ...",
        )
    if choice(reading, element, "coordinate", ("local", "global"), "local") == "global":
        reading.report(UNSUPPORTED, element, "coordinate", element='compiler coordinate="global"')
    groups = reading.vector(element, "inertiagrouprange", 2, settings.groups)
    settings.groups = (groups[0], groups[1]) if groups else settings.groups
    settings.bound_mass = _bound(reading, element, "boundmass", settings.bound_mass)
    settings.bound_inertia = _bound(reading, element, "boundinertia", settings.bound_inertia)
    settings.total_mass = reading.number(element, "settotalmass", settings.total_mass) or -1.0
    settings.mesh_folder = element.get("meshdir", element.get("assetdir", settings.mesh_folder))
    settings.strip_path = choice(reading, element, "strippath", flags, str(settings.strip_path).lower()) == "true"
    settings.fit_box = choice(reading, element, "fitaabb", flags, str(settings.fit_box).lower()) == "true"


def _bound(reading: Reading, element: Element, attribute: str, before: float) -> float:
    """A least mass or moment; one that stands for none is none."""
    value = reading.number(element, attribute, before) or 0.0
    return value if value > STAND_IN else 0.0


def _read_class(
    reading: Reading, element: Element, parent: dict[str, dict[str, str]], settings: Settings, name: str
) -> None:
    """One default class, which inherits from the class around it, and the classes inside it."""
    own = {tag: dict(attributes) for tag, attributes in {**parent, **settings.classes.get(name, {})}.items()}
    for child in element.children:
        if _style(child.tag) in (*_STYLED, "actuator"):
            style = _style(child.tag)
            own[style] = overlay(own.get(style, {}), child.attributes)
    settings.classes[name] = own
    for child in element.all("default"):
        inner = child.get("class")
        if not inner:
            reading.report(MISSING_ATTRIBUTE, child, element="default", attribute="class")
            continue
        _read_class(reading, child, own, settings, inner)


def _style(tag: str) -> str:
    """The name under which defaults of a tag are kept: all actuators share one."""
    return "actuator" if tag in MOTORS else tag


_WAYS = {"quat": 4, "axisangle": 4, "euler": 3, "xyaxes": 6, "zaxis": 3}
_ABOUT = {"x": rotation_x, "y": rotation_y, "z": rotation_z}


def read_pose(reading: Reading, element: Element, settings: Settings) -> PoseMatrix:
    """The pose (4, 4) in `pos` and one of quat, axisangle, euler, xyaxes, zaxis; identity where nothing is given."""
    T = np.eye(4)
    position = reading.vector(element, "pos", 3, (0.0, 0.0, 0.0))
    T[:3, 3] = position or (0.0, 0.0, 0.0)
    way = next((way for way in _WAYS if way in element.attributes), None)
    if way is not None:
        numbers = reading.vector(element, way, _WAYS[way])
        if numbers is not None:
            R = _rotation(way, np.array(numbers), settings)
            if R is None:
                reading.report(
                    NO_ROTATION, element, way, element=element.tag, attribute=way, text=element.get(way)
                )  # fmt: skip
            else:
                T[:3, :3] = R
    return frozen(T)


def _rotation(way: str, numbers: Floats, settings: Settings) -> Floats | None:
    """Rotation matrix (3, 3), or None if the numbers are none."""
    match way:
        case "quat":
            unit = _unit(numbers)
            return None if unit is None else rotation_from_quaternion(unit)
        case "axisangle":
            axis = _unit(numbers[:3])
            angle = float(numbers[3]) * settings.degree
            return None if axis is None else screw_motion(np.concatenate([axis, np.zeros(3)]), angle)[:3, :3]
        case "euler":
            return rotation_from_euler(numbers * settings.degree, settings.eulerseq)
        case "xyaxes":
            return _from_axes(numbers[:3], numbers[3:])
        case _:
            z = _unit(numbers)
            return None if z is None else frame_along(z)


def rotation_from_euler(angles: Floats, sequence: str) -> Floats:
    """Turns one after the other: about the moving axis for a small letter, about the fixed one for a capital."""
    R = np.eye(3)
    for angle, letter in zip(angles, sequence, strict=True):
        turn = _ABOUT[letter.lower()](float(angle))[:3, :3]
        R = R @ turn if letter.islower() else turn @ R
    return R


def _from_axes(x: Floats, y: Floats) -> Floats | None:
    unit_x = _unit(x)
    if unit_x is None:
        return None
    unit_y = _unit(y - unit_x * (unit_x @ y))
    return None if unit_y is None else np.column_stack([unit_x, unit_y, np.cross(unit_x, unit_y)])


def _unit(vector: Floats) -> Floats | None:
    largest = np.abs(vector).max()
    if largest < NO_LENGTH:
        return None
    scaled = vector / largest
    return scaled / np.linalg.norm(scaled)


def row_of(tag: str, parent: str) -> Row | None:
    """The row of an element that is read.

    Args:
        tag: of the element.
        parent: tag of the element around it; `frame` and `replicate` hold what a body holds.
    """
    holder = "body" if parent in ("worldbody", "frame", "replicate") else parent
    if holder == "default" and tag in _CLASS_ROWS:
        return ROWS[_CLASS_ROWS[tag]]
    if tag in MOTORS and holder in ("actuator", "default"):
        return ROWS["actuator/motor"]
    return ROWS.get(f"{holder}/{tag}") or ROWS.get(tag)


def is_neutral(tag: str, attribute: str, text: str) -> bool:
    """Whether a value leaves things as they are: zeros, `false`, `none`, a spring that is no spring."""
    words = text.split()
    if attribute in ("limited", "actuatorfrclimited", "range", "actuatorfrcrange"):
        return tag == "default" or attribute.endswith("limited")
    return all(word.lower() in ("false", "none", "auto") or _is_zero(word) for word in words)


def _is_zero(word: str) -> bool:
    try:
        return float(word) == 0.0
    except ValueError:
        return False


MJCF = Vocabulary(
    "MJCF", row_of, UNKNOWN_ATTRIBUTE, UNKNOWN_PART, strict=True, is_neutral=is_neutral,
    is_neutral_part=lambda _part: False,
)  # fmt: skip
