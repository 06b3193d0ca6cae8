"""What a command's robot is, carries and holds: `--model`, `--base`, `--lock`, `--tool` and so on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import pi
from os import PathLike
from typing import Any

import numpy as np

from mafsil.arrays import frozen
from mafsil.cli.motion_input import typed_pose
from mafsil.cli.registry import ROBOT_OPTIONS
from mafsil.cli.state import coordinate, number
from mafsil.errors import InputError
from mafsil.model import JointKind, Mechanism
from mafsil.model.loading import RobotFile


def equip_robot(robot: str, given: dict[str, Any]) -> str | PathLike[str]:
    """The robot with what the options say; these are taken out of the arguments of the command.

    Args:
        robot: name or file.
        given: arguments of the command by name.

    Raises:
        InputError: a word that is no `name=value`, or no number.
    """
    options = [given.pop(f"robot_{option.name}", None) for option in ROBOT_OPTIONS]
    if all(option is None for option in options):
        return robot
    locks, tool, payload, xacro, model, base, gravity = options
    degrees = bool(given.get("degrees"))
    locked = {name: _coordinate(name, word) for name, word in _pairs(locks or (), "cli.lock_word")}
    mass = 0.0 if payload is None else number("payload", payload)
    T_sb = None if base is None else frozen(typed_pose("base", base, degrees=degrees))
    g = None if gravity is None else np.array([number("gravity", word) for word in gravity])
    T_tool = None if tool is None else typed_pose("tool", tool, degrees=degrees)

    def equip(mechanism: Mechanism) -> Mechanism:
        ready = mechanism.with_locked_joints(_in_radians(locked, mechanism, degrees=degrees)) if locked else mechanism
        ready = ready if T_sb is None else replace(ready, T_sb=T_sb)
        ready = ready if g is None else ready.with_gravity(g)
        ready = ready if T_tool is None else ready.with_tool(T_tool)
        return ready.with_payload(mass) if payload is not None else ready

    return RobotFile(robot, dict(_pairs(xacro or (), "cli.xacro_word")), equip, model)


def _coordinate(name: str, word: str) -> tuple[float, bool]:
    return coordinate(f"lock[{name}]", word)


def _in_radians(locked: Mapping[str, tuple[float, bool]], mechanism: Mechanism, *, degrees: bool) -> dict[str, float]:
    """Coordinates of locked joints; bare numbers of those that turn are degrees, where that is said."""
    kinds = {joint.name: joint.kind for joint in mechanism.joints}
    return {
        name: value * pi / 180 if degrees and not marked and kinds.get(name) is not JointKind.PRISMATIC else value
        for name, (value, marked) in locked.items()
    }


def _pairs(words: list[str] | tuple[()], key: str) -> list[tuple[str, str]]:
    """Names and values of words `name:=value` or `name=value`."""
    pairs: list[tuple[str, str]] = []
    for word in words:
        name, sign, value = word.partition(":=") if ":=" in word else word.partition("=")
        if not sign or not name.strip():
            raise InputError(key, word=word)
        pairs.append((name.strip(), value))
    return pairs
