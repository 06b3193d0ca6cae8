"""Causes and remedies, proved by driving again; gaps held against the errors of the run; a reserve for the feedback."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from mafsil.cli.main import main
from mafsil.collision.status import SMALLEST_GAP
from mafsil.job import Run, parse_job, solve
from mafsil.job.judging.causes import MOST_AGAIN, Cause, causes_of
from mafsil.job.judging.judgement import summary
from mafsil.job.judging.symptoms import symptoms
from mafsil.job.planning.planned_remarks import PLANNED
from mafsil.report.contents import verdict

LINK = """<link name="l{k}"><inertial><origin xyz="0 0 0.15"/><mass value="{mass}"/>
<inertia ixx="{I}" iyy="{I}" izz="{I}" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j{k}" type="revolute"><parent link="{parent}"/><child link="l{k}"/><origin xyz="0 0 {length}"/>
<axis xyz="{axis}"/><limit lower="-3" upper="3" velocity="3" effort="{effort}"/>
<dynamics friction="{friction}" damping="{damping}"/></joint>
"""
AXES = ("0 0 1", "0 1 0", "0 1 0", "0 0 1", "0 1 0", "0 0 1")
LENGTHS = (0.0, 0.3, 0.4, 0.35, 0.1, 0.1)
MASSES = (6.0, 5.0, 4.0, 2.0, 1.0, 0.5)
START, GOALS = [0, 0.2, 0.5, 0, 0.3, 0], ([0.4, 0.5, 0.6, 0.3, 0.4, 0.5], [-0.2, 0.3, 0.7, -0.3, 0.6, -0.5])


def arm(folder: Path, joints: int, friction: float, effort: float) -> None:
    """`arm.urdf`: joints with masses, dry friction and damping."""
    links = ""
    for k in range(joints):
        mass = MASSES[k]
        details = {"k": k + 1, "parent": f"l{k}" if k else "base", "length": LENGTHS[k], "axis": AXES[k]}
        details |= {"mass": mass, "I": 0.004 * mass + 0.001, "effort": effort, "damping": friction * mass}
        links += LINK.format(**details, friction=friction * (1.0 + mass))
    (folder / "arm.urdf").write_text(f'<robot name="arm"><link name="base"/>{links}</robot>', encoding="utf-8")


@cache
def driven(text: str, folder: Path = Path()) -> Run:
    run = solve(parse_job(text), text, folder)
    assert isinstance(run, Run), run.explain()
    return run


def moves(joints: int) -> str:
    """To both goals."""
    return "".join(f"[[move]]\njoints = {goal[:joints]}\n" for goal in GOALS)


def own(
    folder: Path, controller: str = "", simulation: str = "", more: str = "", *, joints: int = 3, friction: float = 0.0,
    effort: float = 200.0,
) -> Run:  # fmt: skip
    """The arm driven to both goals."""
    arm(folder, joints, friction, effort)
    head = f'robot = "arm.urdf"\n[start]\njoints = {START[:joints]}\n[controller]\n{controller}\n'
    return driven(head + f"[simulation]\n{simulation}\n" + moves(joints) + more, folder)


def causes(run: Run) -> list[Cause]:
    """Of all failures; each sentence of a failure ends with it, in both languages."""
    found = [remark for remark in run.remarks if remark.cause is not None]
    for remark in found:
        for language in ("en", "ar"):
            assert remark.cause is not None
            assert remark.sentence(language).endswith(remark.cause.explain(language=language))
    return [remark.cause for remark in found if isinstance(remark.cause, Cause)]


def keys(run: Run) -> set[str]:
    return {one.key.removeprefix("job.cause_") for one in causes(run)}


@pytest.mark.parametrize(("kind", "joints"), [("computed_torque", 6), ("pd_gravity", 3), ("feedforward", 3)])
def test_laws_compensate_the_friction_of_a_description(tmp_path: Path, kind: str, joints: int) -> None:
    run = own(tmp_path, f'kind = "{kind}"', joints=joints, friction=1.0)
    assert run, run.explain()
    without = own(tmp_path, f'kind = "{kind}"\nfriction = false', joints=joints, friction=1.0)
    ours, theirs = (max(one.share for one in summary(each).arrivals) for each in (run, without))
    assert ours < 0.6
    assert theirs > 4.0 * ours
    # At rest nothing is compensated, so nothing chatters.
    rest = run.recording.t > run.plan.cycle + 0.1
    assert np.ptp(run.recording.tau[rest], axis=0).max() < 0.05 * np.abs(run.recording.tau).max()


def test_the_textbook_arm_reaches_its_targets_with_what_is_left_to_us() -> None:
    run = driven('robot = "puma560"\n[start]\njoints = [0, 0.5, -1.8, 0, 0.5, 0]\n' + moves(6))
    assert run, run.explain()
    assert max(one.share for one in summary(run).arrivals) < 0.2


def test_friction_that_is_not_compensated_is_the_cause_and_the_remedy_is_proved(tmp_path: Path) -> None:
    run = own(tmp_path, "friction = false", friction=4.0)
    assert keys(run) == {"friction"}
    for one in causes(run):
        assert one.remedy is not None
        assert one.remedy.key == "job.remedy_friction"
        assert one.remedy.left is not None
    assert own(tmp_path, "friction = true", friction=4.0), "what is advised works"


def test_a_cause_that_the_job_does_not_have_is_never_named(tmp_path: Path) -> None:
    """A remainder is unknown, with its number: no noise where sensors have none, no friction where joints have none."""
    for controller in ('kind = "pid"', 'kind = "pid"\nkp = 300\nkd = 40', "frequency = 3"):
        run = own(tmp_path, controller, "friction = false\nmass_error = 0.0")
        assert keys(run) <= {"law", "soft", "gains", "integral", "rate", "unknown"}
        assert "noise" not in run.explain("en").replace("noise of", "")


def test_noise_is_the_cause_only_where_the_error_goes_with_it(tmp_path: Path) -> None:
    close = "[tolerance]\njoints = 5e-4\n"
    loud = "noise = { position = 5e-3, velocity = 0.0, seed = 4 }"
    assert keys(own(tmp_path, "frequency = 60", loud, close, effort=2e3)) == {"noise"}
    quiet = own(tmp_path, "friction = false", "noise = { position = 1e-6, velocity = 1e-5, seed = 4 }", friction=4.0)
    assert keys(quiet) == {"friction"}


def test_a_payload_beyond_the_motors_is_saturation_with_its_number(tmp_path: Path) -> None:
    lift = "[[move]]\npick = { mass = 25 }\n[[move]]\njoints = [0.4, 1.2, 0.4]\n"
    run = own(tmp_path, more=lift, effort=110.0)
    found = causes(run)
    assert keys(run) == {"limit"}
    assert min(float(str(one.details["share"]).split()[0]) for one in found) > 100.0
    assert all("of its effort limit" in one.explain(language="en") for one in found)
    assert {one.remedy.key for one in found if one.remedy is not None} == {"job.remedy_lighter"}


def test_saturation_that_slower_motion_ends_says_so(tmp_path: Path) -> None:
    fast = "[limits]\nacceleration = 60\n[tolerance]\njoints = 1e-4\n"
    run = own(tmp_path, more=fast, effort=30.0)
    assert keys(run) == {"limit"}
    slower = [one.remedy for one in causes(run) if one.remedy is not None]
    assert {one.key for one in slower} == {"job.remedy_slower"}
    assert all(one.left is not None for one in slower), "driven again at that speed"


def test_masses_delay_and_pushes_are_told_apart(tmp_path: Path) -> None:
    assert keys(own(tmp_path, "frequency = 5", "mass_error = 0.4")) == {"model"}
    assert keys(own(tmp_path, "frequency = 40\ndelay = 0.03")) <= {"delay", "rate"}
    push = "[[disturbance]]\nstart = 0.1\nduration = 9.0\nwrench = [0, 0, 0, 60, 60, 60]\n"
    assert keys(own(tmp_path, "frequency = 8", more=push)) == {"push"}


def test_gains_that_are_too_hard_for_the_rate_are_proved_at_a_higher_one(tmp_path: Path) -> None:
    run = own(tmp_path, "frequency = 2000\nrate = 500")
    assert keys(run) == {"rate"}
    remedies = {one.remedy.key for one in causes(run) if one.remedy is not None}
    assert remedies == {"job.remedy_rate"}
    assert "rate = 2000 in [controller], step = 0.0005 in [simulation]" in run.explain("en")
    assert own(tmp_path, "frequency = 2000\nrate = 2000", "step = 0.0005")


def test_nothing_is_driven_again_where_nothing_failed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run, counted = own(tmp_path), []
    monkeypatch.setattr("mafsil.job.judging.causes.simulate_plan", lambda *a, **k: counted.append(1))
    assert causes_of(run) == {}
    assert not symptoms(run)
    assert not counted


def test_simulations_in_search_of_causes_are_few(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from mafsil.job.driving import plan_simulation

    count = []

    def counted(*args: object, **named: object) -> Run:
        count.append(named["difference"])
        return plan_simulation.simulate_plan(*args, **named)  # type: ignore[arg-type]

    monkeypatch.setattr("mafsil.job.judging.causes.simulate_plan", counted)
    shares: list[float] = []
    text = own(tmp_path, "friction = false", friction=4.0).text
    broken = replace(driven(text, tmp_path))
    assert causes_of(broken, shares.append)
    assert 1 <= len(count) <= MOST_AGAIN
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


PRESS = """
robot = "puma560"
[start]
pose = { position = [0.5, 0.1, 0.002], rpy = [3.14159265358979, 0, 0] }
[controller]
kind = "hybrid"
normal_force = 40
[simulation]
friction = false
settle = 0.0
step = 0.002
[[surface]]
point = [0, 0, 0]
normal = [0, 0, 1]
stiffness = 2e4
damping = 150
friction = 0.4
[tolerance]
position = 0.003
orientation = 0.05
[[move]]
path = "line"
pose = { position = [0.5, 0.1, -0.001], rpy = [3.14159265358979, 0, 0] }
[[move]]
path = "line"
pose = { position = [0.5, 0.06, -0.001], rpy = [3.14159265358979, 0, 0] }
duration = 0.5
"""


def test_a_tip_that_slips_aside_under_force_has_the_friction_of_the_surface_as_cause() -> None:
    run = driven(PRESS)
    assert keys(run) == {"surface_friction"}, run.explain("en")


FULL = """
robot = "panda"
[limits]
speed_scale = {share}
acceleration_scale = {share}
[start]
joints = [0, -0.4, 0, -2.0, 0, 1.8, 0.8]
[[move]]
profile = "time_optimal"
joints = [0.9, 0.6, 0.2, -1.2, 0.4, 1.3, 0.1]
[[move]]
profile = "jerk_limited"
joints = [-0.6, -0.4, 0.4, -2.2, -0.6, 2.3, 1.1]
"""


def test_full_shares_leave_a_stated_reserve_for_the_feedback() -> None:
    run = driven(FULL.format(share=1.0))
    assert run, run.explain()
    assert not [remark for remark in run.remarks if remark.level != "good"]
    limits = run.robot.limits
    planned = np.abs(run.recording.qdd_ref).max(axis=0) / limits.acceleration
    assert planned.max() == pytest.approx(PLANNED["acceleration"], rel=1e-3)
    assert PLANNED["acceleration"] < (np.abs(run.recording.qdd).max(axis=0) / limits.acceleration).max() <= 1.0
    (said,) = (remark for remark in run.remarks if remark.key == "job.reserve")
    assert "96 % of the acceleration limits" in said.sentence("en")
    assert "96 %" in said.sentence("ar")
    assert not [one for one in driven(FULL.format(share=0.7)).remarks if one.key == "job.reserve"]


POST = """
robot = "planar2r"
[start]
joints = [0.5, 0.4]
[collision]
clearance = 0.0
[controller]
frequency = {frequency}
[simulation]
mass_error = {mass_error}
[tolerance]
joints = 0.5
orientation = 0.5
position = 0.5
[[obstacle]]
name = "post"
box = [0.1, 0.1, 1.0]
position = [{x}, {y}, 0.0]
[[move]]
joints = [0.0, 0.4]
"""


def gap(run: Run) -> float:
    found = summary(run).clearances
    assert found is not None
    return float(found.distance.min())


def before_the_post(wanted: float, frequency: float = 20.0, mass_error: float = 0.0) -> Run:
    """A run that starts with about such a gap before a post."""
    far, y = 0.0, 1.9
    for _ in range(12):
        run = driven(POST.format(frequency=frequency, mass_error=mass_error, x=1.35, y=y))
        far = gap(run)
        if 0.6 * wanted < far < 1.4 * wanted:
            return run
        y -= 0.9 * (far - wanted)
    raise AssertionError(f"gap {far} at y = {y}")


def test_a_gap_below_a_millimetre_is_amber_and_a_safe_one_is_not() -> None:
    narrow = before_the_post(4e-4)
    assert narrow, "it is no failure"
    assert verdict(narrow, "en").level == "warning"
    assert verdict(narrow, "en").text == "passes, but the gap is smaller than 1 mm"
    assert verdict(narrow, "ar").text != verdict(narrow, "en").text
    (said,) = (remark for remark in narrow.remarks if remark.key == "job.gap_below_smallest")
    assert "less than 1 mm" in narrow.explain("en")
    assert "post" in said.sentence("ar")
    wide = before_the_post(20.0 * SMALLEST_GAP)
    assert verdict(wide, "en").level == "good"


def test_a_gap_below_the_error_of_the_run_is_amber() -> None:
    run = before_the_post(4e-3, frequency=6.0, mass_error=0.3)
    error = summary(run).tip_error
    assert gap(run) < error
    (said,) = (remark for remark in run.remarks if remark.key == "job.gap_below_error")
    assert said.level == "warning"
    assert verdict(run, "en").text == "passes, but the gap is smaller than the error of the run"


def test_a_tip_that_sinks_into_a_surface_under_force_has_the_contact_as_cause() -> None:
    run = driven(PRESS.replace("friction = 0.4\n", "").replace("normal_force = 40", "normal_force = 200"))
    assert keys(run) == {"contact"}, run.explain("en")
    assert all("contact, up to" in one.explain(language="en") for one in causes(run))


def test_a_tip_that_jumps_off_a_surface_has_the_contact_as_cause() -> None:
    """Where the plan leaves, the force that pressed is let go at once, and the arm breaks its acceleration limits."""
    text = (
        PRESS.replace("puma560", "panda")
        .replace("friction = 0.4\n", "")
        .replace("normal_force = 40", "normal_force = 30")
    )
    text = text.replace("position = 0.003", "position = 0.01").replace("0.06, -0.001]", "0.1, 0.03]")
    run = driven(text.replace("duration = 0.5", ""))
    broken = [remark for remark in run.remarks if remark.key == "job.acceleration_crossed" and remark.cause is not None]
    assert broken, run.explain("en")
    assert keys(run) == {"contact"}, run.explain("en")


def test_plans_say_that_their_gap_is_below_a_millimetre(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    y = 0.9
    for _ in range(12):
        (tmp_path / "scene.toml").write_text(
            f'[[obstacle]]\nname = "post"\nbox = [0.2, 0.2, 1.0]\nposition = [1.9, {y}, 0.0]\n', encoding="utf-8"
        )
        asked = [
            "plan",
            "planar2r",
            "--start",
            "0",
            "0",
            "--goal",
            "-0.5",
            "0.2",
            "--scene",
            str(tmp_path / "scene.toml"),
        ]
        assert main([*asked, "--json"]) == 0
        least = json.loads(capsys.readouterr().out)["clearance"]
        if 1e-4 < least < 9e-4:
            break
        y -= least - 5e-4
    assert main(asked) == 0
    assert "collision-free, but the gap is smaller than 1 mm" in capsys.readouterr().out
