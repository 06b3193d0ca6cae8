"""The robots under test: all of the library, and real descriptions from the example-robot-data wheel."""

from __future__ import annotations

from pathlib import Path

import pinocchio

from mafsil.model import Mechanism, library, urdf

REAL = {
    "panda_hand": "panda_description/urdf/panda.urdf",
    "ur3": "ur_description/urdf/ur3_robot.urdf",
    "ur5": "ur_description/urdf/ur5_robot.urdf",
    "ur10_limited": "ur_description/urdf/ur10_joint_limited_robot.urdf",
    "kinova": "kinova_description/robots/kinova.urdf",
    "xarm7": "xarm_description/urdf/xarm7.urdf",
    "z1": "z1_description/urdf/z1.urdf",
    "so101": "so_arm_description/urdf/so101.urdf",
    "allegro_left": "allegro_hand_description/urdf/allegro_left_hand.urdf",
    "allegro_right": "allegro_hand_description/urdf/allegro_right_hand.urdf",
    "alex_psyonic_hands": "alex_description/urdf/alex_psyonic_hands.urdf",
    "baxter": "baxter_description/urdf/baxter.urdf",
    "pr2": "pr2_description/urdf/pr2.urdf",
    "tiago_dual": "tiago_description/robots/tiago_dual.urdf",
    "tiago_pro": "tiago_pro_description/robots/tiago_pro.urdf",
    "talos_left_arm": "talos_data/robots/talos_left_arm.urdf",
    "romeo": "romeo_description/urdf/romeo.urdf",
    "finger_edu": "finger_edu_description/robots/finger_edu.urdf",
    "hextilt_flying_arm": "hextilt_description/urdf/hextilt_flying_arm_5.urdf",
    "centauro": "centauro_description/urdf/centauro.urdf",
    "g1_with_hands": "g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf",
    "double_pendulum": "double_pendulum_description/urdf/double_pendulum.urdf",
}
"""Arms, hands, dual arms and the upper bodies that carry them, their base fixed, below `data_root()`."""


def data_root() -> Path:
    """The robots of example-robot-data; it shares its wheel format's prefix with Pinocchio."""
    site = Path(pinocchio.__file__).parents[4]
    return site / "share/example-robot-data/robots"


def names() -> tuple[str, ...]:
    """Library robots, then `urdf:` names."""
    return (*library.robots(), *(f"urdf:{name}" for name in REAL))


def mechanism(name: str) -> Mechanism:
    """The robot of that name."""
    kind, _, key = name.rpartition(":")
    return urdf.read(path_of(key)) if kind else library.load(name)


def path_of(key: str) -> Path:
    """The URDF file of a real robot."""
    return data_root() / REAL[key]
