"""The compiled loops of numerical inverse kinematics: one program for all robots."""

from mafsil.kernels.loop_compiler import LoopProgram

PROGRAM = LoopProgram(
    [f"mafsil.ik.numerical.{name}_loops" for name in ("start", "search", "pose", "block")],
    ("advance", "clean", "wind", "verdict", "block"),
)
