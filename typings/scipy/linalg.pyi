from typing import Any

from numpy.typing import NDArray

def expm(A: NDArray[Any]) -> NDArray[Any]: ...
