"""One run of an arm that meets rigid surfaces: the general loop, and what the surfaces did at each tick."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mafsil.arrays import Floats, JointVector, Vector6
from mafsil.control.contact import tip_wrench_of
from mafsil.control.contact.tip_sensor import measured_by
from mafsil.simulation.recording import SimulationStatus
from mafsil.simulation.rigid_plant import RigidPlant
from mafsil.simulation.rigid_stepper import RigidStepper
from mafsil.simulation.run import Progress, Run
from mafsil.simulation.scenario import Scenario

if TYPE_CHECKING:
    from mafsil.control import Law
    from mafsil.trajectory import Motion


class RigidRun(Run):
    """The run of a `RigidPlant`."""

    def __init__(self, scenario: Scenario) -> None:
        super().__init__(scenario)
        assert isinstance(scenario.true_plant, RigidPlant)
        self.plant = scenario.true_plant
        self.held: list[tuple[int, ...]] = [()] * len(self.t)
        self._now = self.start
        self._contacts.begin(*self.start)

    @property
    def _contacts(self) -> RigidStepper:
        assert isinstance(self.stepper, RigidStepper)
        return self.stepper

    def to_the_end(self, progress: Progress | None) -> SimulationStatus:
        """The loop, in which sensors at the tip read what the surfaces exert."""
        with measured_by(self._tip_wrench):
            return super().to_the_end(progress)

    def _command(self, law: Law, k: int, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """What the law asks for; what its sensors read is of the state as it is."""
        self._now = q, qd
        return super()._command(law, k, t, q, qd, reference)

    def _tip_wrench(self) -> Vector6:
        """(6,) what acts on the tip at the present tick, under the efforts of the one before; zero at the first."""
        wrench, (q, qd) = np.zeros(6), self._now
        if self.tick and self._contacts.touching:
            effort, push = self.tau[self.tick - 1], self.pushes[self.tick - 1]
            wrench = self._contacts.force(q, qd, effort, push, self._contacts.touching)[1]
        environment = self.plant.environment
        return wrench if environment is None else wrench + tip_wrench_of(self.plant.robot, environment, q, qd)

    def _acting(self, k: int, command: JointVector) -> JointVector:
        """The command; at each tick it is noted on what the tip is held."""
        self.held[k] = self._contacts.touching
        return command

    def _contact(self, kept: slice, q: Floats, qd: Floats, tau: Floats) -> Floats:
        """(k, 6) what the surfaces and the environment exert on the tip."""
        wrench = self._contacts.forces(q, qd, tau, self._pushes(kept), self.held[kept])[1]
        environment = self.plant.environment
        return wrench if environment is None else wrench + tip_wrench_of(self.plant.robot, environment, q, qd)

    def _accelerations(self, kept: slice, q: Floats, qd: Floats, tau: Floats) -> Floats:
        return self._contacts.forces(q, qd, tau, self._pushes(kept), self.held[kept])[0]

    def metadata(self) -> dict[str, object]:
        """What one needs to know besides the numbers, with what the surfaces did so far."""
        return super().metadata() | {"rigid_contact": self._contacts.events.to_dict()}
