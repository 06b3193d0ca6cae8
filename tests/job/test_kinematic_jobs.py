"""Jobs without forces: robots whose links have no mass, and jobs that ask for none."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import JobError
from mafsil.job import Run, bench_laws, parse_job, solve
from mafsil.job.solve import prepare
from mafsil.report.results import as_data, write_results

JOBS = Path(__file__).parents[2] / "examples" / "jobs"
JOINT = """
<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><origin xyz="0 0 {height}"/>
<axis xyz="0 1 0"/><limit lower="-3" upper="3" velocity="2" effort="50"/></joint>
"""
LINK = """<link name="{name}"><collision><origin xyz="0 0 0.2"/><geometry><box size="0.04 0.04 0.3"/></geometry>
</collision>{mass}</link>"""
MASS = """<inertial><origin xyz="0 0 0.2"/><mass value="2"/>
<inertia ixx="0.02" iyy="0.02" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial>"""
JOB = """
robot = "bare.urdf"
[start]
joints = [0, 0.5]
[[obstacle]]
name = "wall"
box = [0.1, 0.5, 0.5]
position = [0.8, 0, 0.3]
[[move]]
pick = { mass = 0.4, name = "nut" }
[[move]]
joints = [0.5, -0.5]
[[move]]
place = true
[[move]]
joints = [-0.5, 1.0]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_arm(tmp_path / "bare.urdf", "", "")
    return tmp_path


def write_arm(path: Path, upper: str, fore: str) -> None:
    links = LINK.format(name="base", mass="") + LINK.format(name="a", mass=upper) + LINK.format(name="b", mass=fore)
    joints = JOINT.format(name="j1", parent="base", child="a", height=0.1)
    joints += JOINT.format(name="j2", parent="a", child="b", height=0.5)
    path.write_text(f'<robot name="bare">{links}{joints}</robot>')


def solved(text: str, folder: Path) -> Run:
    found = solve(parse_job(text), text, folder)
    assert isinstance(found, Run)
    return found


def test_an_arm_without_masses_follows_its_plan_and_the_report_says_what_is_not_judged(folder: Path) -> None:
    run = solved(JOB, folder)
    assert run
    tape, plan = run.recording, run.plan
    t = tape.t[tape.t <= plan.legs[0].trajectory.duration + plan.legs[1].trajectory.duration - 1e-9]
    moved = plan.legs[1].trajectory.at(t[t > plan.legs[0].trajectory.duration] - plan.legs[0].trajectory.duration)
    assert np.abs(tape.q[: len(t)][t > plan.legs[0].trajectory.duration] - moved.u).max() < 1e-9
    assert (tape.q == tape.q_ref).all()
    assert np.isnan(tape.tau).all()
    assert not tape.saturated.any()
    (warning,) = [remark for remark in run.remarks if remark.level == "warning"]
    assert warning.key == "job.kinematic_masses"
    assert "(a, b)" in warning.sentence("en")
    assert "efforts" in warning.sentence("en")
    assert run.passed[1].carried is not None
    assert run.passed[-1].carried is None


def test_unknown_efforts_are_nowhere_a_number(folder: Path) -> None:
    run = solved(JOB, folder)
    written = write_results(run, folder / "out").parent
    data = as_data(run, mf.job.judging.summary(run))
    assert data["numbers"]["energy"] is None
    assert {joint["peak_effort"] for joint in data["joints"]} == {None}
    page = (written / "report.html").read_text("utf-8")
    assert "Cycle time" in page
    for word in ("Effort", "Energy", "N m", "NaN", "nan"):
        assert not re.search(rf">[^<]*\b{word}\b", page.split("<script")[0]), word
    again = mf.simulation.Recording.load(written / "recording.npz")
    assert again
    assert np.isnan(again.tau).all()


def test_clearance_and_refusals_need_no_masses(folder: Path) -> None:
    into = JOB.replace("joints = [0.5, -0.5]", "joints = [1.2, 0.3]")
    refused = solve(parse_job(into), into, folder)
    assert not refused
    assert "wall" in refused.explain("en")


FORCED = {
    "disturbance": "[[disturbance]]\nstart = 0.1\nduration = 0.1\nwrench = [0, 0, 0, 1, 0, 0]\n",
    "surface": '[[surface]]\nname = "desk"\npoint = [0, 0, -1]\nnormal = [0, 0, 1]\nstiffness = 1e4\n',
    "guide": '[[guide]]\nname = "rail"\npoint = [0, 0, 0]\ndirection = [1, 0, 0]\nstiffness = 100\n',
    "variation": "[variation]\nruns = 5\ninertia = [0.9, 1.1]\n",
    "simulation.mass_error": "[simulation]\nmass_error = 0.1\n",
    "simulation.payload": "[simulation]\npayload = 0.5\n",
    "simulation.method": '[simulation]\nmethod = "rk4"\n',
    "simulation.noise": "[simulation.noise]\nposition = 1e-5\n",
    "simulation.real_time": "[simulation]\nreal_time = true\n",
}


@pytest.mark.parametrize("name", FORCED)
def test_what_needs_forces_is_refused_with_its_line(name: str, folder: Path) -> None:
    text = JOB + FORCED[name]
    job = parse_job(text)
    with pytest.raises(JobError, match=name.split(".")[-1]) as caught:
        solve(job, text, folder)
    assert caught.value.key == "job.forces_masses"
    assert caught.value.details["line"]


def test_one_heavy_link_does_not_make_an_arm_and_a_tool_does_not_either(folder: Path) -> None:
    """The mass of the tool moves both joints, and the numbers would be those of an arm of air."""
    write_arm(folder / "bare.urdf", MASS, "")
    with_tool = JOB.replace("[start]", "[tool]\nmass = 1.0\ncom = [0, 0, 0.1]\n[start]")
    assert solved(with_tool, folder).plan.kinematic
    named = with_tool + '[simulation]\nplant = "mafsil"\n'
    assert not solved(named, folder).plan.kinematic
    bare = JOB + '[simulation]\nplant = "mafsil"\n'
    with pytest.raises(JobError) as caught:
        solve(parse_job(bare), bare, folder)
    assert caught.value.key == "job.no_mass"
    write_arm(folder / "bare.urdf", MASS, MASS)
    assert not solved(JOB, folder).plan.kinematic


@pytest.mark.parametrize("name", ["pallet_panda", "palletiser", "two_arms"])
def test_any_job_can_be_driven_without_forces(name: str) -> None:
    """Plan and times are those of the job with forces; with loops all coordinates keep them closed."""
    run = mf.job.solve_file(JOBS / f"{name}.toml", plant="kinematic")
    assert isinstance(run, Run)
    assert run
    assert "job.kinematic_asked" in {remark.key for remark in run.remarks}
    job = mf.job.read_job(JOBS / f"{name}.toml")
    planned = prepare(job, run.text, JOBS)
    assert isinstance(planned, tuple)
    assert planned[1].duration == pytest.approx(run.plan.duration, abs=1e-12)
    if run.robot.mechanism.loops:
        assert np.abs(mf.parallel.ClosedChain(run.robot).error(run.recording.q[::50])).max() < 1e-8


def test_laws_are_not_compared_without_forces(folder: Path) -> None:
    job = parse_job(JOB)
    planned = prepare(job, JOB, folder)
    assert isinstance(planned, tuple)
    with pytest.raises(JobError) as caught:
        bench_laws(job, JOB, *planned, ("pid",))
    assert caught.value.key == "job.bench_kinematic"
