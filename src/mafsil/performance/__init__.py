"""Velocity kinematics, statics, singularities, dexterity and workspace of arms: five packages, every name here too.

call      robot.singularity, robot.workspace; mf.performance.manipulability, payload, tip_wrench
computed  `singularities.singular_configuration`, `singularities.locus`, `dexterity.manipulability`,
          `workspace.maps`, `statics.payload`
tested    tests/performance
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
