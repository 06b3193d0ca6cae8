from mafsil.kernels.loop_compiler.interface import Singles as Singles
from mafsil.kernels.loop_compiler.interface import Whole as Whole
from mafsil.kernels.loop_compiler.interface import address as address
from mafsil.kernels.loop_compiler.interface import run_kernel as run_kernel
from mafsil.kernels.loop_compiler.program import LoopProgram as LoopProgram
from mafsil.kernels.loop_compiler.records import Record as Record
from mafsil.kernels.loop_compiler.records import Rows as Rows
