"""The page of a design: its numbers are those of the answer, its sheet is the arm, in both languages."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from mafsil.cli.design import design
from mafsil.design import ParametricArm, TaskSet, Tolerances, accuracy, evaluate
from mafsil.errors import InputError
from mafsil.model.dh_from_axes import dh_from_mechanism
from mafsil.report.design_report import write_design
from mafsil.toml_source import read_toml

FILE = Path(__file__).resolve().parents[2] / "examples/design/arm.toml"


def test_the_page_has_every_measure_and_the_arm_again(tmp_path: Path) -> None:
    tables = read_toml(FILE)
    tasks, arm = TaskSet.of(tables["tasks"]), ParametricArm.of(tables["arm"]).at()
    tolerances, judged = Tolerances(**tables["tolerances"]), evaluate(arm, tasks)
    errors = [accuracy(arm, q, tolerances, payload=tasks.payload) for q in judged.q]
    text = write_design(judged, tasks, tmp_path / "design.html", tolerances=tolerances, errors=errors).read_text()
    for name in ("mass", "peak_torque", "deflection", "frequency", "payload"):
        assert f">{judged.measures[name]:.4g} <small>" in text
    assert f"{max(error.rms for error in errors) * 1e3:.4g} mm rms" in text
    for sentence in ("Design of study", "تصميم"):
        assert sentence in text
    # The sheet alone makes the same arm again, up to the digits that are printed.
    cells = [re.sub("<[^>]+>", "", row) for row in re.findall(r"<td[^>]*>(.*?)</td>", text)]
    lengths = [cell for cell in cells if "± 0.05 mm" in cell]
    rows = dh_from_mechanism(arm.robot).rows
    wanted = [f"{1e3 * value:.6g} ± 0.05 mm" for row in rows for value in (row.a, row.d)]
    assert lengths[: len(wanted)] == wanted


def test_the_command_writes_the_page_and_says_what_it_needs(tmp_path: Path) -> None:
    answer = design("report", str(FILE), None, None, None, str(tmp_path / "design.html"))
    assert answer.data["page"] == str(tmp_path / "design.html")
    with pytest.raises(InputError, match="--out"):
        design("report", str(FILE), None, None, None, None)
    data = json.loads(json.dumps(answer.data, default=lambda value: np.asarray(value).tolist()))
    assert data["measures"]["reached"] == 1.0
