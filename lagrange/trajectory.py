"""What a forward solution gives: motion, forces, energies and works at the stored samples."""

from dataclasses import dataclass

import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.raceway_laws import ContactLaws


@dataclass(frozen=True, kw_only=True)
class Trajectory:
    """A forward solution. SI; (n_times,) unless said, (n_times, n_rollers) for the rolling elements."""

    bearing: Bearing
    operation: Operation
    laws: ContactLaws
    time: np.ndarray
    inner_x: np.ndarray
    inner_y: np.ndarray
    inner_vx: np.ndarray
    inner_vy: np.ndarray
    inner_ax: np.ndarray
    inner_ay: np.ndarray
    roller_rho: np.ndarray  # (n_times, n_rollers)
    roller_theta: np.ndarray  # rad, unwrapped
    roller_rho_rate: np.ndarray
    roller_theta_rate: np.ndarray
    roller_spin: float  # rad/s, from kinematics
    inner_force: np.ndarray  # (n_times, n_rollers), N, >= 0
    outer_force: np.ndarray
    energy_kinetic: np.ndarray  # J, translations and the constant rotation
    energy_contact: np.ndarray
    work_load: np.ndarray  # J, since the start
    work_gravity: np.ndarray
    work_cage: np.ndarray  # of what keeps the angles to the kinematics; 0 with free angles
    work_dissipated: np.ndarray  # by the contacts' dampers
    time_step: float
    critical_time_step: float  # s, stability limit of the stiffest mode met
    steps: int

    @property
    def roller_x(self) -> np.ndarray:
        return self.roller_rho * np.cos(self.roller_theta)

    @property
    def roller_y(self) -> np.ndarray:
        return self.roller_rho * np.sin(self.roller_theta)

    @property
    def work_external(self) -> np.ndarray:
        """Of load, weights and cage since the start, J."""
        return self.work_load + self.work_gravity + self.work_cage

    @property
    def energy_error(self) -> np.ndarray:
        """Energy that the integration has made since the start, J: 0 in an exact solution."""
        energy = self.energy_kinetic + self.energy_contact
        return energy - energy[0] - self.work_external + self.work_dissipated
