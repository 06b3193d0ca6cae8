"""`mafsil ik`: tables for people, JSON for machines, refusals with reasons."""

from __future__ import annotations

import json

import numpy as np
import pytest

import mafsil as mf
from mafsil.cli.main import main

POSE = ["0.4", "0.1", "0.3", "180", "0", "90"]


def test_all_solutions_as_json(capsys):
    assert main(["ik", "ur5e", "--pose", *POSE, "--degrees", "--all", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["status"] == "solved"
    assert data["complete"]
    assert len(data["solutions"]) == 8
    robot = mf.load("ur5e")
    for solution in data["solutions"]:
        T = robot.forward_kinematics(np.array(solution["q"]))
        np.testing.assert_allclose(T, data["pose"], atol=1e-9)


@pytest.mark.parametrize("language", ["en", "ar"])
def test_tables_and_refusals(capsys, language):
    assert main(["ik", "ur5e", "--pose", *POSE, "--degrees", "--lang", language]) == 0
    assert "°" in capsys.readouterr().out
    assert main(["ik", "ur5e", "--pose", "5", "0", "0", "--lang", language]) == 1
    assert capsys.readouterr().err
    assert main(["ik", "ur5e", "--pose", "5", "0", "--lang", language]) == 2
    assert capsys.readouterr().err
