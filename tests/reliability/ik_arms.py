"""Arms for the rows of numerical inverse kinematics: the library's, and chains of published robot descriptions."""

from __future__ import annotations

import sysconfig
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from mafsil.model import Mechanism
from mafsil.model.exponentials import chain_to_tip
from mafsil.model.loading import load_mechanism
from mafsil.robot import Robot


@dataclass(frozen=True)
class Arm:
    """A name of the library, or a file of example-robot-data with the chain from one of its links to another."""

    source: str
    base: str | None = None
    tip: str | None = None


ARMS: dict[str, Arm] = {
    "panda": Arm("panda"),
    "fr3": Arm("fr3"),
    "iiwa7": Arm("iiwa7"),
    "ur3e": Arm("ur3e"),
    "ur5e": Arm("ur5e"),
    "ur10e": Arm("ur10e"),
    "puma560": Arm("puma560"),
    "offset_puma": Arm("offset_puma"),
    "stanford_arm": Arm("stanford_arm"),
    "rrprrr": Arm("rrprrr"),
    "kinova": Arm("kinova_description/robots/kinova.urdf", tip="j2s6s200_end_effector"),
    "baxter": Arm("baxter_description/urdf/baxter.urdf", "torso", "right_hand_link"),
    "pr2": Arm("pr2_description/urdf/pr2.urdf", "torso_lift_link", "r_gripper_tool_frame"),
    "tiago": Arm("tiago_description/robots/tiago_no_hand.urdf", "torso_lift_link", "arm_tool_link"),
    "talos": Arm("talos_data/robots/talos_left_arm.urdf", tip="wrist_left_ft_tool_link"),
    "xarm7": Arm("xarm_description/urdf/xarm7.urdf", tip="link7"),
    "z1": Arm("z1_description/urdf/z1.urdf", tip="link06"),
}


def example_robots() -> Path | None:
    """Folder of example-robot-data, if it is installed."""
    folder = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix/share/example-robot-data/robots"
    return folder if folder.is_dir() else None


@cache
def arm(name: str) -> Robot | None:
    """The arm of that name; None if its description is not installed."""
    entry = ARMS[name]
    if not entry.source.endswith(".urdf"):
        return Robot(load_mechanism(entry.source))
    folder = example_robots()
    if folder is None or not (folder / entry.source).exists():
        return None
    return Robot(_chain(name, load_mechanism(folder / entry.source), entry))


def _chain(name: str, whole: Mechanism, entry: Arm) -> Mechanism:
    """The links and joints between base and tip alone."""
    joints = chain_to_tip(whole if entry.tip is None else whole.with_tip(entry.tip))
    if entry.base is not None:
        joints = joints[next(i for i, joint in enumerate(joints) if joint.parent == entry.base) :]
    links = [whole.link(joints[0].parent), *(whole.link(joint.child) for joint in joints)]
    return Mechanism.assemble(name, links, joints, tip=joints[-1].child)
