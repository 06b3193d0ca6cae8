"""Exported laws: the function in C gives the efforts of the law, call after call, to the last bits."""

from __future__ import annotations

import subprocess
from functools import cache

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import (
    combine,
    computed_torque,
    export_law,
    feedforward,
    gravity_compensation,
    model_predictive,
    pid,
    saturate,
)
from mafsil.control.laws.law_export import law_kernel
from mafsil.errors import InputError
from mafsil.kernels.export.exported import compiler, trial
from mafsil.mechanics.loop_terms import Term
from mafsil.trajectory import Motion

CC = compiler()
needs_compiler = pytest.mark.skipif(CC is None, reason="no C compiler")


@cache
def robot(name):
    return mf.load(name)


def laws(arm):
    return {
        "computed_torque": computed_torque(arm, natural_frequency=15.0, integral=20.0),
        "pd_gravity": gravity_compensation(arm, 120.0, 15.0),
        "pid": pid(arm.n, 120.0, 15.0, 30.0),
        "waiting": gravity_compensation(arm, 120.0, 15.0, 9e4, effort_limit=np.resize([60.0, np.inf, 9.0], arm.n)),
        "sum": combine(feedforward(arm), pid(arm.n, 90.0, 9.0, 5.0)),
    }


@needs_compiler
@pytest.mark.parametrize("name", ["puma560", "panda"])
@pytest.mark.parametrize("law", ["computed_torque", "pd_gravity", "pid", "sum"])
def test_the_c_function_is_the_law(name, law, tmp_path):
    arm = robot(name)
    found = trial(export_law(arm, laws(arm)[law], to="c", function="law"), CC)
    assert found.ok, found.said


@needs_compiler
@pytest.mark.parametrize("law", ["computed_torque", "sum", "waiting"])
def test_a_run_in_c_is_the_run_of_the_session(law, tmp_path):
    """Fifty calls with the memory handed on, beside the law's own session in Python, to 1e-12 of the largest effort."""
    arm, period = robot("puma560"), 2e-3
    chosen = laws(arm)[law]
    files = export_law(arm, chosen, period=period, function="law")
    files.write(tmp_path)
    rng = np.random.default_rng(3)
    rows = rng.normal(size=(50, 5, 6))
    inputs = ",".join(x.hex() for x in rows.ravel())
    # The order of the arguments is that of the header: q, qd, reference, integral, then the outputs.
    (tmp_path / "main.c").write_text(f"""
#include <stdio.h>
#include "law.h"
static const double rows[] = {{{inputs}}};
int main(void) {{
    double integral[6] = {{0}}, effort[6];
    for (int k = 0; k < 50; k++) {{
        const double *row = rows + 30 * k;
        law(row, row + 6, row + 12, integral, effort, integral);
        for (int i = 0; i < 6; i++) printf("%.17g ", effort[i]);
    }}
    return 0;
}}
""")
    program = tmp_path / "run"
    subprocess.run([CC, "-std=c99", "-O2", "main.c", "law.c", "-o", str(program), "-lm"], cwd=tmp_path, check=True)
    there = np.array(subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout.split(), float)
    session = chosen.session(period)
    here = [
        saturate(session(k * period, q, qd, Motion(u, v, a)), arm.limits.effort)
        for k, (q, qd, u, v, a) in enumerate(rows)
    ]
    assert np.allclose(there.reshape(50, 6), here, rtol=0, atol=1e-12 * np.abs(here).max())


def test_gains_may_be_inputs():
    arm = robot("puma560")
    kernel = law_kernel(arm, (Term("computed_torque", arm.mechanism),), None, integrates=False, saturate=False)
    rng = np.random.default_rng(1)
    q, qd, u, v, a = rng.normal(size=(5, 6))
    law = computed_torque(arm, natural_frequency=12.0, friction=False)
    gains = np.stack([law.gains.kp, law.gains.kd, law.gains.ki])[None]
    given = {"q": q, "qd": qd, "reference": np.stack([u, v, a]), "gains": gains}
    effort = kernel(*(given[port.name] for port in kernel.signature.inputs))
    assert np.allclose(effort, law(0.0, q, qd, Motion(u, v, a)), rtol=1e-12)


def test_what_is_no_expression_is_refused():
    arm = robot("puma560")
    with pytest.raises(InputError, match=r"ModelPredictive .*not plain arithmetic"):
        export_law(arm, model_predictive(arm))
    with pytest.raises(InputError, match="period"):
        export_law(arm, computed_torque(arm), period=0.0)
    with pytest.raises(InputError, match="name"):
        export_law(arm, computed_torque(arm), function="int")


def test_files_say_what_they_are():
    arm = robot("puma560")
    found = export_law(arm, computed_torque(arm, integral=10.0), period=5e-4, real="float")
    head = found.files[f"{found.name}.h"].decode()
    assert "computed torque" in head
    assert "0.0005 s" in head
    assert "memory" in head
    code = found.files[f"{found.name}.c"].decode()
    assert "malloc" not in code
    assert "for (" not in code
    assert export_law(arm, pid(6, 1.0), to="wasm").details["bytes"] > 100
