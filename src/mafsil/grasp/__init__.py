"""Grasp statics: contacts, force and form closure with certificates, contact forces, quality and synthesis.

call      mf.Grasp(contacts).closure(), .forces(), .quality(); mafsil grasp
computed  `grasp` gathers contacts, `closure` decides with a certificate, `forces` solves the cone programme,
          `planner` proposes fingers on a body
compiled  `loops` and the spans of `mafsil.solvers`
tested    tests/grasp, tests/reliability/grasps.py
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
