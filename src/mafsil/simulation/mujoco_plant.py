"""The same arm moved by MuJoCo: laws, references, pushes and recordings stay as they are."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from mafsil.arrays import Floats, JointVector, Vector6
from mafsil.errors import InputError
from mafsil.model import JointKind
from mafsil.simulation.plant import Plant
from mafsil.simulation.stepping import IMPLICIT_FRICTION, Stepper
from mafsil.solvers.integrate import State, Step
from mafsil.verification.mujoco_peer import MuJoCoArm

METHODS = {"semi_implicit_euler": "mjINT_EULER", IMPLICIT_FRICTION: "mjINT_IMPLICITFAST", "rk4": "mjINT_RK4"}
"""Our names of MuJoCo's integrators."""


@dataclass(frozen=True, eq=False, slots=True)
class MuJoCoPlant(Plant):
    """An arm whose motion MuJoCo computes; everything else is as for `Plant`.

    Viscous friction is MuJoCo's damping, Coulomb friction its dry friction; what the senses differ by, and offsets, are
    constant efforts. Pushes and environments act through J' and are constant over a step.

    Raises:
        InputError: MuJoCo is not installed; the robot has joints that follow others, or helical ones.
    """

    def __post_init__(self) -> None:
        Plant.__post_init__(self)
        if find_spec("mujoco") is None:
            raise InputError("simulation.no_mujoco")
        for joint in self.robot.mechanism.joints:
            if joint.mimic is not None or joint.kind is JointKind.HELICAL:
                raise InputError("simulation.not_for_mujoco", joint=joint.name)

    @property
    def engine(self) -> str:
        """Who computes the motion, and its version, as a recording names it."""
        return f"MuJoCo {import_module('mujoco').__version__}"


class MuJoCoStepper(Stepper):
    """Steps of a plant in MuJoCo; batches one after the other."""

    def __init__(self, plant: Plant, name: str, step: float) -> None:
        super().__init__(plant, name, step)
        if name not in METHODS:
            raise InputError("input.choice", name="integrator", value=name, known=", ".join(METHODS))
        self._arm = MuJoCoArm(plant.robot.mechanism)
        mujoco, model = self._arm.mujoco, self._arm.model
        model.opt.timestep = step
        model.opt.integrator = getattr(mujoco.mjtIntegrator, METHODS[name])
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
        self._constant: Floats = np.zeros(plant.robot.n)
        if plant.has_friction:
            self._add_friction(plant, mujoco, model)

    def _add_friction(self, plant: Plant, mujoco: Any, model: Any) -> None:
        """Coulomb friction of c+ and c- is a dry one of their mean, and a constant effort of half their difference."""
        law, B = plant.friction_law, self._arm.B
        viscous, mean = law.gain.T @ law.viscous, law.gain.T @ ((law.positive + law.negative) / 2.0)
        model.dof_damping[:], model.dof_frictionloss[:] = B @ viscous, B @ mean
        model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        self._constant = law.gain.T @ (law.offset + (law.positive - law.negative) / 2.0)

    def move(self) -> Step:
        """The step as a function of (t, state, h)."""
        return self._step

    def _step(self, t: float, state: State, h: float) -> State:
        q, qd = state
        applied = self._applied_efforts(q, qd, self.effort, self.push)
        arm, (rows, rates) = self._arm, (np.array(part, dtype=np.float64).reshape(-1, q.shape[-1]) for part in state)
        for k, effort in enumerate(applied.reshape(rows.shape)):
            self._write(rows[k], rates[k], effort)
            arm.mujoco.mj_step(arm.model, arm.data)
            rows[k], rates[k] = arm.B.T @ (arm.data.qpos - arm.b), arm.B.T @ arm.data.qvel
        return rows.reshape(q.shape), rates.reshape(q.shape)

    def acceleration(self, q: JointVector, qd: JointVector, effort: JointVector, push: Vector6 | None) -> JointVector:
        """qdd (*batch, n) that MuJoCo finds at a state, dry friction included."""
        applied, found, arm = self._applied_efforts(q, qd, effort, push), np.empty(q.shape), self._arm
        n = q.shape[-1]
        rows = zip(*(part.reshape(-1, n) for part in (q, qd, applied, found)), strict=True)
        for position, rate, force, out in rows:
            self._write(position, rate, force)
            arm.mujoco.mj_forward(arm.model, arm.data)
            out[:] = arm.B.T @ arm.data.qacc
        return found

    def _applied_efforts(
        self, q: JointVector, qd: JointVector, effort: JointVector, push: Vector6 | None
    ) -> JointVector:
        """Efforts (*batch, n) of motors and world together."""
        push = self.plant.tip_push(q, qd, push)
        applied = np.broadcast_to(effort - self._constant, q.shape)
        if push is None:
            return applied
        J = self.plant.robot.jacobian_body(q)
        return applied + (np.swapaxes(J, -1, -2) @ push[..., None])[..., 0]

    def _write(self, q: JointVector, qd: JointVector, effort: JointVector) -> None:
        arm = self._arm
        arm.data.qpos[:], arm.data.qvel[:] = arm.B @ q + arm.b, arm.B @ qd
        arm.data.qfrc_applied[:] = arm.B @ effort
