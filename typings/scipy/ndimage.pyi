from typing import Any

import numpy as np
from numpy.typing import NDArray

def label(input: NDArray[Any], structure: NDArray[Any] | None = ...) -> tuple[NDArray[np.int32], int]: ...
