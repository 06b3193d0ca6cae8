"""The bodies of an arm and the joints that move them as arrays, the form that the compiled loops read."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.collision.arm_loops import Arm
from mafsil.collision.bodies import Body
from mafsil.collision.pieces import boxes, pieces_of
from mafsil.collision.support_loops import BALL, BODY, Pieces


def arm_of(bodies: tuple[Body, ...], pairs: list[tuple[int, int]]) -> Arm:
    """The bodies as arrays.

    Args:
        bodies: of the arm.
        pairs: indices of those that are checked against each other.
    """
    pieces = pieces_of([(geometry, T, b) for b, body in enumerate(bodies) for geometry, T in body.shapes])
    first = np.searchsorted(pieces.rows[:, BODY], np.arange(len(bodies) + 1))
    table = [
        [body.link, first[b], first[b + 1], 0.0, *_ball(pieces, first[b], first[b + 1])]
        for b, body in enumerate(bodies)
    ]
    return Arm(pieces, np.array(table, np.float64), np.array(pairs, np.int64).reshape(-1, 2))


def _ball(pieces: Pieces, first: int, last: int) -> Floats:
    """(4,) a ball around some pieces: about the middle of their extent, by their balls or by their boxes."""
    box = boxes(pieces)[first:last]
    low, high = box[:, :3].min(axis=0), box[:, 3:].max(axis=0)
    centre = (low + high) / 2
    balls = pieces.rows[first:last, BALL:]
    by_balls = (np.linalg.norm(balls[:, :3] - centre, axis=1) + balls[:, 3]).max()
    return np.array([*centre, min(by_balls, float(np.linalg.norm(high - low)) / 2)])
