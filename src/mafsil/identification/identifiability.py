"""Identifiability: parameters that no motion excites, that act only in combinations, that a log does not excite."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.identification.consistency import Parameterisation
from mafsil.identification.regression import Fit
from mafsil.identification.remark import Remark
from mafsil.identification.tolerances import ALONE
from mafsil.identification.torque_model import TorqueModel
from mafsil.mechanics.inertial_parameters import BaseParameters


@dataclass(frozen=True, slots=True)
class Unidentifiable:
    """Parameters that the data cannot identify.

    Attributes:
        labels: their names, such as `link1.m`.
        reason: `never` (no motion of this robot excites them), `combination` (they act only in linear combinations
            with others) or `log` (this log does not excite them).
        remark: the sentence.
    """

    labels: tuple[str, ...]
    reason: str
    remark: Remark

    def sentence(self, language: str | None = None) -> str:
        """What cannot be identified, and why."""
        return self.remark.sentence(language)


def unidentifiable(
    model: TorqueModel, base: BaseParameters, fit: Fit, b0: Floats, parameterisation: Parameterisation
) -> tuple[Unidentifiable, ...]:
    """All that cannot be identified, link by link and joint by joint.

    Args:
        model: names of all parameters.
        base: the base parameters.
        fit: of this log.
        b0: (k,) base parameters of before.
        parameterisation: the prior.
    """
    return (*_structural(model, base, parameterisation), *_by_this_log(base, fit, parameterisation))


def _structural(model: TorqueModel, base: BaseParameters, parameterisation: Parameterisation) -> list[Unidentifiable]:
    """What no motion shows at all, and what shows only in sums."""
    K = base.combination
    basis = np.linalg.svd(K, full_matrices=False)[2]
    alone = 1.0 - (basis**2).sum(axis=0) < ALONE
    shows = np.abs(K).max(axis=0, initial=0.0) > 0.0
    rotors_known = not parameterisation.scale[-model.rotor_count :].any()
    never, combined = dict[str, list[str]](), dict[str, list[str]]()
    for k, label in enumerate(model.labels):
        if rotors_known and k >= len(model.labels) - model.rotor_count:
            continue
        part = label.rpartition(".")[0]
        if not shows[k]:
            never.setdefault(part, []).append(label)
        elif not alone[k]:
            combined.setdefault(part, []).append(label)
    return [
        *(_group("never", part, tuple(labels)) for part, labels in never.items()),
        *(_group("combination", part, tuple(labels)) for part, labels in combined.items()),
    ]


def _group(reason: str, part: str, labels: tuple[str, ...]) -> Unidentifiable:
    key = f"identification.{reason}_all" if len(labels) == 10 else f"identification.{reason}"
    words = [Remark(f"identification.word_{label.rpartition('.')[2].lower()}") for label in labels]
    details: dict[str, object] = {"part": part, "names": _list(words)}
    return Unidentifiable(labels, reason, Remark(key, details))


def _by_this_log(base: BaseParameters, fit: Fit, parameterisation: Parameterisation) -> list[Unidentifiable]:
    """Base parameters whose standard error is no smaller than that of the prior."""
    spread = base.combination @ parameterisation.at(np.zeros(parameterisation.size))[1]
    before = np.sqrt((spread**2).sum(axis=1))
    found: dict[str, list[str]] = {}
    for label, error, size in zip(base.labels, fit.standard_errors, before, strict=True):
        if error > 0.7 * size:
            part = label.rpartition(".")[0]
            found.setdefault(part, []).append(label)
    return [_group("log", part, tuple(labels)) for part, labels in found.items()]


def _list(words: list[Remark]) -> Remark:
    """Words one after the other, as one remark."""
    first, *rest = words
    for word in rest:
        first = Remark("identification.and", {"first": first, "second": word})
    return first
