from mafsil.kernels.loops.entry import Held as Held
from mafsil.kernels.loops.entry import open_held as open_held
from mafsil.kernels.loops.loop import compiled as compiled
from mafsil.kernels.loops.loop import hold as hold
from mafsil.kernels.loops.loop import inlined as inlined
from mafsil.kernels.loops.loop import reordered as reordered
