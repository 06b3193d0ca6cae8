"""The page without a page: the same actions on the same kernels, so that a journal is replayed to the same bits."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from inspect import signature
from math import ceil, inf, isfinite
from typing import Any, TypeAlias, cast

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.model.loading import RobotLike
from mafsil.page.arm import Arm, require_driven, require_free, require_kernel
from mafsil.robot import as_open_tree

Numbers: TypeAlias = tuple[float, ...]


@dataclass(frozen=True)
class ArmState:
    """Where the arm is and what it is doing; every action makes a new one.

    Attributes:
        q, qd: (n,) coordinates and rates [rad | m, per s].
        goal: (n,) where the controller leads.
        loop: whether the controller and the dynamics move the arm, or the actions do.
        push: (6,) wrench on the tip in its frame (moment, force) [N m, N].
        ticks: steps of the loop since it was closed.
        status: how the last action ended.
    """

    q: Numbers
    qd: Numbers
    goal: Numbers
    loop: bool = False
    push: Numbers = (0.0,) * 6
    ticks: int = 0
    status: str = "ready"

    @property
    def here(self) -> Numbers:
        """What actions change: the goal in the loop, else the coordinates."""
        return self.goal if self.loop else self.q


@dataclass(eq=False)
class Session:
    """A robot moved by actions, as on its page, with the bits of the page.

    Args:
        robot: any robot; a name or a file.

    Kernels are compiled without fused products and sums, as WebAssembly has none. Every method is an action of the
    page and the line that the page's journal writes for it.
    """

    robot: RobotLike
    arm: Arm = field(init=False, repr=False)
    state: ArmState = field(init=False)

    def __post_init__(self) -> None:
        self.arm = Arm(as_open_tree(self.robot))
        start: Numbers = tuple(self.arm.settings["start"])
        self.state = ArmState(start, (0.0,) * len(start), start)

    @property
    def q(self) -> Floats:
        """(n,) coordinates [rad | m]."""
        return np.array(self.state.q)

    @property
    def status(self) -> str:
        """How the last action ended: `ready`, `solved`, or why the arm did not move, such as `not_found`."""
        return self.state.status

    def set_joint(self, joint: int, value: float) -> None:
        """Move one joint.

        Args:
            joint: its place in the coordinates.
            value: [rad | m]; limits are not enforced, the page's sliders end there.
        """
        self._check(joint, len(self.state.q))
        require_driven(joint, self.arm)
        q = list(self.state.here)
        q[joint] = float(value)
        if self.arm.settings["driven"] is None:
            self._place(tuple(q), "ready")
        else:
            self._follow(tuple(q), self.state.q)

    def set_joints(self, values: Sequence[float]) -> None:
        """Move all joints.

        Args:
            values: (n,) [rad | m]; with loops those of the driven joints count, and the others are where to look.
        """
        if len(values) != len(self.state.q):
            raise InputError("session.count", got=len(values), wanted=len(self.state.q))
        wanted = tuple(map(float, values))
        if self.arm.settings["driven"] is None:
            self._place(wanted, "ready")
        else:
            self._follow(wanted, wanted)

    def reach(self, position: Sequence[float], quaternion: Sequence[float], branch: int) -> None:
        """Bring the tip to a pose on one branch of the closed form.

        Args:
            position: (3,) in {s} [m].
            quaternion: (4,) of any length but zero, (w, x, y, z).
            branch: row of the closed form.
        """
        self._take(pose_from(position, quaternion), branch)

    def choose(self, branch: int) -> None:
        """Go to another branch of the pose where the tip is.

        Args:
            branch: row of the closed form.
        """
        here = [self.state.here[place] for place in self.arm.places]
        self._take(self._call("tip_pose", here)[0], branch)

    def swing(self, joint: int, value: float, branch: int) -> None:
        """Turn a joint that is free to choose while the tip stays where it is.

        Args:
            joint: its place in the coordinates; one that the closed form leaves free.
            value: [rad | m].
            branch: row of the closed form on which the other joints follow.

        Raises:
            InputError: the closed form determines that joint.
        """
        require_free(joint, self.arm)
        before, here = self.state, [self.state.here[place] for place in self.arm.places]
        T = self._call("tip_pose", here)[0]
        q = list(before.here)
        q[joint] = float(value)
        self._place(tuple(q), "ready")
        self._take(T, branch)
        if self.state.status != "solved":
            self.state = replace(before, status=self.state.status)

    def search(self, position: Sequence[float], quaternion: Sequence[float]) -> None:
        """Bring the tip to a pose by damped steps, from here and then from other starts.

        Of arms with fewer than six joints only the position counts.

        Args:
            position, quaternion: as of `reach`.
        """
        self._require("pose_step")
        T, settings = pose_from(position, quaternion), self.arm.settings
        task = _without_bounds(settings["task"], len(self.arm.places))
        for attempt in range(settings["attempts"]):
            q = self._start(attempt)
            for _ in range(settings["steps"]):
                (out,) = self._call("pose_step", q, T, task)
                turn, shift = out[-6:-3], out[-3:]
                if not all(map(isfinite, out)):
                    break
                turned = not settings["rotates"] or _square(turn) <= settings["tolerance"] ** 2
                if turned and _square(shift) <= settings["tolerance"] ** 2:
                    self._place(self._lift(q), "solved")
                    return
                q = [float(x) for x in out[:-6]]
        self.state = replace(self.state, status="not_found")

    def loop(self, closed: bool) -> None:
        """Close the loop, or open it: then the actions move the arm itself again.

        Args:
            closed: whether the controller moves the arm from now on.
        """
        self._require("closed_loop")
        rest = (0.0,) * len(self.state.q)
        self.state = replace(
            self.state, loop=closed, goal=self.state.q, qd=rest, push=(0.0,) * 6, ticks=0, status="ready"
        )

    def push(self, wrench: Sequence[float]) -> None:
        """Push the tip from now on.

        Args:
            wrench: (6,) moment and force on the tip, in its frame [N m, N].
        """
        if len(wrench) != 6:
            raise InputError("session.count", got=len(wrench), wanted=6)
        self.state = replace(self.state, push=tuple(map(float, wrench)))

    def simulate(self, ticks: int) -> None:
        """Let time pass in the closed loop.

        Args:
            ticks: steps of 1 ms.
        """
        self._require("closed_loop")
        settings, state = self.arm.settings, self.state
        n = len(state.q)
        rest, gains, step = (0.0,) * n, settings["gains"], [settings["step"]]
        T = self._call("forward_kinematics", state.goal)[0]
        effort = [inf if x is None else x for x in settings["effort"]]
        now: Sequence[float] = [*state.q, *state.qd]
        reference = [*state.goal, *rest, *rest]
        for _ in range(ticks):
            now = self._call("closed_loop", now, reference, gains, step, T, effort, state.push)[0]
        if all(map(isfinite, now)):
            values = tuple(float(x) for x in now)
            self.state = replace(state, q=values[:n], qd=values[n:], ticks=state.ticks + ticks, status="ready")
        else:
            self.state = replace(state, status="diverged")

    def do(self, actions: Iterable[Mapping[str, Any]]) -> None:
        """Replay a journal that the page saved as data.

        Args:
            actions: each `{"do": name, "with": {argument: value}}`.

        Raises:
            InputError: an action that is not known.
        """
        for action in actions:
            method = ACTIONS.get(action["do"])
            if method is None:
                raise InputError("input.choice", name="do", value=action["do"], known=", ".join(ACTIONS))
            method(self, **action["with"])

    def _take(self, T: Sequence[float], branch: int) -> None:
        """Go to a branch of a pose if it is there, within the limits."""
        self._require("branches")
        settings, places = self.arm.settings, self.arm.places
        here = [self.state.here[place] for place in places]
        lower = [_or(settings["lower"][place], -inf) for place in places]
        upper = [_or(settings["upper"][place], inf) for place in places]
        turns = self._call("turns", here)[0]
        rows, details, defect = self._call("branches", T, here, turns, lower, upper)
        m = len(places)
        self._check(branch, len(details) // 6)
        residual, excess = details[6 * branch], details[6 * branch + 5]
        if not residual <= settings["tolerance"] or not defect[0] <= 1e-6:
            self.state = replace(self.state, status="no_branch")
        elif not excess <= LEEWAY:
            self.state = replace(self.state, status="beyond_limits")
        else:
            self._place(self._lift(rows[m * branch : m * (branch + 1)]), "solved")

    def _follow(self, wanted: Numbers, guess: Numbers) -> None:
        """Move the driven joints and let the loops move the others, at once or in strides; or stay where that fails.

        Args:
            wanted: of which the driven joints count.
            guess: where the others are looked for first.
        """
        driven: list[int] = self.arm.settings["driven"]
        here = self.state.q
        goal, begin = [wanted[k] for k in driven], [here[k] for k in driven]
        found = self._closed(guess, goal) if guess is not here else None
        if found is None:
            way = max((abs(b - a) for a, b in zip(begin, goal, strict=True)), default=0.0)
            count = max(1, ceil(way / self.arm.settings["stride"])) if isfinite(way) else 0
            found = here if count else None
            for k in range(1, count + 1):
                share = k / count
                step = [a + (b - a) * share for a, b in zip(begin, goal, strict=True)]
                found = None if found is None else self._closed(found, step)
        if found is None:
            self.state = replace(self.state, status="loops_open")
        else:
            self._place(found, "ready")

    def _closed(self, guess: Numbers, driven: Sequence[float]) -> Numbers | None:
        """All joints with closed loops while the driven ones are somewhere; None where they do not close."""
        self._require("closed_following")
        q: Sequence[float] = guess
        for _ in range(self.arm.settings["patience"]):
            q, _, _, doubt = self._call("closed_following", q, [*driven, *[0.0] * (2 * len(driven))])
            if not all(map(isfinite, q)):
                return None
            if doubt[0] < 1.0:
                return tuple(q)
        return None

    def _start(self, attempt: int) -> list[float]:
        """Where a search begins: here, then places that fill the ranges evenly."""
        if attempt == 0:
            return [self.state.here[place] for place in self.arm.places]
        settings = self.arm.settings
        pairs = zip(settings["starts"], settings["ratios"], strict=True)
        return [lower + span * ((attempt * ratio) % 1.0) for (lower, span), ratio in pairs]

    def _lift(self, part: Sequence[float]) -> Numbers:
        q = list(self.state.here)
        for place, value in zip(self.arm.places, part, strict=True):
            q[place] = float(value)
        return tuple(q)

    def _place(self, q: Numbers, status: str) -> None:
        if self.state.loop:
            self.state = replace(self.state, goal=q, status=status)
        else:
            self.state = replace(self.state, q=q, qd=(0.0,) * len(q), goal=q, status=status)

    def _call(self, name: str, *values: Sequence[float]) -> list[list[float]]:
        kernel = self.arm.unfused[name]
        ports = kernel.signature.inputs
        shaped = [np.reshape(np.array(x, dtype=np.float64), p.shape) for x, p in zip(values, ports, strict=True)]
        with np.errstate(all="ignore"):
            found: Any = kernel.point_ufunc(*shaped)
        outputs = cast("tuple[Floats, ...]", found if isinstance(found, tuple) else (found,))
        return [np.ravel(y).tolist() for y in outputs]

    def _require(self, kernel: str) -> None:
        require_kernel(kernel, self.arm)

    def _check(self, index: int, count: int) -> None:
        if not 0 <= index < count:
            raise InputError("session.index", value=index, most=count - 1)


LEEWAY = 1e-12
"""By how much a coordinate may be beyond its limit: winding rounds."""

ACTIONS: dict[str, Callable[..., None]] = {
    method.__name__: method
    for method in (
        Session.set_joint, Session.set_joints, Session.reach, Session.choose, Session.swing, Session.search,
        Session.loop, Session.push, Session.simulate,
    )
}  # fmt: skip
"""What can be done, by name; the page gets names and arguments as data."""


def action_arguments() -> dict[str, list[str]]:
    """Of every action, the names of its arguments in their order."""
    return {name: list(signature(method).parameters)[1:] for name, method in ACTIONS.items()}


def pose_from(position: Sequence[float], quaternion: Sequence[float]) -> list[float]:
    """16 numbers of T, row after row.

    Plain products and sums in a fixed order: a browser finds the same bits.

    Args:
        position: (3,) [m].
        quaternion: (4,) of any length but zero, (w, x, y, z).

    Raises:
        InputError: a number that is not finite, a quaternion of zeros, another count.
    """
    if len(position) != 3 or len(quaternion) != 4:
        raise InputError("session.count", got=len(position) + len(quaternion), wanted=7)
    w, x, y, z = map(float, quaternion)
    px, py, pz = map(float, position)
    size = w * w + x * x + y * y + z * z
    if not all(map(isfinite, (size, px, py, pz))) or size == 0.0:
        raise InputError("session.quaternion", value=tuple(quaternion))
    s = 2.0 / size
    return [
        1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y), px,
        s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x), py,
        s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y), pz,
        0.0, 0.0, 0.0, 1.0,
    ]  # fmt: skip


def _square(v: Sequence[float]) -> float:
    return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]


def _or(value: float | None, bound: float) -> float:
    return bound if value is None else value


def _without_bounds(task: Sequence[float | None], m: int) -> list[float]:
    """The task with its missing bounds infinite: weights (6), axis (3), lower (m), upper (m)."""
    return [_or(value, -inf if k < 9 + m else inf) for k, value in enumerate(task)]
