"""The compiled loops of grasps, each module loaded when it is first used."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mafsil.solvers import contact_span_loops as contact_span_loops
    from mafsil.solvers import direction_cover_loops as direction_cover_loops
    from mafsil.solvers import disc_loops as disc_loops
    from mafsil.solvers import hull_growth_loops as hull_growth_loops
    from mafsil.solvers import nearest_point_loops as nearest_point_loops
    from mafsil.solvers import positive_span_loops as positive_span_loops
    from mafsil.solvers import ray_loops as ray_loops
else:

    def __getattr__(name: str) -> Any:
        if not name.endswith("_loops"):
            raise AttributeError(name)
        globals()[name] = import_module(f"mafsil.solvers.{name}")
        return globals()[name]
