"""Job files: every complaint names the key, the line and the remedy, in both languages."""

from pathlib import Path

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.errors import FileError, JobError, MafsilError
from mafsil.job import parse_job, read_job
from mafsil.job.language import reading
from mafsil.job.language.text import Places
from mafsil.job.solve import prepare

JOBS = Path(__file__).parents[2] / "examples" / "jobs"
PANDA = (JOBS / "pick_and_place_panda.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize("path", sorted(JOBS.glob("*.toml")), ids=lambda p: p.stem)
def test_examples_are_valid(path: Path) -> None:
    assert read_job(path).move


@pytest.mark.parametrize(
    ("old", "new", "key", "mentions"),
    [
        ("robot =", "robbot =", "job.unknown_key_close", ["x.toml:3", "robbot", "robot"]),
        ("robot =", "zzz =", "job.unknown_key", ["x.toml:3", "zzz", "move"]),
        ('robot = "panda"', "", "job.missing_key", ["robot"]),
        ("frequency = 25.0", "frequency = -1", "job.bound", ["x.toml:21", "controller.frequency", "-1", ">= 1e-09"]),
        ("frequency = 25.0", 'frequency = "fast"', "job.type", ["controller.frequency", "a number", "fast"]),
        ("step = 0.001", "step = nan", "job.bound", ["simulation.step", "nan"]),
        ("com = [0.0,", "com = [inf,", "job.not_finite", ["tool.com[1]", "inf"]),
        ('kind = "computed_torque"', 'kind = "magic"', "job.choice", ["magic", "computed_torque, pd_gravity"]),
        ("position = [0.48, -0.30, 0.32]", "position = [0.48]", "job.length", ["move[1].pose.position", "3"]),
        ("position = [0.48, -0.30, 0.32]", "pozition = [0]", "job.unknown_key_close", ["pozition", "position"]),
        ("place = true", "place = true\npause = 1", "job.move_many", ["move[7]", "place, pause"]),
        ("place = true", "", "job.move_empty", ["move[7]", "joints"]),
        ('path = "line"', 'path = "line"\nvia = [[1.0]]', "job.line_via", ["move[2].via"]),
        ("rpy = [180, 0, 0] }", "rpy = [180, 0, 0], quaternion = [1, 0, 0, 0] }", "job.two_orientations", ["move[1]"]),
        ("rpy = [180, 0, 0] }", "quaternion = [0, 0, 0, 0] }", "job.zero_quaternion", ["move[1].pose.quaternion"]),
        ('profile = "double_s"', 'path = "line"', "job.line_pose", ["move[9].path"]),
        ("[start]", "[[obstacle]]\nlength = 1\n[start]", "job.unknown_key", ["obstacle[1].length", "sphere"]),
        ("[start]", "[[obstacle]]\nposition = [1, 0, 0]\n[start]", "job.obstacle_kind", ["box, sphere", "given: -"]),
        (
            "[start]",
            "[[obstacle]]\nposition = [1, 0, 0]\nbox = [1, 1, 1]\nfloor = true\n[start]",
            "job.obstacle_kind",
            ["box, floor"],
        ),
        ('path = "line"', 'path = "line"\navoid = true', "job.avoid_path", ["x.toml:36", "line"]),
        ('profile = "double_s"', 'profile = "trapezoid"\navoid = true', "job.avoid_profile", ["time_optimal"]),
    ],
)
def test_each_mistake_has_its_sentence(old: str, new: str, key: str, mentions: list[str]) -> None:
    assert old in PANDA
    with pytest.raises(JobError) as caught:
        parse_job(PANDA.replace(old, new, 1), "x.toml")
    assert caught.value.key == key
    for word in mentions:
        assert word in caught.value.message("en")
    assert any("\u0600" <= c <= "\u06ff" for c in caught.value.message("ar"))


@pytest.mark.parametrize(
    "text", ["robot = 3\nmove = []", "robot = 'a'\nmove = []", "robot = 'a'\nmove = [3]", "move = 3", ""]
)
def test_other_wrong_shapes_are_refused(text: str) -> None:
    with pytest.raises(JobError):
        parse_job(text)


def test_no_file_no_toml_no_text(tmp_path: Path) -> None:
    cases = {
        "job.no_file": tmp_path / "absent.toml",
        "job.directory": tmp_path,
        "job.syntax_at": tmp_path / "broken.toml",
        "job.encoding": tmp_path / "latin.toml",
        "job.too_large": tmp_path / "huge.toml",
    }
    cases["job.syntax_at"].write_text("[[[", encoding="utf-8")
    cases["job.encoding"].write_bytes(b"title = '\xff'")
    cases["job.too_large"].write_bytes(b"#" * 20_000_001)
    for key, path in cases.items():
        with pytest.raises(FileError) as caught:
            read_job(path)
        assert caught.value.key == key
        assert caught.value.message("en") != caught.value.message("ar")


def test_deep_nesting_is_refused() -> None:
    with pytest.raises(MafsilError):
        parse_job("a = " + "[" * 5000 + "]" * 5000)


def test_direction_characters_in_keys_are_shown_by_number() -> None:
    with pytest.raises(JobError) as caught:
        parse_job('robot = "a"\n"\u202eevil" = 1\nmove = []')
    assert "\u202e" not in caught.value.message()
    assert "<U+202E>" in caught.value.message()


@given(st.binary(max_size=200))
@settings(max_examples=200, deadline=None)
@pytest.mark.row("F1")
def test_any_bytes_give_our_errors_only(noise: bytes) -> None:
    text = PANDA.encode()
    cut = len(noise) * 7 % len(text)
    found: list[MafsilError] = []
    try:
        parse_job((text[:cut] + noise + text[cut + 3 :]).decode("utf-8", "replace"))
    except MafsilError as error:
        found.append(error)
    assert all(error.message("en") and error.message("ar") for error in found)


def test_lines_of_keys() -> None:
    text = "a = 1\n[b]\nc.d = 2\n[[m]]\nx = 1\n[[m]]\ny = { z = 3 }\n[m.n]\nk = 1\n"
    line_of = Places(text).line
    assert line_of(("a",)) == 1
    assert line_of(("b", "c", "d")) == 3
    assert line_of(("m", 0, "x")) == 5
    assert line_of(("m", 1, "y", "z")) == 7
    assert line_of(("m", 1, "n", "k")) == 9
    assert line_of(("nowhere",)) is None


def test_every_key_is_documented() -> None:
    import msgspec

    from mafsil.job.language import description, statements

    text = (Path(__file__).parents[2] / "docs" / "job_files.md").read_text(encoding="utf-8")
    parts = [
        kind
        for kind in (vars(description) | vars(statements)).values()
        if isinstance(kind, type) and issubclass(kind, description.Part)
    ]
    names = {field.encode_name for part in parts for field in msgspec.structs.fields(part)}
    names -= {"origins", "cells", "fork", "skip", "lying", "carrier", "moving"}
    tables = {
        "tool",
        "tools",
        "start",
        "limits",
        "controller",
        "simulation",
        "report",
        "move",
        "disturbance",
        "collision",
        "obstacle",
        "other_robot",
        "frame",
        "pattern",
        "configuration",
        "output",
        "input",
    }
    for name in names:
        assert (f"[{name}]" if name in tables else f"`{name}`") in text, name


def test_keys_of_a_table_are_looked_up_once_however_many_moves_there_are(monkeypatch):
    """Asked for each move, msgspec evaluates all annotations again: 100,000 moves took a minute and a half to read."""
    asked: list[object] = []
    fields = msgspec.structs.fields
    monkeypatch.setattr(msgspec.structs, "fields", lambda kind: asked.append(kind) or fields(kind))
    reading._fields.cache_clear()
    moves = parse_job('robot = "planar2r"\n' + "[[move]]\npause = 0.1\n" * 500)
    assert len(moves.move) == 500
    assert len(asked) == len(set(asked)) < 30


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ('title = "x"\nrobot = "ur5ee"\n', "job.toml:2", "did you mean: ur5"),
        ('robot = "ur5e"\nlock = { elbo = 0 }\n', "job.toml:2", "elbow_joint"),
    ],
)
def test_a_robot_and_a_lock_that_cannot_be_are_said_with_their_line(text, place, words):
    text += "[[move]]\npause = 1\n"
    with pytest.raises(MafsilError, match=words) as caught:
        prepare(parse_job(text), text, Path(), source="job.toml")
    assert str(caught.value).startswith(place)


@pytest.mark.parametrize("wrong", ["nan", "3", "true", "[1]", "{ a = 1 }"])
def test_what_cannot_be_included_is_said_with_its_line(wrong):
    with pytest.raises(JobError, match="include") as caught:
        parse_job(f'robot = "ur5e"\ninclude = {wrong}\n[[move]]\npause = 1\n', source="job.toml")
    assert str(caught.value).startswith("job.toml:2")


def test_a_table_that_is_not_known_is_said_with_its_line():
    with pytest.raises(JobError, match="did you mean: move") as caught:
        parse_job('robot = "ur5e"\n\n[[moves]]\npause = 1\n', source="job.toml")
    assert str(caught.value).startswith("job.toml:3")


def test_a_refused_pose_of_an_arm_with_few_joints_is_one_sentence(recwarn):
    """A warning of inverse kinematics for programmers was printed beside it."""
    text = 'robot = "cobra600"\n[[move]]\npose = { position = [0.4, 0.2, 0.15], rpy = [3.14159265, 0, 0.5] }\n'
    refused = prepare(parse_job(text), text, Path())
    assert "4 joints, fewer than a pose fixes" in refused.explain("en")
    assert not [each for each in recwarn if "no solution" in str(each.message)]
