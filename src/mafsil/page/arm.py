"""What a page computes with: the kernels of a robot and the numbers that go with them.

What a page knows of a robot with loops: driven joints that may be moved, and what the others do then.

What a robot on a page cannot do, refused with the reason: the same for sessions and for pages with a server.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

import mafsil.expression as ex
from mafsil import kernels
from mafsil.arrays import Floats, JointVector
from mafsil.errors import InputError, ModelError
from mafsil.ik.answers.branch import BranchNames
from mafsil.ik.chain import moving_part
from mafsil.ik.numerical.problem import PoseProblem, pose_task
from mafsil.ik.structure.analysis import analysis, closed_form
from mafsil.ik.structure.closed_form import ClosedForm
from mafsil.ik.tolerances import DEFECT
from mafsil.job.planning.resting import home_configuration, resting_place
from mafsil.kernels import Port, Signature
from mafsil.kernels.lazy import lazy
from mafsil.kernels.target import host
from mafsil.lazy_module import lazily
from mafsil.mechanics import catalogue
from mafsil.mechanics.loop_terms import Holding, Loop, Term
from mafsil.model import JointKind
from mafsil.robot import Robot, as_open_tree
from mafsil.robot.compiled_robot import require_masses
from mafsil.simulation.plant import Plant
from mafsil.simulation.stepping import Stepper

if TYPE_CHECKING:
    import mafsil.parallel as parallel
    import mafsil.parallel.closed_compiled as closed_choice
    import mafsil.parallel.closed_kernels as closed_kernels
    import mafsil.parallel.closure as closing
    import mafsil.simulation.fused as fused
    from mafsil.kernels import Kernel
    from mafsil.parallel import ClosedChain
else:
    fused = lazily("mafsil.simulation.fused")
    parallel = lazily("mafsil.parallel")
    closed_choice = lazily("mafsil.parallel.closed_compiled")
    closed_kernels = lazily("mafsil.parallel.closed_kernels")
    closing = lazily("mafsil.parallel.closure")


STRIDE = 0.02
"""Way of a driven joint at once [rad | m]: Newton's method finds the other joints from where they were before."""
PATIENCE = 4
"""Calls for one stride, each of some steps with one matrix."""
DECIDED = 1e-6
"""Smallest singular value of conditions of the loops that are independent."""
STEP = 1e-3
"""Time between two evaluations of the control law, and of the integration [s]."""
NATURAL_FREQUENCY = 40.0
"""Of the controller [rad/s]: soft enough that a push is seen, also at a light wrist."""
TOLERANCE = 1e-9
"""Largest residual of a solution [m | rad]."""
ATTEMPTS, STEPS = 16, 80
"""Of a numerical search: starts, and damped steps from each."""


@dataclass(frozen=True, eq=False)
class Arm:
    """A robot as a page knows it.

    Attributes:
        robot: the whole robot; its tip is the tool.
        quantities: names of the catalogue that views need besides; those that this arm has no masses for are left out.
    """

    robot: Robot
    quantities: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "robot", as_open_tree(self.robot))

    @lazy
    def problem(self) -> PoseProblem:
        """The joints that move the tip, and the step towards a pose."""
        return PoseProblem(moving_part(self.robot, None), limits=True)

    @lazy
    def places(self) -> list[int]:
        """Which coordinates of the robot move its tip."""
        found = self.problem.part.places
        return list(range(self.robot.n)) if found is None else [int(place) for place in found]

    @lazy
    def closed(self) -> ClosedArm | None:
        """The loops of the robot; None without any."""
        return ClosedArm(self.robot) if self.robot.mechanism.loops else None

    @lazy
    def form(self) -> ClosedForm | None:
        """The closed form, where it is the arm's own: neither nearly so, nor of an equation of fourth degree.

        With loops there is none: that of the open tree would tear them.
        """
        if self.closed is not None:
            return None
        found = closed_form(self.problem.robot)
        usable = found is not None and found.pattern.defect <= DEFECT and not found.pattern.quartic
        return found if usable else None

    @lazy
    def branch_names(self) -> BranchNames | None:
        """How the branches of the closed form are called."""
        chain = analysis(self.problem.robot.mechanism).chain
        return None if self.form is None or chain is None else BranchNames(chain, self.form.pattern)

    @lazy
    def kernels(self) -> Mapping[str, Kernel]:
        """By the name under which the page calls them; with loops those alone that keep them closed."""
        part, robot = self.problem.robot, self.robot
        found = {name: robot.kernel(name) for name in ("link_poses", "forward_kinematics")}
        found["tip_pose"] = part.kernel("forward_kinematics")
        if self.closed is not None:
            return found | dict(self.closed.kernels(self.start, masses=self._has("gravity_torque")))
        found["jacobian_body"] = robot.kernel("jacobian_body")
        found["pose_step"] = self.problem.step(False)
        if self.form is not None:
            found |= {"turns": _turns_kernel(part.n), "branches": self.form.labelled}
            if self.branch_names is not None:
                found["branch_code"] = self.branch_names.kernel
        if self.has_dynamics:
            found |= {"gravity_torque": robot.kernel("gravity_torque"), "closed_loop": fused.loop_kernel(self._loop)}
        return found | {name: robot.kernel(name) for name in self.quantities if name not in found and self._has(name)}

    def _has(self, quantity: str) -> bool:
        """Whether a quantity means something for this arm: some need masses."""
        try:
            require_masses(self.robot.mechanism, catalogue.quantity(quantity))
        except ModelError:
            return False
        return True

    @lazy
    def unfused(self) -> Mapping[str, Kernel]:
        """The same for this processor without fused products: the bits of the page."""
        target = host("-fma")
        return {
            name: replace(kernel, recipe=None, fallback=None, target=target) for name, kernel in self.kernels.items()
        }

    @lazy
    def has_dynamics(self) -> bool:
        """Whether the robot has masses that make its motion under forces known; the page moves no loops by forces."""
        if self.closed is not None:
            return False
        try:
            M = self.robot.mass_matrix(self.start)
        except ModelError:
            return False
        return bool(np.isfinite(M).all() and np.linalg.eigvalsh(M).min() > 1e-12)

    @lazy
    def start(self) -> JointVector:
        """(n,) where the page begins [rad | m]."""
        if self.closed is not None:
            return self.closed.start(resting_place(self.robot.limits))
        return home_configuration(self.robot)

    @lazy
    def task(self) -> Floats:
        """What `pose_step` is asked for: weights, axis, limits."""
        asked = pose_task("pose" if self.rotates else "position", (0.0, 0.0, 1.0), None, TOLERANCE, None)
        return np.concatenate(
            [asked.scaled_weights(self.problem.length), asked.axis, self.problem.lower, self.problem.upper]
        )

    @property
    def rotates(self) -> bool:
        """Whether a search seeks an orientation too: fewer than six joints are led by the position alone."""
        return len(self.places) >= 6

    @lazy
    def starts(self) -> Floats:
        """(m, 2) of every joint of the search: where its starts begin, and how far they reach [rad | m]."""
        span = np.where(self.problem.revolute == 1, np.pi, self.problem.length)
        lower = np.where(np.isfinite(self.problem.lower), self.problem.lower, -span)
        upper = np.where(np.isfinite(self.problem.upper), self.problem.upper, np.maximum(lower, -span) + 2 * span)
        return np.stack([lower, upper - lower], axis=1)

    @lazy
    def ratios(self) -> list[float]:
        """(m,) irrational steps of a sequence that fills a cube evenly: powers of 1 / g, g^(m+1) = g + 1.

        Reference: Roberts, The unreasonable effectiveness of quasirandom sequences, 2018.
        """
        m, g = len(self.places), 1.5
        for _ in range(60):
            g = (1.0 + g) ** (1.0 / (m + 1))
        return [g ** -(i + 1.0) % 1.0 for i in range(m)]

    @lazy
    def gains(self) -> Floats:
        """(1, 3, n) gains of computed torque: position, rate, integral."""
        w, n = NATURAL_FREQUENCY, self.robot.n
        return np.stack([np.full(n, w * w), np.full(n, 2.0 * w), np.zeros(n)])[None]

    @lazy
    def settings(self) -> dict[str, Any]:
        """Numbers that session and page share, as plain data; infinite bounds are None."""
        limits = self.robot.limits
        centre, radius = self.problem.reach
        return {
            "n": self.robot.n,
            "places": self.places,
            "start": self.start.tolist(),
            "lower": _bounds(limits.lower),
            "upper": _bounds(limits.upper),
            "task": _bounds(self.task),
            "starts": self.starts.tolist(),
            "ratios": self.ratios,
            "rotates": self.rotates,
            "tolerance": TOLERANCE,
            "attempts": ATTEMPTS,
            "steps": STEPS,
            "centre": centre.tolist(),
            "radius": radius if np.isfinite(radius) else None,
            "locked": [] if self.form is None else [self.places[one.joint] for one in self.form.pattern.locked],
            "step": STEP,
            "gains": self.gains.ravel().tolist(),
            "effort": _bounds(limits.effort),
            "prismatic": [joint.kind is JointKind.PRISMATIC for joint in self.robot.mechanism.coordinates],
            "driven": None if self.closed is None else self.closed.driven_joints(self.start),
            "motors": None if self.closed is None else self.closed.chain.actuated.tolist(),
            "stride": STRIDE,
            "patience": PATIENCE,
        }

    @property
    def _loop(self) -> Loop:
        mechanism = self.robot.mechanism
        return Loop(
            plant=mechanism,
            terms=(Term("computed_torque", mechanism),),
            shown=mechanism,
            scheme=Stepper(Plant(self.robot), "semi_implicit_euler", STEP).scheme(),
            substeps=1,
            friction=None,
            pushed=True,
            noisy=False,
            saturated=True,
            integrates=False,
        )


def _bounds(values: Floats) -> list[float | None]:
    return [float(x) if np.isfinite(x) else None for x in values]


def _turns_kernel(n: int) -> Kernel:
    """Of q (n,) to the cosines and sines (n, 2) that the closed form takes."""
    return kernels.compile(
        Signature("turns", (Port("q", (n,)),), (Port("turns", (n, 2)),)),
        partial(_turns, n),
        key=f"turns {n}",
        recipe=(_turns_kernel, (n,)),
    )


def _turns(n: int) -> Any:
    q = ex.symbol("q", n)
    rows = [ex.horzcat(ex.cos(q[i]), ex.sin(q[i])) for i in range(n)]
    return ex.Function("turns", [q], [ex.reshape(ex.vertcat(*rows).T, 2 * n, 1)])


@dataclass(frozen=True, eq=False)
class ClosedArm:
    """The loops of a robot.

    Attributes:
        robot: with loops.
    """

    robot: Robot

    @lazy
    def chain(self) -> ClosedChain:
        """Its closed chain."""
        return parallel.ClosedChain(self.robot)

    def start(self, q: JointVector) -> JointVector:
        """(n,) the configuration with closed loops that is found from q; the nearest to it where none is found."""
        return np.asarray(self.chain.close_loops(q).q, dtype=np.float64)

    def driven_joints(self, q: JointVector) -> list[int]:
        """Driven joints that move all others, the best of them where there are too many; none where they do not.

        Args:
            q: (n,) with closed loops.
        """
        chain = self.chain
        if not len(chain.actuated) or not chain.close_loops(q):
            return []
        J: Floats = np.asarray(chain.terms(q).J)
        freedoms = chain.n - int(np.linalg.matrix_rank(J * chain.unit, tol=DECIDED))
        deciding = closed_choice.deciding_joints(J[None], chain.actuated, freedoms)
        if deciding is None or len(deciding) < freedoms:
            return []
        return sorted(int(chain.actuated[k]) for k in deciding)

    def kernels(self, q: JointVector, *, masses: bool) -> Mapping[str, Kernel]:
        """Of (guess, motion of the moved joints) to that of all joints; of (q, qd, qdd) to efforts of the driven ones.

        And of q to the twist of the tip per rate of every joint, which the page joins with the rates that loops allow.

        Args:
            q: (n,) with closed loops.
            masses: whether efforts mean something.
        """
        driven, holding = self.driven_joints(q), self.chain.holding(q) if masses else None
        moved = holding or self._without_masses(q)
        if not driven or moved is None:
            return {}
        moved = replace(moved, driven=tuple(driven))
        found = {"closed_following": closed_kernels.following_kernel(self.robot.mechanism, moved)}
        found["tree_jacobian"] = self.robot.kernel("jacobian_body")
        if holding is not None and holding.deciding:
            found["closed_efforts"] = closed_kernels.inverse_kernel(self.robot.mechanism, holding)
        return found

    def _without_masses(self, q: JointVector) -> Holding | None:
        """How the loops hold the robot at q, where no masses say which rows are better."""
        J: Floats = np.asarray(self.chain.terms(q).J)[None]
        rows = closed_choice.independent_rows(np.eye(self.chain.n)[None], J)
        return None if rows is None else Holding(rows, (), (), closing.CLOSED * self.chain.size)


def require_kernel(kernel: str, arm: Arm) -> None:
    """Refuse what this robot has no kernel for.

    Args:
        kernel: its name.
        arm: with the kernels.

    Raises:
        InputError: it has none.
    """
    if kernel not in arm.kernels:
        raise InputError(f"session.no_{kernel if arm.closed is None else 'loops'}", robot=arm.robot.name)


def require_driven(joint: int, arm: Arm) -> None:
    """Refuse a joint that loops move.

    Args:
        joint: its place in the coordinates.
        arm: with the settings.

    Raises:
        InputError: they do.
    """
    driven = arm.settings["driven"]
    if driven is not None and joint not in driven:
        raise InputError("session.not_driven", value=joint, known=", ".join(map(str, driven)) or "-")


def require_free(joint: int, arm: Arm) -> None:
    """Refuse a joint that the closed form determines.

    Args:
        joint: its place in the coordinates.
        arm: with the settings.

    Raises:
        InputError: it does.
    """
    free = arm.settings["locked"]
    if joint not in free:
        raise InputError("session.not_free", value=joint, known=", ".join(map(str, free)) or "-")
