"""Plausibility of robot descriptions: units, mirror images, centres of mass, inertias, limits, each with its repair."""

from mafsil.model.lint.catalogue import FAULTS as FAULTS
from mafsil.model.lint.linting import findings as findings
from mafsil.model.lint.linting import lint as lint
from mafsil.model.lint.linting import mend as mend
