"""Every law, measure and plot has its words, every module its works; motions are found from sensors."""

from __future__ import annotations

import importlib
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import add_delay, citation, computed_torque, gravity_compensation, pid
from mafsil.control.analysis import CITATIONS, citations_of, joint_or_task_space, words_for
from mafsil.control.analysis.explanation import FORMULAS
from mafsil.control.joints import MotionEstimator, accelerometer, joint_acceleration
from mafsil.control.joints.motion_estimator import JointMotionEstimate
from mafsil.errors import InputError
from mafsil.job.driving.laws import KINDS
from mafsil.trajectory import quintic

ARM = mf.load("puma560")
MESSAGES = Path(mf.__file__).parent / "messages"


@pytest.mark.capability("10-115")
@pytest.mark.parametrize("name", FORMULAS)
def test_everything_has_a_formula_and_a_paragraph_in_both_languages(name):
    words = words_for(name)
    assert words.formula
    for language in ("en", "ar"):
        text = words.paragraph(language)
        assert len(text.split()) > 8
        assert text.endswith(".")
        assert bool(re.search("[\u0600-\u06ff]", text)) is (language == "ar")


@pytest.mark.capability("10-115")
def test_laws_explain_themselves_and_nothing_is_without_words():
    assert set(KINDS) <= set(FORMULAS)
    assert words_for(gravity_compensation(ARM, 1.0, 1.0)).name == "pd_gravity"
    assert words_for(pid(6, 1.0)).name == "pid"
    assert words_for(add_delay(computed_torque(ARM), 0.1)).name == "delayed"
    for language in ("en", "ar"):
        keys = tomllib.loads((MESSAGES / language / "explanation.toml").read_text("utf-8"))
        assert set(FORMULAS) == {key for key in keys if not key.startswith(("advice_", "reason_"))}
    with pytest.raises(InputError, match="overshoot"):
        words_for("magic")


@pytest.mark.capability("10-91")
def test_works_are_attached_to_modules_that_exist():
    assert len({one.key for one in CITATIONS}) == len(CITATIONS)
    for one in CITATIONS:
        assert 1840 < one.year < 2030
        assert one.title in str(one)
        assert one.bibtex().startswith(f"@misc{{{one.key},")
        for module in one.modules:
            assert importlib.import_module(module)
            assert one in citations_of(module)
    for _, keys in FORMULAS.values():
        assert all(citation(key).key == key for key in keys)
    assert citation("hogan1985").year == 1985
    with pytest.raises(InputError, match="hogan1985"):
        citation("nobody1999")


REFERENCES = """
    murray1994 harrison1997 kreyszig2011 sommese2004 atkinson1989 shoemake1985 ahmed2011 kelly2005 Hill josephs2002
    anton2005 angeles2007 selig2005 abramowitz1964 siciliano2008 cubero2007 asada1986 craig2005 ruina2015 dombre2007
    kaw2008 antia2002 li2003 hamilton1844 mishra1987 winston2004 featherstone2008 tsai1999 Spong bruyninckx2010
    Park spong2006 siciliano2009 kurfess2005 mittal2003 park1999 Roberts nguyen1986 jazar2010
"""
"""The reference list of the source, in its order; a name alone where only the author is known, no title."""


@pytest.mark.capability("12-11")
def test_the_reference_list_of_the_source_is_cited_but_for_four_works_without_a_title():
    works = REFERENCES.split()
    assert len(works) == 39
    known = [key for key in works if key[-1].isdigit()]
    assert len(set(known)) == 35
    for key in known:
        assert key.rstrip("0123456789") in str(citation(key)).lower()
        assert citation(key).modules
    assert [k + 1 for k, key in enumerate(works) if key not in known] == [9, 29, 31, 37]


@pytest.mark.capability("10-56")
def test_joint_or_task_space_is_advised_with_what_decides():
    calm = quintic([0.1, 0.8, -0.5, 0.2, 0.6, 0.1], [0.3, 0.6, -0.7, 0.3, 0.8, 0.2], 1.0)
    assert joint_or_task_space(ARM, calm).space == "joint_space"
    touching = joint_or_task_space(ARM, calm, contact=True)
    assert touching.space == "task_space"
    assert "contact forces" in touching.sentence("en")
    through = quintic([0.1, 0.8, -0.5, 0.2, 0.6, 0.1], [0.3, 0.6, -0.7, 0.3, -0.6, 0.2], 1.0)
    singular = joint_or_task_space(ARM, through, contact=True)
    assert singular.space == "joint_space"
    assert "singularity" in singular.sentence("en")
    assert singular.sentence("ar") != singular.sentence("en")
    at_limit = quintic([ARM.limits.upper[0] - 1e-3, 0.8, -0.5, 0.2, 0.6, 0.1], calm.at(1.0).u, 1.0)
    assert ARM.joint_names[0] in joint_or_task_space(ARM, at_limit).sentence("en")
    panda = mf.load("panda")
    q = np.array([0.2, -0.3, 0.1, -1.8, 0.1, 1.9, 0.3])
    assert "1 redundant joints" in joint_or_task_space(panda, quintic(q, q + 0.1, 1.0)).sentence("en")
    assert "inverse kinematics" in str(joint_or_task_space(ARM, calm))


@pytest.mark.capability("10-95")
def test_the_estimator_follows_constant_acceleration_exactly_and_passes_little_noise():
    T, a = 1e-3, np.array([0.5, -1.0, 2.0, 0.1, 0.0, -3.0])
    found = None
    estimator = MotionEstimator(T, 60.0, np.zeros(6))
    for k in range(1, 1001):
        found = estimator.update(a * (k * T) ** 2 / 2.0)
    assert np.abs(found.qdd - a).max() < 1e-6
    assert np.abs(found.qd - a).max() < 1e-6
    rng = np.random.default_rng(0)
    noisy = MotionEstimator(T, 60.0, np.zeros((200, 1)))
    for _ in range(2000):
        estimate = noisy.update(1e-4 * rng.normal(size=(200, 1)))
    assert estimate.q.std() < 5e-5
    assert estimate.qd.std() < 0.05 * np.sqrt(2.0) * 1e-4 / T


@pytest.mark.capability("10-95")
def test_the_tips_motion_follows_from_that_of_the_joints():
    rng = np.random.default_rng(3)
    q, qd, qdd = rng.normal(size=(3, 5, 6))
    tip = JointMotionEstimate(q, qd, qdd).tip(ARM)
    h = 1e-5
    places = [ARM.forward_kinematics(q + s * h * qd + h**2 / 2 * qdd)[:, :3, 3] for s in (-1, 0, 1)]
    middle = ARM.forward_kinematics(q)[:, :3, 3]
    velocity = (places[2] - places[0]) / (2 * h)
    acceleration = (places[2] - 2 * middle + places[0]) / h**2
    assert np.abs(tip.velocity[:, 3:] - velocity).max() < 1e-6
    assert np.abs(tip.acceleration[:, 3:] - acceleration).max() < 1e-3


@pytest.mark.capability("10-95", "10-6")
def test_accelerometers_read_gravity_at_rest_and_give_joint_accelerations():
    rng = np.random.default_rng(4)
    q, qd, qdd = 0.5 * rng.normal(size=(3, 6))
    still = accelerometer(ARM, q, np.zeros(6), np.zeros(6))
    assert np.linalg.norm(still) == pytest.approx(np.linalg.norm(ARM.mechanism.gravity))
    assert ARM.forward_kinematics(q)[:3, :3] @ still == pytest.approx(-np.asarray(ARM.mechanism.gravity))
    panda = mf.load("panda")
    q, qd, qdd = np.array([[0.2, -0.3, 0.1, -1.8, 0.1, 1.9, 0.3], 0.3 * rng.normal(size=7), rng.normal(size=7)])
    links = [link.name for link in panda.mechanism.links]
    readings = {name: accelerometer(panda, q, qd, qdd, frame=name) for name in links[2:]}
    known = joint_acceleration(panda, q, qd, readings)
    J = np.concatenate([panda.jacobian_body(q, frame=name)[3:] for name in readings])
    seen = np.linalg.norm(J, axis=0) > 1e-9
    assert seen.tolist() == [True] * 6 + [False], "the last axis passes through the frames of the links that it moves"
    assert np.abs(known - qdd)[seen].max() < 1e-9
    assert np.isnan(known[~seen]).all()
    one = joint_acceleration(panda, q, qd, {links[4]: readings[links[4]]})
    assert np.isnan(one).tolist() == [True] * 7, "three readings do not decide four joints"
    direct = MotionEstimator(1e-3, 50.0, q, qd).update(q, qdd)
    assert np.array_equal(direct.qdd, qdd)
