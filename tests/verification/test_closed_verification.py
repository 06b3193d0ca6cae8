"""`verify` of robots with loops: every part of the closed chain is compared, slips are caught, gaps are said."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.arrays import Floats
from mafsil.cli.main import main
from mafsil.model import Friction, Joint, JointKind, Mechanism, Mimic
from mafsil.parallel import ClosedChain
from mafsil.parallel.closed_terms import Terms
from mafsil.verification.closed import LoopBook, closed_judge
from mafsil.verification.verification import UNCHECKED, Agreement
from mafsil.verification.verify import TREE
from tests.parallel.closed_chains import four_bar, random_chain

PALLETISER = Path(__file__).parents[2] / "examples" / "robots" / "palletiser.xml"
LIMIT = 1e-11
KINDS = list(JointKind)
pytestmark = pytest.mark.filterwarnings("ignore::mafsil.errors.ModelWarning")


def closed_checks(mechanism: Mechanism, states: int = 3, seed: int = 1) -> dict[str, float]:
    judge = closed_judge(mf.Robot(mechanism), states, seed, LIMIT)
    assert judge is not None
    return {check.routine: check.error for check in judge.checks()[0]}


def near(mechanism: Mechanism, q: Floats) -> Mechanism:
    """With limits round a closed configuration, so that others near it are found."""
    moving = iter(q)

    def bounded(joint: Joint) -> Joint:
        if not joint.moves or joint.mimic is not None:
            return joint
        at = float(next(moving))
        return replace(joint, limits=replace(joint.limits, lower=at - 0.1, upper=at + 0.1))

    return replace(mechanism, joints=tuple(bounded(joint) for joint in mechanism.joints))


@pytest.mark.parametrize("kind", KINDS, ids=[kind.value for kind in KINDS])
def test_loops_of_every_kind_of_joint_agree(kind: JointKind) -> None:
    mechanism, q = random_chain(np.random.default_rng(7), kind)
    found = closed_checks(near(mechanism, q))
    assert {name.partition(".")[2].partition(" ")[0] for name in found} >= {
        "close_loops", "terms", "rates", "accelerations", "forward_dynamics", "inverse_dynamics",
    }  # fmt: skip
    assert max(found.values()) < LIMIT, found


@pytest.mark.parametrize("kind", KINDS, ids=[kind.value for kind in KINDS])
def test_the_second_method_is_a_slope_of_positions(kind: JointKind) -> None:
    """Rates and curvature by the complex step, against central differences of the gaps."""
    mechanism, _ = random_chain(np.random.default_rng(8), kind)
    chain = ClosedChain(mechanism)
    judge = closed_judge(mf.Robot(mechanism), 2, 0, LIMIT) or pytest.skip("no state")
    q, qd, h = judge.s.q, judge.s.qd, 1e-5
    book: LoopBook = judge.loops
    slope = (book.gap(q + h * qd) - book.gap(q - h * qd)) / (2 * h)
    np.testing.assert_allclose(np.einsum("brn,bn->br", book.rows(q), qd), slope, atol=1e-8)
    bend = (book.rates(q + h * qd, qd) - book.rates(q - h * qd, qd)) / (2 * h)
    np.testing.assert_allclose(book.curvature(q, qd), bend, atol=1e-7 * max(1.0, np.abs(bend).max()))
    assert chain.m


def coupled(rng: np.random.Generator) -> tuple[Mechanism, Floats]:
    """A closed chain in which one joint follows another, closed again by the search."""
    mechanism, q = random_chain(rng, JointKind.SPHERICAL)
    names = [joint.name for joint in mechanism.joints]
    follower = names.index("j3")
    joints = list(mechanism.joints)
    joints[follower] = replace(joints[follower], mimic=Mimic("j1", 0.7, float(q[3] - 0.7 * q[1])), actuated=False)
    return replace(mechanism, joints=tuple(joints)), np.delete(q, 3)


def test_coupled_joints_move_with_their_leaders() -> None:
    mechanism, q = coupled(np.random.default_rng(3))
    assert ClosedChain(mechanism).error(q) < 1e-10
    assert max(closed_checks(near(mechanism, q)).values()) < LIMIT
    other = list(mechanism.joints)
    other[3] = replace(other[3], mimic=replace(other[3].mimic, multiplier=0.71))
    wrong, right = ClosedChain(replace(mechanism, joints=tuple(other))), closed_judge(mf.Robot(mechanism), 3, 1, LIMIT)
    assert right is not None
    right.chain = wrong
    assert {check.routine for check in right.checks()[0] if not check.passed} >= {
        "ClosedChain.close_loops", "ClosedChain.terms (rows)", "ClosedChain.forward_dynamics",
    }  # fmt: skip


def test_friction_of_followers_counts_and_that_of_loops_is_said() -> None:
    mechanism, q = coupled(np.random.default_rng(3))
    rough = tuple(replace(j, friction=Friction(viscous=0.3, coulomb=0.2)) if j.moves else j for j in mechanism.joints)
    report = mf.verify(near(replace(mechanism, joints=rough), q), states=2)
    assert report, report.explain()
    assert f"{TREE}friction_torque" in {check.routine for check in report}
    assert "friction" not in {name for name, _ in report.left_out}
    loops = tuple(replace(j, friction=Friction(viscous=0.3)) for j in mechanism.loops)
    report = mf.verify(near(replace(mechanism, loops=loops), q), states=2)
    assert ("friction", "verification.loop_friction") in report.left_out
    assert "friction in the description" in report.explain("en")


SLIPS: dict[str, Callable[[Terms], Terms]] = {
    "mass": lambda t: t._replace(M=1.0001 * t.M),
    "bias": lambda t: t._replace(h=t.h + 1e-4),
    "row": lambda t: t._replace(J=t.J + 1e-4 * np.eye(*t.J.shape[-2:])),
    "row left out": lambda t: t._replace(J=t.J * np.where(np.arange(t.J.shape[-2]) == 0, 0.0, 1.0)[:, None]),
    "curvature": lambda t: t._replace(gamma=1.0001 * t.gamma),
    "sign": lambda t: t._replace(gamma=-t.gamma),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_slips_of_the_closed_chain_are_caught(slip: str, monkeypatch: pytest.MonkeyPatch) -> None:
    judge = closed_judge(mf.load(PALLETISER), 4, 0, LIMIT)
    assert judge is not None
    assert all(check.passed for check in judge.checks()[0])
    truth = ClosedChain.terms
    monkeypatch.setattr(ClosedChain, "terms", lambda chain, q, qd=None: SLIPS[slip](truth(chain, q, qd)))
    judge.chain._compiled.inverse = lambda q: None  # the road on which the terms are used
    judge.chain._forward = judge.chain._forward_chosen
    judge.chain._compiled.forward_for = lambda tau, q: None
    failed = {check.routine for check in judge.checks()[0] if not check.passed}
    assert failed, slip
    expected = {
        "mass": "forward_dynamics",
        "bias": "inverse_dynamics",
        "curvature": "terms (bias)",
        "sign": "terms (bias)",
    }
    assert f"ClosedChain.{expected.get(slip, 'terms (rows)')}" in failed


@pytest.mark.parametrize("name", ["forward_dynamics", "inverse_dynamics", "jacobian_body", "joint_torque"])
def test_slips_of_compiled_answers_are_caught(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    judge = closed_judge(mf.load(PALLETISER), 4, 0, LIMIT)
    assert judge is not None
    own = getattr(judge.chain, name)

    def slipped(*arguments: object, **named: object) -> object:
        found = own(*arguments, **named)
        if name == "forward_dynamics":
            return type(found)((1.0001 * found.qdd, found[1]))
        if name == "inverse_dynamics":
            found.tau = 1.0001 * found.tau
            return found
        return 1.0001 * found

    monkeypatch.setattr(judge.chain, name, slipped)
    failed = {check.routine for check in judge.checks()[0] if not check.passed}
    assert name in {routine.partition(".")[2].partition(" ")[0] for routine in failed}


def test_the_report_says_what_was_compared(capsys: pytest.CaptureFixture[str]) -> None:
    report = mf.verify(PALLETISER, states=2)
    assert report
    assert report.status is Agreement.AGREES
    names = [check.routine for check in report]
    assert {"ClosedChain.forward_dynamics", "forward_kinematics", f"{TREE}mass_matrix"} <= set(names)
    assert not any(name in names for name in ("mass_matrix", "inverse_dynamics", "jacobian_body"))
    assert main(["verify", str(PALLETISER), "--states", "2", "--json"]) == 0
    text = capsys.readouterr().out
    told = json.loads(text[text.index("{") :])
    assert {check["routine"] for check in told["checks"]} == set(names)
    assert main(["verify", str(PALLETISER), "--states", "2", "--lang", "ar"]) == 0
    assert "دالمبير" in capsys.readouterr().out


def test_loops_that_were_not_closed_are_no_agreement() -> None:
    """A bar too long for its place: no configuration closes, so nothing was compared of the loops."""
    mechanism = four_bar()
    far = tuple(replace(j, T_pj=j.T_pj + 100.0 * (np.arange(16).reshape(4, 4) == 3)) for j in mechanism.loops)
    report = mf.verify(replace(mechanism, loops=far), states=2)
    assert not report
    assert report.status is Agreement.INCOMPLETE
    assert ("ClosedChain", UNCHECKED) in report.left_out
    assert all(check.passed for check in report)
    assert "no check of its loops ran" in report.explain("en")
    assert report.explain("ar").startswith("\u2068") or "حلقاته" in report.explain("ar")


def test_what_motors_do_not_decide_is_left_out() -> None:
    mechanism = four_bar()
    idle = tuple(replace(joint, actuated=False) for joint in mechanism.joints)
    report = mf.verify(replace(mechanism, joints=idle), states=2)
    left = dict(report.left_out)
    assert left["ClosedChain.jacobian_space, jacobian_body, joint_torque"] == "verification.not_deciding"
    assert left["ClosedChain.inverse_dynamics"] == "verification.not_moved"
    assert report, report.explain()
