"""The quantities of a mechanism as compiled routines: what everything else of a robot is made of.

Robots without enough mass: quantities that would be zeros or NaN are refused, with the reason.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil import kernels
from mafsil.arrays import Floats, JointVector, as_batch
from mafsil.errors import InputError, ModelError
from mafsil.kernels.lazy import lazy
from mafsil.lazy_module import lazily
from mafsil.mechanics.catalogue import quantity
from mafsil.mechanics.friction import SMOOTHING, FrictionLaw, friction_law
from mafsil.mechanics.mass_matrix_singularity import MassMatrixSingularity, mass_matrix_singularity
from mafsil.mechanics.quantity import Quantity
from mafsil.model import Mechanism
from mafsil.model.inertia_check import joints_that_move_matter
from mafsil.robot.degrees import DegreesHint, arrange, evaluate_in_degrees, takes_degrees, twin_form
from mafsil.robot.description import Description
from mafsil.robot.routines import Motionless, Routines, signature_of

if TYPE_CHECKING:
    import mafsil.robot.closed_states as closed_states
    import mafsil.robot.compiling as compiling
else:
    closed_states = lazily("mafsil.robot.closed_states")
    compiling = lazily("mafsil.robot.compiling")


NO_FINITE_ANSWER = ("call.overflow", "call.undefined")
"""Keys of the errors of a kernel that finds no finite number."""


class CompiledRobot(Description, Routines):
    """A description whose quantities are compiled at their first use; `Robot` adds what is computed from them.

    Routines of a robot with loops are those of states with closed loops, or refused (`closed_states`).

    Attributes:
        mechanism: the description; immutable.
        knows_loops: whether the caller keeps the loops closed, so that the tree's routines refuse nothing.
    """

    knows_loops: ClassVar[bool] = False

    def __init__(self, mechanism: Mechanism) -> None:
        super().__init__(mechanism)
        self._kernels: dict[tuple[str | tuple[str, ...], str | None, tuple[str, ...]], kernels.Kernel] = {}

    @takes_degrees("qd")
    def friction_torque(self, qd: ArrayLike, *, smoothing: float = SMOOTHING, degrees: bool = False) -> JointVector:
        """Efforts (*batch, n) that friction takes: viscous qd + coulomb tanh(qd / smoothing) + offset [N m | N].

        Args:
            qd: (*batch, n) joint rates [rad/s | m/s].
            smoothing: rate [rad/s | m/s] within which the Coulomb part changes its sign smoothly.
            degrees: qd is in deg/s.
        """
        return self._friction.torque(as_batch("qd", qd, (self.n,)), smoothing)

    @takes_degrees("q")
    def mass_matrix_singularity(self, q: ArrayLike, *, degrees: bool = False) -> MassMatrixSingularity:
        """Whether the mass matrix at one position can be inverted, and if not, which motion moves no inertia.

        Args:
            q: (n,) joint coordinates [rad | m].
            degrees: the angles in q are in degrees.
        """
        return mass_matrix_singularity(
            self.mass_matrix(as_batch("q", q, (self.n,), finite=True).reshape(self.n)), self.joint_names
        )

    def kernel(self, name: str, frame: str | None = None, optional: tuple[str, ...] = ()) -> kernels.Kernel:
        """The compiled kernel of a quantity; made once.

        Args:
            name: a name of the catalogue.
            frame: link name for framed quantities; the tip frame if None.
            optional: optional inputs that shall be present, such as ("tip_wrench",).

        Raises:
            InputError: the name or the frame is not known; the sentence lists what is.
            ModelError: the robot has loops, and the kernel would be the tree's.
        """
        self._refuse_tree(name)
        if not isinstance(cast(object, frame), str | None):
            raise InputError("robot.frame_name", name=name, got=type(frame).__name__)
        key = (name, frame, optional)
        if key not in self._kernels:
            row = quantity(name)
            if frame is not None:
                self._require_frame(row, frame)
            self._kernels[key] = compiling.compile_quantity(self.mechanism, name, frame, optional)
        return self._kernels[key]

    def fused_routine(self, *names: str, frame: str | None = None, optional: tuple[str, ...] = ()) -> FusedRoutine:
        """Several quantities of the same state as one routine, in which what they share is computed once.

        `T, J = robot.fused_routine("forward_kinematics", "jacobian_body")(q)`. The inputs are those of the quantities
        in the order in which they first occur, then the optional ones; batches, `out=` (a tuple) and `threads=` as
        always.

        Args:
            names: two or more names of the catalogue.
            frame: link name for the framed quantities among them; the tip frame if None.
            optional: optional inputs that shall be present, such as ("tip_wrench",).

        Raises:
            InputError: a name, frame or optional input that is not known, a name given twice, fewer than two names.
            ModelError: the robot has loops.
        """
        self._refuse_tree("fused_routine")
        if not isinstance(cast(object, frame), str | None):
            raise InputError("robot.frame_name", name="fused_routine", got=type(frame).__name__)
        key = (names, frame, optional)
        if key not in self._kernels:
            rows = [quantity(name) for name in names]
            if len(names) < 2 or len(set(names)) < len(names):
                raise InputError("robot.fused", got=", ".join(names))
            possible = [name for row in rows for name in row.optional]
            if unknown := [name for name in optional if name not in possible]:
                raise InputError("input.choice", name="optional", value=unknown[0], known=", ".join(possible))
            if frame is not None:
                self._require_frame(next((row for row in rows if row.framed), rows[0]), frame)
            self._kernels[key] = compiling.compiled_fused(self.mechanism, names, frame, optional)
        return self._kernels[key].call

    def routine(self, name: str) -> Any:
        """The routine of a quantity, as `robot.<name>`; that attribute keeps it.

        Args:
            name: of the catalogue.

        Raises:
            InputError: no such quantity.
            ModelError: a quantity of masses, for a robot that has none; one that is another number where loops close.
        """
        row = quantity(name)
        if self.mechanism.loops and not self.knows_loops:
            return self._closed_routine(row)
        if not self.n and not row.needs_joints:
            return Motionless(self.mechanism, name)
        require_masses(self.mechanism, row)
        if row.solves_mass_matrix and may_be_singular(self.mechanism):
            return Answered(name, self.compiled_routine(name), self.mass_matrix_singularity)
        return self.compiled_routine(name)

    def compiled_routine(self, name: str) -> Any:
        """The fast single call of the tip frame's kernel; whatever is unusual comes to `_general`."""
        self._refuse_tree(name)
        return _routine_kernel(self, name).call

    def _general(
        self,
        row: Quantity,
        evaluate: kernels.Evaluator,
        *arrays: ArrayLike,
        frame: str | None = None,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
        **named: ArrayLike,
    ) -> Floats:
        """Any call: inputs by position or name, optional inputs, frames, batches, degrees.

        1. The inputs alone, by position: a list or a batch for the tip frame's own kernel.
        2. Otherwise the inputs are put in their order, and the kernel is that of this frame and these optional inputs.
        3. A form of call that has a builtin of its own (`twin_form`) gets it, so that the next such call is fast.
        """
        if degrees:
            again = partial(self._general, row, evaluate, frame=frame, out=out, threads=threads)
            return evaluate_in_degrees(self.mechanism, row, again, arrays, named)
        # 1.
        if frame is None and not named and len(arrays) == len(row.inputs):
            found = evaluate(*arrays, out=out, threads=threads)
            self._degrees_hint(arrays[0])
            return found
        # 2.
        inputs = arrange(row, arrays, named, self.mechanism.tip)
        optional = tuple(name for name in row.optional if name in inputs)
        if frame is not None or optional:
            kernel = self.kernel(row.name, frame, optional)
            # 3.
            form = twin_form(row, len(arrays), tuple(named), frame, optional)
            if form is not None and form not in evaluate.twins:
                twin = _twin_kernel(self, row.name, frame, optional).call
                evaluate.twins[form] = twin
                if isinstance(form, tuple):
                    for options in (("out",), ("threads",), ("out", "threads")):
                        evaluate.twins[*form, *options] = twin
            evaluate = kernel.evaluate
        found = evaluate(*inputs.values(), out=out, threads=threads)
        self._degrees_hint(inputs["q"])
        return found

    def _general_of_twin(
        self,
        row: Quantity,
        own_frame: str | None,
        optional: tuple[str, ...],
        evaluate: kernels.Evaluator,
        /,
        *arrays: ArrayLike,
        frame: str | None = None,
        out: Floats | None = None,
        threads: int | None = None,
        degrees: bool = False,
        **named: ArrayLike,
    ) -> Floats:
        """What the builtin of a frame or with optional inputs does not take; these may even be None."""
        if degrees:
            again = partial(
                self._general_of_twin, row, own_frame, optional, evaluate, frame=frame, out=out, threads=threads
            )
            return evaluate_in_degrees(self.mechanism, row, again, arrays, named)
        inputs = arrange(row, arrays, named, self.mechanism.tip)
        there = tuple(name for name in row.optional if name in inputs)
        at = own_frame if frame is None else frame
        if (at, there) != (own_frame, optional):
            evaluate = self.kernel(row.name, at, there).evaluate
        found = evaluate(*inputs.values(), out=out, threads=threads)
        self._degrees_hint(inputs["q"])
        return found

    def _closed_routine(self, row: Quantity) -> Any:
        if row.name not in closed_states.STATES:
            self._refuse_tree(row.name)
        return closed_states.ClosedState(self.mechanism, row.name, CompiledTree(self.mechanism).routine(row.name))

    def _refuse_tree(self, name: str) -> None:
        if self.mechanism.loops and not self.knows_loops:
            raise ModelError("robot.loops_routine", robot=self.mechanism.name, name=name)

    def _require_frame(self, row: Quantity, frame: str) -> None:
        if not row.framed:
            raise InputError("robot.no_frame", name=row.name)
        self.mechanism.link(frame)

    @lazy
    def _degrees_hint(self) -> DegreesHint:
        """Warns of joint angles that look like degrees."""
        return DegreesHint(self.mechanism)

    @lazy
    def _friction(self) -> FrictionLaw:
        """Friction of the joints that have any."""
        return friction_law(self.mechanism)


class CompiledTree(CompiledRobot):
    """The tree of a robot with loops: its routines refuse nothing, for the caller keeps the loops closed."""

    knows_loops = True


def _twin_kernel(robot: CompiledRobot, name: str, frame: str | None, optional: tuple[str, ...]) -> kernels.Kernel:
    """The kernel of a frame or with optional inputs, all by position, falling back to all that the robot knows."""
    row = quantity(name)
    fallback = partial(robot._general_of_twin, row, frame, optional)  # pyright: ignore[reportPrivateUsage]
    recipe = (_twin_kernel, (robot, name, frame, optional))
    return compiling.compile_quantity(robot.mechanism, name, frame, optional, fallback=fallback, recipe=recipe)


def _routine_kernel(robot: CompiledRobot, name: str) -> kernels.Kernel:
    """The tip frame's kernel, falling back to all that the robot knows; it pickles with the robot's description."""
    fallback = partial(robot._general, quantity(name))  # pyright: ignore[reportPrivateUsage]
    return compiling.compile_quantity(robot.mechanism, name, fallback=fallback, recipe=(_routine_kernel, (robot, name)))


class FusedRoutine(Protocol):
    """Several quantities of one state: inputs in the order of `kernel.signature`, one result for each quantity."""

    def __call__(
        self, *inputs: ArrayLike, out: tuple[Floats, ...] | None = None, threads: int | None = None
    ) -> tuple[Floats, ...]:
        """Their values."""
        ...


def require_masses(mechanism: Mechanism, row: Quantity) -> None:
    """Refuse a quantity of masses for a mechanism in which nothing has any.

    Args:
        mechanism: the robot.
        row: the quantity.

    Raises:
        ModelError: no link has mass or inertia and no motor a rotor; the sentence says how to give them.
    """
    if row.needs_mass and not has_inertia(mechanism):
        raise ModelError("robot.massless", robot=mechanism.name, name=row.name)


def has_inertia(mechanism: Mechanism) -> bool:
    """Whether a link has mass or inertia, or a motor a rotor."""
    bodies = (link.inertial for link in mechanism.links)
    heavy = any(body is not None and (body.mass > 0.0 or body.inertia.any()) for body in bodies)
    motors = (joint.actuator for joint in mechanism.joints)
    return heavy or any(motor is not None and motor.reflected_inertia > 0.0 for motor in motors)


def may_be_singular(mechanism: Mechanism) -> bool:
    """Whether some joint moves no matter of its own, so that the mass matrix may be singular at some position.

    Args:
        mechanism: the robot.
    """
    moving = {joint.name for joint in mechanism.joints if joint.moves}
    return not moving <= joints_that_move_matter(mechanism)


class Answered:
    """A routine that divides by the mass matrix: a single call that has no finite answer raises, with the reason.

    In batches such rows stay NaN, and the others keep their numbers.

    Args:
        name: of the quantity.
        routine: which gives NaN there.
        singularity: of a position, by the robot of the routine.
    """

    def __init__(self, name: str, routine: Any, singularity: Callable[..., MassMatrixSingularity]) -> None:
        self.name, self.routine, self.singularity = name, routine, singularity
        self.row = quantity(name)
        self.__name__, self.__doc__, self.__signature__ = name, self.routine.__doc__, signature_of(self.row)

    def __call__(self, *arrays: Any, **named: Any) -> Floats:
        """As the routine.

        Raises:
            ModelError: the mass matrix is singular at this position; the joints and their motion are named.
            InputError: as the routine.
        """
        try:
            found: Floats = self.routine(*arrays, **named)
        except InputError as error:
            if error.key in NO_FINITE_ANSWER:
                self._require_regular(*arrays[:1], **named)
            raise
        if found.ndim == len(self.row.shape) and not np.isfinite(found).all():
            self._require_regular(*arrays[:1], **named)
        return found

    def _require_regular(self, q: ArrayLike, *, degrees: bool = False, **_: Any) -> None:
        self.singularity(q, degrees=degrees).require_regular()

    def __reduce__(self) -> tuple[type[Answered], tuple[Any, ...]]:
        return Answered, (self.name, self.routine, self.singularity)
