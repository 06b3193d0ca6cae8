"""Closed chains for tests: random ones closed by construction, a planar four-bar, and their twins in Pinocchio."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

import mafsil as mf
from mafsil.geometry import pose
from mafsil.mobility.linkages.linkage_joint import across
from mafsil.model import Inertial, Joint, JointKind, Link, Mechanism
from tests.oracles.pinocchio_model import model_of


def random_pose(rng, size=0.4):
    return pose.exp(np.concatenate([rng.normal(size=3), size * rng.normal(size=3)]))


def random_axis(rng):
    axis = rng.normal(size=3)
    return axis / np.linalg.norm(axis)


def random_body(rng, name):
    A = 0.1 * rng.normal(size=(3, 3))
    com = 0.1 * rng.normal(size=3)
    second_moment = A @ A.T + 0.01 * np.eye(3)
    inertia = np.trace(second_moment) * np.eye(3) - second_moment
    return Link(name, inertial=Inertial(mass=rng.uniform(0.5, 2), com=com, inertia=inertia))


def allowed_motion(rng, joint):
    """(4, 4) a displacement that the joint allows."""
    a, s, (first, second) = joint.axis, joint.second, across(joint.axis)
    angle, shift, other = rng.uniform(-1, 1, 3)
    match joint.kind:
        case JointKind.CYLINDRICAL:
            twists = [[*a * angle, *a * shift]]
        case JointKind.UNIVERSAL:
            twists = [[*a * angle, 0, 0, 0], [*s * shift, 0, 0, 0]]
        case JointKind.SPHERICAL:
            twists = [[angle, shift, other, 0, 0, 0]]
        case JointKind.PLANAR:
            twists = [[0, 0, 0, *shift * first + other * second], [*a * angle, 0, 0, 0]]
        case _:
            twists = [0.7 * joint.screw]
    T = np.eye(4)
    for twist in twists:
        T = T @ pose.exp(np.asarray(twist))
    return T


def random_chain(rng, kind, n=9):
    """Two arms whose ends a joint of some kind connects, closed at the coordinates that are returned."""
    half = n // 2
    links = [Link("base"), *(random_body(rng, f"l{k}") for k in range(n))]
    joints = []
    for k in range(n):
        moves = JointKind.REVOLUTE if rng.random() < 0.8 else JointKind.PRISMATIC
        parent = "base" if k in (0, half) else f"l{k - 1}"
        joints.append(Joint(f"j{k}", moves, parent, f"l{k}", random_pose(rng), random_axis(rng)))
    tree = Mechanism.assemble("random", links, joints, tip=f"l{n - 1}")
    robot, q = mf.Robot(tree), rng.uniform(-1, 1, n)
    ends = [robot.forward_kinematics(q, frame=f"l{k}") for k in (half - 1, n - 1)]
    axis = random_axis(rng)
    pitch = 0.1 * (kind is JointKind.HELICAL)
    loop = Joint("loop", kind, f"l{half - 1}", f"l{n - 1}", axis=axis, pitch=pitch, second=across(axis)[0])
    T = pose.inverse(ends[0]) @ ends[1] @ pose.inverse(allowed_motion(rng, loop))
    return replace(tree, loops=(replace(loop, T_pj=T),)), q


def bar(name, length):
    inertia = np.diag([1e-4, length**3 / 12, length**3 / 12])
    return Link(name, inertial=Inertial(mass=length, com=np.array([length / 2, 0, 0]), inertia=inertia))


def shifted(x):
    T = np.eye(4)
    T[0, 3] = x
    return T


def four_bar(ground=1.0, crank=0.4, coupler=1.1, rocker=0.8, driven=("A",)):
    """In the vertical plane; masses per length of one."""
    upright = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    z = np.array([0, 0, 1.0])
    places = {"A": ("base", "crank", upright), "B": ("crank", "coupler", shifted(crank))}
    places["D"] = ("base", "rocker", shifted(ground) @ upright)
    joints = [
        Joint(name, JointKind.REVOLUTE, parent, child, T, z, actuated=name in driven)
        for name, (parent, child, T) in places.items()
    ]
    joints.append(Joint("tip", JointKind.FIXED, "rocker", "end", shifted(rocker)))
    loop = Joint("C", JointKind.REVOLUTE, "coupler", "end", shifted(coupler), z, actuated=False)
    links = [Link("base"), bar("crank", crank), bar("coupler", coupler), bar("rocker", rocker), Link("end")]
    return Mechanism.assemble("four bars", links, joints, loops=[loop], tip="coupler")


class Twin:
    """The same closed chain in Pinocchio: a weld as a contact of six rows, a ball as one of three, a hinge as two."""

    def __init__(self, mechanism):
        self.model, frames = model_of(replace(mechanism, loops=()))
        self.data = self.model.createData()
        (loop,) = mechanism.loops
        ends = [self.model.frames[frames[mechanism.link_names.index(name)]] for name in (loop.parent, loop.child)]
        ids = [frame.parentJoint for frame in ends]
        first, second = ends[0].placement * pin.SE3(np.array(loop.T_pj)), ends[1].placement
        if loop.kind is JointKind.FIXED:
            pairs, kind = [(first, second)], pin.ContactType.CONTACT_6D
        elif loop.kind is JointKind.SPHERICAL:
            pairs, kind = [(first, second)], pin.ContactType.CONTACT_3D
        else:
            points = [pin.SE3(np.eye(3), length * np.array(loop.axis)) for length in (0.0, 0.5)]
            pairs, kind = [(first * point, second * point) for point in points], pin.ContactType.CONTACT_3D
        frame = pin.ReferenceFrame.LOCAL
        self.contacts, self.states = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
        for a, b in pairs:
            self.contacts.append(pin.RigidConstraintModel(kind, self.model, ids[0], a, ids[1], b, frame))
            self.states.append(self.contacts[-1].createData())
        self.settings = pin.ProximalSettings(1e-14, 1e-12, 50)
        pin.initConstraintDynamics(self.model, self.data, self.contacts, self.states)

    def accelerations(self, q, qd, tau):
        return pin.constraintDynamics(self.model, self.data, q, qd, tau, self.contacts, self.states, self.settings)


def hexapod(height=1.2):
    """A Stewart-Gough platform, 6-UPS: its first leg carries the platform, the other five end in balls on it."""
    foot = [np.array([np.cos(a), np.sin(a), 0.0]) for a in np.deg2rad([0, 30, 120, 150, 240, 270])]
    top = [0.6 * np.array([np.cos(a), np.sin(a), 0.0]) for a in np.deg2rad([-15, 45, 105, 165, 225, 285])]
    rod = Inertial(mass=0.5, com=np.array([0, 0, 0.1]), inertia=np.diag([0.01, 0.01, 0.005]))
    ring = Inertial(mass=0.2, com=np.zeros(3), inertia=0.01 * np.eye(3))
    table = Inertial(mass=5.0, com=-top[0], inertia=np.diag([0.3, 0.3, 0.5]))
    links, joints, loops = [Link("base")], [], []
    x, y, z = np.eye(3)

    def joint(name, kind, parent, link, T=None, axis=z, driven=False):
        links.append(link)
        joints.append(Joint(name, kind, parent, link.name, np.eye(4) if T is None else T, axis, actuated=driven))

    for k in range(6):
        along = top[k] + height * z - foot[k]
        length = np.linalg.norm(along)
        turn = _upright(along / length)
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = turn, foot[k]
        joint(f"a{k}", JointKind.REVOLUTE, "base", Link(f"fork{k}", inertial=rod), T, x)
        joint(f"b{k}", JointKind.REVOLUTE, f"fork{k}", Link(f"tube{k}", inertial=rod), axis=y)
        joint(f"P{k}", JointKind.PRISMATIC, f"tube{k}", Link(f"rod{k}", inertial=rod), driven=True)
        end = np.eye(4)
        end[2, 3] = length
        if k:
            joint(f"e{k}", JointKind.FIXED, f"rod{k}", Link(f"ball{k}"), end)
            seat = np.eye(4)
            seat[:3, 3] = top[k] - top[0]
            loops.append(Joint(f"loop{k}", JointKind.SPHERICAL, "platform", f"ball{k}", seat, z, actuated=False))
            continue
        end[:3, :3] = turn.T
        joint("s1", JointKind.REVOLUTE, "rod0", Link("ring1", inertial=ring), end, x)
        joint("s2", JointKind.REVOLUTE, "ring1", Link("ring2", inertial=ring), axis=y)
        joint("s3", JointKind.REVOLUTE, "ring2", Link("platform", inertial=table))
    return Mechanism.assemble("hexapod", links, joints, loops=loops, tip="platform")


def _upright(z):
    """(3, 3) a rotation that takes z there."""
    x = np.cross([0, 1.0, 0], z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)
