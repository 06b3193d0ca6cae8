"""Every outcome that a public function returns is an answer: status, sentence, truth, iteration, plain data, table."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from enum import Enum
from functools import cache
from typing import Any, cast

import numpy as np
import pytest

import mafsil as mf
from mafsil import derivation, grasp, ik, mobility, performance
from mafsil.answer import Answer, Status
from mafsil.grasp.closure_methods import closure_by_all_methods
from mafsil.messages import LANGUAGES
from tests.public import public

VALUES = {
    "Bindings": "a part of JerkLimitedMotion",
    "Condition": "a part of ArmStructure",
    "DeterminantFactors": "a formula: it can be evaluated, and explains its factors",
    "Displacement": "a value of geometry in other coordinates: kind, axis, angle, advance",
    "Ellipsoid": "a value: axes and lengths of an ellipsoid",
    "Exercise": "a question of the book; its check answers",
    "Finding": "a part of Report",
    "FrameChoice": "a remark on one frame of a table",
    "FreeBodyDiagram": "a table of wrenches",
    "Grasp": "a description: what is asked about, not what is answered",
    "LimitExcess": "a part of SolutionSet",
    "LocusComponent": "a part of SingularityLocus",
    "NearSingularity": "a part of Track",
    "Online": "a generator of states, cycle by cycle",
    "ProfileTable": "a table of what there is",
    "ArmState": "what a page shows",
    "BranchSwitch": "a part of Track",
    "PoseErrorResponse": "a motion with its measures, one of several that are compared",
    "Violation": "a part of LimitCheck",
}
"""Public classes that explain themselves and answer no question, and what they are instead."""


def _classes() -> dict[str, list[type]]:
    """All classes of the package by name."""
    found: dict[str, list[type]] = {}
    for module in pkgutil.walk_packages(mf.__path__, "mafsil."):
        if ".cli" in module.name or module.name.endswith("__main__"):
            continue
        for name, value in vars(importlib.import_module(module.name)).items():
            if inspect.isclass(value) and value.__module__ == module.name:
                found.setdefault(name, []).append(value)
    return found


def _callables() -> Iterator[tuple[str, Callable[..., Any]]]:
    """Public functions, and methods and properties of public classes."""
    for name, value in public():
        if inspect.isfunction(value):
            yield name, value
        elif inspect.isclass(value) and value.__module__.startswith("mafsil"):
            for member, attribute in vars(value).items():
                function = getattr(attribute, "fget", None) or getattr(attribute, "__func__", attribute)
                if not member.startswith("_") and inspect.isfunction(function):
                    yield f"{name}.{member}", function


def _returned() -> dict[type, str]:
    """Classes of the package in the return annotations of public functions, each with one of these."""
    classes, found = _classes(), dict[type, str]()
    for name, function in _callables():
        annotation = inspect.unwrap(function).__annotations__.get("return", "")
        text = annotation if isinstance(annotation, str) else getattr(annotation, "__name__", "")
        for word in re.findall(r"\w+", text):
            for one in classes.get(word, []):
                found.setdefault(one, name)
    return found


def _is_outcome(one: Any) -> bool:
    """Whether a class has a status or explains itself."""
    fields = set(dir(one)) | set(getattr(one, "__annotations__", ()))
    return (
        bool(fields & {"status", "explain"}) and not issubclass(one, Enum) and not getattr(one, "_is_protocol", False)
    )


def test_outcomes_of_public_functions_are_answers() -> None:
    returned = _returned()
    assert len(returned) > 100, "annotations were not read"
    found = {one.__name__: name for one, name in returned.items() if _is_outcome(one) and not issubclass(one, Answer)}
    assert not {name: where for name, where in found.items() if name not in VALUES}


def test_values_that_explain_themselves_are_still_there() -> None:
    classes = _classes()
    for name in VALUES:
        assert any(_is_outcome(one) and not issubclass(one, Answer) for one in classes[name]), name


PUMA = mf.load("puma560")
ARM = mf.load("ur5e")
IIWA = mf.load("iiwa7")
Q = np.array([0.3, -1.2, 1.1, 0.2, 0.9, -0.4])
Q7 = np.linspace(0.2, 0.8, 7)
T = ARM.forward_kinematics(Q)
FAR = T.copy()
FAR[:3, 3] *= 10.0
CORNERS = [mf.Contact(p, -np.array(p, float), 0.5) for p in ([1, 0], [-1, 0], [0, 1])]
WRENCHES = mf.Grasp(CORNERS).matrix(8)

DELTA = mf.parallel.legs.rotary_delta(0.2, 0.05, 0.3, 0.8)

ANSWERS: dict[str, tuple[Callable[[], Any], bool]] = {
    "tip wrench": (lambda: performance.tip_wrench(ARM, Q, np.ones(6)), True),
    "tip wrenches": (lambda: performance.tip_wrench(PUMA, np.zeros((30, 6)), np.ones(6)), False),
    "singular": (lambda: performance.singularity(PUMA, np.zeros(6)), True),
    "regular": (lambda: performance.singularity(ARM, Q), False),
    "locus": (lambda: performance.singularity_locus(PUMA, samples=8), True),
    "workspace": (lambda: performance.workspace_map(ARM, 2000), True),
    "empty slice": (lambda: performance.workspace_map(ARM, 2000, view="xy", at=50.0, cell=0.1), False),
    "robust": (lambda: grasp.robustness(mf.Grasp(CORNERS), position=0.01, samples=50), True),
    "fragile": (lambda: grasp.robustness(mf.Grasp(CORNERS[:1]), position=0.01, samples=50), False),
    "continued": (lambda: ik.continued_branches(ARM, T), True),
    "structure": (lambda: ik.arm_structure(PUMA), True),
    "no structure": (lambda: ik.arm_structure(ARM), False),
    "annulus": (lambda: ik.planar_reach("planar2r"), True),
    "place": (lambda: ik.planar_reach("planar2r").place([0.5, 0.1, 0.0]), True),
    "far place": (lambda: ik.planar_reach("planar2r").place([50.0, 0.0, 0.0]), False),
    "derivation": (lambda: derivation.derive_fk(mf.load("planar2r").mechanism), True),
    "method": (lambda: closure_by_all_methods(WRENCHES)["dual"], True),
    "open method": (lambda: closure_by_all_methods(WRENCHES[:, :2])["dual"], False),
    "sweep": (lambda: ik.redundancy(IIWA).sweep(IIWA.forward_kinematics(Q7), 64), True),
    "sweeps": (lambda: ik.redundancy(IIWA).sweep(IIWA.forward_kinematics(np.stack([Q7, -Q7])), 8), True),
    "solutions": (lambda: mf.inverse_kinematics(ARM, T), True),
    "no solutions": (lambda: mf.inverse_kinematics(ARM, FAR), False),
    "all solutions": (lambda: mf.inverse_kinematics(ARM, np.stack([T] * 40)), True),
    "mobility": (lambda: mf.mobility("delta"), True),
    "mobility of loops": (lambda: mf.mobility("peaucellier"), True),
    "structure of bars": (lambda: mf.mobility("truss"), False),
    "redundant_constraints": (lambda: mobility.redundant_constraints(mobility.library.peaucellier()), True),
    "assembly": (lambda: mobility.assembly_modes(mobility.library.watt(), {"01": 0.1}), True),
    "curve": (lambda: mobility.trace_motion(mobility.library.four_bar()), True),
    "indices": (lambda: mf.parallel.legs.rod_indices(DELTA, [0, 0, -0.7]), True),
    "poses on rods": (lambda: DELTA.forward_kinematics([0, 0, 0]), True),
    "turn of a crank": (lambda: mobility.linkages.turn_crank(mobility.library.four_bar(), "A", rows=12), True),
    "surface": (lambda: mobility.trace_surface(mobility.library.chain(2)), True),
    "surfaces": (lambda: mobility.configuration_surfaces(mobility.library.chain(2), starts=4), True),
    "four-bar": (lambda: mobility.FourBar(2, 4, 3.5, 4.5).positions([0.1, 0.2]), True),
    "integrability": (lambda: mobility.bodies.Coin(0.1).constraints.integrability, False),
    "points": (lambda: mobility.bodies.count_points([[0, 0], [1, 0], [0, 1]]), True),
    "polygon": (lambda: mobility.spaces.polygon_space([1, 1, 5]), False),
    "synthesis": (lambda: mobility.synthesise_motion([[0, 0, 0], [1, 0.6, 0.3], [2, 0.8, 0.8]]), True),
    "no synthesis": (lambda: mobility.synthesise_motion([[1, 0, 0], [0, 1, np.pi / 2], [-1, 0, np.pi]]), False),
    "candidate": (lambda: mobility.synthesise_motion([[0, 0, 0], [1, 0.6, 0.3], [2, 0.8, 0.8]])[0], True),
    "cognates": (lambda: mobility.synthesis.cognates(mobility.FourBar(1, 2.2, 2, 2.5), 1.4, 0.9), True),
    "spherical": (
        lambda: mobility.synthesis.synthesise_spherical_function([0, 0.5, 1.1], [0.7, 1.1, 1.6], ground=1.2), True),
    "seven joints": (lambda: mf.inverse_kinematics(IIWA, IIWA.forward_kinematics(Q7)), True),
}  # fmt: skip


@cache
def _answer(kind: str) -> Any:
    return ANSWERS[kind][0]()


@pytest.mark.parametrize("kind", ANSWERS)
def test_an_answer_has_the_one_shape(kind: str) -> None:
    answer, good = _answer(kind), ANSWERS[kind][1]
    assert isinstance(answer, Answer)
    answer = cast("Any", answer)
    assert bool(answer) is good
    assert len(list(answer)) == len(answer)
    status = answer.to_dict()["status"]
    assert status == (
        [one.name.lower() for one in np.ravel(answer.status)]
        if isinstance(status, list)
        else answer.status.name.lower()
    )
    lines = answer.explain(language="en").split("\n")
    assert all(lines)
    assert answer.explain(language="ar") != answer.explain(language="en")
    html = answer._repr_html_()
    assert html.count("<div") == len(answer.explain().split("\n"))
    assert html.count("<pre") <= 1, "a table is shown once"


@pytest.mark.parametrize("kind", ANSWERS)
def test_an_answer_explains_every_status_that_it_could_have(kind: str) -> None:
    answer = _answer(kind)
    has = getattr(answer, "__dataclass_fields__", {})
    if "status" not in has or "details" in has or not isinstance(answer.status, Status):
        pytest.skip("its status follows from its numbers, or brings numbers of its own")
    for status in type(answer.status):
        for language in LANGUAGES:
            assert replace(answer, status=status).explain(language)


@pytest.mark.parametrize("kind", ANSWERS)
@pytest.mark.parametrize("language", ["en", "ar"])
def test_what_is_printed_fits_a_screen(kind: str, language: str) -> None:
    mf.language(language)
    try:
        lines = repr(_answer(kind)).split("\n")
    finally:
        mf.language("en")
    isolates = re.compile("[\u2066-\u2069]")
    assert len(lines) <= 25
    assert max(len(isolates.sub("", line)) for line in lines) <= 100


def test_solutions_are_printed_as_a_table() -> None:
    answer: Any = mf.inverse_kinematics(ARM, T)
    rows = repr(answer).split("\n")[-len(answer) :]
    for k, row in enumerate(rows):
        cells = row.split()
        assert cells[:2] == [str(k + 1), str(answer.branches[k])]
        np.testing.assert_allclose([float(x) for x in cells[2:8]], answer.q[k], atol=5e-4)
        assert cells[9] == "within"
