"""Short forms of what a robot is asked most often; the full functions have more arguments."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.robot.degrees import takes_degrees

if TYPE_CHECKING:
    import mafsil.control as control
    import mafsil.derivation as derivation
    import mafsil.figures.mechanism as mechanism_figures
    import mafsil.ik as inverse
    import mafsil.performance as performance
    import mafsil.simulation as simulation
    from mafsil.control import Law
    from mafsil.derivation import Derivation
    from mafsil.ik import IKResult, SolutionBatch, SolutionSet
    from mafsil.ik.structure.analysis import Task
    from mafsil.performance.workspace import WorkspaceMap
    from mafsil.robot import Robot
    from mafsil.simulation import Recording
    from mafsil.trajectory import Trajectory
else:
    control = lazily("mafsil.control")
    derivation = lazily("mafsil.derivation")
    mechanism_figures = lazily("mafsil.figures.mechanism")
    inverse = lazily("mafsil.ik")
    performance = lazily("mafsil.performance")
    simulation = lazily("mafsil.simulation")

DERIVED = ("fk", "jacobian", "ik", "dynamics")
"""What `derive` writes out."""


def fk(self: Robot, q: ArrayLike, frame: str | None = None, *, degrees: bool = False) -> PoseMatrix:
    """Pose of the tip, or of another link, in the base frame {s}.

    Args:
        q: (*batch, n) joint coordinates [rad | m].
        frame: name of a link; the tip frame if None.
        degrees: the angles in q are in degrees.

    Returns:
        T_sb (*batch, 4, 4).

    Raises:
        InputError: a wrong shape, NaN or infinity.
        ModelError: no such link, or a robot with loops at coordinates that do not close them.
    """
    if frame is None and not degrees:
        return self.forward_kinematics(q)
    return self.forward_kinematics(q, frame=frame, degrees=degrees)


@takes_degrees("q0")
def ik(
    self: Robot,
    T_sd: ArrayLike,
    q0: ArrayLike | None = None,
    *,
    frame: str | None = None,
    task: Task = "pose",
    degrees: bool = False,
) -> IKResult:
    """Joint coordinates that bring the tip to a pose: one solution, the nearest to `q0`.

    An arm with a closed form is solved completely and the nearest solution within the limits is taken, whole turns
    included. Other arms are solved from `q0` by damped least squares, redundant ones towards `q0`.

    Args:
        T_sd: (*batch, 4, 4) desired poses in {s}.
        q0: (*batch, n) start [rad | m]; the middle of the limits if None.
        frame: name of a link; the tip if None.
        task: what counts: `pose`, `position`, or `axis`: position and direction of the frame's z axis.
        degrees: the angles in q0 and in the answer's q are in degrees.

    Returns:
        The answer is false where the pose was not reached, and says why. For all solutions use `ik_all`; `solve_ik` has
        weights, tolerances, time limits and seeds.

    Raises:
        InputError: a wrong shape, no pose, an unknown task.
        ModelError: no such link, a robot with loops.
    """
    answer = inverse.nearest_solution(self, T_sd, q0, frame=frame, task=task)
    return answer.with_joints(self.degrees(answer.nearest)) if degrees else answer


def ik_all(
    self: Robot,
    T_sd: ArrayLike,
    *,
    frame: str | None = None,
    task: Task = "pose",
    q0: ArrayLike | None = None,
    degrees: bool = False,
) -> SolutionSet | SolutionBatch:
    """All joint coordinates that bring the tip to a pose, with branches, families and reasons: `inverse_kinematics`.

    Args:
        T_sd: (4, 4) desired pose in {s}, or (*batch, 4, 4).
        frame: name of a link; the tip if None.
        task: what counts: `pose`, `position`, or `axis`: position and direction of the frame's z axis.
        q0: (n,) where joints stay that the pose leaves free [rad | m]; the middle of their limits if None.
        degrees: the angles in q0 and in the answer's solutions, sentences and tables are in degrees.

    Raises:
        InputError: a wrong shape, no pose, an unknown task.
        ModelError: no such link, a robot with loops.
    """
    return inverse.inverse_kinematics(self, T_sd, frame=frame, task=task, q0=q0, degrees=degrees)


def jacobian(
    self: Robot,
    q: ArrayLike,
    frame: str | None = None,
    *,
    expressed_in: Literal["body", "space", "aligned"] = "body",
    degrees: bool = False,
) -> Floats:
    """Jacobian of the tip frame, or of another link's: twist (omega, v) = J qd.

    Args:
        q: (*batch, n) joint coordinates [rad | m].
        frame: name of a link; the tip frame if None.
        expressed_in: `body`: the axes and origin of that frame; `space`: those of {s}; `aligned`: the axes of {s} and
            the origin of that frame (its velocity as seen from the base).
        degrees: the angles in q are in degrees. The Jacobian is per radian all the same.

    Returns:
        J (*batch, 6, n), rows omega [rad/s] before v [m/s].

    Raises:
        InputError: a wrong shape, NaN or infinity, another `expressed_in`.
        ModelError: no such link.
    """
    if expressed_in == "space":
        return self.jacobian_space(q, frame=frame, degrees=degrees)
    if expressed_in not in ("body", "aligned"):
        raise InputError("input.choice", name="expressed_in", value=expressed_in, known="body, space, aligned")
    J_b = self.jacobian_body(q, frame=frame, degrees=degrees)
    if expressed_in == "body":
        return J_b
    R = self.forward_kinematics(q, frame=frame, degrees=degrees)[..., :3, :3]
    return np.concatenate([R @ J_b[..., :3, :], R @ J_b[..., 3:, :]], axis=-2)


@takes_degrees("q")
def simulate(
    self: Robot,
    trajectory: Trajectory,
    law: Law | None = None,
    *,
    q: ArrayLike | None = None,
    duration: float | None = None,
    step: float = 1e-3,
    degrees: bool = False,
) -> Recording:
    """Closed-loop motion of the robot along a trajectory; pushes, noise and variants are of `mafsil.Scenario`.

    Args:
        trajectory: the reference.
        law: the controller; computed torque with its default gains if None.
        q: (*batch, n) initial coordinates [rad | m]; the start of the trajectory if None.
        duration: of the run [s]; that of the trajectory if None.
        step: of the integration and of the law [s].
        degrees: the angles in q are in degrees; trajectory and recording hold radians.

    Raises:
        InputError: a wrong shape, numbers that are not finite or not positive, a trajectory of another width.
    """
    controller = control.computed_torque(self) if law is None else law
    return simulation.simulate(
        simulation.Scenario(robot=self, trajectory=trajectory, law=controller, q=q, duration=duration, step=step)
    )


def workspace(self: Robot, samples: int = 1_000_000, *, frame: str | None = None, seed: int = 0) -> WorkspaceMap:
    """Where the tip can be, from random configurations within the limits: `performance.workspace_map` has slices.

    Args:
        samples: configurations.
        frame: name of a link; the tip frame if None.
        seed: random seed.

    Raises:
        InputError: no samples, a prismatic joint without limits.
    """
    return performance.workspace_map(self, samples, frame=frame, seed=seed)


def derive(self: Robot, what: str = "fk") -> Derivation:
    """The formulas of the robot in numbered steps: printed as text, as a page in a notebook.

    Args:
        what: `fk`, `jacobian`, `ik` or `dynamics`; `mafsil.derivation` has their variants, and writes LaTeX and HTML.

    Raises:
        InputError: something else.
        ModelError: a robot without such formulas.
    """
    if what not in DERIVED:
        raise InputError("input.choice", name="what", value=what, known=", ".join(DERIVED))
    if what == "ik":
        return _derive_ik(self)
    functions = {
        "fk": derivation.derive_fk,
        "jacobian": derivation.derive_jacobian,
        "dynamics": derivation.derive_dynamics,
    }
    return functions[what](self.mechanism)


def _derive_ik(robot: Robot) -> Derivation:
    form = inverse.closed_form(robot)

    def solutions(T: PoseMatrix) -> Floats:
        assert form is not None
        rows = form.solve(T)
        return rows.q[rows.solves_pose()]

    return derivation.derive_ik(robot.mechanism, None if form is None else form.pattern, solutions)


@takes_degrees("q")
def plot(
    self: Robot, q: ArrayLike | None = None, path: str | PathLike[str] | None = None, *, degrees: bool = False
) -> Any:
    """A picture of the robot, drawn by Matplotlib.

    Args:
        q: (n,) joint coordinates [rad | m]; a bent configuration within the limits if None.
        path: also write it to this file: .png, .svg or .pdf.
        degrees: the angles in q are in degrees.

    Returns:
        A matplotlib Figure, which a notebook shows.

    Raises:
        InputError: a wrong shape, NaN or infinity, Matplotlib is not installed.
    """
    if path is None:
        return mechanism_figures.draw_mechanism(self.mechanism, q)
    return mechanism_figures.plot_mechanism(self, path, q)
