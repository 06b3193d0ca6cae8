"""Jobs of mechanisms with loops."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from mafsil.cli.main import main
from mafsil.errors import JobError, MafsilError
from mafsil.job import Refusal, Run, parse_job, solve
from mafsil.parallel import ClosedChain
from mafsil.parallel.robot_file import read_parallel

ROOT = Path(__file__).resolve().parents[2]
JOBS = ROOT / "examples" / "jobs"
JOB = """
robot = "../robots/palletiser.xml"
[tool]
link = "forearm"
offset = { position = [0.35, 0, 0] }
[simulation]
step = 0.002
"""


def run(text: str):
    return solve(parse_job(JOB + text), JOB + text, JOBS)


def test_the_palletiser_does_its_job():
    text = (JOBS / "palletiser.toml").read_text()
    done = solve(parse_job(text), text, JOBS)
    assert isinstance(done, Run)
    assert done
    tape, chain = done.recording, ClosedChain(done.robot)
    assert chain.error(tape.q).max() < 1e-10
    assert not tape.tau[:, [k for k in range(4) if k not in chain.actuated]].any()
    names = list(done.robot.joint_names)
    goals = np.radians([[0, 0], [40, 10], [60, 45], [60, 45], [10, -20], [10, -20]])
    at = np.searchsorted(tape.t, done.plan.starts[: len(goals)] - 1e-9)
    ends = tape.q[np.minimum(at, len(tape.t) - 1)][:, [names.index("shoulder"), names.index("lever")]]
    assert np.abs(ends - goals).max() < 2e-4
    # A parallelogram: the forearm turns with the lever, whatever the shoulder does.
    forearm = tape.q[:, names.index("shoulder")] + tape.q[:, names.index("elbow")]
    assert np.abs(forearm - tape.q[:, names.index("lever")]).max() < 1e-9


@pytest.mark.parametrize("law", ["computed_torque", "pd_gravity"])
def test_laws_hold_it_and_errors_of_the_model_show(law):
    text = f"""
[controller]
kind = "{law}"
[[move]]
joints = [0.4, 0.2]
"""
    done = run(text)
    assert isinstance(done, Run)
    assert done
    heavy = run("mass_error = 0.3\n" + text)
    assert isinstance(heavy, Run)
    assert (
        np.abs(heavy.recording.q - heavy.recording.q_ref).max() > np.abs(done.recording.q - done.recording.q_ref).max()
    )


def test_a_robot_that_is_too_weak_is_said_to_be():
    weak = (ROOT / "examples" / "robots" / "palletiser.xml").read_text().replace(
        'joint name="shoulder" type="hinge"', 'joint name="shoulder" type="hinge" actuatorfrcrange="-5 5"'
    )  # fmt: skip
    text = 'robot = "weak.xml"\n[tool]\nlink = "forearm"\n[[move]]\njoints = [1.0, 0.2]\n'

    def solved(folder: Path):
        (folder / "weak.xml").write_text(weak)
        return solve(parse_job(text), text, folder)

    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        done = solved(Path(folder))
    assert isinstance(done, Run)
    assert not done
    assert any(remark.key.startswith("job.cannot_hold") or "hold" in remark.key for remark in done.remarks)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[[move]]\npose = { position = [0.3, 0, 0.5], branch = { elbow = 'up' } }", "leave branch away"),
        ('[controller]\nkind = "sliding_mode"\n[[move]]\njoints = [0, 0]', "computed_torque, pd_gravity"),
        ("[controller]\nfriction = true\n[[move]]\njoints = [0, 0]", "compensate no friction"),
        ('plant = "mujoco"\n[[move]]\njoints = [0, 0]', "plant"),
        ("[[move]]\njoints = [0, 0, 0]", "shoulder, lever"),
        ("[[move]]\njoints = [2, 0]", "shoulder"),
        (
            '[controller]\nkind = "pd_gravity"\nkp = [1, 2, 3]\n[[move]]\njoints = [0, 0]',
            "needs one number or 2",
        ),
    ],
)
def test_what_such_jobs_cannot_say_is_named(text, said):
    with pytest.raises(JobError, match=said):
        run(text)


def test_moves_that_the_loops_forbid_are_refused(tmp_path):
    from mafsil.model import mjcf
    from tests.parallel.closed_chains import four_bar

    (tmp_path / "bars.xml").write_text(mjcf.write(four_bar(1.0, 0.7, 0.6, 0.5)))
    head = 'robot = "bars.xml"\n[tool]\nlink = "coupler"\n[start]\njoints = [0.3, 0.5, 1.5]\n'
    for goal in (2.5, -2.5):
        text = head + f"[[move]]\nname = 'over'\njoints = [{goal}]\n"
        refused = solve(parse_job(text), text, tmp_path)
        assert isinstance(refused, Refusal)
        assert "no closed configuration was found" in refused.explain("en")
        assert "over" in refused.explain("en")
        assert "over" in refused.explain("ar")
    text = 'robot = "bars.xml"\n[tool]\nlink = "coupler"\n[start]\njoints = [3.1]\n[[move]]\njoints = [3.0]\n'
    refused = solve(parse_job(text), text, tmp_path)
    assert isinstance(refused, Refusal)
    assert "not found" in refused.explain("en")


def test_the_command_writes_a_report(tmp_path, capsys):
    assert main(["run", str(JOBS / "palletiser.toml"), "--out", str(tmp_path / "out"), "--lang", "ar"]) == 0
    assert (tmp_path / "out" / "report.html").stat().st_size > 10_000
    results = json.loads((tmp_path / "out" / "results.json").read_text())
    assert results["verdict"] == "good"


DELTA = """
robot = "delta.toml"
[start]
joints = [0.3, 0.3, 0.3]
[[move]]
pose = { position = [0.15, 0.05, -0.7], task = "position" }
[[move]]
path = "line"
pose = { relative = "space", position = [0, 0, -0.04], task = "position" }
[[move]]
pick = { mass = 0.1 }
[[move]]
joints = [0.5, 0.4, 0.6]
[[move]]
place = true
"""


def test_a_delta_robot_of_a_file_is_the_robot_of_a_job():
    folder = Path("examples/robots")
    run = solve(parse_job(DELTA, "job.toml"), DELTA, folder)
    assert run, run.explain("en")
    delta = read_parallel(folder / "delta.toml")
    for leg in run.plan.legs[:2]:
        t = np.linspace(0.0, leg.trajectory.duration, 21)
        q = leg.trajectory.at(t).u
        T = run.robot.forward_kinematics(q)
        np.testing.assert_allclose(T[:, :3, :3], np.broadcast_to(np.eye(3), (21, 3, 3)), atol=1e-8)
        names = run.robot.joint_names
        arms = [names.index(f"leg {i} joint 1") for i in (1, 2, 3)]
        for row, place in zip(q[:, arms], T[:, :3, 3], strict=True):
            np.testing.assert_allclose(row, delta.inverse_kinematics(place).q[:, 0], atol=1e-7)
    np.testing.assert_allclose(T[-1, :3, 3], [0.15, 0.05, -0.74], atol=1e-8)


def test_a_stewart_platform_in_a_file_is_a_robot(tmp_path):
    """Its driven joints are the lengths of the legs beyond those in which it is drawn."""
    angles = "base_angles = [-15, 15, 105, 135, 225, 255]\nplatform_angles = [-45, 45, 75, 165, 195, 285]\n"
    file = tmp_path / "six.toml"
    file.write_text(f'kind = "stewart"\nbase_radius = 2.0\nplatform_radius = 1.0\n{angles}')
    job = f'robot = "six.toml"\n[start]\njoints = {[0.05] * 6}\n[[move]]\njoints = {[0.1] * 6}\n'
    run = solve(parse_job(job, "job.toml"), job, tmp_path)
    assert isinstance(run, Run)
    robot, platform = run.robot, read_parallel(file)
    chain, rng = ClosedChain(robot), np.random.default_rng(4)
    assert [robot.joint_names[k] for k in chain.actuated] == [f"leg {i} joint 3" for i in range(1, 7)]
    drawn = platform.inverse_kinematics(np.asarray(chain.robot.forward_kinematics(np.zeros(robot.n))))
    for _ in range(5):
        q = np.zeros(robot.n)
        q[chain.actuated] = rng.uniform(-0.2, 0.2, 6)
        found = chain.close_loops(q, hold=chain.actuated)
        T = np.asarray(chain.robot.forward_kinematics(found.q))
        np.testing.assert_allclose(platform.inverse_kinematics(T) - drawn, q[chain.actuated], atol=1e-8)


def test_a_robot_that_hangs_in_cables_is_refused(tmp_path):
    shutil.copy(Path(__file__).resolve().parents[2] / "examples/parallel/crane.toml", tmp_path)
    text = DELTA.replace("delta.toml", "crane.toml")
    with pytest.raises(MafsilError, match="'cable' cannot be loaded as a robot of joints"):
        solve(parse_job(text, "job.toml"), text, tmp_path)
