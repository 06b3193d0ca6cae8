"""SDF robots by sdformat's rules, read a second time in the plainest way and handed to Pinocchio joint by joint.

No wheel of Pinocchio or MuJoCo reads SDF. What is read here: one model; poses of links in the model's frame, of joints
in their child's and of inertias in their link's, or in the frame that `relative_to` names; axes in the joint's frame,
in the one that `expressed_in` names or, up to version 1.4 or when a flag says so, in the model's.
"""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from mafsil.arrays import Floats
from mafsil.model import Mechanism
from tests.oracles.oracle import Answers, stacked
from tests.oracles.states import States

Element = ElementTree.Element
KINDS = {
    "revolute": pin.JointModelRevoluteUnaligned,
    "continuous": pin.JointModelRevoluteUnaligned,
    "prismatic": pin.JointModelPrismaticUnaligned,
}


class NotPlain(ValueError):
    """The file uses more of SDF than is read here."""


class SdfFile:
    """Link poses relative to our first link, mass matrix and inverse dynamics.

    Raises:
        NotPlain: several models, included ones, loops, frames, other joints, loose links, an undeclared prefix.
    """

    def __init__(self, path: Path, mechanism: Mechanism) -> None:
        try:
            root = ElementTree.fromstring(re.sub(r"(</?\w+):(?=\w)", r"\1_", path.read_text("utf-8")))
        except ElementTree.ParseError as error:
            raise NotPlain(str(error)) from None
        models = list(root.iter("model"))
        unread = [tag for tag in ("include", "frame", "mimic") if root.find(f".//{tag}") is not None]
        if len(models) != 1 or unread:
            raise NotPlain(f"{len(models)} models {', '.join(unread)}")
        robot = models[0]
        self.version = tuple(map(int, (root.get("version") or "1.12").split(".")))[:2]
        self.links = {str(link.get("name")): link for link in robot.findall("link")}
        if self.links.keys() - set(mechanism.link_names):
            raise NotPlain("loose links")
        self.joints = list(robot.findall("joint"))
        self.placed = {str(part.get("name")): part for part in (*robot.findall("link"), *robot.findall("joint"))}
        self.model, self.at = pin.Model(), dict[str, tuple[int, pin.SE3]]()
        children = [str(joint.findtext("child")).strip() for joint in self.joints]
        if len(children) != len(set(children)):
            raise NotPlain("loops")
        self.standing = _pose(robot)
        for name in [name for name in dict.fromkeys(["world", *self.links]) if name not in children]:
            self.at[name] = (0, self.standing * self._place(name))
            self._add_below(name)
        self.names = [name for name in mechanism.link_names if name in self.links]
        self.data = self.model.createData()
        if sorted(joint.name for joint in mechanism.coordinates) != sorted(list(self.model.names)[1:]):
            raise AssertionError("other joints")
        joints = [self.model.joints[self.model.getJointId(joint.name)] for joint in mechanism.coordinates]
        self.v_at = [joint.idx_v for joint in joints]
        self.rows = [mechanism.link_names.index(name) for name in self.names]

    def _add_below(self, parent: str) -> None:
        """Joints depth first, as Pinocchio numbers them."""
        for joint in self.joints:
            if joint.findtext("parent", "").strip() == parent:
                child = joint.findtext("child", "").strip()
                self._add(joint, parent, child)
                self._add_below(child)

    def _add(self, joint: Element, parent: str, child: str) -> None:
        number, X_jp = self.at[parent]
        X_pc = self._place(parent).inverse() * self._place(child)
        own = self._place(child).inverse() * self._place(str(joint.get("name")))
        if joint.get("type") == "fixed":
            X_jc = X_jp * X_pc
        elif joint.get("type") in KINDS:
            kind = KINDS[str(joint.get("type"))](self._axis(joint))
            number = self.model.addJoint(number, kind, X_jp * X_pc * own, str(joint.get("name")))
            X_jc = own.inverse()
        else:
            raise NotPlain(f"joint of type {joint.get('type')}")
        self.at[child] = (number, X_jc)
        self.model.appendBodyToJoint(number, _inertia(self.links[child]), X_jc)

    def _place(self, name: str) -> pin.SE3:
        """Pose of a link or joint in the model's frame."""
        if name == "__model__":
            return pin.SE3.Identity()
        if name == "world" and name not in self.links:
            return self.standing.inverse()
        part = self.placed[name]
        holder = part.find("pose")
        usual = "__model__" if part.tag == "link" else part.findtext("child", "").strip()
        given = "" if holder is None else holder.get("relative_to") or holder.get("frame")
        return self._place(given or usual) * _pose(part)

    def _axis(self, joint: Element) -> Floats:
        axis = joint.find("axis")
        xyz = None if axis is None else axis.find("xyz")
        if axis is None or xyz is None:
            raise NotPlain("no axis")
        direction = np.array(str(xyz.text).split(), float)
        flag = (axis.findtext("use_parent_model_frame") or "").strip() in ("1", "true")
        in_model = self.version <= (1, 4) or (self.version < (1, 7) and flag)
        frame = xyz.get("expressed_in") or ("__model__" if in_model else str(joint.get("name")))
        R = (self._place(str(joint.get("name"))).inverse() * self._place(frame)).rotation
        return R @ direction / np.linalg.norm(direction)

    def evaluate(self, states: States) -> Answers:
        """The answers at all states."""
        return stacked([self._state(*row) for row in zip(*states.arguments(("q", "qd", "qdd")), strict=True)])

    def _state(self, q: Floats, qd: Floats, qdd: Floats) -> Answers:
        x, xd, xdd = np.zeros((3, self.model.nv))
        x[self.v_at], xd[self.v_at], xdd[self.v_at] = q, qd, qdd
        pin.forwardKinematics(self.model, self.data, x)
        poses = [(self.data.oMi[self.at[name][0]] * self.at[name][1]).homogeneous for name in self.names]
        upper = np.triu(pin.crba(self.model, self.data, x))
        M = (upper + np.triu(upper, 1).T)[np.ix_(self.v_at, self.v_at)]
        return {
            "link_poses": np.linalg.inv(poses[0]) @ np.array(poses),
            "mass_matrix": M,
            "inverse_dynamics": pin.rnea(self.model, self.data, x, xd, xdd)[self.v_at],
        }


def _pose(element: Element) -> pin.SE3:
    x, y, z, *rpy = map(float, (element.findtext("pose") or "0 0 0 0 0 0").split())
    return pin.SE3(pin.rpy.rpyToMatrix(*rpy), np.array([x, y, z]))


def _inertia(link: Element) -> pin.Inertia:
    given = link.find("inertial")
    holder = None if given is None else given.find("pose")
    if holder is not None and (holder.get("relative_to") or holder.get("frame")):
        raise NotPlain("inertia in another frame")
    if given is None:
        return pin.Inertia(1.0, np.zeros(3), np.eye(3))
    tensor = given.find("inertia")
    xx, yy, zz, xy, xz, yz = (
        float((None if tensor is None else tensor.findtext(tag)) or default)
        for tag, default in (("ixx", 1), ("iyy", 1), ("izz", 1), ("ixy", 0), ("ixz", 0), ("iyz", 0))
    )
    X, moments = _pose(given), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return pin.Inertia(float(given.findtext("mass") or 1.0), X.translation, X.rotation @ moments @ X.rotation.T)
