"""A free cage in the steps of `integrate.NumpyIntegration`: the reference of the compiled one.

The cage is seen from the ground, hub and elements as their system has them: in a housing from the outer ring's centre.
Vectors are complex, x + iy. Of a contact n is its normal, a = −in the way across it on an element, +in on the guide.
Springs push along n by k ⟨depth⟩, with what keeps their energy in a step (a discrete gradient); dashpots and friction
end the step, each solved for the velocity that it leaves, one contact after the other, the guide last.
"""

import numpy as np

from lagrange.bearing import Cage
from lagrange.cage_motion import SMALLEST

STANDING = 1e-4  # of a depth: what changes less works as a constant force
REPAID, MOST_REPAID = 0.25, 0.01  # of a contact's residual energy, in a step; of its force, at most
GUIDE_SIDES = {"inner_ring": -1.0, "outer_ring": 1.0}  # of the cage, where it meets that ring
APPROACH, FORCE, KICK, RESIDUAL, CLOSING = range(5)  # of `CageSteps.met`
DASHPOT, RUBBED = 0, 1  # of `CageSteps.given`


class CageSteps:
    """A free cage of a system, in steps of dt, s.

    `memory` is what the next step needs: motion (2, 3), place, m, angle, rad, and rates; losses (3,), J; of all
    contacts, the guide's the last, what the last kick has left, (5, n + 1), and what dashpots and friction gave.
    """

    def __init__(self, system, cage: Cage, dt: float, ring: complex):
        self._system, self._cage, self._dt = system, cage, dt
        bearing, housing = system.problem.bearing, system.problem.operation.mounting.housing
        n = system.n
        self._radius, self._pitch = bearing.roller_radius, bearing.pitch_radius
        self._in_housing = housing is not None
        ring_mass = system.ring_mass if self._in_housing else np.inf
        guides = {"inner_ring": (system.inner_mass, bearing.inner_raceway_radius),
                  "outer_ring": (ring_mass, bearing.outer_raceway_radius)}  # fmt: skip
        self._guide_mass, radius = guides.get(cage.guidance, (np.inf, 0.0))
        self._guide_radius = GUIDE_SIDES.get(cage.guidance, 0.0) * radius
        self._play = np.full(n + 1, 0.5 * cage.pocket_clearance)
        self._play[n] = np.inf if cage.guidance_clearance is None else 0.5 * cage.guidance_clearance
        self.motion = np.array([[ring.real, ring.imag, 0.0], [0.0, 0.0, system.cage]])
        self.lost, self.met, self.given = np.zeros(3), np.zeros((5, n + 1)), np.zeros((2, n + 1))
        self.met[APPROACH] = np.nan
        self.memory = {"motion": self.motion, "lost": self.lost, "met": self.met, "given": self.given}

    @property
    def _rate(self) -> complex:
        return complex(*self.motion[1, :2])

    def drift(self, seconds: float) -> None:
        """Move on."""
        self.motion[0] += seconds * self.motion[1]

    def row(self, z, z_rate) -> np.ndarray:
        """A sample, as `cage_motion.CageRows` has it."""
        motion = self.motion.copy()
        for i, of_hub in enumerate((z, z_rate)):
            ring = self._ring(of_hub)
            motion[i, :2] -= ring.real, ring.imag
        n = self._system.n
        return np.concatenate([*motion, self.lost, self.given[:, n], self.given[0, :n], self.given[1, :n]])

    def _ring(self, of_hub) -> complex:
        """The outer ring's part of the hub's places or rates."""
        return complex(of_hub[1]) if self._in_housing else 0j

    def meet(self, z, z_rate, q, q_rate):
        """Find the contacts; rates of hub and elements with what springs give them, the cage's with weight and drag."""
        system, cage, dt = self._system, self._cage, self._dt
        ring, hub = self._ring(z), self._hub(z)
        place, angle = complex(*self.motion[0, :2]), self.motion[0, 2]
        self._to_elements = q + ring - place
        outward = np.exp(1j * (system.first + system.spacing + angle))
        if cage.guidance == "rollers":
            off = self._to_elements - self._pitch * outward
        else:
            off = np.real(self._to_elements * np.conj(1j * outward)) * 1j * outward
        ways = np.append(off, place - (hub if cage.guidance == "inner_ring" else ring))
        far = np.abs(ways)
        self._normal = ways / np.maximum(far, SMALLEST)
        n = self._normal[:-1]
        self._arms = np.array([(np.conj(self._to_elements) * n).imag, -(np.conj(self._to_elements) * n).real])
        self._arms[1] -= self._radius
        self._turned = self.motion[1, 2]
        self._before = self._rates(z_rate, q_rate)
        kick = self._kicked(far - self._play, self._before[0])
        self._closed = self.met[FORCE] > 0.0
        self.given[:] = 0.0
        given = -dt * kick * self._normal  # on elements, and on the cage by its guide
        self.motion[1, 2] += dt * float(kick[:-1] @ self._arms[0]) / cage.inertia
        self._push_cage(complex(given[-1] - given[:-1].sum() - 1j * cage.mass * system.gravity * dt))
        z_rate, q_rate = self._push_guide(z_rate, q_rate, -complex(given[-1]))
        most = cage.drag_torque * dt
        self._drag = -np.clip(cage.inertia * self.motion[1, 2], -most, most)
        self.motion[1, 2] += self._drag / cage.inertia
        return z_rate, q_rate + given[:-1] / system.mass

    def _hub(self, of_hub) -> complex:
        """From the ground."""
        return complex(of_hub[0] + of_hub[1]) if self._in_housing else complex(of_hub)

    def _push_cage(self, given: complex) -> None:
        self.motion[1, :2] += given.real / self._cage.mass, given.imag / self._cage.mass

    def _push_guide(self, z_rate, q_rate, given: complex):
        """Rates of hub and elements once the guiding ring has an impulse, N s."""
        gained = given / self._guide_mass
        if self._cage.guidance == "inner_ring":
            return (np.array([z_rate[0] + gained, z_rate[1]]) if self._in_housing else z_rate + gained), q_rate
        if not self._in_housing:
            return z_rate, q_rate
        return np.array([z_rate[0] - gained, z_rate[1] + gained]), q_rate - gained

    def _rates(self, z_rate, q_rate):
        """How fast contacts close, and surfaces pass along a: of elements against pockets, of the cage against its
        guide, m/s, (2, n + 1)."""
        turning, ideal = self.motion[1, 2], self._system.ideal
        ring = self._ring(z_rate)
        of_elements = (q_rate + ring - self._rate) * np.conj(self._normal[:-1])
        along = of_elements.real - turning * self._arms[0]
        across = -of_elements.imag - ideal.roller * self._radius - turning * self._arms[1]
        inner = self._cage.guidance == "inner_ring"
        of_cage = (self._rate - (self._hub(z_rate) if inner else ring)) * np.conj(self._normal[-1])
        passing = of_cage.imag + (turning - (ideal.shaft if inner else 0.0)) * self._guide_radius
        return np.array([np.append(along, of_cage.real), np.append(across, passing)])

    def _kicked(self, approach: np.ndarray, coming: np.ndarray) -> np.ndarray:
        """What springs give in a kick so that they store what they take, N; `coming` : m/s, rates before it."""
        met, stiffness, dt = self.met, self._cage.stiffness, self._dt
        before, last, kick, residual, closing = met
        force = stiffness * np.maximum(approach, 0.0)
        step, closed = approach - before, np.minimum(before, approach) > 0.0
        known = ~np.isnan(before) & np.isfinite(approach)
        plain = ~known | (np.maximum(before, approach) <= 0.0) | (closed & (np.abs(step) < STANDING * approach))
        step = np.where(known, step, 0.0)
        work = 0.5 * (force**2 - last**2) / stiffness
        due, way = residual - 0.5 * step * (kick - last), np.where(plain, 1.0, step)
        back = np.where(closed, np.clip(REPAID * due / way, -MOST_REPAID * force, MOST_REPAID * force), 0.0)
        given = np.where(plain, force, 0.5 * (force - last) + work / way + back)
        left = residual + work - 0.5 * step * (kick + given)
        left -= 0.5 * ((dt * closing - step) * kick + (dt * coming - step) * given)  # normals turn
        met[RESIDUAL] = np.where(known, left, residual)
        met[APPROACH], met[FORCE], met[KICK] = approach, force, given
        return given

    def rub(self, z_rate, q_rate):
        """End a kick by dashpots and friction: rates of hub and elements, and the work of what turns elements and
        shaft, J."""
        cage, system, dt = self._cage, self._system, self._dt
        light, heavy = 1.0 / system.mass + 1.0 / cage.mass, self._arms**2 / cage.inertia
        q_rate = q_rate.copy()
        for j in np.flatnonzero(self._closed[:-1]):
            n, spring = self._normal[j], self.met[FORCE, j]
            rate = self._rates(z_rate, q_rate)[0, j]
            damped = max(cage.damping * rate / (1.0 + cage.damping * (light + heavy[0, j]) * dt), -spring)
            self._push_element(q_rate, j, -damped * dt * n, -damped * dt * self._arms[0, j])
            slip, limit = self._rates(z_rate, q_rate)[1, j], cage.friction_coefficient * (spring + damped)
            rubbed = -np.clip(slip / ((light + heavy[1, j]) * dt), -limit, limit)
            self._push_element(q_rate, j, rubbed * dt * -1j * n, rubbed * dt * self._arms[1, j])
            self.given[:, j] = -damped, rubbed
        work = dt * float(self.given[RUBBED, :-1].sum()) * self._radius * system.ideal.roller
        if self._closed[-1]:
            z_rate, q_rate = self._rub_guide(z_rate, q_rate)
            inner = cage.guidance == "inner_ring"
            work += dt * self.given[RUBBED, -1] * self._guide_radius * (system.ideal.shaft if inner else 0.0)
        after = self._rates(z_rate, q_rate)
        self.met[CLOSING] = np.where(self.met[KICK] != 0.0, after[0], self.met[CLOSING])
        self.lost[:2] -= 0.5 * dt * np.sum(self.given * (self._before + after), axis=1)
        self.lost[2] -= 0.5 * self._drag * (self._turned + self.motion[1, 2])
        return z_rate, q_rate, work

    def _push_element(self, q_rate: np.ndarray, j: int, given: complex, turning: float) -> None:
        """An impulse on element j, N s, against it on the cage, and its moment about the cage's centre, N m s."""
        q_rate[j] += given / self._system.mass
        self._push_cage(complex(-given))
        self.motion[1, 2] -= turning / self._cage.inertia

    def _rub_guide(self, z_rate, q_rate):
        cage, dt, n, spring = self._cage, self._dt, self._normal[-1], self.met[FORCE, -1]
        light = 1.0 / cage.mass + 1.0 / self._guide_mass
        rate = self._rates(z_rate, q_rate)[0, -1]
        damped = max(cage.damping * rate / (1.0 + cage.damping * light * dt), -spring)
        self._push_cage(complex(-damped * dt * n))
        z_rate, q_rate = self._push_guide(z_rate, q_rate, complex(damped * dt * n))
        slip, limit = self._rates(z_rate, q_rate)[1, -1], cage.friction_coefficient * (spring + damped)
        mobility = light + self._guide_radius**2 / cage.inertia
        rubbed = -np.clip(slip / (mobility * dt), -limit, limit)
        self._push_cage(complex(rubbed * dt * 1j * n))
        self.motion[1, 2] += rubbed * dt * self._guide_radius / cage.inertia
        self.given[:, -1] = -damped, rubbed
        return self._push_guide(z_rate, q_rate, complex(-rubbed * dt * 1j * n))
