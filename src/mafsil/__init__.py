"""mafsil: robot manipulators, from the mathematics of a screw to a controlled arm.

Names are found at their first use, so that `import mafsil` stays quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from mafsil.version import __version__ as __version__

if TYPE_CHECKING:
    from mafsil import collision as collision
    from mafsil import control as control
    from mafsil import derivation as derivation
    from mafsil import geometry as geometry
    from mafsil import grasp as grasp
    from mafsil import ik as ik
    from mafsil import mobility as mobility
    from mafsil import one_joint as one_joint
    from mafsil import parallel as parallel
    from mafsil import performance as performance
    from mafsil import planning as planning
    from mafsil import trajectory as trajectory
    from mafsil.collision import Scene as Scene
    from mafsil.errors import FileError as FileError
    from mafsil.errors import InputError as InputError
    from mafsil.errors import InputWarning as InputWarning
    from mafsil.errors import JobError as JobError
    from mafsil.errors import KernelError as KernelError
    from mafsil.errors import MafsilError as MafsilError
    from mafsil.errors import ModelError as ModelError
    from mafsil.errors import ModelWarning as ModelWarning
    from mafsil.errors import language as language
    from mafsil.geometry import Pose as Pose
    from mafsil.geometry import Rotation as Rotation
    from mafsil.geometry import ScrewAxis as ScrewAxis
    from mafsil.geometry import Twist as Twist
    from mafsil.geometry import Wrench as Wrench
    from mafsil.geometry.frames import FrameGraph as FrameGraph
    from mafsil.grasp import Contact as Contact
    from mafsil.grasp import Grasp as Grasp
    from mafsil.grasp import plan_grasps as plan_grasps
    from mafsil.identification import MotionLog as MotionLog
    from mafsil.identification import estimate_payload as estimate_payload
    from mafsil.identification import excitation_trajectory as excitation_trajectory
    from mafsil.identification import identify as identify
    from mafsil.ik import inverse_kinematics as inverse_kinematics
    from mafsil.ik import solve_ik as solve_ik
    from mafsil.kernels.device import DeviceArray as DeviceArray
    from mafsil.kernels.device import device_array as device_array
    from mafsil.mechanics.rigid_body import RigidBody as RigidBody
    from mafsil.model import Actuator as Actuator
    from mafsil.model import Friction as Friction
    from mafsil.model import Inertial as Inertial
    from mafsil.model import Joint as Joint
    from mafsil.model import JointKind as JointKind
    from mafsil.model import Limits as Limits
    from mafsil.model import Link as Link
    from mafsil.model import Mechanism as Mechanism
    from mafsil.model import library as library
    from mafsil.model import urdf as urdf
    from mafsil.model.denavit_hartenberg import DHRow as DHRow
    from mafsil.model.lint import lint as lint
    from mafsil.model.lint import mend as mend
    from mafsil.page import show as show
    from mafsil.page.exporting import export as export
    from mafsil.planning import place as place
    from mafsil.planning import plan as plan
    from mafsil.robot import Robot as Robot
    from mafsil.robot import load as load
    from mafsil.simulation import Plant as Plant
    from mafsil.simulation import Recording as Recording
    from mafsil.simulation import Sampled as Sampled
    from mafsil.simulation import Scenario as Scenario
    from mafsil.simulation import forward_dynamics_trajectory as forward_dynamics_trajectory
    from mafsil.simulation import free_body_motion as free_body_motion
    from mafsil.simulation import inverse_dynamics_trajectory as inverse_dynamics_trajectory
    from mafsil.simulation import simulate as simulate
    from mafsil.solvers import Event as Event
    from mafsil.verification import Verification as Verification
    from mafsil.verification import verify as verify


_HOME_OF = {
    "collision": "mafsil.collision",
    "control": "mafsil.control",
    "derivation": "mafsil.derivation",
    "geometry": "mafsil.geometry",
    "ik": "mafsil.ik",
    "library": "mafsil.model.library",
    "mobility": "mafsil.mobility",
    "one_joint": "mafsil.one_joint",
    "parallel": "mafsil.parallel",
    "performance": "mafsil.performance",
    "planning": "mafsil.planning",
    "trajectory": "mafsil.trajectory",
    "urdf": "mafsil.model.urdf",
    "grasp": "mafsil.grasp",
    "FileError": "mafsil.errors:FileError",
    "InputWarning": "mafsil.errors:InputWarning",
    "ModelWarning": "mafsil.errors:ModelWarning",
    "InputError": "mafsil.errors:InputError",
    "JobError": "mafsil.errors:JobError",
    "KernelError": "mafsil.errors:KernelError",
    "MafsilError": "mafsil.errors:MafsilError",
    "ModelError": "mafsil.errors:ModelError",
    "MotionLog": "mafsil.identification:MotionLog",
    "estimate_payload": "mafsil.identification:estimate_payload",
    "excitation_trajectory": "mafsil.identification:excitation_trajectory",
    "identify": "mafsil.identification:identify",
    "inverse_kinematics": "mafsil.ik:inverse_kinematics",
    "language": "mafsil.errors:language",
    "Actuator": "mafsil.model:Actuator",
    "Contact": "mafsil.grasp:Contact",
    "Grasp": "mafsil.grasp:Grasp",
    "plan_grasps": "mafsil.grasp:plan_grasps",
    "DeviceArray": "mafsil.kernels.device:DeviceArray",
    "DHRow": "mafsil.model.denavit_hartenberg:DHRow",
    "FrameGraph": "mafsil.geometry.frames:FrameGraph",
    "Friction": "mafsil.model:Friction",
    "Inertial": "mafsil.model:Inertial",
    "Joint": "mafsil.model:Joint",
    "JointKind": "mafsil.model:JointKind",
    "Limits": "mafsil.model:Limits",
    "Link": "mafsil.model:Link",
    "Mechanism": "mafsil.model:Mechanism",
    "Pose": "mafsil.geometry:Pose",
    "Event": "mafsil.solvers:Event",
    "Plant": "mafsil.simulation:Plant",
    "Recording": "mafsil.simulation:Recording",
    "Sampled": "mafsil.simulation:Sampled",
    "forward_dynamics_trajectory": "mafsil.simulation:forward_dynamics_trajectory",
    "free_body_motion": "mafsil.simulation:free_body_motion",
    "inverse_dynamics_trajectory": "mafsil.simulation:inverse_dynamics_trajectory",
    "RigidBody": "mafsil.mechanics.rigid_body:RigidBody",
    "Robot": "mafsil.robot:Robot",
    "Rotation": "mafsil.geometry:Rotation",
    "Scenario": "mafsil.simulation:Scenario",
    "Scene": "mafsil.collision:Scene",
    "place": "mafsil.planning:place",
    "plan": "mafsil.planning:plan",
    "ScrewAxis": "mafsil.geometry:ScrewAxis",
    "Twist": "mafsil.geometry:Twist",
    "Wrench": "mafsil.geometry:Wrench",
    "device_array": "mafsil.kernels.device:device_array",
    "export": "mafsil.page.exporting:export",
    "lint": "mafsil.model.lint:lint",
    "load": "mafsil.robot:load",
    "mend": "mafsil.model.lint:mend",
    "show": "mafsil.page:show",
    "simulate": "mafsil.simulation:simulate",
    "solve_ik": "mafsil.ik:solve_ik",
    "Verification": "mafsil.verification:Verification",
    "verify": "mafsil.verification:verify",
}

__all__ = tuple(_HOME_OF)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'mafsil' has no attribute {name!r}")
    module, _, attribute = _HOME_OF[name].partition(":")
    found = import_module(module)
    value = getattr(found, attribute) if attribute else found
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
