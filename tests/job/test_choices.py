"""Choices of a job: moves that are made or not by what signals and variables are, and loops that end by them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.cli.main import main
from mafsil.errors import JobError
from mafsil.job import parse_job, solve
from mafsil.job.judging.judgement import summary
from mafsil.job.solve import prepare
from mafsil.report.contents import page as page_of
from mafsil.report.results import as_data

CELL = """
robot = "planar2r"
[variables]
product = "large"
rounds = 3.0
glue = true
[output]
close = false
[input.part_ok]
changes = [[2.0, true], [4.0, false]]
[input.level]
start = 0.0
changes = [[1.0, 3.0]]
"""
CHOICE = """
[[move]]
pause = 2.5
[[move]]
name = "quality"
if = { part_ok = true, product = "large" }
[[move.then]]
name = "good"
joints = [0.3, 0.4]
[[move.else]]
name = "bad"
joints = [-0.3, 0.4]
[[move]]
name = "home"
joints = [0.0, 0.2]
"""


def planned(text, variables=None):
    job = parse_job(text, "job.toml", variables)
    return prepare(job, text, Path())[1]


def made(plan):
    return [leg.name for leg in plan.legs if leg.kind in ("joint", "pause") and leg.name]


@pytest.fixture(scope="module")
def run():
    text = CELL + CHOICE
    found = solve(parse_job(text, "job.toml"), text, Path())
    assert found, found.explain("en")
    return found


def test_moves_are_made_where_all_tests_hold(run):
    assert made(run.plan) == ["good", "home"]
    assert made(planned(CELL + CHOICE, {"product": "small"})) == ["bad", "home"]
    assert made(planned(CELL + CHOICE.replace("2.5", "4.5"))) == ["bad", "home"]
    assert made(planned(CELL + CHOICE.replace("2.5", "4.5").replace("[[move.else]]\nname = \"bad\"\njoints = [-0.3, 0.4]\n", ""))) == ["home"]  # fmt: skip  # noqa: E501
    assert run.plan.made == 3


def test_a_choice_takes_one_tick_and_the_arm_stands(run):
    (leg,) = (leg for leg in run.plan.legs if leg.kind == "if")
    assert 1e-3 - 1e-9 <= leg.trajectory.duration < 2e-3
    assert np.ptp(leg.trajectory.at(np.linspace(0, leg.trajectory.duration, 5)).u, axis=0).max() == 0.0


@pytest.mark.parametrize(("language", "word"), [("en", "part_ok is true since 2 s"), ("ar", "part_ok")])
def test_report_results_and_check_say_which_way_and_why(run, language, word):
    page = page_of(run, summary(run), language)
    step = page.steps[1]
    assert step.name == "quality"
    assert word in step.text
    assert "product" in step.text
    (choice,) = (each["choice"] for each in as_data(run, summary(run))["steps"] if each["choice"])
    assert choice["holds"] is True
    assert [each["value"] for each in choice["reasons"]] == [True, "large"]
    assert json.loads(json.dumps(choice)) == choice
    said = [remark.sentence(language) for remark in run.remarks if remark.key == "job.else_never"]
    assert len(said) == 1
    assert "quality" in said[0]


def test_what_does_not_hold_is_the_reason():
    (leg,) = (leg for leg in planned(CELL + CHOICE, {"product": "small"}).legs if leg.decision)
    assert [each.value for each in leg.decision.reasons] == ["small"]
    assert leg.decision.explain(language="en") == (
        'part_ok = true, product = "large" does not hold: product is "small"'
    )


def test_choices_in_choices_go_on_after_the_outermost():
    """The last move of one way leads past the other way, however deep it stands."""
    text = """
[[move]]
if = { glue = true }
then = [{ if = { product = "large" }, then = [{ pause = 0.1, name = "a" }], else = [{ pause = 0.1, name = "b" }] }]
else = [{ if = { product = "large" }, then = [{ pause = 0.1, name = "c" }] }, { pause = 0.1, name = "d" }]
[[move]]
pause = 0.1
name = "e"
"""
    ways = {(True, "large"): "ae", (True, "small"): "be", (False, "large"): "cde", (False, "small"): "de"}
    for (glue, product), names in ways.items():
        assert "".join(made(planned(CELL + text, {"glue": glue, "product": product}))) == names


TREES = st.recursive(
    st.just("leaf"),
    lambda inner: st.tuples(st.booleans(), st.lists(inner, min_size=1, max_size=3), st.lists(inner, max_size=3)),
    max_leaves=12,
)


@settings(max_examples=40)
@given(st.lists(TREES, min_size=1, max_size=4))
def test_the_way_through_any_choices_is_that_of_a_programming_language(trees):
    """Against Python's own `if`: the flat list of moves with its jumps."""
    names: list[str] = []
    right: list[str] = []

    def written(tree, taken):
        if tree == "leaf":
            names.append(f"m{len(names)}")
            if taken:
                right.append(names[-1])
            return f'{{ pause = 0.1, name = "{names[-1]}" }}'
        holds, then, other = tree
        first = ", ".join([written(each, taken and holds) for each in then])
        second = ", ".join([written(each, taken and not holds) for each in other])
        test = str(holds).lower()
        return f"{{ if = {{ yes = {test} }}, then = [{first}]" + (f", else = [{second}] }}" if other else " }")

    moves = ", ".join([written(tree, True) for tree in trees])
    job = parse_job(f'robot = "planar2r"\nmove = [{moves}]\n[variables]\nyes = true\n')
    k, way = 0, []
    while k < len(job.move):
        move = job.move[k]
        if move.fork is not None:
            k += 1 + (0 if move.fork.tests["yes"] is True else move.fork.skip)
            continue
        way.append(move.name)
        k += 1 + move.skip
    assert way == right


def test_a_loop_ends_when_its_tests_do_not_hold_any_more():
    text = """
[[move]]
while = { part_ok = false, level = { below = 5 } }
repeat = 100
do = [{ pause = 0.3, name = "look" }]
[[move]]
name = "after"
pause = 0.1
"""
    plan = planned(CELL + text)
    assert made(plan) == ["look"] * 7 + ["after"], "at 2.1 s the part is there"
    bounded = planned(CELL + text.replace("100", "4"))
    assert made(bounded) == ["look"] * 4 + ["after"]
    none = planned(CELL + text.replace("part_ok = false", "glue = false"))
    assert made(none) == ["after"]
    assert any(remark.key == "job.loop_never" for remark in none.remarks)


def test_places_of_a_pattern_are_left_when_no_part_comes():
    text = """
[pattern.tray]
position = [0.5, 0.5, 0.0]
count = [5]
pitch = [0.1]
[[move]]
each = "tray"
while = { part_ok = false }
do = [{ pose = { frame = "tray", task = "position" }, name = "at" }, { pause = 0.5 }]
"""
    names = made(planned(CELL.replace("[[2.0, true], [4.0", "[[3.5, true], [9.0") + text))
    assert names[0] == "at (tray 1)"
    assert 1 < len([name for name in names if name.startswith("at")]) < 5


def test_a_part_is_let_go_of_only_where_one_was_taken():
    """What each way holds is known on the way; what no way can hold is refused before anything is planned."""
    take = "[[move]]\nif = { glue = true }\nthen = [{ pick = { mass = 0.1 } }]\n"
    leave = "[[move]]\nif = { glue = true }\nthen = [{ place = true }]\n"
    assert [leg.kind for leg in planned(CELL + take + leave).legs].count("place") == 1
    with pytest.raises(JobError) as caught:
        planned(CELL + take + "[[move]]\nplace = true\n", {"glue": False})
    assert caught.value.key == "job.nothing_carried"
    with pytest.raises(JobError) as caught:
        planned(CELL + leave)
    assert caught.value.key == "job.nothing_carried"


def test_a_choice_whose_outcome_would_change_saves_nothing_that_is_known():
    """Ten per cent more of a limit brings the arm to the choice earlier, where another way is taken: not a number."""
    text = """
[[move]]
joints = [1.0, 0.4]
[[move]]
if = { level = { above = 1 } }
then = [{ joints = [0.0, 0.4] }]
"""
    when = planned(CELL + "[[move]]\njoints = [1.0, 0.4]\n").cycle
    cell = CELL.replace("[[1.0, 3.0]]", f"[[{when - 1e-3:.4f}, 3.0]]")
    run = solve(parse_job(cell + text), cell + text, Path())
    assert any(leg.decision and leg.decision.holds for leg in run.plan.legs)
    assert any(np.isnan(one.saved) for one in run.limits)


WRONG = {
    "if = { part_okay = true }\nthen = [{ pause = 1 }]": "job.test_unknown",
    "if = { part_ok = 1 }\nthen = [{ pause = 1 }]": "job.signal_digital",
    "if = { part_ok = 'yes' }\nthen = [{ pause = 1 }]": "job.test_text",
    "if = { product = 1 }\nthen = [{ pause = 1 }]": "job.test_kind",
    "if = { rounds = 'three' }\nthen = [{ pause = 1 }]": "job.test_kind",
    "if = { level = { above = 3, below = 2 } }\nthen = [{ pause = 1 }]": "job.signal_bounds",
    "if = { part_ok = true }": "job.choice_empty",
    "if = { part_ok = true }\nthen = []": "job.choice_empty",
    "if = { part_ok = true }\nthen = [{ pause = 1 }]\nelse = []": "job.choice_empty",
    "if = { part_ok = true }\nthen = [{ pause = 1 }]\npause = 1": "job.move_many",
    "if = { part_ok = true }\nthen = [{ pause = 1 }]\ntimeout = 1": "job.no_effect",
    "if = { part_ok = true }\nthen = [{ pose = 1 }]": "job.type",
    "if = { part_ok = true }\nthen = [{ pauze = 1 }]": "job.unknown_key_close",
    "if = { part_ok = true }\nthen = [{ pick = {} }]": "job.missing_key",
    "then = [{ pause = 1 }]\npause = 1": "job.no_effect",
    "while = { part_ok = true }\ndo = [{ pause = 1 }]": "job.loop_endless",
    "while = {}\nrepeat = 2\ndo = [{ pause = 1 }]": "job.test_empty",
    "while = { part_ok = true }\npause = 1": "job.no_effect",
    "wait = { product = 'large' }": "job.type",
    "pose = { position = [1, 1, 0], task = 'position' }\npath = 'line'\nblend = 0.1\n[[move]]\n"
    "if = { part_ok = true }\nthen = [{ pose = { position = [1, 1, 0], task = 'position' }, path = 'line' }]": (
        "job.blend_next"
    ),
}


@pytest.mark.parametrize("move", WRONG)
@pytest.mark.parametrize("language", ["en", "ar"])
def test_wrong_choices_are_named_with_their_line(move, language):
    with pytest.raises(JobError) as caught:
        parse_job(f"{CELL}[[move]]\n{move}\n", "job.toml")
    assert caught.value.key == WRONG[move]
    assert "job.toml:1" in caught.value.message(language)
    assert "{" not in caught.value.message(language).replace("{ part_ok", "").replace("{ above", "")


def test_a_name_is_a_signal_or_a_variable():
    text = CELL.replace("[variables]", "[variables]\npart_ok = true") + CHOICE
    with pytest.raises(JobError) as caught:
        parse_job(text)
    assert caught.value.key == "job.test_both"


def test_lengths_inside_choices_are_in_the_unit_of_the_file():
    move = "{ pose = { position = [1200, 100, 0], task = 'position' }, path = 'line' }"
    text = f"lengths = 'millimetres'\n{CELL}[[move]]\nif = {{ glue = true }}\nthen = [{move}]\nelse = [{move}]\n"
    job = parse_job(text)
    assert [move.pose.position for move in job.move if move.pose is not None] == [(1.2, 0.1, 0.0)] * 2


def test_variables_are_true_or_false_from_the_command_line(tmp_path, capsys):
    path = tmp_path / "job.toml"
    path.write_text(CELL + "[[move]]\nif = { glue = true }\nthen = [{ pause = 1 }]\nelse = [{ pause = 2 }]\n", "utf-8")
    for said, cycle in (("true", 1.0), ("false", 2.0)):
        assert main(["run", str(path), "--dry-run", "--set", f"glue={said}", "--json"]) == 0
        data = json.loads(capsys.readouterr().out)
        assert data["cycle"] == pytest.approx(cycle, abs=2e-3)
        assert data["moves"][0]["choice"]["holds"] is (said == "true")


def test_a_sweep_over_true_and_false_shows_them(tmp_path, capsys):
    path = tmp_path / "job.toml"
    path.write_text(CELL + "[[move]]\nif = { glue = true }\nthen = [{ pause = 1 }]\nelse = [{ pause = 2 }]\n", "utf-8")
    assert main(["sweep", str(path), "glue=true,false"]) == 0
    words = capsys.readouterr().out
    assert "glue = true" in words
    assert " false" in words


GROUPS = """
robot = "planar2r"
[variables]
again = true
[[group.reach]]
joints = [0.3, 0.4]
[[group.reach]]
if = { again = true }
[[group.reach.then]]
name = "far"
joints = [0.5, 0.6]
[[group.twice]]
call = "reach"
repeat = 2
[[move]]
call = "twice"
[[move]]
joints = [0.0, 0.1]
"""


def test_groups_are_made_where_they_are_called():
    job = parse_job(GROUPS, "job.toml")
    assert [move.joints for move in job.move if move.joints] == [(0.3, 0.4), (0.5, 0.6)] * 2 + [(0.0, 0.1)]
    assert [move.name for move in job.move if move.name] == ["far", "far"]
    plan = prepare(job, GROUPS, Path())[1]
    assert [leg.kind for leg in plan.legs if leg.index >= 0] == ["joint", "if", "joint"] * 2 + ["joint"]


@pytest.mark.parametrize(
    ("old", "new", "line", "key"),
    [
        ('call = "reach"', 'call = "twice"', 13, "job.group_circle"),
        ('call = "twice"', 'call = "nothing"', 16, "job.unknown_name"),
        ('call = "twice"', 'call = "twice"\nwhile = { again = true }', None, "job.loop_endless"),
        ("joints = [0.5, 0.6]", "joints = [0.5, 0.6]\npause = 1", None, "job.move_many"),
        ("joints = [0.5, 0.6]", "joints = [0.5, 0.6]\nhold = 1", 12, "job.no_effect"),
    ],
)
def test_wrong_groups_are_refused_with_their_line(old, new, line, key):
    with pytest.raises(JobError) as caught:
        parse_job(GROUPS.replace(old, new, 1), "job.toml")
    assert caught.value.key == key
    assert line is None or f"job.toml:{line}" in str(caught.value)
