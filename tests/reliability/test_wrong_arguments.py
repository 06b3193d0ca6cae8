"""Row F3 at the size of a pull request: one wrong argument in valid calls of public functions."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import mafsil as mf
from mafsil import control, trajectory
from mafsil.errors import InputError, InputWarning, MafsilError
from mafsil.trajectory import JointPath, MotionLimits
from tests.reliability import wrong_arguments
from tests.sizes import size

OPEN = ("=a class): ", "grasp.eliminate(A=ragged)")
"""A class can be called, too; rows of unequal length are found by NumPy."""


@pytest.mark.row("F3")
def test_a_wrong_argument_is_said_in_our_words():
    counts, foreign = wrong_arguments.work(wrong_arguments.CALLS[:: size(8, 1)])
    late = [each for each in foreign if each.endswith(": late")]
    assert [each for each in foreign if each not in late and not any(words in each for words in OPEN)] == []
    assert counts["ours"] > 10 * counts["answered"]
    assert len(late) < 0.01 * counts["ours"]


LIMITS = MotionLimits.of(1, velocity=1.0, acceleration=1.0, jerk=1.0)
SENTENCES = {
    "minimum_duration: expected a number, got None": lambda: trajectory.jerk_limited(
        [0], [1], LIMITS, minimum_duration=None
    ),
    "trajectory: expected Trajectory, got str 'x'": lambda: trajectory.check("x", LIMITS),
    "MotionLimits: argument position, acceleration, jerk, effort is missing": lambda: MotionLimits(velocity=1),
    "JointPath.through: argument point is unknown": lambda: JointPath.through(point=3),
    "Gains.of: argument kq is unknown": lambda: control.Gains.of(1, kq=1),
    "plan: argument scene, start, goal is missing": lambda: mf.plan("ur5e"),
    "jerk_limited: argument goal, limits is missing (given: start)": lambda: trajectory.jerk_limited(1),
    "f: expected a function of 1 argument, got": lambda: mf.ik.find_root(lambda: 0, [1.0]),
}


@pytest.mark.parametrize("words", SENTENCES)
def test_the_gate_names_the_argument_what_it_should_be_and_what_it_is(words):
    with pytest.raises(InputError) as caught:
        SENTENCES[words]()
    assert str(caught.value).startswith(words)
    assert caught.value.message("ar") != caught.value.message("en")


def test_what_fits_is_not_to_blame():
    """An error that a user's own function raises goes on as it is, and so does one that no argument explains."""

    def broken(x):
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        mf.ik.find_root(broken, np.ones(2))


def test_methods_of_what_functions_give_back_pass_the_gate():
    """Nobody has asked for the class by its name."""
    code = """
from mafsil import trajectory
try:
    trajectory.bspline([[0.0], [1.0], [2.0], [1.0]], 1.0).derivative(no_such=1)
except Exception as error:
    print(type(error).__name__, error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("ArgumentError BSpline.derivative: argument no_such is unknown")


def test_public_functions_are_themselves_wherever_they_are_found():
    asked = trajectory.jerk_limited
    from mafsil.trajectory.jerk.via_points import jerk_limited

    assert asked is jerk_limited
    assert trajectory.jerk.jerk_limited is jerk_limited


UR5E, PLANAR2R = mf.load("ur5e"), mf.load("planar2r")
Q = np.array([0.1, -1.0, 1.0, 0.2, 0.3, 0.4])
T = UR5E.forward_kinematics(Q)
FAR = np.block([[T[:3, :3], 1000.0 * T[:3, 3:]], [np.zeros(3), 1.0]])
DEGREES, NO_MOTION = [10, -60, 60, 10, 20, 30], trajectory.profiles.rest([0.0, 0.0], 1.0)
FIRST_HOUR = {
    "base_angles: -15 rad is more than a whole turn": lambda: mf.parallel.StewartPlatform.on_circles(
        1, 0.6, [-15, 15, 105, 135, 225, 255], [0, 1, 2, 3, 4, 5]
    ),
    "write robot.fk(q)": lambda: UR5E.fkine(Q),
    'expressed_in="aligned")': lambda: UR5E.jacob0(Q),
    "robot.ik(T, q0) for the nearest": lambda: UR5E.ikine_LM(T),
    "robot.ik_all(T) for all": lambda: UR5E.inverse_kinematics(T),
    "write robot.show()": lambda: UR5E.teach(Q),
    "write robot.n": lambda: UR5E.dof,
    "write robot.inverse_dynamics(q, qd, qdd)": lambda: UR5E.rne(Q, Q, Q),
    "write robot.mass_matrix(q)": lambda: UR5E.inertia(Q),
    "write robot.limits": lambda: UR5E.qlim,
    "mf.performance.manipulability(robot, q)": lambda: UR5E.manipulability(Q),
    "mafsil has no attribute 'Panda': write mf.load(\"panda\")": lambda: mf.Panda,
    "mafsil.ik has no attribute 'ik': write robot.ik_all": lambda: mf.ik(UR5E, T),
    "write mf.robots()": lambda: mf.list_robots,
    "mf.simulation.monte_carlo": lambda: mf.montecarlo,
    "mf.Pose(T), or mf.Pose.of(R, p)": lambda: mf.SE3(0, 0, 1),
    'mf.Robot.from_dh(rows, "classic")': lambda: mf.DHRobot([]),
    "mf.trajectory.trapezoid(": lambda: trajectory.trapezoidal([0], [1]),
    "has no attribute 'PID'; did you mean: pid": lambda: control.PID(1, 2, 3),
    "if they are one value, write Robot.fk((0.1, -1, 1, 0.2, 0.3, 0.4))": lambda: UR5E.fk(*Q),
    "with the last row 0 0 0 1": lambda: UR5E.ik(T[:3]),
    "mass: expected real numbers, got str '2kg'": lambda: UR5E.with_payload("2kg"),
    "make one by JointPath.through": lambda: trajectory.time_optimal([[0, 0], [1, 1]], LIMITS),
    "argument vel is unknown or given twice; did you mean: velocity?": lambda: MotionLimits.of(2, vel=1),
    "language '/nowhere' is not known; choose one of: en, ar": lambda: mf.solve_ik(UR5E, T).explain(
        language="/nowhere"
    ),
    "source: expected": lambda: mf.model.urdf.read(3.5),
    "path: expected": lambda: mf.job.read_job(None),
    "did you mean: iiwa7": lambda: mf.load("kuka"),
    "MotionLimits.of makes one of what matters: it takes n": lambda: MotionLimits(velocity=1),
    "impedance: expected Impedance, got int 100; make one by Impedance.of": lambda: control.impedance_control(
        PLANAR2R, 100, control.hold_pose(np.eye(4))
    ),
    "Scenario(robot=..., trajectory=..., law=...)": lambda: mf.Scenario(PLANAR2R, NO_MOTION, None),
    "Checker: argument margin is unknown or given twice; did you mean: clearance?": lambda: mf.collision.Checker(
        UR5E, margin=0.02
    ),
    "Box((1, 2, 3))": lambda: mf.collision.Box(1, 2, 3),
    "did you mean: base, platform?": lambda: mf.parallel.DeltaRobot(rb=0.3, re=0.1),
    "did you mean: natural_frequency, damping_ratio?": lambda: control.computed_torque(UR5E, kp=100, kd=20),
    "write mf.Rotation(R) or mf.Pose(T)": lambda: mf.Rotation.from_matrix(np.eye(3)),
    "mf.Pose.of(mf.Rotation.from_rpy(rpy), xyz)": lambda: mf.Pose.from_xyz_rpy([0, 0, 1], [0, 0, 0]),
    "Pose.of(R, p) joins both": lambda: mf.Pose(np.eye(3), [0, 0, 1]),
    "transpose it with .T": lambda: mf.inverse_kinematics(UR5E, T.T),
    "different lengths (2, 6 numbers)": lambda: UR5E.forward_kinematics([[0, 0, 0, 0, 0, 0], [0, 0]]),
    "degrees: expected True or False, got str 'no'": lambda: mf.Robot.from_dh([[0, 0, 1, 0]], "classic", degrees="no"),
    "other: expected Pose, got ndarray": lambda: mf.Pose(T).displacement_to(T),
    "got (); Impedance.of makes one of what matters: it takes m": lambda: control.Impedance(1, 2, 3),
    "law: expected shape n = 2, got n = 6": lambda: mf.Scenario(
        robot=PLANAR2R, trajectory=NO_MOTION, law=control.pid(6, 1, 0, 1)
    ),
    "q: expected shape (*batch, 2), got (3,)": lambda: mf.control.TaskCoordinates().pose(PLANAR2R, [0, 0, 0]),
}
"""What a beginner writes in the first hour: each answer names what was wrong and what to write."""


@pytest.mark.parametrize("words", FIRST_HOUR)
def test_the_first_hour_is_answered_with_what_to_write(words: str) -> None:
    with pytest.raises(MafsilError) as caught:
        FIRST_HOUR[words]()
    assert words in str(caught.value)
    assert caught.value.message("ar") != caught.value.message("en")


REMARKS = {
    "q0: -60 rad at joint 'shoulder_lift_joint'": lambda robot: mf.solve_ik(robot, T, q0=DEGREES),
    "q0: -60 rad": lambda robot: mf.inverse_kinematics(robot, T, q0=DEGREES),
    "q: -60 rad": lambda robot: robot.forward_kinematics(DEGREES),
    "inputs: 20 rad": lambda robot: mf.mobility.synthesise_function([20, 40, 60], [30, 45, 70]),
    "poses: 17 rad": lambda robot: mf.mobility.synthesise_motion([[0, 0, 0], [1, 1, 17], [2, 2.5, 46]]),
    "theta_1: 90 rad": lambda robot: mf.mobility.FourBar(2, 4, 3.5, 4.5).positions(90),
    "q: 30 rad": lambda robot: mf.parallel.DeltaRobot(0.3, 0.1, 0.3, 0.8).forward_kinematics([30, 30, 30]),
    "rpy: 90 rad": lambda robot: mf.Rotation.from_rpy([0, 0, 90]),
    "tool: 150 m is implausibly long": lambda robot: robot.with_tool([0, 0, 150]),
    "the start is outside the joint limits: shoulder_pan_joint at 8": lambda robot: mf.simulate(
        mf.Scenario(
            robot=robot, trajectory=trajectory.profiles.rest([8.0, 0, 0, 0, 0, 0.5], 0.01), law=control.pid(6, 1, 0, 1)
        )
    ),
}


@pytest.mark.parametrize("words", REMARKS)
def test_degrees_and_millimetres_are_remarked_on(words: str) -> None:
    with pytest.warns(InputWarning) as said:
        REMARKS[words](mf.load("ur5e"))
    assert any(words in str(each.message) for each in said)


def test_targets_in_millimetres_are_said_to_be():
    assert "divide its translation by 1000" in mf.solve_ik(UR5E, FAR).explain()
    assert "divide its translation by 1000" in mf.inverse_kinematics(UR5E, FAR).explain()


@pytest.mark.parametrize("name", ["four-bar", "Four Bar", "fourbar", "FOUR_BAR"])
def test_mechanisms_are_known_however_they_are_written(name: str) -> None:
    assert mf.mobility(name).explain() == mf.mobility("four_bar").explain()
