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

class cKDTree:
    def __init__(self, data: NDArray[np.float64], *, boxsize: NDArray[np.float64] | None = ...) -> None: ...
    def query_ball_point(self, x: NDArray[np.float64], r: float | NDArray[np.float64]) -> NDArray[np.object_]: ...
    def query(self, x: NDArray[np.float64], k: list[int]) -> tuple[NDArray[np.float64], NDArray[np.intp]]: ...
