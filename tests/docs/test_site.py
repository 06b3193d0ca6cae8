"""The site builds without a warning, its reference lists what the packages offer, and formulas are typeset."""

import importlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import axe_core_python
import nbformat
import pytest

import mafsil as mf
from tests.page.browser import Browser

ROOT = Path(__file__).parents[2]
sys.path.append(str(ROOT / "docs" / "site"))
formulas = importlib.import_module("formulas")
notebooks = importlib.import_module("notebooks")
FORMULAS = (
    *("conventions", "control_laws", "dynamics", "identification", "mobility", "numerical-inverse-kinematics"),
    *("rigid-motions", "singularities", "time_optimal", "velocities-and-statics"),
)
PAGES = ("index", "index.ar", "dynamics", "command_line", "gallery", "coming-from", "search", "reference/ik")
"""Pages with all kinds of content that there are."""
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
    quicker = os.environ | {"MAFSIL_SITE_QUICK": "1"}
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
def test_signatures_read_as_the_source_writes_them(site: Path) -> None:
    """`ArrayLike` and `Floats`, not the unions behind them."""
    for page in (site / "reference").glob("*.html"):
        for signature in re.findall(r'<dt class="sig[^>]*>(.*?)</dt>', page.read_text("utf-8"), re.S):
            assert not re.search(r"_NestedSequence|_Buffer|(?<!np\.)ndarray|Annotated", signature), signature


@pytest.mark.slow
def test_no_backticks_are_left(site: Path) -> None:
    """Markup that does not close, as in ``Name``s, shows its signs to the reader."""
    for page in site.rglob("*.html"):
        prose = re.sub(r"<pre.*?</pre>|<script.*?</script>|<[^>]+>", "", page.read_text("utf-8"), flags=re.S)
        if page.parent.name not in ("live", "_modules"):
            assert "``" not in prose, f"{page.name}: {prose[(at := prose.index('``')) - 60 : at + 60]}"


@pytest.mark.slow
def test_home_shows_a_live_arm_and_menu_in_groups(site: Path) -> None:
    home = (site / "index.html").read_text("utf-8")
    assert 'src="live/panda.html"' in home
    assert (site / "live" / "panda.html").read_text("utf-8").startswith("<!doctype html>")
    assert home.count('class="sd-card-body') == 6
    assert home.count('class="caption"') == 5


@pytest.mark.slow
def test_gallery_opens_every_robot_and_job(site: Path) -> None:
    page = (site / "gallery.html").read_text("utf-8")
    jobs = [path.stem for path in (ROOT / "examples" / "jobs").glob("*.toml")]
    assert set(re.findall(r'href="live/(\w+)\.html"', page)) == {*mf.robots(), *jobs}
    assert (site / "live" / "pick_and_place_puma560.html").exists()


@pytest.mark.slow
def test_tutorials_are_notebooks_with_outputs(site: Path) -> None:
    page = (site / "tutorials.html").read_text("utf-8")
    links = re.findall(r'href="(notebooks/[\w-]+\.ipynb)"', page)
    assert len(links) == 7
    cells = json.loads((site / links[0]).read_text("utf-8"))["cells"]
    printed = "".join(part for cell in cells for output in cell.get("outputs", []) for part in output["text"])
    assert "[-0.478 -0.183  0.488]" in printed


@pytest.mark.slow
def test_sections_of_the_tutorials_stand_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each is a notebook of its own, with the page's first imports."""
    monkeypatch.chdir(tmp_path)
    for title, notebook in notebooks.notebooks((ROOT / "docs" / "tutorials.md").read_text("utf-8")):
        names: dict[str, object] = {}
        for cell in notebook.cells:
            if cell.cell_type == "code":
                exec(compile(cell.source, title, "exec"), names)


def test_the_course_is_one_source_in_two_languages() -> None:
    """Fourteen weeks that read, run and exercise what exists: same code, other words."""
    both = [notebooks.week_notebooks(language) for language in ("en", "ar")]
    assert [len(weeks) for weeks in both] == [14, 14]
    for (_, english), (_, arabic) in zip(*both, strict=True):
        nbformat.validate(english)
        codes = [[c.source for c in book.cells if c.cell_type == "code"] for book in (english, arabic)]
        assert codes[0][1:] == codes[1][1:]
        texts = [[c.source for c in book.cells if c.cell_type == "markdown"] for book in (english, arabic)]
        assert all(re.search("[\u0600-\u06ff]", text) and 'dir="rtl"' in text for text in texts[1])
        assert not re.search("[\u0600-\u06ff]", "".join(texts[0]))
        assert "## Mini-project" in "".join(texts[0])
    for week in notebooks._weeks():
        assert (ROOT / "examples" / "python" / week["script"]).exists()
        assert all((ROOT / "docs" / page).exists() for page in week["pages"])
        assert set(week["sections"]) <= set(mf.book.sections())
        assert [bool(cell.get("project")) for cell in week["cell"]][-1]


@pytest.mark.parametrize("week", range(14))
def test_weeks_of_the_course_run(week: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In Arabic, whose code is that of the English notebook but for the language."""
    monkeypatch.chdir(tmp_path)
    title, notebook = notebooks.week_notebooks("ar")[week]
    names: dict[str, object] = {}
    try:
        for cell in notebook.cells:
            if cell.cell_type == "code":
                exec(compile(cell.source, title, "exec"), names)
    finally:
        mf.language("en")


@pytest.mark.slow
def test_arabic_pages_run_from_right_to_left(site: Path) -> None:
    for page in site.glob("*.html"):
        opening = re.search(r"<html[^>]*>", page.read_text("utf-8"))
        assert opening
        assert ('lang="ar" dir="rtl"' in opening[0]) == page.stem.endswith(".ar"), page.name


@pytest.mark.slow
def test_pages_are_accessible(site: Path, tmp_path: Path) -> None:
    """No violation of the rules of axe."""
    script = Path(axe_core_python.__file__).with_name("axe.min.js").read_text("utf-8")
    with Browser(tmp_path, (1440, 900)) as browser:
        for page in PAGES:
            browser.load(site / f"{page}.html", drawn="document.readyState === 'complete'")
            browser.ask(script)
            violations = browser.ask(
                "axe.run({iframes: false}).then(found => found.violations.map(v => [v.id, v.nodes[0].html]))"
            )
            assert not violations, f"{page}: {violations}"


@pytest.mark.slow
def test_formulas_of_the_reference_are_typeset(site: Path) -> None:
    assert "<math" in (site / "reference" / "mechanics.html").read_text("utf-8")


@pytest.mark.slow
def test_formulas_of_the_guide_are_typeset(site: Path) -> None:
    """Also code that is a formula from end to end."""
    for page in FORMULAS:
        assert "<math" in (site / f"{page}.html").read_text("utf-8"), page


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
    assert formulas.typeset("It slides: F_t = 2 F_n.") == r"It slides: \ :math:`F_{t} = 2 F_{n}`\ ."
    assert text == r"Efforts \ :math:`\tau = M \ddot{q}`\ , of q (\*batch, n) [rad], as ``name = value`` says."


@pytest.mark.parametrize("words", ["a robot", "q (*batch, n)", "the frame {s}", "x, y", "(n = "])
def test_words_are_no_formula(words: str) -> None:
    assert ":math:" not in formulas.typeset(words)


def test_steps_and_blocks_get_blank_lines() -> None:
    lines = ["Two steps:", "1. first", "   goes on", "2. second:", "       a = b", "After."]
    assert formulas.laid_out(lines) == [
        "Two steps:", "", "1. first", "   goes on", "", "2. second:", "", "       a = b", "", "After.",
    ]  # fmt: skip
