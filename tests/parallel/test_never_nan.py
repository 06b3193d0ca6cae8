"""Where nothing fits, answers hold the nearest there is and say how far it is: no NaN in them, nor in what they say."""

import warnings

import numpy as np
import pytest

from mafsil import mobility as mo
from mafsil import parallel as pa

ALL = np.linspace(-np.pi, np.pi, 9)
RPR = pa.PlanarThreeRPR([[0, 0], [4, 0], [2, 3]], [[0, 0], [1, 0], [0.5, 0.8]])
RRR = pa.PlanarThreeRRR(RPR.base, RPR.platform, [1, 1, 1.0], [1.2, 1.2, 1.2])
TURN = np.radians([0, 60, 120, 180, 240, 300])
HEXAPOD = pa.StewartPlatform.on_circles(1, 0.6, TURN + np.tile([0.1, -0.1], 3), TURN + np.tile([-0.2, 0.2], 3))
DELTA, FIVE = pa.DeltaRobot(0.3, 0.1, 0.4, 0.05), pa.FiveBar(1, 0.2, 0.25, 1, 2)
PLANE = pa.CableRobot([[0, 0], [1, 0], [0, 1.0]], [[0.4, 0.4], [0.5, 0.4], [0.4, 0.5]], np.ones(3), np.full(3, 9.0))
ASKED = {
    "four-bar": lambda: mo.FourBar(2, 3, 2.5, 4).positions(ALL),
    "four-bar that never closes": lambda: mo.FourBar(1, 1, 1, 3.5).positions(ALL),
    "rocker": lambda: pa.planar.output_angles(mo.FourBar(4, 3, 3, 4), ALL),
    "rates": lambda: mo.FourBar(2, 2, 2, 2).branch_rates(mo.FourBar(2, 2, 2, 2).positions(ALL).theta),
    "slider": lambda: mo.SliderCrank(1, 0.5, 0.2).positions(ALL),
    "slider rates": lambda: mo.SliderCrank(1, 0.5, 0.2).rates(ALL),
    "slider that never reaches": lambda: mo.SliderCrank(1, 3, 5).positions(ALL),
    "five-bar": lambda: FIVE.forward_kinematics(np.stack([ALL, -ALL], axis=-1)),
    "five-bar chain": lambda: FIVE.chain_angles(np.stack([ALL, -ALL], axis=-1)),
    "five-bar motors": lambda: FIVE.inverse_kinematics([[50.0, 0.0], [0.0, 0.0], [2.0, 0.0]]),
    "Delta": lambda: DELTA.forward_kinematics(np.stack([ALL, -ALL, 2 * ALL], axis=-1)),
    "Delta in the middle": lambda: DELTA.forward_kinematics([np.arccos(-0.5)] * 3),
    "Delta motors": lambda: DELTA.inverse_kinematics([[0, 0, -5.0], [0, 0, 0]]),
    "3-RPR": lambda: RPR.forward_kinematics([0.1, 0.1, 9.0]),
    "3-RPR of no length": lambda: RPR.forward_kinematics([0.0, 0.0, 0.0]),
    "3-RPR batch": lambda: RPR.forward_kinematics(np.tile([0.1, 0.1, 9.0], (2, 1))),
    "3-RRR": lambda: RRR.forward_kinematics([[3.0, 0.0, 1.5]]),
    "hexapod": lambda: HEXAPOD.forward_near([[0.01] * 6, [0.0] * 6], np.eye(4)),
    "3-RPS": lambda: pa.ThreeRPS(1, 0.5).forward_kinematics([5, 0.1, 0.1]),
    "cables": lambda: pa.cable_tensions(PLANE, [0.0, 0.0, 0.3], np.full((2, 3), 1e4)),
    "too few cables": lambda: pa.cable_tensions(
        pa.CableRobot([[0, 0], [1, 0]], [[0, 0.5], [1, 0.5]], [1, 1], [9, 9]), [0.0, 0.2, 0.0], [0.0, 0.0, -2.0]
    ),
    "no cables asked": lambda: pa.cable_tensions(PLANE, np.zeros((0, 3)), np.zeros((0, 3))),
}  # fmt: skip


def numbers(value):
    """All arrays and numbers in plain data."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list | tuple):
        for each in value:
            yield from numbers(each)
    elif isinstance(value, float | np.ndarray) and np.asarray(value).dtype.kind in "fc":
        yield np.asarray(value)


@pytest.mark.parametrize("case", ASKED)
def test_no_answer_holds_or_says_nan(case):
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        found = ASKED[case]()
        data = found.to_dict() if hasattr(found, "to_dict") else found
    assert not any(np.isnan(each).any() for each in numbers(data))
    if hasattr(found, "explain"):
        for language in ("en", "ar"):
            assert "nan" not in found.explain(language).lower().replace("-", " ").split()
