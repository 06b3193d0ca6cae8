"""The compiled loops of numerical inverse kinematics: one program for all robots."""

from mafsil.kernels.loop_compiler import LoopProgram

MODULES = ("records", "sample_loops", "search_loops", "pose_loops", "batch_loops")
PROGRAM = LoopProgram(
    [f"mafsil.ik.numerical.{name}" for name in MODULES], ("advance", "clean", "wind", "check", "solve_batch")
)
