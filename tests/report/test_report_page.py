"""The page: complete in itself, safe against names, true to the recording, in both directions of writing."""

import base64
import hashlib
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mafsil.errors import FileError
from mafsil.job import Run, parse_job, solve_file
from mafsil.job.judging.judgement import summary
from mafsil.messages import LANGUAGES
from mafsil.model import library
from mafsil.page.assemble import own_views
from mafsil.report import contents, fragments
from mafsil.report.page import MAIN, render
from mafsil.report.replay import recipe
from mafsil.scene import Drawing, compact, one_script
from mafsil.scene.modules import read
from tests.page.node import run_module

ROOT = Path(__file__).resolve().parents[2]


class Reader(HTMLParser):
    """Collects elements, attributes and texts as a browser would see them."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.texts: dict[str, str] = {}
        self.inside = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        kind = dict(attrs).get("type") or ""
        self.inside = f"{tag}{'/json' if 'json' in kind else ''}"

    def handle_endtag(self, tag: str) -> None:
        if tag in {"script", "style"}:
            self.inside = ""

    def handle_data(self, data: str) -> None:
        self.texts[self.inside] = self.texts.get(self.inside, "") + data


@pytest.fixture(params=LANGUAGES)
def page(request: pytest.FixtureRequest, small_run: Run) -> tuple[str, str, Reader]:
    html = render(contents.page(small_run, summary(small_run), request.param))
    reader = Reader()
    reader.feed(html)
    return request.param, html, reader


def data_of(reader: Reader) -> dict[str, Any]:
    return json.loads(reader.texts["script/json"])


def unpacked(text: str, columns: int) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), "<f4").reshape(-1, columns)


@pytest.mark.row("N2")
def test_the_page_asks_nobody_for_anything(page: tuple[str, str, Reader]) -> None:
    _, html, reader = page
    names = {"http://www.w3.org/2000/svg", "http://www.w3.org/1998/Math/MathML"}
    addresses = set(re.findall(r"https?://[^\s\"'<>)]*", html)) - names
    assert not addresses
    for tag, attributes in reader.tags:
        assert tag not in {"link", "iframe", "object", "embed", "img", "base", "form"}, tag
        assert not {"src", "href", "srcset", "action", "data", "poster"} & set(attributes), (tag, attributes)
        assert not any(name.startswith("on") for name in attributes), (tag, attributes)
    assert "@import" not in html
    assert "url(" not in html
    for word in ("fetch(", "XMLHttpRequest", "WebSocket", "import(", "eval(", "innerHTML", "document.write"):
        assert word not in html


def test_a_report_has_every_card_of_the_robot(page: tuple[str, str, Reader]) -> None:
    for module in own_views():
        for name in re.findall(r'^  name: "(\w+)",$', read(module), re.M):
            assert f'name:"{name}"' in page[1], name


def test_what_is_quoted_stays_when_scripts_are_made_small() -> None:
    """Every text of every module stands in the joined script as often as in the modules; blanks around signs do not."""
    quoted, joined = re.compile(r'"(?:[^"\\\n]|\\.)*"'), one_script(*own_views(), MAIN)
    plain = [line for module in own_views() for line in read(module).splitlines() if not re.search("[`'/]", line)]
    texts = [text for line in plain for text in quoted.findall(line)]
    assert len(texts) > 200
    assert all(joined.count(text) >= texts.count(text) for text in set(texts))


def test_the_policy_allows_just_this_style_and_script(page: tuple[str, str, Reader]) -> None:
    _, _, reader = page
    policy = next(a["content"] for _, a in reader.tags if a.get("http-equiv") == "Content-Security-Policy")
    assert policy is not None
    assert policy.startswith("default-src 'none'")
    assert "unsafe" not in policy.replace("'wasm-unsafe-eval'", "")
    assert "connect-src" not in policy
    for kind in ("script", "style"):
        digest = base64.b64encode(hashlib.sha256(reader.texts[kind].encode()).digest()).decode()
        assert f"{kind}-src 'sha256-{digest}'" in policy


def test_names_stay_text(page: tuple[str, str, Reader]) -> None:
    _, html, reader = page
    assert sum(tag == "script" for tag, _ in reader.tags) == 2
    assert "\u202e" not in html
    assert "<U+202E>" in reader.texts["bdi"]
    assert "<script>alert(1)</script>" in "".join(reader.texts.values())
    data = data_of(reader)
    assert data["texts"][data["language"]]["moves"][0].startswith("down </script>")


def test_direction_and_language(page: tuple[str, str, Reader]) -> None:
    code, html, reader = page
    root = next(attributes for tag, attributes in reader.tags if tag == "html")
    assert (root["lang"], root["dir"]) == (code, "rtl" if code == "ar" else "ltr")
    assert "{{" not in html.replace("{{}}", "")
    for tag, attributes in reader.tags:
        if attributes.get("id") in {"scene", "track", "clock", "legend"}:
            assert attributes.get("dir") == "ltr", tag
    if code == "ar":
        headings = reader.texts["h2"]
        assert not re.search(r"[A-Za-z]{3,}", headings)


def test_plots_keep_every_extreme(page: tuple[str, str, Reader], small_run: Run) -> None:
    data = data_of(page[2])
    n, tape = small_run.robot.n, small_run.recording
    curves = (tape.q, tape.qd, tape.tau, tape.q - tape.q_ref)
    for plot, curve in zip(data["plots"][:4], curves, strict=True):
        drawn = unpacked(plot["values"], n)
        np.testing.assert_allclose(drawn.max(axis=0), curve.max(axis=0), rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(drawn.min(axis=0), curve.min(axis=0), rtol=1e-6, atol=1e-9)
        assert len(drawn) == len(unpacked(data["time"], 1))
    for (low, high), a, b in zip(
        data["plots"][0]["limits"], small_run.robot.limits.lower, small_run.robot.limits.upper, strict=True
    ):
        assert (low, high) == (a, b)


def test_replay_shows_what_was_recorded(page: tuple[str, str, Reader], small_run: Run) -> None:
    data = data_of(page[2])
    drawn, tape = data["tape"], small_run.recording
    frames, q, tips = drawn["frames"], unpacked(drawn["q"], small_run.robot.n), unpacked(drawn["tips"], 7)
    assert drawn["end"] == tape.t[-1]
    for frame in (0, frames // 2, frames - 1):
        row = min(int(np.searchsorted(tape.t, min(frame * drawn["period"], tape.t[-1]))), len(tape.t) - 1)
        np.testing.assert_array_equal(q[frame], tape.q[row].astype("<f4"))
        np.testing.assert_allclose(tips[frame], compact(small_run.robot.forward_kinematics(tape.q[row])), atol=1e-6)
    assert len(data["scene"]["bodies"]) == len(small_run.robot.mechanism.links)
    (part,) = drawn["carried"]
    poses, carried = unpacked(part["poses"], 7), slice(part["first"], part["end"])
    np.testing.assert_allclose(np.linalg.norm(poses[:, 3:], axis=-1), 1.0, atol=1e-6)
    near = np.linalg.norm(poses[:, :3] - tips[:, :3], axis=1) < 1e-5
    assert 0 < part["first"] < part["end"] < frames
    assert near[carried].all()
    assert not near[: part["first"] // 2].any()


@pytest.mark.parametrize("name", library.robots())
def test_every_robot_of_the_library_has_a_body(name: str) -> None:
    mechanism = library.load(name)
    poses = np.broadcast_to(np.eye(4), (len(mechanism.links), 4, 4))
    bodies = Drawing(mechanism).bodies(-1.0, poses)
    assert [body.name for body in bodies] == list(mechanism.link_names)
    solids = [solid for body in bodies for solid in body.solids]
    assert solids
    for solid in solids:
        assert all(np.isfinite(solid.size))
        assert min(solid.size) >= 0
        assert np.isclose(np.linalg.norm(solid.pose[3:]), 1.0)


def test_a_bracket_that_the_arabic_opened_is_closed_by_it() -> None:
    html = fragments.text("افتُرض 4 rad/s² (أو m/s²)")
    assert '<bdi dir="ltr">m/s²</bdi>)' in html
    assert '<bdi dir="ltr">sin(q)</bdi>' in fragments.text("الدالة sin(q)")


DRAWN = """
import { Figure } from "./page/stage/figure.js";
import { Scenery } from "./page/stage/scenery.js";
const place = [0.1, 0.2, 0.3, 1, 0, 0, 0], pack = (rows) => btoa(String.fromCharCode(...new Uint8Array(new Float32Array(rows).buffer)));
let corners = 0;
const renderer = { mesh: (shape) => { corners += shape.vertices.length / 6; return { count: shape.indices.length }; } };
const empty = { surfaces: [], bodies: [] };
const figure = new Figure(renderer, { ...empty, size: 1, floor: 0 });
for (const count of [0, 12, 13, 2000]) {
  corners = 0;
  const tape = { frames: 1, tips: pack(place), reference: pack(place), carried: [], fixed: [], scenery: empty, targets: Array(count).fill({ pose: place }) };
  const items = new Scenery(figure, tape).items(0, new Float32Array(16), [1, 0, 0, 1]);
  console.log(count, items.length, items.filter((item) => item.mesh.count === count * 18).length, corners);
}
"""  # noqa: E501


def test_many_targets_are_drawn_in_three_meshes(tmp_path: Path) -> None:
    """Of 2,000 targets, 12,000 draws of round shafts and cones a frame would be too many."""
    rows = {
        int(line.split()[0]): [int(word) for word in line.split()[1:]]
        for line in run_module(DRAWN, tmp_path).splitlines()
    }
    frames = rows[0][0]
    assert rows[12][0] == frames + 6 * 12
    assert rows[13][:2] == rows[2000][:2] == [frames + 3, 3]
    assert rows[2000][2] - rows[0][2] == 2000 * 3 * 6


CARRIED = """
import { Figure } from "./page/stage/figure.js";
import { Scenery } from "./page/stage/scenery.js";
const pack = (rows) => btoa(String.fromCharCode(...new Uint8Array(new Float32Array(rows).buffer)));
const h = Math.SQRT1_2, tip = [0.5, 0, 0.4, h, 0, h, 0], part = [0.5, 0, 0.3, h, 0, h, 0], empty = { surfaces: [], bodies: [] };
const figure = new Figure({ mesh: () => ({ count: 0 }) }, { ...empty, size: 1, floor: 0 });
const scenery = { surfaces: [], bodies: [{ shapes: [{ kind: "box", size: [0.1, 0.1, 0.1], pose: [0, 0, 0, 1, 0, 0, 0], colour: [1, 1, 1, 1] }] }] };
const three = (row) => pack([...row, ...row, ...row]);
const tape = { frames: 3, tips: three(tip), reference: three(tip), carried: [{ poses: three(part), first: 1, end: 3 }], fixed: [], scenery, targets: [] };
const here = [0, 0, 1, 0.5, 0, 1, 0, 0.2, -1, 0, 0, 0.6, 0, 0, 0, 1]; // the tip was led to another place, turned as before
for (const frame of [0, 1]) console.log(JSON.stringify([...new Scenery(figure, tape).items(frame, here, [1, 0, 0, 1])[0].model.slice(12, 15)]));
"""  # noqa: E501


def test_what_is_carried_goes_with_the_tool_that_is_led(tmp_path: Path) -> None:
    """A part that the tip carries at the time of the replay; before that it lies where it is."""
    lying, carried = map(json.loads, run_module(CARRIED, tmp_path).splitlines())
    np.testing.assert_allclose(lying, [0.5, 0.0, 0.3], atol=1e-6)
    np.testing.assert_allclose(carried, [0.5, 0.2, 0.5], atol=1e-6)


@pytest.mark.parametrize("value", ["4.3e-16", "-0.5", "−m g·p", "½ m v·v", "joint_2", "12.5 %", "(0, -1.5, 2)"])
def test_a_number_or_formula_in_arabic_is_one_isolate(value: str) -> None:
    html = fragments.text(f"أكبر فرق {value} عند المفصل الثاني.")
    assert f'<bdi dir="ltr">{value}</bdi>' in html
    assert html.count('<bdi dir="ltr">') == 1


def test_the_lines_that_do_a_run_again(tmp_path: Path) -> None:
    """A robot of the library is found from anywhere; a file from the folder that is named."""
    lines = "\n[start]\njoints = [0, -1, 1, 0.1, 0.1, 0]\n[[move]]\njoints = [0.1, -1, 1, 0.1, 0.1, 0]\n"
    assert recipe(parse_job('robot = "ur5e"' + lines))[-1] == 'run = solve_file("job.toml")'
    text = 'robot = "robots/ur5.urdf"' + lines
    assert recipe(parse_job(text))[-1] == 'run = solve_file("job.toml", folder=".")'
    (tmp_path / "job.toml").write_text(text, encoding="utf-8")
    first, second = (solve_file(tmp_path / "job.toml", folder=ROOT / "examples") for _ in range(2))
    assert isinstance(first, Run)
    assert isinstance(second, Run)
    assert first.recording.q.tobytes() == second.recording.q.tobytes()
    with pytest.raises(FileError):
        solve_file(tmp_path / "job.toml")
