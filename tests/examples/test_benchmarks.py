"""Each script of `benchmarks/` runs at its smallest size: a claim of speed whose script no longer runs is none."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.page.node import needed

ROOT = Path(__file__).resolve().parents[2]

SMALLEST: dict[str, list[str]] = {
    "batch_sizes": ["--robots", "puma560", "--quantities", "ID", "--quick"],
    "cable_robots": [],
    "call_forms": ["--robots", "puma560", "--quick"],
    "closed_chains": [],
    "closed_poses": ["--poses", "1", "--peer", "1"],
    "closed_runs": [],
    "collision": ["--batch", "16", "--verdicts", "20"],
    "configuration_surfaces": ["--pentagons", "0", "--linkages", "four-bar and slider-crank"],
    "constrained_planning": ["--count", "1", "--seconds", "1"],
    "derivatives_vs_pinocchio": ["--robots", "puma560", "--quick"],
    "dynamics_vs_pinocchio": ["--robots", "puma560", "--quick"],
    "exported_c": ["--robots", "puma560", "--quantities", "inverse_dynamics"],
    "first_use": ["--questions", "pose", "--repeats", "1"],
    "grasp_closure": ["--grasps", "20", "--rival", "2"],
    "ik_closed_form": ["--robots", "puma560", "--poses", "40"],
    "ik_general": ["--six", "xarm6", "--poses", "4"],
    "ik_numerical": ["--robots", "ur5e", "--poses", "40", "--rival-poses", "5"],
    "ik_redundant": ["--seven", "iiwa7", "--poses", "4"],
    "jerk_limited": ["--problems", "8", "--points", "8"],
    "kernels_raw": ["--rows", "128"],
    "linkage_synthesis": ["--lists", "8", "--peer", "1", "--starts", "1"],
    "live_log": ["--steps", "20"],
    "mobility_rank": ["--batch", "8", "--random", "2"],
    "parallel_robots": ["--batch", "60", "--platforms", "2"],
    "planning": ["--whole", "1"],
    "predictive_control": ["--horizon", "4"],
    "rigid_contact": ["--duration", "0.02"],
    "robot_page": ["--quick", "--robots", "puma560"],
    "rotations_vs_scipy": ["--rows", "16"],
    "simulation_step": ["--steps", "20", "--batch", "4"],
    "studio": ["--quick"],
    "threads": ["--robot", "puma560"],
    "time_optimal": ["--intervals", "20", "--batch", "4", "--long", "100"],
    "tracing": [],
    "trajectory_curves": [],
    "two_arms": ["--batch", "16", "--verdicts", "20"],
    "variants": ["--seconds", "0.1", "--runs", "4"],
}
"""Arguments of each script."""
LACKING = {"gpu_inverse_dynamics": "libcuda", "phcpack": "phc"}
"""What a script asks for that no package index has, and that its refusal names."""
OTHERS = {
    "page",  # runs those above
    "ik_rival_rtb", "planning_rival_roboplan",  # run by an interpreter of their own, from another script
}  # fmt: skip
BROWSING = {"robot_page", "studio"}


def run(script: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, str(ROOT / "benchmarks" / f"{script}.py"), *arguments],
        cwd=ROOT, env=os.environ | {"MAFSIL_BENCHMARK_ONCE": "1"}, capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.mark.parametrize("script", SMALLEST)
def test_a_script_prints_figures_at_its_smallest_size(script):
    if script in BROWSING:
        needed("chromium", "chromium-browser", "google-chrome")
    done = run(script, *SMALLEST[script])
    assert done.returncode == 0, done.stderr[-2000:]
    assert any(character.isdigit() for character in done.stdout.partition("\n")[2])


@pytest.mark.parametrize("script", LACKING)
def test_a_script_without_its_peer_or_device_says_what_it_lacks(script):
    done = run(script)
    assert "Traceback" not in done.stderr
    assert not done.returncode or LACKING[script] in done.stderr


def test_no_script_is_left_out():
    scripts = {path.stem for path in (ROOT / "benchmarks").glob("*.py") if '"__main__"' in path.read_text("utf-8")}
    assert scripts == SMALLEST.keys() | LACKING.keys() | OTHERS
