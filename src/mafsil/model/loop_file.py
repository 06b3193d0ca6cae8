"""Loops of a robot whose format cannot say them: `arm.urdf` is read with `arm.loops.toml` beside it.

driven = ["shoulder", "lever"]         # the joints with motors; all of them if left away

[[loop]]
name = "rod end"
kind = "revolute"                       # or prismatic, helical, cylindrical, universal, spherical, planar, fixed
parent = "rod"                          # two links of the tree
child = "forearm"
parent_at = { xyz = [0, 0, 0.4] }       # the joint's frame in each of them; rpy too
child_at = { xyz = [-0.12, 0, 0] }
axis = [0, 1, 0]                        # in the joint's frame; second for universal, pitch for helical joints

[[joint]]                               # a joint of the tree that URDF cannot say: it draws a hinge in its place
name = "rod foot"
kind = "spherical"                      # or universal, cylindrical, revolute, prismatic, fixed
axis = [0, 1, 0]                        # and second, as above

`parent` and `child` of a loop may also name a joint: its frame is that of the link that it carries.

A joint of several freedoms in a tree: revolute and prismatic joints in a row, with massless links between them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, frozen, single
from mafsil.errors import FileError, MafsilError
from mafsil.messages import say
from mafsil.model.joint import Joint, JointKind
from mafsil.model.limits import Limits
from mafsil.model.link import Link
from mafsil.model.mechanism import Mechanism
from mafsil.model.placement import pose_from_xyz_rpy
from mafsil.regular_file import is_file
from mafsil.toml_source import read_toml

REVOLUTE, PRISMATIC = JointKind.REVOLUTE, JointKind.PRISMATIC
KINDS = {
    JointKind.FIXED: (JointKind.FIXED,),
    JointKind.REVOLUTE: (REVOLUTE,),
    JointKind.PRISMATIC: (PRISMATIC,),
    JointKind.CYLINDRICAL: (PRISMATIC, REVOLUTE),
    JointKind.UNIVERSAL: (REVOLUTE, REVOLUTE),
    JointKind.SPHERICAL: (REVOLUTE, REVOLUTE, REVOLUTE),
}
"""Joints of one freedom for every kind that a tree can have so."""
ENDING = ".loops.toml"
_KEYS = ("driven", "loop", "joint")
_JOINT_KEYS = ("name", "kind", "axis", "second")
_LOOP_KEYS = ("name", "kind", "parent", "child", "parent_at", "child_at", "axis", "second", "pitch")
_FRAME_KEYS = ("xyz", "rpy")


def loop_file_of(path: Path) -> Path | None:
    """The file of loops beside the file of a robot, if there is one."""
    beside = path.with_suffix(ENDING)
    return beside if is_file(beside) else None


def with_loops(mechanism: Mechanism, path: str | Path) -> Mechanism:
    """The mechanism with the loops that a TOML file names.

    Args:
        mechanism: the tree.
        path: of the file.

    Raises:
        FileError: missing, unreadable, malformed, unknown keys, links or kinds; the sentence names the loop.
    """
    return _Reader(mechanism, Path(path).name).read(read_toml(path))


class _Reader:
    """Reads one file.

    Args:
        mechanism: the tree.
        source: name of the file, for errors.
    """

    def __init__(self, mechanism: Mechanism, source: str) -> None:
        self.mechanism, self.source = mechanism, source
        self.links: list[Link] = []
        self.joints: list[Joint] = []

    def read(self, data: dict[str, Any]) -> Mechanism:
        """The mechanism with its loops."""
        self.known(data, _KEYS, "")
        entries = data.get("loop")
        if not isinstance(entries, list) or not entries:
            raise FileError("model.loops_none", path=self.source)
        loops = [self.loop(entry, k + 1) for k, entry in enumerate(cast("list[object]", entries))]
        own, joints = self.mechanism, self.replace_joints(data.get("joint", []))
        joints = self.set_driven(joints, data.get("driven")) if "driven" in data else joints
        note = say("model.loops_read", language="en", source=self.source, loops=", ".join(each.name for each in loops))
        try:
            return Mechanism.assemble(
                own.name, (*own.links, *self.links), (*joints, *self.joints), loops=(*own.loops, *loops), tip=own.tip,
                T_lt=own.T_lt, T_sb=own.T_sb, gravity=cast("Any", own.gravity),
                provenance=replace(own.provenance, notes=(*own.provenance.notes, note)),
            )  # fmt: skip
        except FileError:
            raise
        except MafsilError as error:
            raise FileError("mobility.file_joint", path=self.source, place="loop", reason=error.message()) from None

    def loop(self, entry: object, number: int) -> Joint:
        """One joint that closes a loop; a massless link carries the joint's frame where it is not the child's."""
        place = f"loop {number}"
        table = self.table(entry, place)
        place = f"{place} ({table['name']})" if isinstance(table.get("name"), str) else place
        self.known(table, _LOOP_KEYS, f"{place}: ")
        for key in ("name", "kind", "parent", "child"):
            if not isinstance(table.get(key), str):
                raise FileError("mobility.file_missing", path=self.source, place=place, name=key)
        self.one_of(table["kind"], [kind.value for kind in JointKind], f"{place}: kind")
        parent, child = (self.link(table[end], f"{place}: {end}") for end in ("parent", "child"))
        T_cj = self.frame(table.get("child_at"), f"{place}: child_at")
        if np.any(T_cj != np.eye(4)):
            self.links.append(Link(f"{table['name']}/end"))
            self.joints.append(Joint(f"{table['name']}/end", JointKind.FIXED, child, f"{table['name']}/end", T_cj))
            child = f"{table['name']}/end"
        axes = self.axes(table, place)
        pitch = table.get("pitch", 0.0)
        if not isinstance(pitch, int | float) or isinstance(pitch, bool):
            raise FileError("mobility.file_value", path=self.source, place=f"{place}: pitch", expected="number")
        try:
            return Joint(
                table["name"], JointKind(table["kind"]), parent, child,
                self.frame(table.get("parent_at"), f"{place}: parent_at"), actuated=False, pitch=float(pitch), **axes,
            )  # fmt: skip
        except MafsilError as error:
            raise FileError("mobility.file_joint", path=self.source, place=place, reason=error.message()) from None

    def link(self, name: str, place: str) -> str:
        """The link that is named, or that the named joint carries."""
        carried = {joint.name: joint.child for joint in self.mechanism.joints}
        if name in self.mechanism.link_names or name not in carried:
            self.one_of(name, self.mechanism.link_names, place)
            return name
        return carried[name]

    def replace_joints(self, given: object) -> tuple[Joint, ...]:
        """The joints of the tree, those that the file names as it says; links between their parts are kept apart."""
        chains: dict[str, list[Joint]] = {joint.name: [joint] for joint in self.mechanism.joints}
        for k, entry in enumerate(cast("list[object]", given) if isinstance(given, list) else [given]):
            place = f"joint {k + 1}"
            table = self.table(entry, place)
            self.known(table, _JOINT_KEYS, f"{place}: ")
            name = self.one_of(table.get("name"), chains, f"{place}: name")
            place = f"{place} ({name})"
            kind = JointKind(self.one_of(table.get("kind"), [kind.value for kind in KINDS], f"{place}: kind"))
            axes = {"axis": np.array([0.0, 0.0, 1.0]), "second": np.array([1.0, 0.0, 0.0])} | self.axes(table, place)
            try:
                Joint(name, kind, "", "", axis=axes["axis"], second=axes["second"])  # Says what is wrong with the axes.
                chains[name], links = joint_chain(chains[name][0], kind, axes["axis"], axes["second"])
            except MafsilError as error:
                raise FileError("mobility.file_joint", path=self.source, place=place, reason=error.message()) from None
            self.links += links
        return tuple(joint for chain in chains.values() for joint in chain)

    def axes(self, table: dict[str, Any], place: str) -> dict[str, Any]:
        """Directions of a joint that are given."""
        return {key: self.numbers(table[key], f"{place}: {key}") for key in ("axis", "second") if key in table}

    def one_of(self, given: object, known: Iterable[str], place: str) -> str:
        """A text that is one of some."""
        if not isinstance(given, str) or given not in known:
            shown = place if given is None else f"{place}: {given!r}"
            raise FileError("mobility.file_value", path=self.source, place=shown, expected=", ".join(known))
        return given

    def set_driven(self, joints: tuple[Joint, ...], given: object) -> tuple[Joint, ...]:
        """The joints, actuated if they are named."""
        names = cast("list[object]", given) if isinstance(given, list) else [None]
        known = [joint.name for joint in joints if joint.moves]
        for name in names:
            if name not in known:
                expected = ", ".join(known)
                raise FileError("mobility.file_value", path=self.source, place="driven", expected=expected)
        return tuple(replace(joint, actuated=joint.name in names) for joint in joints)

    def frame(self, given: object, place: str) -> PoseMatrix:
        """(4, 4) of a table with xyz and rpy; the link's own frame if there is none."""
        if given is None:
            return np.eye(4)
        table = self.table(given, place)
        self.known(table, _FRAME_KEYS, f"{place}: ")
        xyz, rpy = (self.numbers(table.get(key, [0.0, 0.0, 0.0]), f"{place}: {key}") for key in _FRAME_KEYS)
        return pose_from_xyz_rpy(xyz, rpy)

    def numbers(self, given: object, place: str) -> Any:
        """(3,) finite numbers."""
        try:
            return single(place, cast("Any", given), (3,))
        except MafsilError:
            raise FileError("mobility.file_value", path=self.source, place=place, expected="[x, y, z]") from None

    def table(self, given: object, place: str) -> dict[str, Any]:
        """A table of TOML."""
        if not isinstance(given, dict):
            raise FileError("mobility.file_value", path=self.source, place=place, expected="table")
        return cast("dict[str, Any]", given)

    def known(self, table: dict[str, Any], keys: tuple[str, ...], place: str) -> None:
        """Refuse keys that mean nothing."""
        for key in table:
            if key not in keys:
                known = ", ".join(keys)
                raise FileError("mobility.file_key", path=self.source, place=place, name=key, known=known)


def joint_chain(joint: Joint, kind: JointKind, axis: Floats, second: Floats) -> tuple[list[Joint], list[Link]]:
    """What stands in place of a joint: joints NAME, NAME/axis2, NAME/axis3, and links NAME/between, NAME/between2.

    They are not driven and have no ranges.

    Args:
        joint: whose frame, parent and child they have.
        kind: of `KINDS`.
        axis: (3,) unit axis in the joint's frame; of a ball joint x, y and z are, in their order.
        second: (3,) of a universal joint.
    """
    kinds, name = KINDS[kind], joint.name
    axes = (
        np.eye(3) if kind is JointKind.SPHERICAL else np.stack([axis, second if kind is JointKind.UNIVERSAL else axis])
    )
    links = [Link(f"{name}/between{'' if k == 0 else k + 1}") for k in range(len(kinds) - 1)]
    ends = [joint.parent, *(link.name for link in links), joint.child]
    joints = [
        replace(
            joint, name=name if k == 0 else f"{name}/axis{k + 1}", kind=one, parent=ends[k], child=ends[k + 1],
            T_pj=joint.T_pj if k == 0 else frozen(np.eye(4)), axis=frozen(axes[k] if one.freedoms else joint.axis),
            limits=Limits(), wraps=one is REVOLUTE, actuated=False, mimic=None, friction=None,
        )
        for k, one in enumerate(kinds)
    ]  # fmt: skip
    return joints, links
