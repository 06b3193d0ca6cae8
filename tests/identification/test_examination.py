"""Logs examine themselves: the commonest faults are named with their numbers, and good logs are not accused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mafsil.identification import identify
from mafsil.identification.examination import examine_log
from mafsil.identification.smoothing import prepare_log
from mafsil.model import JointKind
from tests.identification.simulated import different, noisy_log
from tests.sizes import size

ROBOTS = ("panda", "ur5e", "puma560", "planar2r", "stanford_arm", "scara_rrrp")


def turned(log, rng):
    k = int(rng.integers(min(log.n, 3)))
    sign = np.where(np.arange(log.n) == k, -1.0, 1.0)
    return replace(log, q=log.q * sign, tau=log.tau * sign)


def exchanged(array, rng):
    i, j = rng.choice(min(array.shape[1], 3), 2, replace=False)
    order = np.arange(array.shape[1])
    order[[i, j]] = j, i
    return np.asarray(array)[:, order]


def in_degrees(robot, log):
    turning = [joint.kind is not JointKind.PRISMATIC for joint in robot.mechanism.coordinates]
    return replace(log, q=np.where(turning, np.degrees(log.q), log.q))


FAULTS = {
    "reversed_effort": lambda log, _: replace(log, tau=-log.tau),
    "reversed_joint": turned,
    "time_unit": lambda log, _: replace(log, t=1e3 * log.t),
    "scaled_effort": lambda log, rng: replace(log, tau=log.tau / rng.choice([50, 100, 160])),
    "swapped_columns": lambda log, rng: replace(log, tau=exchanged(log.tau, rng)),
}


def log_of(seed):
    described, truth = different(ROBOTS[seed % len(ROBOTS)], seed)
    return described, noisy_log(truth, seed, duration=15.0, step=2e-3)


def keys(robot, log):
    return {remark.key.rpartition(".")[2] for remark in examine_log(robot, prepare_log(log, None)[0])}


def test_good_logs_are_not_accused():
    for seed in range(size(6, 100)):
        assert not keys(*log_of(seed)), seed


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_are_named(fault):
    """A planar arm of two joints that gravity does not load differs in few ways; most faults show there, too."""
    count = size(6, 36)
    named = 0
    for seed in range(count):
        robot, log = log_of(seed)
        found = keys(robot, FAULTS[fault](log, np.random.default_rng(seed)))
        named += fault in found or fault + "s" in found
    assert named >= 0.8 * count


def test_of_broken_logs_nearly_all_are_diagnosed():
    """Every fault in turn on every robot: of 100 logs 95 are found, and 90 named.

    Without gravity milliseconds are like a scale of all efforts, and a vertical joint turned round moves as before.
    """
    count, faults = size(12, 100), [*FAULTS, "in_degrees"]
    found, named = 0, 0
    for seed in range(count):
        robot, log = log_of(seed)
        fault = faults[(seed + seed // len(faults)) % len(faults)]
        broken = FAULTS[fault](log, np.random.default_rng(seed)) if fault in FAULTS else in_degrees(robot, log)
        said = keys(robot, broken)
        found += bool(said)
        named += bool({fault, fault + "s"} & said)
    assert found >= 0.95 * count
    assert named >= 0.9 * count


def test_degrees_are_named():
    for seed in range(size(6, 36)):
        robot, log = log_of(seed)
        assert "in_degrees" in keys(robot, in_degrees(robot, log)), seed


def test_the_answer_is_false_and_says_why():
    described, log = log_of(0)
    found = identify(described, replace(log, tau=-log.tau))
    assert not found
    assert found.status.name == "SUSPECT"
    (fault,) = found.faults
    assert fault.details["slope"] == pytest.approx(-1.1, abs=0.3)
    assert "their sign is reversed" in found.explain("en")
    assert found.to_dict()["faults"]
    assert identify(described, log)
