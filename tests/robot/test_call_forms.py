"""Every form of a call of a robot's routine: the same bits, the same errors, and Python only where it must be."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.robot import Robot

LINK = "link2"


@pytest.fixture
def watched(monkeypatch) -> tuple[Robot, list[str]]:
    """A robot of its own, and the names of its general paths as they are taken."""
    seen: list[str] = []
    for name in ("_general", "_general_of_twin"):
        general = getattr(Robot, name)

        def note(self: Robot, *args: Any, general=general, name=name, **named: Any) -> Any:
            seen.append(name)
            return general(self, *args, **named)

        monkeypatch.setattr(Robot, name, note)
    return Robot(mf.load("planar3r").mechanism), seen


def states(*shape: int) -> tuple[np.ndarray, ...]:
    random = np.random.default_rng(4)
    return tuple(random.uniform(-1, 1, (*shape, size)) for size in (3, 3, 3, 6, 6, 6))


FRAMED: dict[str, Callable[[Any, np.ndarray], Any]] = {
    "array": lambda f, q: f(q, frame=LINK),
    "list": lambda f, q: f(q.tolist(), frame=LINK),
    "strided": lambda f, q: f(np.repeat(q, 2)[::2], frame=LINK),
    "single precision": lambda f, q: f(q.astype(np.float32), frame=LINK),
    "into an array": lambda f, q: f(q, frame=LINK, out=np.zeros(f(q).shape)),
    "batch": lambda f, q: f(np.stack([q, q, q]), frame=LINK)[1],
    "batch into an array": lambda f, q: f(np.stack([q, q]), frame=LINK, out=np.zeros((2, *f(q).shape)))[1],
}
OTHER_FRAMED: dict[str, Callable[[Any, np.ndarray], Any]] = {
    "name first": lambda f, q: f(frame=LINK, q=q),
    "array first": lambda f, q: f(q, out=np.zeros(f(q).shape), frame=LINK),
    "threads": lambda f, q: f(q, frame=LINK, threads=1),
    "text made at run time": lambda f, q: f(q, **{"".join(["fra", "me"]): "".join(["li", "nk2"])}),
}


@pytest.mark.parametrize("routine", ["forward_kinematics", "jacobian_body", "jacobian_space"])
@pytest.mark.parametrize("form", FRAMED | OTHER_FRAMED)
def test_frames_in_every_form(watched, routine: str, form: str) -> None:
    robot, _ = watched
    q = states()[0].astype(np.float32).astype(np.float64)
    f = getattr(robot, routine)
    wanted = robot.kernel(routine, LINK).evaluate(q)
    call = (FRAMED | OTHER_FRAMED)[form]
    assert (call(f, q) == wanted).all()
    assert (call(f, q) == wanted).all()
    assert not (f(q) == wanted).all()


@pytest.mark.parametrize("form", FRAMED)
def test_known_frames_need_no_python(watched, form: str) -> None:
    """Once the frame is known and the code for one point, or for a batch, has come."""
    robot, seen = watched
    q = states()[0]
    robot.forward_kinematics(q, frame=LINK)
    FRAMED[form](robot.forward_kinematics, q)
    seen.clear()
    FRAMED[form](robot.forward_kinematics, q)
    assert not seen


PUSHED: dict[str, Callable[..., Any]] = {
    "position": lambda f, q, qd, qdd, F: f(q, qd, qdd, F),
    "name": lambda f, q, qd, qdd, F: f(q, qd, qdd, tip_wrench=F),
    "all names": lambda f, q, qd, qdd, F: f(q=q, qd=qd, qdd=qdd, tip_wrench=F),
    "names in another order": lambda f, q, qd, qdd, F: f(q, tip_wrench=F, qdd=qdd, qd=qd),
    "lists": lambda f, q, qd, qdd, F: f(q.tolist(), tuple(qd), list(qdd), F.tolist()),
    "into an array": lambda f, q, qd, qdd, F: f(q, qd, qdd, tip_wrench=F, out=np.zeros(3)),
    "position into an array": lambda f, q, qd, qdd, F: f(q, qd, qdd, F, out=np.zeros(3)),
    "batch": lambda f, q, qd, qdd, F: f(*(np.stack([x, x]) for x in (q, qd, qdd)), F)[1],
    "batch of wrenches": lambda f, q, qd, qdd, F: f(q, qd, qdd, tip_wrench=np.stack([0 * F, F]))[1],
}


@pytest.mark.parametrize("form", PUSHED)
def test_tip_wrench_in_every_form(watched, form: str) -> None:
    robot, seen = watched
    q, qd, qdd, F, *_ = states()
    wanted = robot.kernel("inverse_dynamics", None, ("tip_wrench",)).evaluate(q, qd, qdd, F)
    call = PUSHED[form]
    assert (call(robot.inverse_dynamics, q, qd, qdd, F) == wanted).all()
    assert seen
    seen.clear()
    assert (call(robot.inverse_dynamics, q, qd, qdd, F) == wanted).all()
    assert not seen


def test_optional_inputs_are_never_mistaken_for_each_other(watched) -> None:
    """Once every form has its builtin, each still means what its names and places say."""
    robot, _ = watched
    f = robot.inverse_dynamics
    q, qd, qdd, F, V, A = states()
    full = robot.kernel("inverse_dynamics", None, ("tip_wrench", "base_twist", "base_acceleration"))
    none = np.zeros(6)
    for _round in range(2):
        for wanted, given in (
            (full.evaluate(q, qd, qdd, F, V, A), f(q, qd, qdd, F, V, A)),
            (full.evaluate(q, qd, qdd, F, V, none), f(q, qd, qdd, F, V)),
            (full.evaluate(q, qd, qdd, none, V, none), f(q, qd, qdd, base_twist=V)),
            (full.evaluate(q, qd, qdd, none, V, none), f(q, qd, qdd, None, V)),
            (full.evaluate(q, qd, qdd, none, V, A), f(q, qd, qdd, base_acceleration=A, base_twist=V)),
            (full.evaluate(q, qd, qdd, F, V, none), f(q, qd, qdd, base_twist=V, tip_wrench=F)),
            (full.evaluate(q, qd, qdd, F, none, none), f(qd=qd, tip_wrench=F, qdd=qdd, q=q)),
            (full.evaluate(q, qd, qdd, none, none, none), f(q, qd, qdd, tip_wrench=None)),
            (full.evaluate(q, qd, qdd, none, none, none), f(q, qd, qdd, None, None, None)),
        ):
            np.testing.assert_allclose(given, wanted, atol=1e-13)


def test_typed_wrenches_keep_their_frame_after_plain_ones(watched) -> None:
    robot, _ = watched
    q, qd, qdd, F, *_ = states()
    wanted = robot.inverse_dynamics(q, qd, qdd, F)
    assert (robot.inverse_dynamics(q, qd, qdd, mf.Wrench(F, "b")) == wanted).all()
    assert (robot.inverse_dynamics(q, qd, qdd, tip_wrench=mf.Wrench(F, "b")) == wanted).all()
    for call in (
        lambda: robot.inverse_dynamics(q, qd, qdd, mf.Wrench(F, "s")),
        lambda: robot.inverse_dynamics(q, qd, qdd, tip_wrench=mf.Wrench(F, "s")),
    ):
        call_again_raises(call, "tip_wrench")


def call_again_raises(call: Callable[[], object], *words: str) -> None:
    for _round in range(2):
        with pytest.raises(mf.MafsilError) as caught:
            call()
        for word in words:
            assert word in str(caught.value)


def test_errors_are_the_same_in_every_form(watched) -> None:
    robot, _ = watched
    q, qd, qdd, F, V, _ = states()
    fk, dynamics = robot.forward_kinematics, robot.inverse_dynamics
    fk(q, frame=LINK)
    dynamics(q, qd, qdd, F)
    dynamics(q, qd, qdd, tip_wrench=F)
    bad = [0.0, np.nan, 0.0]
    call_again_raises(lambda: fk(bad, frame=LINK), "q", "nan", "(1,)")
    call_again_raises(lambda: fk(q[:2], frame=LINK), "q", "(*batch, 3)", "(2,)")
    call_again_raises(lambda: fk(q, frame=LINK, out=np.zeros((3, 4))), "out", "(4, 4)", "(3, 4)")
    call_again_raises(lambda: fk(q, frame="elbow"), "elbow", LINK)
    call_again_raises(lambda: fk(q, frame=2), "forward_kinematics", "int")
    call_again_raises(lambda: fk(q, q, frame=LINK), "2 arguments")
    call_again_raises(lambda: dynamics(q, qd, qdd, F, tip_wrench=F), "'tip_wrench'")
    call_again_raises(lambda: dynamics(q, qd, tip_wrench=F), "qdd", "missing")
    call_again_raises(lambda: dynamics(q, qd, qdd, F[:5]), "tip_wrench", "(*batch, 6)")
    call_again_raises(lambda: dynamics(q, qd, qdd, tip_wrench=F[:5]), "tip_wrench", "(*batch, 6)")
    call_again_raises(lambda: dynamics(q, qd, qdd, tip_wrench=np.full(6, np.inf)), "tip_wrench", "inf", "(0,)")
    call_again_raises(lambda: dynamics(q, qd, qdd, F, V, V, V), "7 arguments")
    call_again_raises(lambda: dynamics(q, qd, qdd, wrench=F), "'wrench'")
    call_again_raises(lambda: robot.mass_matrix(q, frame=LINK), "mass_matrix", "frame")


@pytest.mark.parametrize("rows", [1, 2, 3, 8, 33, 2048])
def test_batches_of_every_size_with_frame_and_wrench(watched, rows: int) -> None:
    robot, _ = watched
    q, qd, qdd, F, *_ = states(rows)
    poses, efforts = (robot.forward_kinematics(q, frame=LINK), robot.inverse_dynamics(q, qd, qdd, F))
    q[rows // 2, 0] = np.nan
    for _round in range(2):
        again = robot.forward_kinematics(q, frame=LINK), robot.inverse_dynamics(q, qd, qdd, tip_wrench=F)
        others = np.arange(rows) != rows // 2
        for k, whole in enumerate((poses, efforts)):
            assert (again[k][others] == whole[others]).all()
            assert np.isnan(again[k][rows // 2]).any()
    k = 0 if rows > 1 else None
    if k is not None:
        assert (robot.inverse_dynamics(q[k], qd[k], qdd[k], F[k]) == efforts[k]).all()


def test_routines_travel_after_all_their_forms(watched) -> None:
    robot, _ = watched
    q, qd, qdd, F, *_ = states()
    want = robot.forward_kinematics(q, frame=LINK), robot.inverse_dynamics(q, qd, qdd, F)
    for fk, dynamics in (
        pickle.loads(pickle.dumps((robot.forward_kinematics, robot.inverse_dynamics))),
        copy.deepcopy((robot.forward_kinematics, robot.inverse_dynamics)),
    ):
        for _round in range(2):
            assert (fk(q, frame=LINK) == want[0]).all()
            assert (dynamics(q, qd, qdd, tip_wrench=F) == want[1]).all()


def test_without_machine_code_behind_the_builtin_the_answers_stay(watched, monkeypatch) -> None:
    from mafsil.kernels import runtime

    robot, _ = watched
    q, qd, qdd, F, *_ = states()
    want = robot.forward_kinematics(q, frame=LINK), robot.inverse_dynamics(q, qd, qdd, F)
    monkeypatch.setattr(runtime, "available", lambda: False)
    plain = Robot(robot.mechanism)
    for _round in range(2):
        assert (plain.forward_kinematics(q, frame=LINK) == want[0]).all()
        assert (plain.inverse_dynamics(q, qd, qdd, tip_wrench=F) == want[1]).all()
        with pytest.raises(InputError, match="q"):
            plain.forward_kinematics(q[:1], frame=LINK)


def test_a_frame_after_the_fast_form_was_learned_is_refused_as_before():
    robot, x, F = mf.load("cobra600"), np.zeros(4), np.zeros(6)
    for _ in range(3):
        robot.inverse_dynamics(x, x, x, F)
    with pytest.raises(InputError, match="does not depend on a frame"):
        robot.inverse_dynamics(x, x, x, F, frame="nowhere")
