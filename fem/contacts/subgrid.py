"""What the mesh can't see of a contact: the sub-grid Hertz compliance, calibrated to each body's mesh.

The finite elements carry the contact force as a smooth patch two to four nodes wide. The true Hertz pressure of
half-width b is far narrower; its extra approach, per body,

    δ_i = A_i Q (B_i − ½ ln Q),    A_i = 2 / (π E'_i L),

has the half-plane's dependence on b, and a B_i fixed so that finite elements plus sub-grid term give the exact
continuum answer for that body: a free disc squeezed by two Hertz pressures, a ring held on its other circle. A mesh
is softer at some places of its surface than at others (0.1 % between node and mid-edge, 1 % along a sextant of the
disc), so B_i is a periodic function of the contact's position: a mean and a ripple, a spline over one period.

The tangential compliance of a contact that sticks is that of the normal one for a little more force, A_i (B_i − ½ ln
Q) with a B_i of its own. It is calibrated in the same way, by a free disc and a held ring under one traction, but for
its mean over positions alone.

Equation (3) of docs/method.md.
"""

from dataclasses import dataclass
from math import log, pi
from typing import ClassVar

import numpy as np
from scipy import sparse

from fem.contacts.contact_law import ContactLaw
from fem.contacts.model import EVENLY, LIGHT, KernelData, Model, assembled_bodies
from fem.contacts.points import patch, patch_force, patch_traction, patches
from fem.elastic.bodies import DiscBody, RingBody
from fem.elastic.cache import kept
from fem.elastic.continuum import hertz_approach, roller_section, stick_approach
from fem.kernels.elements.surfaces import ONE
from fem.kernels.law import KNOTS_PER_NODE, STEEPEST, ripple_at
from lagrange import Bearing
from lagrange.contact.hertz import Pair, contact_pairs, line_compliance
from meshes import bearing_shapes

REFERENCE_HALF_WIDTH = 0.01  # of a roller's radius: calibrated there, the constants hold for any narrow contact
PLACES_PER_NODE = 2  # about which a disc's answer to tractions is averaged
NEIGHBOURLY = 3.5  # nodes; two patches so far apart share 1.5e-3 of what each has of itself (a B-spline of degree 11)


@dataclass(frozen=True, kw_only=True)
class SurfaceCompliance:
    """Approach of one body's surface under unit load: exact continuum minus finite elements."""

    whole: float  # m/N, at half_width, of the continuum
    missing: float  # m/N, of it, mean over positions
    half_width: float  # b at which the continuum was evaluated, m
    unit: float  # A_i = 2/(π E'_i L), m/N
    ripple: np.ndarray  # (period · KNOTS_PER_NODE,), coefficients of A_i·B_i minus its mean, cubic B-spline, m/N
    missing_shear: float  # m/N, as `missing`, tangentially, of a contact that sticks


@dataclass(frozen=True, kw_only=True)
class SubgridModel(Model):
    """Contacts of one patch each, with what the mesh can't see of them as a law."""

    roller_surface: SurfaceCompliance
    inner_surface: SurfaceCompliance
    outer_surface: SurfaceCompliance
    whole_levels: tuple[float, float, float]  # by kind, of the continuum's approach A Q (level − ½ ln Q)
    shear_levels: tuple[float, float, float]  # by kind, of a compliance A (level − ½ ln Q)

    static_passes: ClassVar[int] = 3
    shares: ClassVar = staticmethod(patches)
    has_law: ClassVar[bool] = True

    @classmethod
    def build(cls, bearing: Bearing, mesh_size, largest_force=0.0, stiffness=0.0) -> Model:
        bodies = assembled_bodies(bearing, bearing_shapes(bearing, mesh_size))
        thickness = bearing.roller_length
        half_width = REFERENCE_HALF_WIDTH * bearing.roller_radius
        roller, inner, outer = (surface_compliance(body, thickness, half_width) for body in bodies.values())
        between = roller
        if bearing.roller.rigid:  # two of them need a compliance to meet with: their material's own
            disc = roller_section(bearing).elastic
            exact, sticking = hertz_approach(disc.squeezed, half_width), stick_approach(disc, half_width)
            none, unit = np.zeros(KNOTS_PER_NODE), line_compliance(disc.material, thickness)
            between = _missing(exact / thickness, none, sticking / thickness, half_width, unit)
        met = list(zip(((inner, roller), (outer, roller), (between, between)), contact_pairs(bearing), strict=True))
        return cls.of(
            bearing, bodies, [contact_law(*sides, pair) for sides, pair in met], roller_surface=roller,
            inner_surface=inner, outer_surface=outer,
            whole_levels=tuple(level(*sides, pair, "whole") for sides, pair in met),
            shear_levels=tuple(level(*sides, pair, "missing_shear") for sides, pair in met),
        )  # fmt: skip

    def places(self, forces) -> list[np.ndarray]:
        return 2 * self.bearing.n_rollers * [np.zeros(1)]

    def beside(self, kind: int, on_ring: np.ndarray, on_roller: np.ndarray) -> np.ndarray:
        """See `Model.beside`: the ripples of both surfaces."""
        rings = (self.inner_surface, self.inner_ring), (self.outer_surface, self.outer_ring)
        (surface, ring), found = rings[kind], np.zeros(on_ring.size)
        roller = self.roller_surface, on_roller, self.roller.n_surface
        for ripple, angles, nodes in ((surface, on_ring, ring.n_surface), roller):
            places = np.mod(angles * nodes / (2.0 * pi), nodes)
            found += [ripple_at(place, ripple.ripple)[0] for place in places]
        return np.diag(found)

    def springs(self, force: float, sticks: bool = False) -> dict[str, sparse.csc_matrix]:
        """See `Model.springs`: one on each patch, stiffer the larger the force; so are those of contacts that stick."""
        rings, found = {"inner_ring": self.inner_ring, "outer_ring": self.outer_ring}, {"roller": []}
        ends = [LIGHT if self.roller.material.rigid or ring.material.rigid else EVENLY for ring in rings.values()]
        kinds = (self._normal(force), patch_force), (self._tangential(force), patch_traction)
        for stiffness, push in kinds[: 1 + sticks]:
            sizes = np.sqrt(np.array([*ends, EVENLY]) * stiffness)
            found["roller"] += [size * push(self.roller, 2.0 * pi * k / 3.0) for k, size in enumerate(sizes)]
            for size, (name, ring) in zip(sizes, rings.items(), strict=False):
                found.setdefault(name, []).append(size * push(ring, 0.0).ravel())
        return {name: sparse.csc_matrix(np.stack(columns, axis=1)) for name, columns in found.items()}

    def stiffnesses(self, force: float, sticks: bool) -> np.ndarray:
        return np.maximum(self._normal(force), self._tangential(force) if sticks else 0.0)

    def _normal(self, force):
        return np.array([law.stiffness(force) for law in self.laws])

    def _tangential(self, force):
        found = zip(self.laws, self.shear_levels, strict=True)
        return np.array([
            1.0 / (law.A * max(level - 0.5 * log(min(force, law.Q_line)), STEEPEST)) for law, level in found
        ])  # fmt: skip

    def kernel_data(self, largest_force: float) -> KernelData:
        return KernelData(
            laws=tuple(law.constants for law in self.laws),
            ripples=tuple(each.ripple for each in (self.inner_surface, self.outer_surface, self.roller_surface)),
            units=ONE, neighbourly=NEIGHBOURLY, shear_levels=self.shear_levels, whole_levels=self.whole_levels,
        )  # fmt: skip

    def carried(self, kind: int, n_surface: int, angle: float, radius: float, force: float):
        return patch(n_surface, angle)

    def smeared(self, spacing: float, half_width: float) -> float:
        """See `Model.smeared`: the patch is one of the mesh's nodes."""
        return spacing

    def indentation(self, kind: int, force: np.ndarray) -> np.ndarray:
        return self.laws[kind].approach(force) * (force > 0.0)


def contact_law(first: SurfaceCompliance, second: SurfaceCompliance, pair: Pair) -> ContactLaw:
    """Law of two calibrated surfaces, ripples apart."""
    return ContactLaw.of_level(first.unit + second.unit, level(first, second, pair, "missing"), pair)


def level(first: SurfaceCompliance, second: SurfaceCompliance, pair: Pair, what: str) -> float:
    """Level of both surfaces' `whole`, `missing` or `missing_shear` together, A (level − ½ ln Q)."""
    wide, sides = 0.5 * log(pair.half_width_factor), (first, second)
    AB = sum(getattr(side, what) + side.unit * (log(side.half_width) - wide) for side in sides)
    return AB / (first.unit + second.unit)


def surface_compliance(body: DiscBody | RingBody, thickness: float, half_width: float) -> SurfaceCompliance:
    """Calibrate a body: a free disc against the exact one squeezed by two opposite Hertz pressures, a held ring against
    the exact annulus under one. Kept between starts."""
    if body.material.rigid:
        return rigid_surface(half_width)
    if isinstance(body, DiscBody):
        respond, section, period = body.relaxed, body.section.squeezed, body.n_surface // body.shape.repeats
    else:
        respond, section, period = body.held, body.section, 1
    angles = np.arange(period * KNOTS_PER_NODE) / KNOTS_PER_NODE * (2.0 * pi / body.n_surface)

    def approaches(load, angles, opposite=False):
        """Of the mesh's surface at unit loads, (n_angles,), m/N, each alone, or with one on the other side."""
        found = []
        for some in np.array_split(angles, 1 + angles.size // 512):
            near = np.stack([load(body, angle) for angle in some], axis=-1)
            far = np.stack([load(body, angle + pi) for angle in some], axis=-1) if opposite else 0.0
            found.append(np.sum(near * respond(near + far), axis=tuple(range(near.ndim - 1))))
        return np.concatenate(found)

    def make():
        places = angles[:: KNOTS_PER_NODE // PLACES_PER_NODE] if period > 1 else angles
        pulled = float(approaches(patch_traction, places).mean())
        sticking = stick_approach(body.section, half_width) / thickness - pulled
        exact = hertz_approach(section, half_width) / thickness
        pushed, unit = approaches(patch_force, angles, section.loads == 2), line_compliance(body.material, thickness)
        found = _missing(exact, pushed, sticking, half_width, unit)
        return {name: np.asarray(value) for name, value in vars(found).items()}

    key = repr((body.shape, getattr(body, "held_row", None), body.material, thickness, half_width))
    found = kept("surface", key, make)
    return SurfaceCompliance(**{name: value if value.ndim else float(value) for name, value in found.items()})


def rigid_surface(half_width: float) -> SurfaceCompliance:
    """The compliance of a rigid body."""
    return _missing(0.0, np.zeros(KNOTS_PER_NODE), 0.0, half_width, 0.0)


def _missing(exact, found, sticking, half_width, unit):
    rise = found.mean() - found
    wave = 2.0 * np.pi * np.fft.rfftfreq(rise.size)  # coefficients of the spline through the samples
    ripple = np.fft.irfft(np.fft.rfft(rise) * 3.0 / (2.0 + np.cos(wave)), n=rise.size)
    return SurfaceCompliance(
        whole=float(exact), missing=float(exact - found.mean()), half_width=half_width, unit=unit, ripple=ripple,
        missing_shear=float(sticking),
    )  # fmt: skip
