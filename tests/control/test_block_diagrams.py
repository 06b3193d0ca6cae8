"""Block diagrams say what the laws compute; a drive's inner loop is there, in the drawing and in the run."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import (
    Impedance,
    add_delay,
    block_diagram,
    combine,
    computed_torque,
    current_loop,
    feedforward,
    force_control,
    gravity_compensation,
    hold_pose,
    hybrid_control,
    impedance_control,
    null_space_feedback,
    pid,
    sliding_mode,
    task_computed_torque,
)
from mafsil.errors import InputError
from mafsil.figures.block_diagram import plot_block_diagram, plot_response, skeleton
from mafsil.simulation import Scenario, simulate
from mafsil.trajectory import quintic

ARM = mf.load("puma560")
Q = np.array([0.1, -0.4, 0.6, 0.3, -0.5, 0.2])
T = ARM.forward_kinematics(Q)
WRENCH = [0, 0, 0, 1, 2, 3.0]
LAWS = {
    "pid": pid(6, 100.0, 20.0, 3.0),
    "pd_gravity": gravity_compensation(ARM, 100.0, 20.0),
    "computed_torque": computed_torque(ARM),
    "feedforward_pd": combine(feedforward(ARM), pid(6, 50.0, 5.0)),
    "force": force_control(ARM, WRENCH, sensor=lambda q, qd: 0.3 * np.ones(6), kp=0.5, ki=1.0, damping=4.0),
    "null_space": null_space_feedback(ARM),
    "task": task_computed_torque(ARM, hold_pose(T)),
    "impedance": impedance_control(ARM, Impedance.of(6, stiffness=1.0), hold_pose(T)),
    "hybrid": hybrid_control(ARM, hold_pose(T), [0, 0, 0, 0, 0, 1], WRENCH),
    "sliding": sliding_mode(ARM),
    "late": add_delay(current_loop(computed_torque(ARM), 2000.0), 0.002),
}


@pytest.mark.capability("10-108", "10-5")
@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("idealised", [False, True])
def test_diagrams_close_the_loop_and_compute_the_law(name, idealised):
    law = LAWS[name]
    diagram = block_diagram(law, idealised=idealised)
    names = [block.name for block in diagram.blocks]
    assert len(set(names)) == len(names)
    assert {end for arrow in diagram.arrows for end in (arrow.start, arrow.end)} <= set(names)
    assert len({(block.column, block.row) for block in diagram.blocks}) == len(names)
    reached, new = set(), ["sum"]
    while new:
        here = new.pop()
        reached.add(here)
        new += [one for one in diagram.followers(here) if one not in reached]
    assert {"arm", "sensors"} <= reached
    assert any(one.startswith("term") for one in reached), "what is measured comes back to the law"
    inner = "amplifier" in diagram.followers("actuator")
    assert inner is not idealised
    assert ("amplifier" in names) is not idealised
    assert ("delay" in names) is (name == "late")
    if name == "late" and not idealised:
        assert "ω = 2000 rad/s" in [block.text for block in diagram.blocks]
    rng = np.random.default_rng(1)
    reference = quintic(np.zeros(6), np.ones(6), 1.0).at(0.4)
    q, qd = Q + 0.1 * rng.normal(size=6), rng.normal(size=6)
    effort = diagram.effort(0.4, q, qd, reference)
    if name in ("task", "impedance", "hybrid", "sliding"):
        assert effort is None
        assert len(diagram.terms) > 1
    else:
        assert np.abs(effort - law(0.4, q, qd, reference)).max() < 1e-10


def test_a_law_of_ones_own_is_one_block():
    class Mine:
        def __call__(self, t, q, qd, reference):
            return -q

        def session(self, period):
            return self

    diagram = block_diagram(Mine())
    assert diagram.terms[0].text.startswith("Mine")
    assert np.array_equal(diagram.effort(0.0, Q, Q, None), -Q)


@pytest.mark.capability("10-5")
def test_the_inner_loop_follows_exactly_and_endless_bandwidth_is_the_ideal():
    class Step:
        def __call__(self, t, q, qd, reference):
            return np.full_like(q, 1.0 if t > 0.0 else 0.0)

        def session(self, period):
            return self

    w, period = 50.0, 0.01
    session = current_loop(Step(), w).session(period)
    got = [session(k * period, np.zeros(1), np.zeros(1), None)[0] for k in range(6)]
    assert got[1:] == pytest.approx([1.0 - np.exp(-w * k * period) for k in range(1, 6)], rel=1e-12)
    path = quintic(np.zeros(6), 0.3 * np.ones(6), 0.3)
    ideal, fast, slow = (
        simulate(Scenario(robot=ARM, trajectory=path, law=law, saturate=False), fused=False)
        for law in (
            computed_torque(ARM), current_loop(computed_torque(ARM), 1e6), current_loop(computed_torque(ARM), 60.0)
        )
    )  # fmt: skip
    assert np.abs(fast.q - ideal.q).max() < 1e-9
    assert np.abs(slow.q - ideal.q).max() > 1e-4
    with pytest.raises(InputError):
        current_loop(Step(), -1.0)


@pytest.mark.capability("10-108")
@pytest.mark.parametrize("language", ["en", "ar"])
def test_diagrams_and_responses_are_drawn(tmp_path, language):
    plot_block_diagram(block_diagram(LAWS["late"]), tmp_path / "diagram.svg", language=language)
    assert (tmp_path / "diagram.svg").stat().st_size > 5_000
    path = quintic(np.zeros(6), Q, 0.2)
    run = simulate(Scenario(robot=ARM, trajectory=path, law=LAWS["computed_torque"]))
    plot_response(run, ARM, tmp_path / "response.png", language=language)
    assert (tmp_path / "response.png").stat().st_size > 5_000
    line = skeleton(ARM, Q)
    assert np.array_equal(line[-1], T[:3, 3])
    assert len(line) == len(ARM.mechanism.links) + 1
