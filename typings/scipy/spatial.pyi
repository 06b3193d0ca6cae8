import numpy as np
from numpy.typing import NDArray

class QhullError(RuntimeError): ...

class ConvexHull:
    vertices: NDArray[np.int32]
    simplices: NDArray[np.int32]
    neighbors: NDArray[np.int32]
    equations: NDArray[np.float64]
    points: NDArray[np.float64]
    volume: float
    area: float
    def __init__(
        self, points: NDArray[np.float64], incremental: bool = ..., qhull_options: str | None = ...
    ) -> None: ...

class HalfspaceIntersection:
    intersections: NDArray[np.float64]
    def __init__(self, halfspaces: NDArray[np.float64], interior_point: NDArray[np.float64]) -> None: ...
