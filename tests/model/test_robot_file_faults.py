"""Every fault of the catalogue is raised by a file of the tables, and says itself in both languages."""

from __future__ import annotations

import string

import pytest

from mafsil.messages import keys, template
from mafsil.model import mjcf, sdf, urdf
from mafsil.model.faults import FAULTS
from mafsil.model.xacro import expansion
from tests.model.mjcf.hostile_models import CASES as MJCF_CASES
from tests.model.sdf.test_sdf import HOSTILE as SDF_CASES
from tests.model.urdf.hostile_files import CASES as URDF_CASES
from tests.model.xacro.hostile_xacros import CASES as XACRO_CASES

ELSEWHERE = {
    "F0101",
    "F0102",
    "F0103",
    "M0704",
    "F0138",
    "F0142",
    "X1114",
    "X1119",
    "X1121",
    "D1205",
    "D1207",
    "D1215",
    "T1301",
    "M0723",
    "M0727",
}
"""Faults of files on disk and of loops, raised in test_robot_file_source.py, test_hostile_models.py, test_xacro.py,
test_sdf.py, test_worlds_and_computed_masses.py and test_mjcf_loops.py."""


def test_every_fault_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(expansion, "STEPS", 100_000)  # Files that never end are expanded for seconds elsewhere.
    raised = {code for case in URDF_CASES for code in urdf.diagnose(case.data).codes}
    raised |= {code for case in MJCF_CASES for code in mjcf.diagnose(case.data).codes}
    raised |= {code for case in XACRO_CASES for code in urdf.diagnose(case.data).codes}
    raised |= {code for text in SDF_CASES.values() for code in sdf.diagnose(text).codes}
    assert raised | ELSEWHERE == set(FAULTS)


def test_every_fault_has_its_sentence_and_no_sentence_is_left_over() -> None:
    named = {fault.key.partition(".")[2] for fault in FAULTS.values()}
    for language in ("en", "ar"):
        others = {key for key in keys(language, "robotfile") if not key.startswith("repair_")}
        assert others == named | {"refused", "perhaps"}
        for key in named:
            assert list(string.Formatter().parse(template(f"robotfile.{key}", language)))
