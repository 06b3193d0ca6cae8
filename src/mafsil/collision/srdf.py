"""Semantic robot descriptions (SRDF): the file, its words, pairs of links that need no check, and groups of joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import JointVector, as_batch, single
from mafsil.errors import FileError, InputError, ModelWarning, warn
from mafsil.messages.visible import visible
from mafsil.model import Mechanism
from mafsil.model.diagnostics import shown
from mafsil.model.faults import FILE_MISSING, FOREIGN_ATTRIBUTE, NOT_A_FILE, UNKNOWN_ELEMENT
from mafsil.model.loading import RobotLike
from mafsil.model.reading import Reading
from mafsil.model.source import load
from mafsil.model.vocabulary import Row, Treatment, Vocabulary, audit
from mafsil.model.xml_tree import Element, Refusal, parse
from mafsil.robot import Robot, as_robot

ROWS: Mapping[str, Row] = MappingProxyType(
    {
        "robot": Row(
            other={Treatment.DATA: "name version"},
            children="group group_state disable_collisions",
            whole={
                Treatment.LEFT_OUT: "enable_collisions disable_default_collisions",
                Treatment.DATA: "end_effector virtual_joint passive_joint joint_property",
                Treatment.CONTACT: "link_sphere_approximation",
            },
        ),
        "group": Row("name", children="link joint chain group"),
        "link": Row("name"),
        "chain": Row("base_link tip_link"),
        "group/joint": Row("name"),
        "group_state": Row("name group", children="joint"),
        "group_state/joint": Row("name value"),
        "disable_collisions": Row("link1 link2 reason"),
    }
)
"""The words of SRDF, as srdfdom and MoveIt write and read them."""
SRDF = Vocabulary(
    "SRDF", lambda tag, parent: ROWS.get(f"{parent}/{tag}") or ROWS.get(tag), FOREIGN_ATTRIBUTE, UNKNOWN_ELEMENT,
    strict=False, is_neutral=lambda _tag, _attribute, _text: False, is_neutral_part=lambda _part: False,
)  # fmt: skip
_MOST_SHOWN = 3


def disabled_pairs(path: str | Path) -> dict[frozenset[str], str]:
    """Unordered pairs of link names of an SRDF file, with the reason that it gives.

    Args:
        path: of the file, with elements `disable_collisions link1 link2 reason`.

    Raises:
        FileError: no such file, or no XML.
    """
    return {
        frozenset((each.get("link1"), each.get("link2"))): each.get("reason")
        for each in read(path).walk()
        if each.tag == "disable_collisions"
    }


def read(path: str | Path) -> Element:
    """The root of an SRDF file.

    Warns:
        ModelWarning: misspelt and unknown words, words that are left out though they mean something, pardoned XML.

    Raises:
        FileError: no such file, or no XML.
    """
    path = Path(path)
    try:
        text = load(path)
        document = parse(text.data)
    except Refusal as refusal:
        if refusal.diagnostic.fault in (FILE_MISSING, NOT_A_FILE):
            raise FileError("collision.no_srdf", path=shown(str(path)), reason=refusal.diagnostic) from None
        raise FileError("collision.bad_srdf", path=shown(str(path)), why=refusal.diagnostic) from None
    reading = Reading(document, [*text.remarks, *document.remarks])
    audit(reading, document.root, SRDF)
    if remarks := reading.diagnostics:
        first = "; ".join(remark.line_of_text() for remark in remarks[:_MOST_SHOWN])
        warn(ModelWarning("collision.srdf_remarks", path=shown(str(path)), count=len(remarks), remarks=first))
    return document.root


@dataclass(frozen=True, eq=False, slots=True)
class JointGroup:
    """Some joints of a robot; the others stand still.

    Attributes:
        name: of the group.
        robot: with the joints of the group alone; its tip is that of the group's chain, if it is one.
        places: of the group's coordinates among those of the whole robot.
        at: (n,) where the whole robot stands [rad | m].
        states: named configurations of the group, (k,) each.
    """

    name: str
    robot: Robot
    places: tuple[int, ...]
    at: JointVector
    states: dict[str, JointVector]

    def configuration(self, state: str) -> JointVector:
        """(k,) a named configuration.

        Raises:
            InputError: no such name; the sentence lists those that are known.
        """
        if state not in self.states:
            raise InputError("input.choice", name="state", value=state, known=", ".join(self.states))
        return self.states[state].copy()

    def of_whole(self, q: ArrayLike) -> JointVector:
        """(*batch, k) the group's coordinates of configurations (*batch, n) of the whole robot."""
        return as_batch("q", q, (len(self.at),), finite=True)[..., list(self.places)]

    def whole(self, q: ArrayLike) -> JointVector:
        """(*batch, n) the whole robot where the group stands at (*batch, k)."""
        rows = as_batch("q", q, (len(self.places),), finite=True)
        found = np.broadcast_to(self.at, (*rows.shape[:-1], len(self.at))).copy()
        found[..., list(self.places)] = rows
        return found


def joint_group(robot: RobotLike, path: str | Path, name: str, *, at: ArrayLike | None = None) -> JointGroup:
    """A group of an SRDF file: plan for `group.robot` with `group.configuration("ready")` as a start or goal.

    Args:
        robot: the whole robot.
        path: of the SRDF file; groups are made of chains, joints, links and other groups.
        name: of the group.
        at: (n,) where the joints outside the group stand; zero, or as near to it as their limits allow, if None.

    Raises:
        InputError: no such group, wrong shapes.
        FileError: no such file, no XML, a group that names what the robot does not have, or itself.
    """
    arm = as_robot(robot)
    mechanism = arm.mechanism
    root = read(path)
    groups = {each.get("name"): each for each in root.walk() if each.tag == "group" and each.children}
    if name not in groups:
        raise InputError("input.choice", name="name", value=name, known=", ".join(groups))
    limits = arm.limits
    stands = np.clip(np.zeros(arm.n), limits.lower, limits.upper) if at is None else single("at", at, (arm.n,))
    wanted = _joints(mechanism, groups, name, (), str(path))
    moving = [joint.name for joint in mechanism.coordinates]
    places = tuple(k for k, joint in enumerate(moving) if joint in wanted)
    if not places:
        raise InputError("planning.group_empty", group=visible(name))
    locked = {joint: float(stands[k]) for k, joint in enumerate(moving) if k not in places}
    part = mechanism.with_locked_joints(locked) if locked else mechanism
    chain = groups[name].first("chain")
    if chain is not None:
        part = part.with_tip(chain.get("tip_link"))
    states = _states(root, str(path), name, [moving[k] for k in places])
    return JointGroup(name, Robot(part), places, np.asarray(stands, dtype=np.float64), states)


def _joints(mechanism: Mechanism, groups: dict[str, Element], name: str, above: tuple[str, ...], path: str) -> set[str]:
    """Names of all joints of a group."""
    if name in above:
        raise FileError("planning.group_circle", path=path, group=visible(name))
    if name not in groups:
        raise FileError("planning.group_unknown", path=path, what=visible(name), group=visible(above[-1]))
    found: set[str] = set()
    carriers = {link.name: joint for joint, link in zip(mechanism.joints, mechanism.links[1:], strict=True)}
    known = {joint.name for joint in mechanism.joints}
    for each in groups[name].children:
        if each.tag == "group":
            found |= _joints(mechanism, groups, each.get("name"), (*above, name), path)
        elif each.tag == "joint":
            joint = each.get("name")
            if joint not in known:
                raise FileError("planning.group_unknown", path=path, what=visible(joint), group=visible(name))
            found.add(joint)
        elif each.tag in ("link", "chain"):
            link = each.get("name") or each.get("tip_link")
            last = each.get("base_link") if each.tag == "chain" else None
            for wanted in (link, last):
                if wanted is not None and wanted not in mechanism.link_names:
                    raise FileError("planning.group_unknown", path=path, what=visible(wanted), group=visible(name))
            while link != last and link in carriers:
                found.add(carriers[link].name)
                link = carriers[link].parent if last is not None else last
    return found


def _states(root: Element, path: str, group: str, joints: list[str]) -> dict[str, JointVector]:
    """Named configurations that give every joint of the group a number."""
    found: dict[str, JointVector] = {}
    for each in root.walk():
        if each.tag == "group_state" and each.get("group") == group:
            values = {joint.get("name"): joint.get("value") for joint in each.children if joint.tag == "joint"}
            try:
                q = np.array([float(values[joint]) for joint in joints])
            except (KeyError, ValueError):
                raise FileError("planning.group_state", path=path, state=visible(each.get("name"))) from None
            if not np.isfinite(q).all():
                raise FileError("planning.group_state", path=path, state=visible(each.get("name")))
            found[each.get("name")] = q
    return found
