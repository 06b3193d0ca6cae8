"""The site builds without a warning, its reference lists what the packages offer, and formulas are typeset."""

import importlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.append(str(ROOT / "docs" / "site"))
formulas = importlib.import_module("formulas")
pytestmark = pytest.mark.timeout(1200)  # the whole site is built: two minutes of a processor


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    command = [
        sys.executable,
        "-m",
        "sphinx",
        "-q",
        "-W",
        "--keep-going",
        "-c",
        "docs/site",
        "-D",
        "toc_object_entries=0",
        "docs",
        str(folder),
    ]
    quicker = os.environ | {"MAFSIL_SITE_WITHOUT_CODE": "1"}
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, env=quicker)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.slow
def test_reference_lists_what_packages_offer(site: Path) -> None:
    page = (site / "reference" / "ik.html").read_text("utf-8")
    assert 'id="mafsil.ik.inverse_kinematics"' in page
    assert 'id="mafsil.ik.SolutionSet.explain"' in page
    assert 'id="mafsil.robot.Robot.inverse_dynamics"' in (site / "reference" / "robot.html").read_text("utf-8")


@pytest.mark.slow
def test_pages_fetch_nothing_from_elsewhere(site: Path) -> None:
    """Scripts, styles and pictures stand beside the pages."""
    for page in site.rglob("*.html"):
        text = page.read_text("utf-8")
        assert 'src="http' not in text
        assert 'rel="stylesheet" href="http' not in text


@pytest.mark.slow
def test_formulas_of_the_reference_are_typeset(site: Path) -> None:
    assert "<math" in (site / "reference" / "mechanics.html").read_text("utf-8")


@pytest.mark.parametrize(
    ("plain", "latex"),
    [
        ("tau = M qdd + c + g + J' F_tip", r"\tau = M \ddot{q} + c + g + J ^{\top} F_{tip}"),
        ("V_s = J_s qd", r"V_{s} = J_{s} \dot{q}"),
        ("|r| <= pi/4", r"| r | \le \pi / 4"),
        ("T = exp([S_1] q_1) M", r"T = \exp ( [ S_{1} ] q_{1} ) M"),
        ("dV_s/dt = J_s qdd", r"\frac{\mathrm{d} V_{s}}{\mathrm{d}t} = J_{s} \ddot{q}"),
    ],
)
def test_formula_becomes_latex(plain: str, latex: str) -> None:
    assert formulas.is_relation(plain)
    assert formulas.latex(plain) == latex
    assert formulas.mathml(latex).startswith("<math")


def test_prose_around_a_formula_stays() -> None:
    text = formulas.typeset("Efforts tau = M qdd, of q (*batch, n) [rad], as `name = value` says.")
    assert text == r"Efforts \ :math:`\tau = M \ddot{q}`\ , of q (\*batch, n) [rad], as ``name = value`` says."


@pytest.mark.parametrize("words", ["a robot", "q (*batch, n)", "the frame {s}", "x, y", "(n = "])
def test_words_are_no_formula(words: str) -> None:
    assert ":math:" not in formulas.typeset(words)


def test_steps_and_blocks_get_blank_lines() -> None:
    lines = ["Two steps:", "1. first", "   goes on", "2. second:", "       a = b", "After."]
    assert formulas.laid_out(lines) == [
        "Two steps:", "", "1. first", "   goes on", "", "2. second:", "", "       a = b", "", "After.",
    ]  # fmt: skip
