"""A true answer keeps what its truth says: recomputed from its own numbers, over lengths and times of many decades.

`python -m tests.reliability.test_good_answers --problems 1000` draws more.
"""

from __future__ import annotations

import argparse
import ast
import inspect
import re
import typing
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from mafsil.geometry.values.value import Value
from tests.public import faces
from tests.reliability.good import arms, mechanisms, searches
from tests.sizes import size

ROWS = {**arms.ROWS, **mechanisms.ROWS, **searches.ROWS}

ELSEWHERE = {
    "tests/book": "Assessment Erratum",
    "tests/cli": "ResultsComparison",
    "tests/collision": "CollisionCheck Clearance PathCheck",
    "tests/control": (
        "ElasticRun Selection JointCoupling SetPointCondition EstimatedConstraint GainReport "
        "EnergyCertificate SlidingCertificate Interaction RenderedImpedance Suitability"
    ),
    "tests/derivation": "Derivation Review",
    "tests/design": "Accuracy Allocation DriveChoice Evaluation Front PayloadMap ReachMap",
    "tests/grasp": "GraspQuality SecondOrderClosure MethodResult GraspPlan Robustness",
    "tests/identification": "Identification Payload",
    "tests/ik": "ParametricSolutions Place Continuation PlanarReach ArmStructure",
    "tests/job": "LawBench",
    "tests/lint": "Report",
    "tests/mobility": (
        "IntegrabilityAnswer Candidate FourBarPositions SliderCrankPositions Actuation ConfigurationCurves "
        "Existence GrueblerCount InstantaneousMobility PolygonSpace RedundantConstraints Mobility Structure "
        "ConfigurationSurface ConfigurationSurfaces CrankTurn LinkageLoads"
    ),
    "tests/one_joint": (
        "Bandwidth Deadlines Holding StiffnessCommand Braking TransmissionAnswer DriveSizing StickSlip "
        "JointRun Margins DriveAnswer ResponseMeasures RootLocus SampledStability RateSweep RestError "
        "WallContact"
    ),
    "tests/parallel": (
        "ActuatorEfforts Certificate ClosedAccelerations ClosedConfigurations ForwardPoses LoopSingularities "
        "MotorAngles PlanarPoses PlatformPoints SingularKinds ThreeRPSModes CableClosure CableWorkspace "
        "ClosedMotion LegBranches LegModes PlatformWorkspace RodPoses RodIndices GeometricCalibration"
    ),
    "tests/performance": "Singularity SingularityLocus VirtualWork WorkspaceMap",
    "tests/planning": "BasePlacement FieldPath ApproachPlan PlannerBench",
    "tests/reliability": (
        "JerkLimitedBatch ViaMotion TimeOptimalBatch ArmPlan ArmsMotion CoordinatedPlan Separation "
        "ClosureBatch WrenchClosureBatch FiniteMobility Stability Run LimitCheck LimitProof"
    ),
    "tests/acceptance": "PointCount",
    "tests/simulation": "HybridCertificate ForwardMotion InverseMotion Recording LearningRun MonteCarlo FreeBodyMotion",
    "tests/trajectory": (
        "TickReport Continuity PathDiagnosis PathReach PathRemedies Diagnosis TrajectoryFile "
        "ProfileComparison RequirementCheck RouteComparison PathPoints"
    ),
    "tests/verification": "Verification",
}
"""Where the other answers are held against an independent source: tests that assert something of calls which return
them; rows of reliability count instead."""
NO_CLAIM = {"Expression", "Refusal", "Figure", "Example", "Remark", "SectionPage"}
"""Truths that say nothing of a number."""


def answers() -> dict[str, set[str]]:
    """Classes with a truth that public functions, methods and properties return, and the names of these."""
    found: dict[str, set[str]] = {}
    for face in faces():
        for name in face.__all__:
            each = getattr(face, name)
            if inspect.isfunction(each):
                note(found, name, each)
            elif inspect.isclass(each) and each.__module__.startswith("mafsil"):
                for member in dir(each):
                    note(found, member, inspect.getattr_static(each, member))
    return found


def note(found: dict[str, set[str]], name: str, member: object) -> None:
    """Add the classes with a truth that a function, method or property returns.

    Args:
        found: added to.
        name: of the member; private ones are left out.
        member: as it stands in its class or module.
    """
    function = getattr(member, "fget", None) or getattr(member, "func", None) or getattr(member, "__func__", member)
    if name.startswith("_") or not inspect.isfunction(function):
        return
    try:  # The return alone: arguments may name what is imported for type checkers only.
        own = inspect.unwrap(function)
        returned = eval(str(own.__annotations__.get("return")), own.__globals__)
    except NameError:
        return
    for kind in (returned, *typing.get_args(returned)):
        claims = inspect.isclass(kind) and "__bool__" in dir(kind) and not issubclass(kind, Value)
        if claims and kind.__module__.startswith("mafsil"):
            found.setdefault(kind.__name__, set()).add(name)


@cache
def asserting(folder: str) -> str:
    """The functions of a folder of tests that assert something, as text."""
    found: list[str] = []
    for path in (Path(__file__).resolve().parents[2] / folder).rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        lines = text.splitlines()
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef):
                body = "\n".join(lines[node.lineno - 1 : node.end_lineno])
                if folder == "tests/reliability" or re.search(r"\bassert(_\w+)?\b", body):
                    found.append(body)
    return "\n".join(found)


def work(row: str, problems: int, seed: int = 0) -> dict[str, float]:
    """How many answers of a row were true, and how many of those lack more than is allowed."""
    counts = {"answers": 0, "true": 0, "bad": 0}
    for k in range(seed, seed + problems):
        rng = np.random.default_rng(k)
        for good, lacks in ROWS[row](rng, float(rng.choice([1e-3, 1.0, 1e3]))):
            counts["answers"] += 1
            counts["true"] += good
            counts["bad"] += good and not lacks <= 1.0
    return counts


@pytest.mark.parametrize("row", ROWS)
def test_what_is_called_good_is_good(row):
    counts = work(row, size(9, 90))
    assert counts["bad"] == 0
    assert counts["true"] > 0


def test_every_answer_with_a_truth_is_recomputed_somewhere():
    rows = set(re.findall(r"[A-Z]\w+", " ".join(ROWS)))
    elsewhere = {name: folder for folder, names in ELSEWHERE.items() for name in names.split()}
    known = answers()
    assert not set(elsewhere) - set(known)
    for name, functions in known.items():
        if name in rows | NO_CLAIM:
            continue
        names = "|".join(map(re.escape, functions))
        calls = re.compile(rf"\b({names})\(|\.({names})\b")
        assert calls.search(asserting(elsewhere[name])), name


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--problems", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    for title in ROWS:
        print(title, work(title, chosen.problems, chosen.seed))
