"""Numbers in values that users write: each field of each public class is given NaN, infinities and wrong shapes."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import re
from collections.abc import Iterator
from enum import Enum
from functools import partial
from typing import Any

import numpy as np

from mafsil.answer import Answer
from mafsil.errors import MafsilError
from tests.public import public
from tests.reliability.decade_calls import space

NUMBERS = re.compile(r"\bfloat\b|\bBound\b|Floats|Vector|Matrix|ArrayLike|Points|RotationMatrix|Quaternion")
ARRAY = re.compile(r"Bound|Floats|Vector|Matrix|ArrayLike|Points|Quaternion|tuple")
NO_NUMBERS = re.compile(r"^(Callable|Sequence)")

WRITTEN = (
    "mf.model.Actuator(rotor_inertia=0.1, gear_ratio=10.0, armature=0.1)",
    "mf.Contact(point=(0.0, 0.0), normal=(1.0, 0.0), mu=0.5, curvature=1.0, finger_curvature=2.0)",
    "mf.Contact(point=(0, 0, 0), normal=(1, 0, 0), mu=0.5, gamma=0.1)",
    "mf.DHRow(a=1.0, alpha=0.1, d=0.2, theta=0.3, offset=0.4)",
    "mf.model.Friction(viscous=0.1, coulomb=0.2, coulomb_negative=0.3, offset=0.1)",
    "mf.model.Inertial(mass=1.0, com=[0, 0, 0], inertia=np.eye(3))",
    "mf.model.Joint(name='j', kind=mf.model.JointKind.HELICAL, parent='a', child='b', T_pj=np.eye(4), axis=[0, 0, 1], "
    "pitch=0.1)",
    "mf.model.Limits(lower=-1.0, upper=1.0, velocity=1.0, acceleration=1.0, jerk=1.0, effort=1.0)",
    "mf.model.Mimic(leader='a', multiplier=2.0, offset=0.1)",
    "mf.identification.MotionLog(t=LOG.t, q=LOG.q, tau=LOG.tau, qd=LOG.q, qdd=LOG.q)",
    "mf.Pose(array=NEAR)",
    "mf.Rotation(array=np.eye(3))",
    "mf.simulation.Sampled(values=[[0.0, 0.0], [1.0, 1.0]], step=0.1)",
    "mf.Scenario(robot=R2, trajectory=STILL, law=PID, q=Q2, qd=Q2, duration=0.1, step=0.01, period=0.02)",
    "mf.ScrewAxis(array=np.array([0, 0, 1.0, 0, 0, 0]))",
    "mf.Twist(array=np.ones(6))",
    "mf.Wrench(array=np.ones(6))",
    "collision.Box(size=(1.0, 2.0, 3.0))",
    "collision.Capsule(radius=0.1, length=1.0)",
    "collision.Cone(radius=0.1, length=1.0)",
    "collision.ConvexHull(points=HULL, rounding=0.1)",
    "collision.Cylinder(radius=0.1, length=1.0)",
    "collision.HeightMap(heights=np.zeros((2, 2)), size=(1.0, 2.0), base=-1.0)",
    "collision.ArmMount('a', R2, T_sb=np.eye(4), radius=0.02)",
    "collision.Obstacle(collision.Sphere(0.1), T_so=np.eye(4))",
    "collision.PointCloud(points=np.zeros((1, 3)), radius=0.1)",
    "collision.Sphere(radius=0.1)",
    "collision.TriangleMesh(vertices=HULL, faces=FACES)",
    "control.contact.AtPoints(environment=WALL, points=np.eye(3))",
    "control.contact.Door(hinge=np.zeros(3), axis=np.array([0, 0, 1]), handle=HANDLE, stiffness=1.0, damping=1.0, "
    "rotational_stiffness=1.0, rotational_damping=1.0, friction=0.1)",
    "control.Gains(kp=np.ones(2), kd=np.ones(2), ki=np.ones(2))",
    "control.contact.Hole(mouth=np.zeros(3), axis=np.array([0, 0, 1]), clearance=0.001, depth=0.1, chamfer=0.01, "
    "stiffness=1.0, damping=1.0, friction=0.1)",
    "control.Impedance(inertia=np.eye(2), damping=np.eye(2), stiffness=np.eye(2))",
    "control.laws.MatrixGains(kp=np.eye(2), kd=np.eye(2), ki=np.eye(2))",
    "control.contact.RoundSurface(centre=np.zeros(3), radius=1.0, stiffness=1.0, damping=1.0, friction=0.1, "
    "axis=np.array([0, 0, 1]), slow=0.1)",
    "control.SpringDamper(place=np.zeros(3), stiffness=1.0, damping=1.0)",
    "control.Wall(point=np.zeros(3), normal=np.array([0, 0, 1]), stiffness=10.0, damping=1.0, friction=0.1, slow=0.1)",
    "mf.design.Drive(mass=1.0, radius=0.1, length=0.1, stiffness=1e4)",
    "mf.design.Material(density=2700.0, young=7e10, shear=2.6e10, expansion=2e-5)",
    "mf.design.Parameter(value=0.5, low=0.1, high=1.0)",
    "mf.design.Tube(outer=0.1, wall=0.01)",
    "mf.design.Tolerances(encoder=1e-4, backlash=1e-4, zero=1e-4, length=1e-4, angle=1e-4, temperature=1.0, "
    "expansion=1e-5, stiffness=0.1)",
    "mf.design.TaskSet(poses=np.eye(4)[None], payload=1.0, centre=[0.0, 0, 0], period=1.0, characteristic_length=0.3)",
    "mf.design.Catalogue(name=['a'], peak_torque=[1.0], continuous_torque=[1.0], speed=[1.0], rotor_inertia=[1.0], "
    "ratio=[1.0], efficiency=[0.9], mass=[1.0], backlash=[1.0], cost=[1.0])",
    "geometry.Point(array=np.ones(3))",
    "geometry.Vector(array=np.ones(3))",
    "grasp.FrictionLaw(mu_s=0.5, mu_k=0.4, stribeck_speed=0.1, viscous=0.1, aging=0.1, aging_time=0.2)",
    "mobility.bodies.Car(length=1.0)",
    "mobility.bodies.Cart(radius=0.1, width=1.0)",
    "mobility.bodies.Coin(radius=0.1)",
    "mobility.linkages.BodyLoad(body='a', force=np.ones(3), at=np.zeros(3), moment=np.ones(3))",
    "mobility.linkages.BodyMass(body='a', mass=1.0, center=np.zeros(3), inertia=np.eye(3))",
    "mobility.linkages.LinkageLoads(gravity=np.ones(3))",
    "mobility.linkages.Coupling(follower='a', leader='b', ratio=2.0)",
    "mobility.FourBar(crank=2.0, coupler=4.0, rocker=3.5, ground=4.5)",
    "mobility.SliderCrank(crank=1.0, rod=3.0, offset=0.1)",
    "mobility.synthesis.FunctionTask(function=np.sqrt, interval=(1.0, 2.0), inputs=(0.0, 1.0), outputs=(0.0, 1.0))",
    "mobility.synthesis.LinkageLimits(pivots=[[-1.0, -1.0], [1.0, 1.0]], transmission=0.5, longest=3.0)",
    "mobility.synthesis.SphericalFourBar(crank=0.4, coupler=1.2, rocker=0.8, ground=1.0, A=np.eye(3)[2], "
    "D=np.array([np.sin(1.0), 0.0, np.cos(1.0)]))",
    "mobility.synthesis.ThreeLinkChain(pivot=(0.0, 0.0), lengths=(1.0, 2.0, 2.0), phase=0.1)",
    "one_joint.LoopConditions(torque_limit=1.0, tracking_time=0.1, quantum=0.1, filter_time=0.1, dither=0.1, "
    "dither_frequency=10.0)",
    "mf.identification.Measured(points=np.zeros((5, 3)), direction=np.ones(3), center=np.zeros(3), noise=0.1, "
    "angle_noise=0.1)",
    "parallel.legs.RodLimits(least_transmission=0.1, largest_condition=10.0)",
    "parallel.RodRobot(motion=parallel.legs.PlatformMotion.POINT, drive=parallel.legs.LegDrive.CRANK, base=np.eye(3), "
    "rods=np.ones(3), rotating=np.zeros((3, 3)), fixed=np.zeros((3, 3)), axes=np.eye(3), arms=np.ones(3), "
    "zeros=np.eye(3)[[1, 2, 0]])",
    "parallel.legs.RodMasses(platform=1.0, rods=np.full(3, 0.1), com=np.zeros(3), inertia=np.eye(3), arms=np.ones(3), "
    "motors=np.ones(3), sleeves=np.ones(3))",
    "parallel.legs.RodDynamics(robot=parallel.legs.rotary_delta(0.2, 0.05, 0.3, 0.8), "
    "masses=parallel.legs.RodMasses(1.0), gravity=np.ones(3))",
    "parallel.SphericalPlatform(motors=np.eye(3), zeros=np.eye(3)[[2, 0, 1]], platform=np.eye(3)[[1, 2, 0]], "
    "first=np.full(3, 1.5), second=np.full(3, 1.5))",
    "parallel.CableRobot(base=np.eye(3), platform=np.zeros((3, 3)), lowest=1.0, highest=2.0)",
    "parallel.DeltaRobot(base=0.3, platform=0.1, arm=0.3, forearm=0.8)",
    "parallel.Eclipse(guide=1.0, rod=1.2, platform=0.5)",
    "parallel.FiveBar(crank_1=1.0, rod_1=2.0, rod_2=2.0, crank_2=1.0, ground=1.5)",
    "parallel.Leg(screws=np.eye(6), home=np.eye(4))",
    "parallel.ParallelCranks(length=1.0, pivots=[0.0, 1.0])",
    "parallel.PlanarChain(lengths=[1.0, 1.0, 1.0])",
    "parallel.PlanarThreeRPR(base=[[0.0, 0], [1, 0], [0, 1]], platform=[[0.0, 0], [0.5, 0], [0, 0.5]])",
    "parallel.PlanarThreeRRR(base=[[0.0, 0], [1, 0], [0, 1]], platform=[[0.0, 0], [0.5, 0], [0, 0.5]], "
    "cranks=[1.0, 1, 1], rods=[1.0, 1, 1])",
    "parallel.PlatformLimits(shortest=0.5, longest=1.0, base_cone=1.0, platform_cone=1.0, leg_radius=0.01, "
    "least_measure=0.1)",
    "parallel.StewartPlatform(base=STEWART.base, platform=STEWART.platform)",
    "parallel.ThreeRPS(base=1.0, platform=0.6)",
    "performance.statics.LinkLoad(link='link1', force=[1.0, 0, 0], moment=[0.0, 0, 0], point=[0.0, 0, 0])",
    "planning.FixedOrientation(R=np.eye(3), tolerance=0.1)",
    "planning.GoalRegion(T=np.eye(4), box=0.1, angle=0.1, axis=[0.0, 0, 1])",
    "planning.InPlane(normal=[0.0, 0, 1], point=[0.0, 0, 0], tolerance=0.1, at=[0.0, 0, 0])",
    "planning.LoopClosed('link1', 'link2', at=[0.0, 0, 0], other_at=[0.0, 0, 0], tolerance=0.1)",
    "planning.OnLine(direction=[0.0, 0, 1], point=[0.0, 0, 0], tolerance=0.1, at=[0.0, 0, 0])",
    "planning.Problem(lower=[-1.0], upper=[1.0], free=lambda q: q[:, 0] < 2, resolution=0.02)",
    "planning.Query('plain', PROBLEM, start=np.zeros(2), goal=np.ones(2))",
    "planning.Upright(angle=0.1, axis=[0.0, 0, 1], direction=[0.0, 0, 1])",
    "simulation.Normal(mean=0.0, deviation=1.0)",
    "simulation.RigidSurface(point=[0.0, 0, 0], restitution=0.5, normal=[0.0, 0, 1], friction=0.1)",
    "simulation.SensorNoise(position=0.1, velocity=0.1)",
    "simulation.Uniform(low=0.0, high=1.0)",
    "simulation.WrenchPulse(start=0.0, duration=0.1, push=[0.0, 0, 0, 0, 0, 1])",
    "trajectory.splines.BSpline(knots=np.array([0.0, 0, 1, 1]), control=np.array([[0.0], [1.0]]), degree=1)",
    "trajectory.paths.CartesianPath(T_start=NEAR, T_goal=FAR)",
    "trajectory.KeepsClear(point=[0.0, 0, 0], distance=0.1, begin=0.0, end=1.0)",
    "trajectory.PassThrough(point=[0.0, 0, 0], distance=0.1, begin=0.0, end=1.0)",
    "trajectory.splines.PiecewisePolynomial(knots=np.array([0.0, 1.0]), coefficients=np.zeros((1, 4, 2)))",
    "trajectory.MaxDuration(least=0.0, most=1.0)",
    "trajectory.TrajectoryGenerator(trajectory=STILL, rate=10.0)",
    "trajectory.MotionLimits.of(n=1, position=2.0, velocity=1.0, acceleration=1.0, jerk=1.0, effort=1.0)",
    "trajectory.splines.PiecewisePolynomial.from_pieces(durations=[1.0], coefficients=np.zeros((1, 4, 2)))",
    "control.Gains.of(n=2, kp=1.0, kd=1.0, ki=1.0)",
    "control.Gains.from_natural_frequency(n=2, natural_frequency=1.0, damping_ratio=1.0, integral=0.1)",
    "control.laws.MatrixGains.of(n=2, kp=1.0, kd=1.0, ki=1.0)",
    "control.Impedance.of(m=2, inertia=1.0, damping=1.0, stiffness=1.0)",
    "planning.PolygonWorld.of(lower=[-1.0, -1], upper=[1.0, 1], polygons=[[[0.0, 0], [0.5, 0], [0, 0.5]]])",
    "parallel.StewartPlatform.on_circles(base=1.0, platform=0.6, base_angles=[0.0, 1, 2, 3, 4, 5], "
    "platform_angles=[0.3, 1.3, 2.3, 3.3, 4.3, 5.3])",
    "one_joint.drives.SpeedFriction.of(static=1.0, kinetic=0.5, viscous=0.1, stribeck_speed=0.1, exponent=2.0)",
    "one_joint.Backlash.of(gap=0.1, stiffness=1.0)",
    "one_joint.Gear.of(ratio=10.0, motor_inertia=0.1, efficiency=0.9, motor_friction=0.1)",
    "one_joint.drives.FrictionConditions.of(friction=one_joint.drives.SpeedFriction.of(1.0), load_share=0.1, "
    "rest_time=0.1, thinning=0.1, reference=20.0, stiffness=1.0)",
    "one_joint.ForceLoop.of(kfp=1.0, kfi=1.0, damping=1.0)",
    "one_joint.drives.TorqueLoop.of(motor_inertia=1.0, stiffness=1.0, viscous=0.1, dry=0.1, kp=1.0, ki=1.0)",
    "one_joint.drives.VariableStiffness.of(spring=1.0, radius=0.1, motor_radius=0.1, longest=0.5)",
    "one_joint.SecondOrder.of(natural_frequency=1.0, damping_ratio=0.5)",
    "one_joint.ErrorDynamics.from_row(coefficients=[1.0, 2.0, 1.0])",
    "one_joint.JointLaw.pid(kp=1.0, ki=1.0, kd=1.0)",
    "one_joint.Motor.of(constant=0.1, resistance=1.0, inductance=0.001, voltage=24.0)",
    "one_joint.drives.MotorRating.of(peak_torque=2.0, continuous_torque=1.0, speed=10.0, inertia=0.1)",
    "one_joint.ElasticJoint.of(link_inertia=1.0, motor_inertia=0.1, stiffness=1.0, damping=0.1, link_friction=0.1, "
    "motor_friction=0.1)",
    "one_joint.TrackingError.of(inertia=1.0, friction=0.1, kp=1.0, ki=0.1, kd=0.1)",
    "one_joint.ViscousJoint.of(inertia=1.0, friction=0.1)",
    "one_joint.JointArm.of(inertia=1.0, mass=0.1, radius=0.1, friction=0.1, gravity=9.81)",
    "mf.Mechanism(name='r', links=R2.mechanism.links, joints=R2.mechanism.joints, tip=R2.mechanism.tip, T_lt=NEAR, "
    "T_sb=np.eye(4), gravity=[0.0, 0, -9.81])",
    "mf.model.JointLimits(lower=[-1.0], upper=[1.0], velocity=[1.0], acceleration=[1.0], jerk=[1.0], effort=[1.0])",
    "mf.model.Mesh(reference='link.stl', scale=(1.0, 1.0, 1.0))",
    "mf.model.Shape(geometry=mf.model.Mesh('link.stl'), T_lg=np.eye(4), colour=(1.0, 0, 0, 1.0))",
    "trajectory.MotionLimits(position=[[-1.0], [1.0]], velocity=[[-1.0], [1.0]], acceleration=[[-1.0], [1.0]], "
    "jerk=[[-1.0], [1.0]], effort=[[-1.0], [1.0]])",
    "planning.PolygonWorld(lower=[-1.0, -1], upper=[1.0, 1], polygons=[[[0.0, 0], [0.5, 0], [0, 0.5]]])",
    "one_joint.drives.SpeedFriction(static=1.0, kinetic=0.5, viscous=0.1, stribeck_speed=0.1, exponent=2.0)",
    "one_joint.Backlash(gap=0.1, stiffness=1.0)",
    "one_joint.Gear(ratio=10.0, motor_inertia=0.1, efficiency=0.9, motor_friction=0.1)",
    "one_joint.drives.FrictionConditions(one_joint.drives.SpeedFriction.of(1.0), load_share=0.1, rest_time=0.1, "
    "thinning=0.1, reference=20.0, stiffness=1.0)",
    "one_joint.ForceLoop(kfp=1.0, kfi=1.0, damping=1.0)",
    "one_joint.drives.TorqueLoop(motor_inertia=1.0, stiffness=1.0, viscous=0.1, dry=0.1, kp=1.0, ki=1.0)",
    "one_joint.drives.VariableStiffness(spring=1.0, radius=0.1, motor_radius=0.1, longest=0.5)",
    "one_joint.SecondOrder(natural_frequency=1.0, damping_ratio=0.5)",
    "one_joint.ErrorDynamics(coefficients=[1.0, 2.0, 1.0])",
    "one_joint.JointLaw(one_joint.LawKind.FEEDBACK, kp=1.0, ki=1.0, kd=1.0)",
    "one_joint.Motor(constant=0.1, resistance=1.0, inductance=0.001, voltage=24.0)",
    "one_joint.drives.CurrentLoop(one_joint.Motor.of(0.1, 1.0, 0.001, 24.0), kp=1.0, ki=1.0)",
    "one_joint.drives.MotorRating(peak_torque=2.0, continuous_torque=1.0, speed=10.0, inertia=0.1)",
    "one_joint.ElasticJoint(link_inertia=1.0, motor_inertia=0.1, stiffness=1.0, damping=0.1, link_friction=0.1, "
    "motor_friction=0.1)",
    "one_joint.TrackingError(inertia=1.0, friction=0.1, kp=1.0, ki=0.1, kd=0.1)",
    "one_joint.ViscousJoint(inertia=1.0, friction=0.1)",
    "one_joint.JointArm(inertia=1.0, gravity_moment=1.0, friction=one_joint.drives.SpeedFriction.of(1.0))",
)
"""One valid value of every public class that users write themselves; what stands under a name is driven."""
MADE = (
    "ArmDesign FrontPoint Provenance SixBar "
    "Slider ActuatorKind AdaptiveControl AdmittanceControl Annulus BindingLimit BlendedLines BodyPoints BranchChange "
    "Branches Budget BurmesterCurves CellDecomposition Change Check Condition ConstrainedDynamics ContactPair "
    "ContactSwitch CornerBlend Crossing CurrentLoopLaw Delayed DeterminantFactors Detour DrivenTrajectory Dyad "
    "ElasticArm ElasticLinearization Ellipsoid EmbeddedPair EncoderLoop ExcitationTrajectory FastStretch "
    "ForceControl FourBarPoint FreeBodyDiagram FreeMotions GeneralSolutions GraspFile GraspedBody "
    "HybridControl ImpedanceByForce InfeasibleLeg JoinedPath JointCoordinates JointFeedback JointGroup "
    "JointMotionEstimate JointReactions Jump KernelRecord LawResult LearnedEffort LimitExcess LinearArm "
    "LinearQuadratic Linkage LinkageJoint LoadCapacity LocusComponent ManyDyads MatrixFeedback MinMax "
    "ModelPredictive MotionGroup MotionRequest NavigationFunction NearSingularity NearestLengths PathMotion "
    "PathPoint PathRemedy Pfaffian PinnedArm PlanarArm PlanarEllipse PlannedGrasp PlannerResult Polytope "
    "PlatformDesign PoseErrorResponse PotentialField ProfileRun PumaShape Quadtree ReducedDynamics Remedy SearchBudget "
    "SearchLog SecondBody SelfMotionFamily SensorKind Sequence ShapedMotion SingularPerturbationControl "
    "SingularityCause SlidingMode Solid Solution SolutionFamily SphereBand StructuralError Surface BranchSwitch "
    "TaskDynamics TimedArm TipDamping TipMotionEstimate Tolerance TransmissionKind UnreachableStretch Variants "
    "Violation BlockedArm "
)
"""Classes of which only functions of ours make values, of numbers that were checked or computed."""

UNBOUNDED = {
    "mf.design.Drive": ("stiffness",),
    "mf.model.Limits": ("lower", "upper", "velocity", "acceleration", "jerk", "effort"),
    "mf.model.JointLimits": ("lower", "upper", "velocity", "acceleration", "jerk", "effort"),
    "trajectory.MotionLimits": ("position", "velocity", "acceleration", "jerk", "effort"),
    "trajectory.MotionLimits.of": ("position", "velocity", "acceleration", "jerk", "effort"),
    "mf.Contact": ("finger_curvature",), "trajectory.MaxDuration": ("most",), "trajectory.PassThrough": ("end",),
    "trajectory.KeepsClear": ("end",), "one_joint.LoopConditions": ("torque_limit",),
    "one_joint.drives.FrictionConditions.of": ("stiffness",), "one_joint.drives.FrictionConditions": ("stiffness",),
    "parallel.CableRobot": ("highest",),
}  # fmt: skip
"""Fields that are documented to be infinite where there is no bound."""

BATCHED = (
    "one_joint.",
    "mf.Pose",
    "mf.Rotation",
    "mf.Twist",
    "mf.Wrench",
    "mf.ScrewAxis",
    "geometry.",
    "trajectory.",
    "mf.simulation.Sampled",
)
"""Where leading dimensions are a batch, so that many shapes are good."""
PASSING = ("mf.Pose", "mf.Rotation", "mf.ScrewAxis", "mf.Twist", "mf.Wrench", "geometry.Point", "geometry.Vector")
"""Values of geometry, of which a batch holds NaN where a row has no answer."""


def public_classes() -> dict[type, str]:
    """Public data classes with fields of real numbers that are no answers, each with its shortest name."""
    return {
        each: name
        for name, each in public()
        if inspect.isclass(each) and not issubclass(each, Enum | Answer) and numbers_of(each)
    }


def numbers_of(kind: type) -> list[tuple[str, str]]:
    """Name and annotation of the fields that hold numbers."""
    if not dataclasses.is_dataclass(kind):
        return []
    fields = [(field.name, str(field.type)) for field in dataclasses.fields(kind) if field.init]
    return [(name, kind) for name, kind in fields if NUMBERS.search(kind) and not NO_NUMBERS.search(kind)]


def names() -> dict[str, Any]:
    """What the texts use."""
    found = dict(space(""))
    stewart = found["parallel"].StewartPlatform.on_circles(1.0, 0.6, range(6), np.arange(6) + 0.3)
    wall = found["control"].Wall(np.zeros(3), [0, 0, 1], 10.0)
    return {**found, "STEWART": stewart, "WALL": wall, "HANDLE": found["geometry"].pose.exp([0.0, 0, 0, 1, 0, 0])}


def wrong_values(kind: str, value: Any, *, unbounded: bool, passing: bool, batched: bool) -> Iterator[Any]:
    """What a field must refuse: not finite, no numbers, another shape.

    Args:
        kind: the annotation.
        value: what it holds.
        unbounded, passing: whether infinity has a meaning; NaN too.
        batched: whether any shape does.
    """
    array = np.asarray(value, dtype=np.float64)
    for bad in () if passing else (np.nan,) if unbounded else (np.nan, np.inf, -np.inf):
        changed = array.copy() if array.size else np.zeros(1)
        changed[(-1,) * changed.ndim] = bad
        yield changed if changed.ndim else bad
    yield from ("text", 1j, {}, [[1.0], [1.0, 2.0]])
    if "None" not in kind:
        yield None
    if not batched:
        yield np.zeros((2, 5, 4, 3))
    if not ARRAY.search(kind):
        yield [1.0, 2.0]


def misses(text: str, known: dict[str, Any]) -> list[str]:
    """The wrong values that a class takes, or answers with an error that is not ours.

    Args:
        text: a valid call.
        known: the names that it uses.
    """
    call = ast.parse(text, mode="eval").body
    assert isinstance(call, ast.Call)
    name = ast.unparse(call.func)
    make = eval(name, known)
    make = partial(make, *(eval(ast.unparse(each), known) for each in call.args))
    given = {str(each.arg): eval(ast.unparse(each.value), known) for each in call.keywords}
    make(**given)
    kinds = {each.name: str(each.annotation) for each in inspect.signature(make).parameters.values()}
    found = list[str]()
    for argument, value in given.items():
        kind = kinds[argument]
        if not NUMBERS.search(kind) or NO_NUMBERS.search(kind):
            continue
        meant = {
            "unbounded": argument in UNBOUNDED.get(name, ()),
            "passing": name in PASSING,
            "batched": name.startswith(BATCHED) or name == "control.Gains",
        }
        for bad in wrong_values(kind, value, **meant):
            said = f"{name}({argument}={str(bad)[:40]!r})".replace("\n", " ")
            try:
                make(**{**given, argument: bad})
            except MafsilError as error:
                if error.message("ar") == error.message("en"):
                    found.append(f"{said}: refused in one language")
            except Exception as error:
                found.append(f"{said}: {type(error).__name__}: {str(error)[:60]}")
            else:
                found.append(f"{said}: taken")
    return found
