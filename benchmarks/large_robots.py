"""Robots of 30 joints and more for the benchmarks: a random tree, a chain, and Talos from a published file."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

import mafsil as mf
from mafsil.model import Mechanism
from tests.oracles.random_tree import branched_tree, serial_chain


def large_robot(name: str) -> Mechanism | None:
    """`tree30`, `chain30` or `talos` (32 joints, from the package example-robot-data); None for another name."""
    match name:
        case "tree30":
            return branched_tree(30, np.random.default_rng(30))
        case "chain30":
            return serial_chain(30, np.random.default_rng(30))
        case "talos":
            return _talos()
        case _:
            return None


def _talos() -> Mechanism:
    import pinocchio

    share = Path(pinocchio.__file__).parents[4] / "share/example-robot-data/robots"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return mf.load(share / "talos_data/robots/talos_reduced.urdf").mechanism
