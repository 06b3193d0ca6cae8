"""Published robots from their tables: reach, payload, torque and repeatability beside their makers' statements.

docs/design.md names the data sheets and has the table; the numbers of its rows are those of `STATED`.
"""

from __future__ import annotations

from math import pi
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.design import ParametricArm, Tolerances, accuracy
from mafsil.design.family import ArmNumbers, reach_and_void
from mafsil.geometry import rotation
from mafsil.parallel import DeltaRobot, StewartPlatform
from mafsil.performance.velocity.scaling import ranges

PAGE = Path(__file__).resolve().parents[2] / "docs/design.md"
FIXED = {"lower": 0.0, "upper": 0.0}
PUMA = {
    "convention": "modified", "parameters": {"a2": 0.4318, "a3": 0.0203, "d3": 0.15005, "d4": 0.4318},
    "joint": [{}, {"alpha": "-pi / 2"}, {"a": "a2", "d": "d3"}, {"a": "a3", "d": "d4", "alpha": "-pi / 2"},
              {"alpha": "pi / 2"}, {"alpha": "-pi / 2"}],
}  # fmt: skip
UR5E = {
    "convention": "classic",
    "parameters": {"d1": 0.1625, "a2": 0.425, "a3": 0.3922, "d4": 0.1333, "d5": 0.0997, "d6": 0.0996},
    "joint": [{"d": "d1", "alpha": "pi / 2"}, {"a": "-a2"}, {"a": "-a3", "limits": FIXED},
              {"d": "d4", "alpha": "pi / 2", "limits": FIXED}, {"d": "d5", "alpha": "-pi / 2", "limits": FIXED},
              {"d": "d6", "limits": FIXED}],
}  # fmt: skip
IIWA7 = {
    "convention": "classic", "parameters": {"bs": 0.34, "se": 0.4, "ew": 0.4},
    "joint": [{"d": "bs", "alpha": "-pi / 2"}, {"alpha": "pi / 2"}, {"d": "se", "alpha": "pi / 2"},
              {"alpha": "-pi / 2"}, {"d": "ew", "alpha": "-pi / 2"}, {"alpha": "pi / 2"}, {}],
}  # fmt: skip
PANDA = {
    "convention": "modified",
    "parameters": {"d1": 0.333, "d3": 0.316, "a": 0.0825, "d5": 0.384, "a7": 0.088, "flange": 0.107},
    "joint": [{"d": "d1"}, {"alpha": "-pi / 2"}, {"d": "d3", "alpha": "pi / 2"}, {"a": "a", "alpha": "pi / 2"},
              {"a": "-a", "d": "d5", "alpha": "-pi / 2"}, {"alpha": "pi / 2"}, {"a": "a7", "alpha": "pi / 2"}],
    "tool": {"xyz": [0.0, 0.0, "flange"]},
}  # fmt: skip
STATED = {
    "puma560": (PUMA, 863.6, 2.5, 0.1),
    "ur5e": (UR5E, 850.0, 5.0, 0.03),
    "panda": (PANDA, 855.0, 3.0, 0.1),
    "iiwa7": (IIWA7, 800.0, 7.0, 0.1),
}
"""Table, reach [mm], payload [kg], repeatability [mm] of the data sheets."""


def _row(name: str) -> list[str]:
    """Cells of a robot's row in the table of the page, without its name."""
    (line,) = (line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith(f"| `{name}`"))
    return [cell.strip() for cell in line.strip("|").split("|")][1:]


@pytest.mark.parametrize("name", STATED)
def test_reach_is_within_one_percent_of_the_data_sheet(name: str) -> None:
    table, stated, _, _ = STATED[name]
    robot = ParametricArm.of(table).robot()
    arm = ArmNumbers.stack([ArmNumbers.of(robot)])
    (reach,), _ = reach_and_void(arm, *(bound[None] for bound in ranges(robot)))
    # The Puma's data sheet leaves out its sideways offset.
    aside = table["parameters"]["d3"] if name == "puma560" else 0.0
    reach = 1e3 * np.sqrt(reach**2 - aside**2)
    assert reach == pytest.approx(stated, rel=0.01)
    assert _row(name)[0] == f"{reach:.1f} / {stated:.4g}"


def test_reach_of_the_ur5e_along_the_floor() -> None:
    """With all joints at zero the flange stands 849.7 mm from axis 1, of 850 mm that the data sheet gives."""
    assert np.hypot(*mf.load("ur5e").fk(np.zeros(6))[:2, 3]) == pytest.approx(0.850, rel=1e-3)


@pytest.mark.parametrize("name", STATED)
def test_payload_and_torque_are_within_the_data_sheet(name: str) -> None:
    """The published torques hold the stated payload everywhere, sampled over the joint ranges."""
    _, _, payload, _ = STATED[name]
    robot = mf.load(name)
    q = np.random.default_rng(0).uniform(*ranges(robot), (50_000, robot.n))
    held = float(np.nan_to_num(mf.performance.largest_payload(robot, q).largest, nan=0.0).min())
    share = np.abs(robot.with_payload(payload, com=(0, 0, 0)).gravity_torque(q)) / robot.limits.effort
    assert held > payload
    assert share.max() < 1.0
    assert _row(name)[1:3] == [f"{held:.1f} / {payload:.4g}", f"{100 * share.max():.0f}"]


@pytest.mark.parametrize("name", STATED)
def test_repeatability_beside_the_data_sheet(name: str) -> None:
    """Three standard deviations of the distance for one play at all joints, arm stretched as far as samples show."""
    _, _, _, stated = STATED[name]
    robot = mf.load(name)
    q = np.random.default_rng(0).uniform(*ranges(robot), (50_000, robot.n))
    far = q[np.linalg.norm(robot.fk(q)[:, :3, 3], axis=1).argmax()]
    play = stated / (3e3 * accuracy(robot, far, Tolerances(backlash=1.0)).repeatability)
    assert _row(name)[3:] == [f"{stated:.4g}", f"{1e6 * play:.0f}"]


def test_repeatability_of_the_puma_from_its_encoders() -> None:
    """1,000 counts a turn of each motor through its gear: 0.1 mm of the data sheet holds for 99.7 % of visits."""
    ratios = np.abs([actuator.gear_ratio for actuator in _actuators("puma560")])
    error = accuracy("puma560", [0, 0, pi / 2, 0, 0, 0], Tolerances(encoder=2 * pi / 1000 / ratios), samples=20_000)
    assert np.quantile(np.linalg.norm(error.samples[:, 3:], axis=1), 0.997) < 0.1e-3


def _actuators(name: str) -> list:
    return [joint.actuator for joint in mf.load(name).mechanism.coordinates]


IRB360 = DeltaRobot(base=0.164, platform=0.044, arm=0.524, forearm=1.244)
"""IRB 360-1/1600 as measured by Williams, The Delta Parallel Robot: Kinematics Solutions, 2015."""


def test_delta_has_the_published_motor_angles() -> None:
    q = np.degrees(IRB360.inverse_kinematics([[0.0, 0.0, -0.9], [-0.5, 0.3, -1.1]]).q[..., 0])
    np.testing.assert_allclose(q[0], -20.5, atol=0.05)
    # His first leg stands along -y, ours along x: his place (0.3, 0.5, -1.1) m.
    np.testing.assert_allclose(q[1], [47.5, -11.6, 21.4], atol=0.05)


def test_delta_reaches_the_stated_cylinder() -> None:
    """1,600 mm across and 300 mm high, within motor angles of -40 to 80 degrees; the rods alone allow 9 % more."""
    turn, z = np.linspace(0.0, 2 * pi, 181), np.linspace(-1.2, -0.9, 7)[:, None]

    def reached(radius: float) -> bool:
        p = np.stack(np.broadcast_arrays(radius * np.cos(turn), radius * np.sin(turn), z), axis=-1)
        found = IRB360.inverse_kinematics(p)
        q = np.degrees(found.q[..., 0])
        return bool(found.reached.all() and q.min() >= -40.0 and q.max() <= 80.0)

    assert reached(0.800)
    assert not reached(0.880)


def _simona() -> StewartPlatform:
    """Gimbals on circles of 1.65 m (0.6 m apart in pairs) and 1.60 m (0.2 m apart) of the SIMONA simulator."""

    def pairs(radius: float, apart: float, first: float) -> np.ndarray:
        middle = np.radians([first, first + 120.0, first + 240.0])
        half = np.arcsin(apart / 2 / radius)
        return np.stack([middle - half, middle + half], axis=-1).ravel()

    return StewartPlatform.on_circles(1.65, 1.60, pairs(1.65, 0.6, 60.0), np.roll(pairs(1.60, 0.2, 0.0), -1))


@pytest.mark.parametrize(
    ("axis", "low", "high"),
    [("x", -0.981, 1.259), ("y", -1.031, 1.031), ("z", -0.678, 0.636), ("roll", -25.9, 25.9), ("pitch", -24.3, 23.7),
     ("yaw", -41.6, 41.6)],
)  # fmt: skip
def test_simulator_has_its_published_excursions(axis: str, low: float, high: float) -> None:
    """Each alone from the middle, legs of 2.131 to 3.281 m: surge, sway, heave [m], roll, pitch, yaw [deg]."""
    robot = _simona()
    names = ("x", "y", "z", "roll", "pitch", "yaw")

    def lengths(value: float, height: float) -> np.ndarray:
        T = np.eye(4)
        T[2, 3] = height
        if names.index(axis) < 3:
            T[names.index(axis), 3] += value
        else:
            T[:3, :3] = rotation.from_rpy(np.radians(value) * np.eye(3)[names.index(axis) - 3])
        return robot.lengths(T)

    def beyond(value: float) -> float:
        legs = lengths(value, rest)
        return max(legs.max() - 3.281, 2.131 - legs.min())

    rest = _root(lambda height: lengths(0.0, height).max() - 2.706, 1.0, 3.0)
    for stated in (low, high):
        assert _root(beyond, 0.0, 1.3 * stated) == pytest.approx(stated, rel=2e-3)


def _root(f, low: float, high: float) -> float:
    from scipy.optimize import brentq

    return float(brentq(f, low, high))
