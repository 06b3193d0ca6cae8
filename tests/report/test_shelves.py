"""Things of the replay lie on something: on the floor, on one another, on what the job describes, else on a tray."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil.report.touched import shelves
from mafsil.scene import Body, Solid


def thing(x: float, y: float, z: float, size: tuple[float, float, float] = (0.1, 0.1, 0.1), turn: float = 0.0):
    """A box whose middle is there."""
    T = np.eye(4)
    c, s = np.cos(turn), np.sin(turn)
    T[:2, :2], T[:3, 3] = [[c, -s], [s, c]], (x, y, z)
    return Body("thing", (Solid("box", size),)), T


def test_what_hangs_in_the_air_gets_a_tray_that_touches_it_and_a_post_to_the_floor():
    ((body, T),) = shelves([thing(0.4, 0.2, 0.5, turn=np.pi / 4)], [], -0.1, 1.0)
    plate, post = body.solids
    np.testing.assert_allclose(T[:3, 3], [0.4, 0.2, 0.45])
    assert min(plate.size[:2]) > np.sqrt(2) * 0.1
    np.testing.assert_allclose(plate.pose[2] + plate.size[2] / 2, 0.0, atol=1e-15)
    np.testing.assert_allclose(T[2, 3] + post.pose[2] - post.size[1] / 2, -0.1)


@pytest.mark.parametrize(
    ("lying", "others", "trays"),
    [
        ([thing(0, 0, 0.05)], [], 0),
        ([thing(0, 0, 0.5), thing(0, 0, 0.6)], [], 1),
        ([thing(0, 0, 0.5), thing(0.12, 0, 0.5), thing(0.24, 0, 0.5)], [], 1),
        ([thing(0, 0, 0.5), thing(0.24, 0, 0.5), thing(0.12, 0, 0.5)], [], 1),
        ([thing(0, 0, 0.5), thing(0.8, 0, 0.5)], [], 2),
        ([thing(0, 0, 0.5), thing(0.0, 0.05, 0.7)], [], 2),
        ([thing(0, 0, 0.5)], [thing(0.3, 0, 0.4, (1.0, 1.0, 0.1))], 0),
        ([thing(0, 0, 0.5)], [thing(2.0, 0, 0.4, (1.0, 1.0, 0.1))], 1),
        ([thing(0, 0, 0.5)], [thing(0.3, 0, 0.8, (1.0, 1.0, 0.1))], 1),
        ([thing(0, 0, 0.5)], [(Body("pin", (Solid("cylinder", (0.1, 0.9)),)), np.eye(4))], 0),
    ],
)
def test_one_tray_for_what_lies_side_by_side_and_none_for_what_lies_on_something(lying, others, trays):
    assert len(shelves(lying, others, 0.0, 1.0)) == trays
