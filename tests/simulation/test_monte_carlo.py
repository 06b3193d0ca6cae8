"""Many drawn runs: each equals the run of its own plant, whatever runs beside it and wherever."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache, partial
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mafsil as mf
from mafsil import figures
from mafsil.control import (
    Gains,
    Wall,
    closed_computed_torque,
    closed_gravity_compensation,
    combine,
    computed_torque,
    feedforward,
    gravity_compensation,
)
from mafsil.control.laws import ComputedTorque, driven_trajectory
from mafsil.errors import InputError
from mafsil.mechanics.inertial_parameters import inertial_of, moved_parameters, parameters_of
from mafsil.model import Friction, Inertial
from mafsil.parallel import ClosedChain
from mafsil.simulation import (
    ClosedPlant,
    Normal,
    Plant,
    Scenario,
    Uniform,
    Variation,
    cluster_executor,
    monte_carlo,
    simulate,
)
from mafsil.simulation.chunk_runs import chunk_size
from mafsil.simulation.closed_plant import plant_of as plant_as_it_is
from mafsil.simulation.many_runs import MonteCarloStatus, wilson
from mafsil.simulation.variation import drawn, drawn_name
from mafsil.trajectory import quintic
from mafsil.trajectory.profiles import rest
from tests.parallel.closed_chains import four_bar

ALL = Variation(payload=(0.0, 2.0), payload_offset=(-0.05, 0.05), inertia=(0.9, 1.1), friction=(0.5, 2.0),
                gains=(0.8, 1.2), start=Normal(0.0, 0.01))  # fmt: skip


@cache
def scenario(law="computed_torque", seconds=0.2, **options):
    robot = mf.load("puma560")
    laws = {
        "computed_torque": lambda: computed_torque(robot, natural_frequency=25.0, integral=50.0),
        "pd_gravity": lambda: gravity_compensation(robot, kp=200.0, kd=20.0),
        "two": lambda: combine(feedforward(robot), gravity_compensation(robot, kp=200.0, kd=20.0)),
        "own": lambda: Own(computed_torque(robot)),
    }
    path = quintic(np.zeros(6), [0.3, -0.2, 0.2, 0.4, -0.4, 0.5], seconds)
    return Scenario(robot=robot, trajectory=path, law=laws[law](), **options)


class Own:
    """A law that only Python knows."""

    def __init__(self, law):
        self.law = law

    def __call__(self, t, q, qd, reference):
        return self.law(t, q, qd, reference)

    def session(self, period):
        return self


def plant_of(robot, variants, k):
    """The plant of run k by the models' own means."""
    joints, row = [], 0
    for joint in robot.mechanism.joints:
        if joint.moves and joint.friction is not None:
            f, factor = joint.friction, variants.friction[k, row]
            row += 1
            back = None if f.coulomb_negative is None else f.coulomb_negative * factor
            joint = replace(joint, friction=replace(f, viscous=f.viscous * factor, coulomb=f.coulomb * factor,
                                                    coulomb_negative=back, offset=f.offset * factor))  # fmt: skip
        joints.append(joint)
    arm = mf.Robot(replace(robot.mechanism, joints=tuple(joints)))
    plant = plant_as_it_is(arm).with_scaled_inertia(variants.inertia[k])
    return plant.with_payload(variants.payload[k], com=variants.payload_offset[k], inertia=np.zeros((3, 3)))


@pytest.mark.parametrize("fused", [True, False])
def test_each_variant_is_the_run_of_its_own_plant(fused):
    given = scenario()
    variants = drawn(ALL, given.robot, 1e-3, 3, 7)
    assert variants.friction is not None
    assert variants.friction.shape[1] > 0
    many = simulate(replace(given, variants=variants), fused=fused)
    for k in range(3):
        law = given.law
        gains = type(law.gains)(*(x * variants.gains[k] for x in (law.gains.kp, law.gains.kd, law.gains.ki)))
        law = ComputedTorque(given.robot, gains)
        alone = simulate(replace(given, law=law, plant=plant_of(given.robot, variants, k),
                                 q=variants.start[k] + given.trajectory.at(0.0).u,
                                 integrator=replace(given, variants=variants).chosen_integrator))  # fmt: skip
        assert np.allclose(many.q[:, k], alone.q, rtol=0, atol=1e-11)
        assert np.allclose(many.tau[:, k], alone.tau, rtol=0, atol=1e-8)
        assert np.allclose(many.qdd[:, k], alone.qdd, rtol=0, atol=1e-6)


@pytest.mark.parametrize("law", ["computed_torque", "pd_gravity", "two", "own"])
def test_runs_are_the_same_alone_and_in_any_company(law):
    variation = Variation(payload=(0.0, 2.0), inertia=(0.9, 1.1), start=Normal(0.0, 0.01))
    given = scenario(law)
    few, many = monte_carlo(given, variation, 3, seed=5), monte_carlo(given, variation, 9, seed=5)
    assert all(np.array_equal(a, many.variants.columns()[name][:3]) for name, a in few.variants.columns().items())
    for k in range(3):
        recording = many.again(k)
        assert recording.tip_position_error.max() == many.outcomes.tip_error[k]
        assert np.array_equal(np.abs(recording.tau).max(axis=0), few.outcomes.effort[k])
        rms = np.sqrt(np.mean(recording.tip_position_error**2))
        assert rms == pytest.approx(many.outcomes.tip_rms[k], rel=1e-12)
        work = np.abs(recording.tau * recording.qd).sum() * 1e-3
        assert work == pytest.approx(many.outcomes.work[k], rel=1e-12)


def test_an_executor_gives_the_same_bits(monkeypatch):
    monkeypatch.setattr("mafsil.simulation.chunk_runs.MOST_IN_CHUNK", 4)
    given, seen = scenario(), []
    here = monte_carlo(given, ALL, 10, progress=seen.append)
    with ThreadPoolExecutor(2) as pool:
        there = monte_carlo(given, ALL, 10, executor=pool)
    for name, array in here.outcomes.arrays().items():
        assert np.array_equal(array, there.outcomes.arrays()[name]), name
    assert seen == [0.4, 0.8, 1.0]
    stopped = monte_carlo(given, ALL, 10, progress=lambda done: False)
    assert len(stopped) == 4
    assert np.array_equal(stopped.outcomes.tip_error, here.outcomes.tip_error[:4])


def test_two_dask_workers_give_the_same_bits(monkeypatch):
    distributed = pytest.importorskip("distributed")
    given = scenario()
    variation = Variation(payload=(0.0, 2.0), inertia=(0.9, 1.1))
    size = chunk_size([given])
    here = monte_carlo(given, variation, size + 5)
    with cluster_executor("2") as client:
        assert isinstance(client, distributed.Client)
        there = monte_carlo(given, variation, size + 5, executor=client)
        assert len(client.scheduler_info(n_workers=-1)["workers"]) == 2
    for name, array in here.outcomes.arrays().items():
        assert np.array_equal(array, there.outcomes.arrays()[name]), name


def test_clusters_that_are_none_are_named(monkeypatch):
    with cluster_executor(None) as nobody:
        assert nobody is None
    for where in ("0", "100000", "nonsense://somewhere"):
        with pytest.raises(InputError, match="cluster"), cluster_executor(where):
            pass
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"mafsil\[distributed\]"), cluster_executor("2"):
        pass


def test_runs_that_blow_up_leave_the_others_alone():
    given = scenario("pd_gravity", seconds=0.3, saturate=False)
    variation = Variation(gains=(0.5, 30.0), start=Normal(0.0, 0.02))
    found = monte_carlo(given, variation, 24, seed=1, bound=0.05)
    assert found.status is MonteCarloStatus.SOME_FAILED
    assert not found
    finished = found.outcomes.finished
    assert 0 < finished.sum() < 24
    assert np.isinf(found.outcomes.tip_error[~finished]).all()
    assert np.isfinite(found.outcomes.tip_error[finished]).all()
    assert (found.outcomes.end[~finished] < 0.3 - 1e-9).all()
    alone = found.again(int(np.flatnonzero(finished)[0]))
    assert alone.tip_position_error.max() == found.outcomes.tip_error[finished][0]
    assert next(iter(found.influence)) == "gains"
    assert f"{int(finished.sum())} of 24" in found.explain("en")
    assert np.isinf(found.quantile(1.0))
    assert np.isfinite(found.quantile(0.01))
    assert not finished[next(iter(found))]


@pytest.mark.parametrize("law", ["computed_torque", "own"])
def test_a_delay_is_that_of_the_delayed_law(law):
    given = scenario(law)
    found = monte_carlo(given, Variation(delay=Uniform(0.0, 0.004)), 6, seed=2)
    late = found.variants.delay
    assert late is not None
    assert len(set(late.tolist())) > 2
    for k in range(3):
        alone = simulate(replace(given, law=mf.control.add_delay(given.law, late[k] * 1e-3)))
        assert alone.tip_position_error.max() == pytest.approx(found.outcomes.tip_error[k], rel=1e-9)


def test_walls_are_felt_by_every_variant():
    robot = mf.load("puma560")
    tip = robot.forward_kinematics(np.zeros(6))
    stands = Wall(point=tip[:3, 3] + [0.0, 0.0, 0.01], normal=[0.0, 0.0, -1.0], stiffness=2e4, damping=50.0)
    given = scenario(plant=Plant(robot, environment=stands))
    variation = Variation(payload=(0.0, 1.0))
    found = monte_carlo(given, variation, 2, seed=3)
    plant = given.plant.with_payload(found.variants.payload[1])
    alone = simulate(replace(given, plant=plant, integrator=given.chosen_integrator))
    assert alone.tip_position_error.max() == pytest.approx(found.outcomes.tip_error[1], rel=1e-9)
    with pytest.raises(InputError, match="once a step"):
        monte_carlo(replace(given, integrator="rk4"), variation, 2)


@given(st.integers(0, 60), st.integers(1, 60))
def test_the_interval_of_a_share_is_wilsons(good, count):
    """Its ends are the shares from which what was seen lies 1.96 standard deviations away."""
    good = min(good, count)
    share, low, high = wilson(good, count)
    assert 0.0 <= low <= share <= high <= 1.0
    for end in (low, high):
        if 1e-12 < end < 1.0 - 1e-12:
            assert abs(share - end) == pytest.approx(1.959963984540054 * np.sqrt(end * (1 - end) / count), rel=1e-6)


def test_draws_have_their_distributions():
    robot = mf.load("puma560")
    variants = drawn(Variation(payload=(1.0, 3.0), start=Normal(0.5, 0.1)), robot, 1e-3, 4000, 0)
    assert variants.payload.min() >= 1.0
    assert variants.payload.max() <= 3.0
    assert variants.payload.mean() == pytest.approx(2.0, abs=0.05)
    assert variants.start.mean() == pytest.approx(0.5, abs=0.005)
    assert variants.start.std() == pytest.approx(0.1, rel=0.03)
    together = np.corrcoef(variants.payload, variants.start[:, 0])[0, 1]
    assert abs(together) < 0.06


@given(st.integers(0, 10_000))
def test_parameters_seen_from_another_frame(seed):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(3, 3))
    body = Inertial(float(rng.uniform(0.1, 5)), rng.normal(size=3), A @ A.T)
    R = np.linalg.qr(A)[0]
    R, p = R * np.sign(np.linalg.det(R)), rng.normal(size=3)
    moved = inertial_of(moved_parameters(parameters_of(body), R, p))
    assert moved.mass == pytest.approx(body.mass)
    assert np.allclose(moved.com, R @ body.com + p)
    assert np.allclose(moved.inertia, R @ body.inertia @ R.T, atol=1e-8)


def test_what_makes_no_sense_is_refused():
    given = scenario()
    for bad in ((1.0,), (2.0, 1.0), (0.0, np.nan), "wide"):
        with pytest.raises(InputError, match="payload"):
            Variation(payload=bad)
    with pytest.raises(InputError, match="deviation"):
        Normal(0.0, -1.0)
    for name, spread in (
        ("payload", (-2.0, -1.0)),
        ("inertia", (0.0, 0.0)),
        ("friction", (-1.0, -0.5)),
        ("delay", (-1, -1)),
    ):
        with pytest.raises(InputError, match=name):
            monte_carlo(given, Variation(**{name: spread}), 4)
    with pytest.raises(InputError, match="gains"):
        monte_carlo(scenario("own"), Variation(gains=(0.9, 1.1)), 4)
    with pytest.raises(InputError, match="batch"):
        monte_carlo(replace(given, q=np.zeros((2, 6))), Variation(), 4)
    for options in ({"runs": 0}, {"seed": -1}, {"bound": 0.0}, {"executor": 3}, {"progress": 3}):
        with pytest.raises(InputError):
            monte_carlo(given, Variation(), **{"runs": 2, **options})
    with pytest.raises(InputError, match="delay"):
        monte_carlo(given, Variation(delay=(1e3, 1e3)), 2)


def test_the_answer_in_words_and_as_a_picture(tmp_path):
    found = monte_carlo(scenario(), Variation(payload=(0.0, 2.0), inertia=(0.99, 1.01)), 40, bound=1e-3)
    share, low, high = found.share_within
    assert share == np.mean(found.outcomes.tip_error <= 1e-3)
    for language in ("en", "ar"):
        text = found.explain(language)
        assert f"{100 * share:.4g}" in text
        assert f"{100 * low:.4g}" in text
        assert {"en": "payload", "ar": "الحمل"}[language] in text
        assert all(drawn_name(name, language, unit=True) for name in found.variants.columns())
    worst = list(found)
    assert all(a >= b for a, b in pairwise(found.outcomes.tip_error[worst]))
    assert str(worst[0]) in repr(found)
    assert set(found.to_dict()) >= {"influence", "drawn", "tip_error", "share_within"}
    for name in ("a.png", "b.svg"):
        figures.plot_monte_carlo(found, tmp_path / name, language="en")
        assert (tmp_path / name).stat().st_size > 5000
    assert "payload [kg]" in (tmp_path / "b.svg").read_text("utf-8")
    assert high > share


def test_other_engines_run_what_they_can_vary():
    given = scenario(plant=mf.simulation.MuJoCoPlant(mf.load("puma560"), friction=False))
    found = monte_carlo(given, Variation(gains=(0.8, 1.2), start=Normal(0.0, 0.01)), 2)
    assert found
    with pytest.raises(InputError, match="MuJoCo"):
        monte_carlo(given, Variation(payload=(0.0, 1.0)), 2)


def several(law="computed_torque", **options):
    """Three motions that follow each other; the plant of the second carries something that its law knows."""
    robot = mf.load("puma560")
    carrying = Plant(robot).with_payload(1.0, com=np.zeros(3), inertia=np.zeros((3, 3)))
    stops = np.array(
        [[0, 0, 0, 0, 0, 0], [0.1, -0.1, 0.1, 0.1, -0.1, 0.2], [0.2, 0, 0, 0.2, 0, 0], [0, 0, 0, 0, 0, 0.1]]
    )
    made = {
        "computed_torque": lambda r: computed_torque(r, natural_frequency=25.0),
        "own": lambda r: Own(computed_torque(r)),
    }
    for k, (a, b) in enumerate(pairwise(stops)):
        plant = carrying if k == 1 else Plant(robot)
        yield Scenario(
            robot=plant.robot, plant=plant, trajectory=quintic(a, b, 0.05), law=made[law](plant.robot), **options
        )


@pytest.mark.parametrize("law", ["computed_torque", "own"])
def test_motions_that_follow_each_other(law):
    parts = list(several(law, noise=mf.simulation.SensorNoise(1e-4, 1e-3, 5)))
    variation = Variation(payload=(0.0, 2.0), inertia=(0.9, 1.1), noise=(0.0, 3.0), start=Normal(0.0, 0.01))
    marks = [0.0, 0.02, 0.05, 0.0725, 0.15]
    found = monte_carlo(parts, variation, 5, seed=5, marks=marks)
    assert found
    for k in (0, 4):
        tape = found.again(k)
        assert tape.t[-1] == found.outcomes.end[k] == pytest.approx(0.15)
        assert len(tape.t) == 151
        assert tape.tip_position_error.max() == found.outcomes.tip_error[k]
        assert np.array_equal(np.abs(tape.tau).max(axis=0), found.outcomes.effort[k])
        assert np.sqrt(np.mean(tape.tip_position_error**2)) == pytest.approx(found.outcomes.tip_rms[k], rel=1e-12)
        for mark, q in zip(marks, found.outcomes.marked[k], strict=True):
            near = np.abs(tape.t - mark).argmin()
            between = 0.0 if abs(tape.t[near] - mark) < 1e-9 else np.abs(tape.qd[near]).max() * 6e-4
            assert np.abs(tape.q[near] - q).max() <= between + 1e-12
    few = monte_carlo(parts, variation, 2, seed=5, marks=marks)
    assert np.array_equal(few.outcomes.marked, found.outcomes.marked[:2])


@pytest.mark.parametrize("compiled", [True, False])
def test_laws_remember_from_motion_to_motion(compiled, monkeypatch):
    """As single runs do that hand on what their law remembers: here what an integral holds up."""
    monkeypatch.setattr("mafsil.simulation.chunk_runs.can_fuse", lambda scenario: compiled)
    parts = [
        replace(each, law=gravity_compensation(each.robot, 200.0, 20.0, 900.0, friction=False)) for each in several()
    ]
    found = monte_carlo(parts, Variation(gains=(1.0, 1.0)), 1, marks=[0.15])
    memory, q, qd = mf.control.laws.LawMemory(), parts[0].q, parts[0].qd
    for part in parts:
        tape = mf.simulate(replace(part, q=q, qd=qd), memory=memory)
        q, qd = tape.q[-1], tape.qd[-1]
    np.testing.assert_allclose(found.outcomes.marked[0, 0], q, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.again(0).q[-1], q, rtol=0, atol=1e-9)


def test_commands_that_are_late_act_in_the_next_motion():
    """As those of the delayed law do: here of a law that pulls where a motion ends, far from the reference."""
    parts = [replace(each, law=gravity_compensation(each.robot, 60.0, 6.0)) for each in several()]
    found = monte_carlo(parts, Variation(delay=(0.006, 0.006)), 1, marks=[0.15])
    memory, q, qd = mf.control.laws.LawMemory(), parts[0].q, parts[0].qd
    for part in parts:
        tape = mf.simulate(replace(part, law=mf.control.add_delay(part.law, 0.006), q=q, qd=qd), memory=memory)
        q, qd = tape.q[-1], tape.qd[-1]
    np.testing.assert_allclose(found.outcomes.marked[0, 0], q, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.again(0).q[-1], q, rtol=0, atol=1e-12)


def test_a_run_that_ends_in_one_motion_is_not_in_the_next():
    parts = [replace(each, law=gravity_compensation(each.robot, 200.0, 20.0), saturate=False) for each in several()]
    found = monte_carlo(parts, Variation(gains=(0.5, 80.0)), 12, seed=1, marks=[0.0, 0.15])
    done = found.outcomes.finished
    assert 0 < done.sum() < 12
    assert np.isnan(found.outcomes.marked[~done, 1]).all()
    assert np.isfinite(found.outcomes.marked[done]).all()
    for k in np.flatnonzero(~done)[:2]:
        tape = found.again(int(k))
        assert tape.status.name == "BLOWN_UP"
        assert tape.t[-1] == pytest.approx(found.outcomes.end[k])
        assert np.isfinite(tape.tau).all()
        assert found.outcomes.end[k] < 0.15


def test_the_integrator_is_one_for_all_runs_whatever_runs_beside_them():
    given = scenario("own", step=1.2e-4, seconds=0.02)
    alone = given.stiffness
    assert alone < 1.0
    variation = Variation(friction=(0.1, 1.5 / alone))
    found = monte_carlo(given, variation, 6, seed=3)
    assert found.scenarios[0].integrator == "implicit_friction"
    for k in range(6):
        assert found.again(k).tip_position_error.max() == found.outcomes.tip_error[k]


def test_the_noise_of_a_run_is_its_own(monkeypatch):
    monkeypatch.setattr("mafsil.simulation.chunk_runs.MOST_IN_CHUNK", 2)
    given = scenario(noise=mf.simulation.SensorNoise(1e-3, 1e-2, 7), seconds=0.05)
    found = monte_carlo(given, Variation(noise=(1.0, 1.0)), 5)
    assert len(set(found.outcomes.tip_error.tolist())) == 5
    assert found.again(4).tip_position_error.max() == found.outcomes.tip_error[4]
    loud = monte_carlo(given, Variation(noise=(10.0, 10.0)), 5)
    assert loud.outcomes.tip_rms.std() > 3 * found.outcomes.tip_rms.std()
    with pytest.raises(InputError, match="noise"):
        monte_carlo(scenario(), Variation(noise=(1.0, 2.0)), 2)


def test_gains_behind_a_delay_are_varied_too():
    given = scenario()
    late = replace(given, law=mf.control.add_delay(given.law, 0.002))
    found = monte_carlo(late, Variation(gains=(0.5, 2.0)), 2, seed=1)
    slow = mf.control.add_delay(computed_torque(given.robot, natural_frequency=25.0, integral=50.0), 0.002)
    factor = found.variants.gains[0]
    law = ComputedTorque(
        given.robot,
        type(slow.law.gains)(*(x * factor for x in (slow.law.gains.kp, slow.law.gains.kd, slow.law.gains.ki))),
    )
    alone = simulate(replace(given, law=mf.control.add_delay(law, 0.002), integrator=found.scenarios[0].integrator))
    assert alone.tip_position_error.max() == pytest.approx(found.outcomes.tip_error[0], rel=1e-9)


def test_sequences_and_marks_that_make_no_sense_are_refused():
    with pytest.raises(InputError, match="scenario"):
        monte_carlo([], Variation(), 2)
    with pytest.raises(InputError, match="scenario"):
        monte_carlo([3], Variation(), 2)
    other = mf.load("planar2r")
    with pytest.raises(InputError, match="same coordinates"):
        monte_carlo(
            [scenario(), Scenario(robot=other, trajectory=quintic([0, 0], [1, 1], 0.1), law=computed_torque(other))],
            Variation(),
            2,
        )
    for marks in ([-0.1], [0.3], [0.1, 0.05], [np.nan]):
        with pytest.raises(InputError, match="marks"):
            monte_carlo(scenario(), Variation(), 2, marks=marks)


def rubbing_four_bar():
    joints = (replace(j, friction=Friction(0.05, 0.1)) if j.moves else j for j in four_bar().joints)
    return replace(four_bar(), joints=tuple(joints))


def closed_scenario(law, **options):
    chain = ClosedChain(rubbing_four_bar(), ("A",))
    start = chain.close_loops([0.5, 0.5, 1.5], hold=["A"]).q
    motion = driven_trajectory(chain, quintic(start[:1], start[:1] + 0.6, 0.1), start)
    return Scenario(robot=mf.Robot(rubbing_four_bar()), trajectory=motion, law=law(chain), **options)


@pytest.mark.parametrize("fused", [True, False])
@pytest.mark.parametrize("integrator", ["semi_implicit_euler", "implicit_friction"])
def test_each_variant_with_loops_is_the_run_of_its_own_plant(fused, integrator):
    spread = replace(ALL, payload=(0.0, 0.3))
    given = closed_scenario(closed_computed_torque, integrator=integrator)
    variants = drawn(spread, given.robot, 1e-3, 3, 7)
    many = simulate(replace(given, variants=variants), fused=fused)
    assert ClosedChain(given.robot.mechanism).error(many.q).max() < 1e-12
    starts = replace(given, variants=variants).start()[0]
    for k in range(3):
        own = plant_of(given.robot, variants, k)
        gains = Gains(*(variants.gains[k] * x for x in (given.law.gains.kp, given.law.gains.kd, given.law.gains.ki)))
        law = replace(given.law, gains=gains)
        alone = simulate(replace(given, plant=ClosedPlant(own.robot), q=starts[k], law=law), fused=False)
        assert np.abs(many.q[:, k] - alone.q).max() < 1e-10
        assert np.abs(many.tau[:, k] - alone.tau).max() < 1e-7 * np.abs(alone.tau).max()
    assert np.abs(many.q[-1, 0] - many.q[-1, 1]).max() > 1e-6


def test_many_runs_with_loops_count_what_single_runs_say():
    given = closed_scenario(lambda chain: closed_gravity_compensation(chain, 80.0, 8.0))
    found = monte_carlo(given, replace(ALL, payload=(0.0, 0.3)), 4, seed=3)
    assert found
    worst = next(iter(found))
    assert np.isclose(found.outcomes.tip_error[worst], found.again(worst).tip_position_error.max(), rtol=1e-9)


@pytest.mark.parametrize("compiled", [True, False])
def test_runs_that_tear_their_loops_fail_by_themselves(compiled, monkeypatch):
    monkeypatch.setattr("mafsil.simulation.chunk_runs.can_fuse", lambda _: compiled)
    given = closed_scenario(lambda chain: closed_gravity_compensation(chain, 80.0, 8.0), saturate=False)
    found = monte_carlo(given, Variation(gains=(0.5, 60.0)), 12, seed=1, marks=[0.0, 0.1])
    lost = found.outcomes.lost
    assert 0 < lost.sum() < 12
    assert (found.outcomes.finished == ~lost).all()
    assert np.isfinite(found.outcomes.marked[~lost]).all()
    assert np.isnan(found.outcomes.marked[lost, 1]).all()
    assert "loops could not be followed" in found.explain("en")
    for k in range(12):
        tape = found.again(k)
        assert tape.t[-1] == pytest.approx(found.outcomes.end[k])
        assert ClosedChain(given.robot.mechanism).error(tape.q).max() < 1e-9
        assert tape.status.name == ("LOOPS_LOST" if lost[k] else "COMPLETED")
        assert lost[k] or np.isclose(tape.tip_position_error.max(), found.outcomes.tip_error[k], rtol=1e-9)


@pytest.mark.parametrize("fused", [True, False])
def test_recorded_variants_that_tear_stand_where_they_were_and_the_others_go_on(fused):
    given = closed_scenario(lambda chain: closed_gravity_compensation(chain, 80.0, 8.0), saturate=False)
    spread = Variation(gains=(0.5, 60.0))
    found = monte_carlo(given, spread, 6, seed=1)
    lost = np.flatnonzero(found.outcomes.lost)
    assert 0 < len(lost) < 6
    many = simulate(replace(given, variants=found.variants), fused=fused)
    assert many.status.name == "LOOPS_LOST"
    assert many.metadata["runs_lost"] == lost.tolist()
    np.testing.assert_allclose(many.metadata["run_ends"], found.outcomes.end, atol=1e-9)
    assert f"{6 - len(lost)} of 6 runs completed" in many.explain("en")
    assert all(np.isfinite(array).all() for array in many.arrays().values())
    for k, one in enumerate(many):
        tape = found.again(k)
        assert one.status is tape.status
        np.testing.assert_allclose(one.t, tape.t, atol=1e-12)
        np.testing.assert_allclose(one.q, tape.q, atol=1e-9)


def test_runs_that_tear_end_alike_in_compiled_code_and_in_python(monkeypatch):
    given = closed_scenario(lambda chain: closed_gravity_compensation(chain, 80.0, 8.0), saturate=False)
    run = partial(monte_carlo, given, Variation(gains=(0.5, 60.0)), 12, seed=1)
    compiled = run().outcomes
    monkeypatch.setattr("mafsil.simulation.chunk_runs.can_fuse", lambda _: False)
    assert np.array_equal(compiled.end, run().outcomes.end)


@pytest.mark.parametrize("fused", [True, False])
def test_runs_that_come_near_lost_rank_end_where_they_are(fused):
    """A folded parallelogram: no code of fixed size holds there, and nobody makes other plants' steps by hand."""
    mechanism = four_bar(1.0, 0.5, 1.0, 0.5)
    given = Scenario(robot=mf.Robot(mechanism), trajectory=rest(np.zeros(3), 0.01), law=mf.control.pid(3, 0.0))
    spread = Variation(inertia=(0.9, 1.1))
    varied = replace(given, variants=drawn(spread, given.robot, 1e-3, 2, 0))
    none = simulate(varied, fused=fused)
    assert none.status.name == "LOOPS_LOST"
    assert none.metadata["run_ends"] == [0.0, 0.0]
    assert np.isfinite(none.q).all()
    found = monte_carlo(given, spread, 2)
    assert found.outcomes.lost.all()
    assert not found.outcomes.end.any()


def test_starts_that_cannot_be_closed_are_refused_by_name():
    mechanism = four_bar(1.0, 0.9, 0.5, 0.8)
    q = ClosedChain(mechanism).close_loops([0.5, 0.5, 1.5], hold=["A"]).q
    given = Scenario(robot=mf.Robot(mechanism), trajectory=rest(q, 0.01), law=mf.control.pid(3, 0.0))
    with pytest.raises(InputError, match="no closed configuration was found for the start of run 0"):
        simulate(replace(given, variants=drawn(Variation(start=(2.5, 2.6)), given.robot, 1e-3, 2, 0)))
