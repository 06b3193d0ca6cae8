"""One call that compares every routine of a robot with an independent method for the same number.

Peers as a further method, where they are installed: the same mechanism built in their memory, the same states.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Literal, TypeAlias

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError, ModelError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mechanics.arm_size import ArmSize
from mafsil.mechanics.catalogue import CATALOGUE, quantity
from mafsil.mechanics.quantity import Quantity, States, random_states
from mafsil.mechanics.textbook import Textbook
from mafsil.messages import say
from mafsil.model.loading import RobotLike, as_mechanism
from mafsil.robot import Robot, as_robot
from mafsil.robot.closed_states import STATES
from mafsil.verification.closed import closed_judge
from mafsil.verification.tolerances import LIMIT, ROUNDING, SINGULAR
from mafsil.verification.verification import UNCHECKED, Check, LeftOut, Verification, composed_checks

PEERS = {"pinocchio": "mafsil.verification.pinocchio_peer", "mujoco": "mafsil.verification.mujoco_peer"}
"""Their names as Python imports them, and the module that knows how to ask them."""
MOST_STATES = 10_000
TREE = "without_loops()."
"""How names of the open tree's routines begin, where a robot has loops."""
Peer: TypeAlias = Literal["pinocchio", "mujoco"]


def verify(
    robot: RobotLike,
    against: Peer | Collection[Peer] | None = None,
    *,
    states: int = 8,
    seed: int = 0,
    limit: float = LIMIT,
) -> Verification:
    """Compare every routine of the robot with a second method for the same number, at random states.

    The methods are the textbooks' formulas in NumPy (sums over links, virtual work, energies and Jacobians
    differentiated by the complex step, the recursion of Newton and Euler), which share no code with the routines.

    Args:
        robot: any.
        against: also peers that are installed, `pinocchio`, `mujoco` or both.
        states: how many random states.
        seed: of the states.
        limit: relative error that counts as rounding.

    Of a robot with loops, the closed chain is compared at states that close them, with d'Alembert's principle along the
    motions that the loops leave; and the routines of its tree, whose names begin with `without_loops().`.

    Returns:
        One check per routine and way of calling it; `ok`, `failed`, `explain()`. Without a state that closes the loops
        the answer is false: they were not compared.

    Raises:
        InputError: no such peer, or not installed, or not a number of states.
        ModelError: the robot has no joints.
    """
    peers = () if against is None else (against,) if isinstance(against, str) else tuple(dict.fromkeys(against))
    for peer in peers:
        if peer not in PEERS:
            raise InputError("input.choice", name="against", value=peer, known=", ".join(PEERS))
    if not 1 <= states <= MOST_STATES:
        raise InputError("verification.states", count=states, most=MOST_STATES)
    mechanism = as_mechanism(robot, keeps_loops=True)
    if not mechanism.n:
        raise ModelError("robot.no_joints", robot=mechanism.name)
    if not mechanism.loops:
        arm = robot if isinstance(robot, Robot) else as_robot(mechanism)
        checks, left_out = _of_tree(arm, peers, states, seed, limit)
        return Verification(mechanism.name, tuple(checks), states, seed, tuple(left_out), standing(peers))
    checks, left_out = _of_loops(Robot(mechanism), states, seed, limit)
    trees, missing = _of_tree(Robot(mechanism.without_loops()), peers, states, seed, limit)
    checks += [replace(check, routine=f"{TREE}{check.routine}") for check in trees]
    left_out += [(f"{TREE}{name}", key) for name, key in missing]
    return Verification(mechanism.name, tuple(checks), states, seed, tuple(left_out), standing(peers))


def _of_tree(robot: Robot, peers: Sequence[str], states: int, seed: int, limit: float) -> tuple[list[Check], LeftOut]:
    """Every routine of a robot without loops, and what was not compared."""
    size, book = ArmSize.of(robot.mechanism), Textbook(robot.mechanism)
    drawn = random_states(robot.mechanism, size, states, seed)
    judge = Judge(book, size, drawn, limit)
    checks: list[Check] = []
    for row in CATALOGUE.values():
        checks += [judge.check(robot, row, called) for called in ways(row, drawn, robot)]
    composed, left_out = composed_checks(robot, book, size, drawn, limit)
    checks += composed
    for peer in peers:
        found, missing = peer_checks(peer, robot, drawn, limit, judge.error)
        checks, left_out = checks + found, left_out + missing
    return checks, left_out


def _of_loops(robot: Robot, states: int, seed: int, limit: float) -> tuple[list[Check], LeftOut]:
    """The closed chain, and the routines that a robot with loops has, at states that close them."""
    closed = closed_judge(robot, states, seed, limit)
    if closed is None:
        return [], [("ClosedChain", UNCHECKED)]
    checks, left_out = closed.checks()
    judge = Judge(closed.book, closed.size, closed.s, limit)
    for name in sorted(STATES):
        row = CATALOGUE[name]
        checks += [judge.check(robot, row, called) for called in ways(row, closed.s, robot)]
    if len(closed.s.q) < states:
        left_out.append((f"ClosedChain ({len(closed.s.q)}/{states})", "verification.loops_fewer"))
    return checks, left_out


def ways(row: Quantity, drawn: States, robot: Robot) -> Iterator[States]:
    """The ways in which a routine is called: plain, with all it may take, and for another frame."""
    plain = replace(drawn, tip_wrench=None, base_twist=None, base_acceleration=None)
    yield plain
    if row.optional:
        yield replace(plain, **{name: getattr(drawn, name) for name in row.optional})
    if row.framed:
        yield replace(plain, frame=middle_link(robot))


def middle_link(robot: Robot) -> str:
    """A link halfway to the tip."""
    names = robot.mechanism.link_names
    return names[len(names) // 2]


class Judge:
    """Compares a routine with its second method.

    Attributes:
        book: of the second methods.
        size: of the robot.
        drawn: the states.
        limit: relative error allowed.
    """

    def __init__(self, book: Textbook, size: ArmSize, drawn: States, limit: float) -> None:
        self.book, self.size, self.drawn, self.limit = book, size, drawn, limit

    def check(self, robot: Robot, row: Quantity, s: States) -> Check:
        """One routine called in one way."""
        second, name = row.second, call_name(row, s)
        try:
            ours = call(robot, row, s)
        except ModelError as refusal:
            return self._refuse(row, name, s, refusal)
        try:
            errors = self.error(row.name, ours, second.value(self.book, s))
        except np.linalg.LinAlgError:
            return Check(name, second.key, float("inf"), self.limit, reason=say("verification.should_refuse"))
        return Check(name, second.key, float(errors.max()), self.limit, int(errors.argmax()))

    def error(self, name: str, ours: Floats, reference: Floats) -> Floats:
        """(b,) largest error of each state; infinite where a number is missing."""
        row = quantity(name)
        if row.solves_mass_matrix:
            return self._error_of_motion(ours, reference)
        size = row.size(self.size)
        largest = np.maximum(1.0, _worst(np.abs(reference) / size))
        return _worst(np.abs(ours - reference) / size) / largest

    def _error_of_motion(self, ours: Floats, reference: Floats) -> Floats:
        """Of accelerations (b, n) or their derivatives (b, 3, n, n), in coordinates in which all M_ii are one.

        There, what solving costs is bounded by the condition of M times the largest entry of the block; the slopes of
        accelerations are at least as large as these, for a turn by one radian.
        """
        D, margin = _balance(self.book.mass_matrix(self.drawn.q))
        unit = np.broadcast_to(self.size.unit, D.shape)
        least = (D * unit).max(axis=1)
        if reference.ndim == 2:
            pairs = [(np.ones((len(D), 1)), least)]
        else:
            qdd = self.book.accelerations_of(self.drawn.q, self.drawn.qd, self.drawn.tau)
            steepest = np.maximum(least, (D * np.abs(qdd)).max(axis=1))
            pairs = [(unit, steepest), (unit, least), (D, np.ones(len(D)))]
        blocks, gaps = (np.abs(x).reshape(len(D), len(pairs), D.shape[1], -1) for x in (reference, ours - reference))
        worst = np.zeros(len(D))
        for k, (column, floor) in enumerate(pairs):
            scale = D[:, :, None] * column[:, None, :]
            largest = np.maximum(floor, _worst(blocks[:, k] * scale))
            worst = np.maximum(worst, _worst(gaps[:, k] * scale) / largest)
        return worst * np.maximum(margin, SINGULAR)

    def _refuse(self, row: Quantity, name: str, s: States, refusal: ModelError) -> Check:
        """A refusal is right where the mass matrix of the second method is singular, or its numbers are not finite."""
        _, margins = _balance(self.book.mass_matrix(self.drawn.q))
        right = float(margins.min()) < SINGULAR
        if not right and not row.solves_mass_matrix:
            with np.errstate(all="ignore"):
                right = not np.isfinite(row.second.value(self.book, s)).all()
        return Check(name, row.second.key, 0.0 if right else float("inf"), self.limit, reason=str(refusal))


def _balance(M: Floats) -> tuple[Floats, Floats]:
    """(b, n) roots of the diagonal, and (b,) the smallest eigenvalue of M scaled to a diagonal of one."""
    diagonal = np.einsum("bii->bi", M)
    D: Floats = np.sqrt(np.maximum(diagonal, np.maximum(ROUNDING * diagonal.max(axis=1, keepdims=True), LEAST_DIVISOR)))
    margins: Floats = np.linalg.eigvalsh(M / (D[:, :, None] * D[:, None, :])).astype(np.float64)[:, 0]
    return D, margins


def call(robot: Robot, row: Quantity, s: States) -> Floats:
    """The routine's numbers for a set of states."""
    routine: Callable[..., Any] = getattr(robot, row.name)
    named = {name: getattr(s, name) for name in row.optional if getattr(s, name) is not None}
    frame = {"frame": s.frame} if s.frame is not None else {}
    return np.asarray(routine(*(getattr(s, name) for name in row.inputs), **named, **frame))


def call_name(row: Quantity, s: States) -> str:
    """`inverse_dynamics(tip_wrench)`."""
    named = [name for name in row.optional if getattr(s, name) is not None]
    named += [f"frame={s.frame!r}"] if s.frame is not None else []
    return f"{row.name}({', '.join(named)})" if named else row.name


def _worst(ratio: Floats) -> Floats:
    """(b,) largest entry of each state; infinite where it is NaN."""
    flat = ratio.reshape(len(ratio), -1).max(axis=1, initial=0.0)
    return np.where(np.isfinite(flat), flat, np.inf)


def standing(against: Collection[str]) -> tuple[tuple[str, str], ...]:
    """For every peer the key of the sentence: compared, installed but not compared, or not installed."""
    return tuple(
        (name, f"verification.peer_{'compared' if name in against else 'idle' if find_spec(name) else 'missing'}")
        for name in PEERS
    )


def peer_checks(
    name: str, robot: Robot, s: States, limit: float, error: Callable[[str, Floats, Floats], Floats]
) -> tuple[list[Check], list[tuple[str, str]]]:
    """Checks of all that the peer computes too, and what was left out.

    Args:
        name: of the peer.
        robot: the robot.
        s: states.
        limit: relative error allowed.
        error: how far two arrays of a quantity are apart, per state.

    Raises:
        InputError: the peer is not installed.
    """
    if find_spec(name) is None:
        raise InputError("verification.not_installed", peer=name)
    answers, missing = import_module(PEERS[name]).answers(robot.mechanism, s)
    checks: list[Check] = []
    for routine, theirs in answers.items():
        try:
            ours = _ours(robot, routine, s)
        except ModelError:
            missing = [*missing, (f"{routine}, {name}", "verification.no_inverse")]
            continue
        gaps = error(routine.partition("(")[0], ours, np.asarray(theirs))
        checks.append(Check(routine, f"verification.{name}", float(gaps.max()), limit, int(gaps.argmax())))
    return checks, missing


def _ours(robot: Robot, routine: str, s: States) -> Floats:
    name, _, with_wrench = routine.partition("(")
    inputs = [getattr(s, key) for key in quantity(name).inputs]
    return np.asarray(getattr(robot, name)(*inputs, *([s.tip_wrench] if with_wrench else [])))
