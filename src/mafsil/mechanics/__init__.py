"""Every algorithm of a mechanism once, as an expression; `quantities` holds the table of them.

call      no public face: `mafsil.robot` calls its quantities
computed  `quantity` and `catalogue` declare them, `quantities` holds their builders over `body_tree`,
          `composite_motion`, `articulated_body`; `closed_form.decision` solves poses
compiled  everything by `mafsil.kernels`, once for each robot
tested    tests/mechanics, tests/laws, tests/reliability/random_trees.py
"""

__all__ = ()
