"""An arm whose base may stand anywhere in a scene: the pose of the base belongs to the coordinates."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import JointVector, Truth, as_batch
from mafsil.collision.checker import Checker
from mafsil.collision.joints import joints_of
from mafsil.collision.scene import Scene
from mafsil.lazy_module import lazily
from mafsil.model.mounting import PLACES, on_movable_base
from mafsil.robot import as_open_tree

if TYPE_CHECKING:
    import mafsil.collision.layout as layout
else:
    layout = lazily("mafsil.collision.layout")


class MovableArm(Checker):
    """The checker of an arm with coordinates (x, y, z, yaw, q): answers are those of the arm with its base there.

    What no joint of the arm moves, such as its base, is not checked against the scene here, as with any arm;
    `base_is_free` does that.

    Args:
        arm: the checker of the arm, with all its settings.
        scene: what stands around, in {s}.
    """

    def __init__(self, arm: Checker, scene: Scene) -> None:
        self.scene, self.clearance, self.samples, self.seed = scene, arm.clearance, arm.samples, arm.seed
        self._self_clearance = arm._self_clearance
        self.robot = as_open_tree(on_movable_base(arm.robot.mechanism))
        self.bodies = tuple(replace(body, link=body.link + len(PLACES)) for body in arm.bodies)
        self._still, self._skipped, self._self_collision = arm._still, arm._unchecked(), True
        self._joints = joints_of(self.robot.mechanism)
        self._workshops, self._arm = {}, arm

    def _near(self, distance: float) -> dict[tuple[int, int], float]:
        return self._arm._near(distance)

    @cached_property
    def _base(self) -> Checker:
        still = [tuple(not each for each in row) for row in self._still]
        return self._with_arm(layout.arm_of(self.bodies, [], still))

    def base_is_free(self, bases: ArrayLike, stands_on: Iterable[str] = ()) -> Truth:
        """Whether what no joint moves keeps more than the clearance.

        Args:
            bases: (*batch, 4) x, y, z [m], yaw [rad] of the base.
            stands_on: names of obstacles that it may touch.

        Raises:
            InputError: a wrong shape, or no such obstacle.
        """
        rows = as_batch("bases", bases, (len(PLACES),), finite=True)
        allowed = tuple(stands_on)
        for name in allowed:
            self.scene.index(name)
        around = Scene(each for each in self.scene if each.name not in allowed)
        return self._base.with_scene(around).free(self.join(rows, np.zeros(self.robot.n - len(PLACES))))

    def join(self, bases: ArrayLike, q: ArrayLike) -> JointVector:
        """(*batch, 4 + n) coordinates of bases (*batch, 4) and of the arm (*batch, n); the batches broadcast."""
        a, b = np.asarray(bases, dtype=np.float64), np.asarray(q, dtype=np.float64)
        batch = np.broadcast_shapes(a.shape[:-1], b.shape[:-1])
        parts = [np.broadcast_to(part, (*batch, part.shape[-1])) for part in (a, b)]
        return np.concatenate(parts, axis=-1)
