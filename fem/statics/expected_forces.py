"""The contact forces to expect of a scene, before anything is meshed."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fem.statics.contact_balance import NotFound
from fem.statics.exact_statics import exact_statics
from lagrange import Bearing, Operation


@dataclass(frozen=True)
class ExpectedForces:
    """Static forces of a bearing's contacts, N."""

    bearing: Bearing
    operation: Operation

    @cached_property
    def largest(self) -> float:
        """Largest force by exact statics, solved when first asked for; the bound where there is no equilibrium."""
        try:
            found = exact_statics(self.bearing, self._load, self.operation.first_roller_angle)
        except NotFound:
            return self.bound
        return float(np.concatenate([found.inner_force, found.outer_force]).max()) + self._centrifugal

    @property
    def bound(self) -> float:
        """Above any contact's force: all the load on one roller, and the preload of rigid rings."""
        bearing = self.bearing
        preload = max(0.0, -bearing.radial_clearance)
        bodies = bearing.roller, bearing.inner_ring, bearing.outer_ring
        modulus = max(material.plane_strain_modulus for material in bodies if not material.rigid)
        return self._load + self._centrifugal + modulus * bearing.roller_length * preload

    @property
    def _load(self) -> float:
        return self.operation.heaviest + self.operation.inner_mass * self.operation.gravity

    @property
    def _centrifugal(self) -> float:
        cage = 0.5 * self.operation.fastest  # or less
        return self.bearing.roller_mass * cage**2 * self.bearing.pitch_radius
