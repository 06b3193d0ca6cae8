"""The table of MJCF is whole: MuJoCo's own schema holds nothing that it does not know, and it decides what is said."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

import pytest

from mafsil.model import mjcf
from mafsil.model.mjcf.settings import MOTORS, ROWS, row_of
from mafsil.model.vocabulary import Row, Treatment
from tests.corpus.mujoco_file import MuJoCoFile
from tests.model.mjcf.mjcf_models import ARM

mujoco = pytest.importorskip("mujoco")

_LINE = re.compile(r"^( *)(?:\(world\))?(\w+) \([!?*R]\)\s*(.*)$")


@dataclass
class Known:
    """One element of MuJoCo's schema."""

    tag: str
    depth: int
    attributes: list[str]
    children: list[Known] = field(default_factory=list)


def schema() -> Known:
    """The schema as MuJoCo prints it: a line for each element, attributes behind and below."""
    top = Known("", -1, [])
    open_: list[Known] = [top]
    for line in mujoco.mj_printSchema(False, False).splitlines():
        found = _LINE.match(line)
        if found is None:
            open_[-1].attributes += line.split()
            continue
        depth = len(found[1])
        while open_[-1].depth >= depth:
            open_.pop()
        element = Known(found[2], depth, found[3].split())
        open_[-1].children.append(element)
        open_.append(element)
    (root,) = top.children
    return root


def gaps(known: Known, tag: str, parent: str) -> Iterator[str]:
    """What the table lacks."""
    row = row_of("body" if tag == "worldbody" else tag, parent)  # MuJoCo's schema has one line for both
    if row is None:
        yield f"{parent}/{tag}"
        return
    yield from (f"{parent}/{tag}.{name}" for name in known.attributes if row.treatment_of(name) is None)
    for child in known.children:
        inner = "worldbody" if tag == "mujoco" and child.tag == "body" else child.tag
        treatment = row.treatment_inside(inner)
        if treatment is None:
            yield f"{tag}/{inner}"
        elif treatment is Treatment.READ:
            yield from gaps(child, inner, tag)


def test_everything_that_mujoco_knows_has_its_place() -> None:
    root = schema()
    count = sum(1 for _ in _walk(root))
    assert count > 150
    assert list(gaps(root, "mujoco", "")) == []


def _walk(known: Known) -> Iterator[Known]:
    yield known
    for child in known.children:
        yield from _walk(child)


def test_no_name_has_two_meanings_in_one_row() -> None:
    with pytest.raises(ValueError, match="pos"):
        Row("name pos", {Treatment.DATA: "pos"})
    with pytest.raises(ValueError, match="geom"):
        Row(children="geom site", whole={Treatment.PICTURE: "geom"})
    assert len(ROWS) > 30
    assert row_of("joint", "default") is row_of("joint", "body") is row_of("joint", "frame")
    assert row_of("joint", "equality") is not row_of("joint", "fixed")
    assert all(row_of(motor, "actuator") for motor in MOTORS)


HARMLESS = {
    "option": {
        "timestep": "0.01", "integrator": "RK4", "cone": "elliptic", "wind": "3 0 0", "magnetic": "1 0 0",
        "impratio": "7", "solver": "CG",
    },
    "flag": {"contact": "disable", "actuation": "disable", "energy": "enable", "eulerdamp": "disable"},
    "body/joint": {"springref": "0.3", "margin": "0.1", "solreflimit": "0.1 1", "group": "3", "user": "1 2"},
    "body/geom": {"condim": "6", "friction": "2 1 1", "priority": "3", "margin": "0.1", "fluidshape": "ellipsoid"},
    "body": {"simple": "false"},
}  # fmt: skip
"""Attributes of the table that leave a mechanism as it is, with values that are not their defaults."""
_BEFORE = {
    "option": "<option ",
    "flag": "<flag ",
    "body/joint": '<joint name="j2" ',
    "body/geom": '<geom type="capsule" ',
    "body": '<body name="l3" ',
}


@pytest.mark.parametrize(("place", "attribute"), [(p, a) for p, values in HARMLESS.items() for a in values])
def test_what_is_called_harmless_changes_nothing_in_mujoco(place: str, attribute: str) -> None:
    row = ROWS[place]
    assert row.treatment_of(attribute) not in (None, Treatment.READ, Treatment.LEFT_OUT, Treatment.SOFT)
    plain = ARM.replace('-9.7"/>', '-9.7"><flag override="disable"/></option><size nuser_jnt="2"/>')
    changed = plain.replace(_BEFORE[place], f'{_BEFORE[place]}{attribute}="{HARMLESS[place][attribute]}" ', 1)
    assert changed != plain
    mechanism = mjcf.read(changed)
    for text in (plain, changed):
        error, where = MuJoCoFile(text).difference(mechanism, 2)
        assert error < 1e-12, where
