"""SDFormat files of ours as Drake, with libsdformat, reads them: tip pose, mass matrix, gravity and bias."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from mafsil.arrays import Floats
from mafsil.model import Mechanism
from tests.model.peer_readers import Motion, spread_of

parsing = pytest.importorskip("pydrake.multibody.parsing", reason="Drake is not installed")
plants = pytest.importorskip("pydrake.multibody.plant")
OWN = "{https://github.com/mafsil/mafsil}"


def plant_of(text: str, gravity: Floats | None = None) -> Any:
    """The one model of a text."""
    plant = plants.MultibodyPlant(0.0)
    parsing.Parser(plant).AddModelsFromString(text, "sdf")
    if gravity is not None:
        plant.mutable_gravity_field().set_gravity_vector(gravity)
    plant.Finalize()
    return plant


def warnings_of(text: str) -> list[str]:
    """What is said of a text but for the gravity of a world, which Drake passes over."""
    said: list[str] = []
    catcher = logging.Handler()
    catcher.emit = lambda record: said.append(record.getMessage())
    logger = logging.getLogger("drake")
    logger.addHandler(catcher)
    try:
        plant_of(text)
    finally:
        logger.removeHandler(catcher)
    return [line for line in said if "unsupported SDFormat element in world: gravity" not in line]


def by_drake(mechanism: Mechanism, text: str) -> Callable[[Floats, Floats], Motion]:
    """libsdformat's parser and Drake's algorithms; the gravity of a world is set after."""
    root = ElementTree.fromstring(text)
    gravity = root.findtext("./world/gravity")
    plant = plant_of(text, None if gravity is None else np.array(gravity.split(), float))
    context = plant.CreateDefaultContext()
    moving = [joint for joint in mechanism.joints if joint.moves]
    names = {each.get(f"{OWN}name", each.get("name")): each.get("name") for each in root.iter("joint")}
    joints = [plant.GetJointByName(names[joint.name]) for joint in moving]
    at, q_at = [joint.velocity_start() for joint in joints], [joint.position_start() for joint in joints]
    assert sorted(at) == list(range(plant.num_velocities()))
    spread, shift = spread_of(mechanism, moving)
    tip = next(str(frame.get("name")) for frame in root.iter("frame") if frame.get(f"{OWN}tip"))

    def motion(q: Floats, qd: Floats) -> Motion:
        x, xd = np.zeros(plant.num_positions()), np.zeros(plant.num_velocities())
        x[q_at], xd[at] = spread @ q + shift, spread @ qd
        plant.SetPositions(context, x)
        plant.SetVelocities(context, xd)
        g = -plant.CalcGravityGeneralizedForces(context)[at]
        bias = plant.CalcBiasTerm(context)[at] + g
        M = plant.CalcMassMatrix(context)[np.ix_(at, at)]
        T = plant.GetFrameByName(tip).CalcPoseInWorld(context).GetAsMatrix4()
        return Motion(T, spread.T @ M @ spread, spread.T @ g, spread.T @ bias)

    return motion
