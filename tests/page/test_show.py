"""`mf.show` and `mafsil show`: what is written, how large it is, and that nothing in it asks for anything."""

from __future__ import annotations

import json
import re
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.main import main
from mafsil.errors import FileError, InputError, KernelError
from mafsil.messages import LANGUAGES
from mafsil.messages.catalogue import keys
from mafsil.page import Session, show
from mafsil.page.assemble import own_views
from mafsil.scene import modules
from tests.page.node import needed


@pytest.mark.parametrize("name", ["panda", "ur5e", "puma560"])
def test_the_page_is_small_and_complete(name: str) -> None:
    """Below 300 kB for an arm of primitives; no address, no style or script but its own."""
    html = show(name).html
    assert len(html.encode()) < 300_000
    assert not re.findall(r"(?:src|href)\s*=", html.split("<script")[0])
    assert "http" not in re.sub(r"http-equiv|http://www\.w3\.org/(?:1998/Math/MathML|2000/svg)", "", html)
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', html)
    assert policy
    assert policy[1].startswith("default-src 'none'; style-src 'sha256-")
    assert "'wasm-unsafe-eval'" in policy[1]
    assert "unsafe-inline" not in policy[1]
    assert "'unsafe-eval'" not in policy[1]
    assert "connect-src" not in policy[1]
    assert not re.search(r"fetch\(|EventSource|XMLHttpRequest|WebSocket|import\(|innerHTML", html)


def test_equal_robots_equal_pages() -> None:
    assert show("puma560").html == show(mf.load("puma560")).html


def test_every_sentence_stands_in_both_languages() -> None:
    assert keys("en", "page") == keys("ar", "page")
    data = json.loads(re.search(r'id="data">(.*?)</script>', show("planar2r").html, re.S)[1])  # pyright: ignore
    assert set(data["languages"]) == set(LANGUAGES)
    used = set(re.findall(r'"((?:view|why)_\w+)"', modules.one_script(*own_views(), "page/main.js")))
    assert used <= set(data["languages"]["ar"]["sentences"])


def test_what_is_written_appears_whole(tmp_path: Path) -> None:
    path = show("planar2r").write(tmp_path / "arm.html")
    assert path.read_text(encoding="utf-8") == show("planar2r").html
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(FileError):
        show("planar2r").write(tmp_path / "missing" / "arm.html")


def test_the_command_takes_views(tmp_path: Path) -> None:
    text = 'view({ name: "mine", order: 1, title: { en: "Mine", ar: "لي" }, mount: () => () => {} });\n'
    (tmp_path / "mine.js").write_text('import { view } from "page/core/views.js";\n' + text, encoding="utf-8")
    out = tmp_path / "arm.html"
    assert main(["show", "planar2r", "--out", str(out), "--view", str(tmp_path / "mine.js")]) == 0
    assert 'name: "mine"' in out.read_text(encoding="utf-8")
    assert main(["show", "planar2r", "--out", str(out), "--view", str(tmp_path / "missing.js")]) == 2


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    out = tmp_path / "arm.html"
    assert main(["--json", "show", "planar2r", "--out", str(out), "--open"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["page"] == str(out)
    assert opened == [out.as_uri()]
    assert "Session(" in out.read_text(encoding="utf-8")
    assert main(["--lang", "ar", "show", "planar2r", "--open"]) == 0
    assert opened[1].endswith("planar2r.html")
    assert 'dir="rtl"' in Path(opened[1].removeprefix("file://")).read_text(encoding="utf-8")


def test_a_robot_of_a_file_is_loaded_from_it_by_the_script(tmp_path: Path) -> None:
    data = show("planar2r").html
    assert '"python":"\'planar2r\'"' in data
    with pytest.raises(mf.InputError):
        Session("planar2r").set_joint(5, 0.0)


def test_a_view_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"none\.js"):
        _ = show("planar2r", views=[tmp_path / "none.js"]).html


def test_modules_are_joined_or_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the joiner does not understand it refuses by name, and so two things of one name."""
    texts = {
        "page/a.js": 'import { b } from "./b.js";\nexport const a = b + 1;\n',
        "page/b.js": "// why\nexport const b = 1;\n",
        "page/c.js": 'import { b } from "./b.js";\nconst b2 = 2, a = 3;\nexport function b3() {}\n',
        "page/d.js": 'import { a } from "./a.js";\nconst b = 2;\n',
        "page/e.js": 'import * as all from "./a.js";\n',
        "page/f.js": "export { a };\n",
    }
    monkeypatch.setattr(modules, "read", texts.__getitem__)
    assert modules.one_script("page/a.js") == '"use strict";\nconst b=1;\nconst a=b+1;'
    for name in "def":
        with pytest.raises(KernelError):
            modules.one_script(f"page/{name}.js")


def test_what_a_view_needs_is_there_or_left_out(tmp_path: Path) -> None:
    """A kernel more for a view's quantity; none where the arm has no masses for it; a wrong name is refused."""
    own, wrong = tmp_path / "own.js", tmp_path / "wrong.js"
    own.write_text('view({\n  name: "a",\n  needs: ["center_of_mass"],\n});\n', encoding="utf-8")
    wrong.write_text('view({\n  name: "b",\n  needs: ["center_of_mas"],\n});\n', encoding="utf-8")
    bare = mf.Robot.from_dh([[0.3, 90, 0.1, 0], [0.2, 0, 0, 45]], "classic", degrees=True)
    assert '"center_of_mass":{"inputs"' in mf.show("planar2r", views=[own]).html
    assert '"center_of_mass":{' not in mf.show(bare, views=[own]).html
    with pytest.raises(InputError, match="center_of_mass"):
        _ = mf.show("planar2r", views=[wrong]).html


def test_a_picture_is_what_the_page_draws(tmp_path: Path) -> None:
    """The arm fills it; nothing of the page around the view is in it, and its background is plain at the edges."""
    needed("chromium", "chromium-browser", "google-chrome")
    image = plt.imread(show("ur5e", language="en").photograph(tmp_path / "ur5e.png"))[..., :3]
    assert image.shape[:2] == (1280, 1920)
    grey = image.mean(axis=2)
    assert len(np.unique((255 * image).astype(int).reshape(-1, 3), axis=0)) > 1000
    assert np.ptp(grey[200:1000, :40]) < 0.2, "no panel stands at the left"
    rows, columns = np.nonzero(grey[100:1150, 200:1700] > 0.98)
    assert 0.4 < np.ptp(rows) / 1280 < 0.9
    assert 0.3 < np.ptp(columns) / 1920 < 0.9


def test_without_a_browser_a_picture_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="Chromium"):
        show("planar2r").photograph(tmp_path / "a.png")
