"""Rollers along their axis: profiles, and the forces of slices by their approaches, each by the plane law.

A slice of n carries the n-th part of what the plane law gives the whole length. Coupled, it yields to the others too:
d = δ_law(n F) + Σ C F, F ≥ 0, C symmetric. A contact's table is made of the energy of its slices at every knot. Result
files hold the slices of elastic bodies, from which pressures along rollers follow by forces and moments.
"""

from dataclasses import dataclass, replace
from math import ceil, inf
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple

import numpy as np
from numpy import ndarray

from lagrange.axial.table import ContactTable, SpalledTable, TiltedContact, spline_coefficients
from lagrange.bearing import Bearing
from lagrange.contact.laws import LogarithmicLaw, PowerLaw
from lagrange.errors import ROUND_OFF, exceeds
from lagrange.files.hdf5 import Damaged, check_array, has, variable
from lagrange.surface.deviation import profiles
from lagrange.surface.faults import Spall

if TYPE_CHECKING:
    import h5py

LONG = 2.5  # L_we/D_we beyond which the middle of the standard's profile is straight
STEPS = 60  # of Newton's method
SETTLED = 1e-12  # of the largest approach
MATRICES = 2**22  # numbers in the matrices of contacts that are solved at once: 34 MB, which some copies share
FIRST = 1e-8  # m, beyond the opening, to begin with
OUT_OF_REACH = 1e-3  # m, further than any slice approaches
KNOTS = 72  # between the opening and the largest approach of a straight contact
COARSER = 2.0  # steps of slope, at a roller's end, over those of approach: energy is smoother along it
MOST_SLOPES = 300  # steps of slope either way
BELOW = 6  # steps of approach below the opening of which a spline's values above it still know
MORE = 3.0  # times the largest force: what moves carries more than what stands
SIDES = "inner", "outer"  # before _slice_compliance, variables of the file
LAW = "compliance", "level", "largest_force"  # after law_, their attributes: m/N, 1, N

LineLaw = PowerLaw | LogarithmicLaw
Laws = tuple[LineLaw, LineLaw]  # of the inner and the outer contact


class Profile(NamedTuple):
    """Drop of one surface along the roller's length, from its middle. SI."""

    kind: Literal["none", "logarithmic", "crowned", "lundberg", "measured"] = "none"
    crown: float = 0.0  # m, drop of "crowned" at the roller's ends
    load: float = 0.0  # N, for which a "lundberg" profile makes the pressure even
    place: tuple[float, ...] = ()  # m from the middle, of "measured", rising
    depth: tuple[float, ...] = ()  # m, there

    def drop(self, z, bearing: Bearing) -> ndarray:
        """P(z), m, >= 0, z in m from the roller's middle, shape of z; infinite at the ends of logarithmic profiles.

        Source: ISO/TS 16281:2008 (42) to (44); Lundberg 1939, P = Q/(π E* L) ln[1/(1 − (2z/L)²)].
        """
        z, length = np.asarray(z, dtype=float), bearing.roller_length
        if self.kind == "logarithmic":
            return logarithmic_drop(z, length, 2.0 * bearing.roller_radius)
        if self.kind == "crowned":
            return self.crown * (2.0 * z / length) ** 2
        if self.kind == "lundberg":
            return self.load * _even_drop(bearing) * _falling(2.0 * z / length)
        return np.interp(z, self.place, self.depth) if self.kind == "measured" else np.zeros(z.shape)

    @property
    def knees(self) -> ndarray:
        """Where a measured profile bends outwards, m, and by how much, rad, (2, n)."""
        bend = np.diff(np.diff(self.depth) / np.diff(self.place))
        return np.array([self.place[1:-1], bend])[:, bend > 0.0] if self.place else np.zeros((2, 0))

    def even_load(self, bearing: Bearing) -> float:
        """Of a roller, N, whose pressure is even up to the ends; 0 of profiles without a logarithm."""
        if self.kind == "logarithmic":
            near = 1e-9  # of half the length, from the end
            drop = self.drop(0.5 * bearing.roller_length * (1.0 - near * np.array([1.0, np.e])), bearing)
            return float(drop[0] - drop[1]) / _even_drop(bearing)
        return self.load if self.kind == "lundberg" else 0.0


def _even_drop(bearing):
    """1/(π E* L), m/N: of Lundberg's profile, by its load."""
    compliance = 1.0 / bearing.roller.plane_strain_modulus + 1.0 / bearing.inner_ring.plane_strain_modulus
    return compliance / (np.pi * bearing.roller_length)


def logarithmic_drop(x, length: float, diameter: float) -> ndarray:
    """P(x) of the standard's logarithmic profile, in the unit of x, length and diameter.

    Source: ISO/TS 16281:2008 (42), of long rollers (43), (44).
    """
    x = np.asarray(x, dtype=float)
    if not exceeds(length, LONG * diameter):
        return 0.00035 * diameter * _falling(2.0 * x / length)
    straight = length - LONG * diameter
    return 0.0005 * diameter * _falling(np.maximum(2.0 * np.abs(x) - straight, 0.0) / (LONG * diameter))


def _falling(share):
    """ln[1/(1 − s²)]; infinite from s = 1 on."""
    with np.errstate(divide="ignore"):
        return -np.log(np.maximum(1.0 - share**2, 0.0))


def centres(length: float, slices: int) -> ndarray:
    """z of the middles of equal slices of a length from its middle, (slices,)."""
    return (np.arange(slices) + 0.5 - 0.5 * slices) * length / slices


def slices_over(bearing: Bearing, slices: int, spall: Spall) -> ndarray:
    """Which slices of a roller have their middles over a spall, (slices,)."""
    z, (first, last) = centres(bearing.roller_length, slices), spall.along or (-np.inf, np.inf)
    near = ROUND_OFF * bearing.roller_length
    return (z >= first - near) & (z <= last + near)


@dataclass(frozen=True, kw_only=True)
class Axial:
    """Rollers, raceways and shaft along the axis. SI."""

    roller: Profile
    inner_raceway: Profile
    outer_raceway: Profile
    slices: int  # of a roller, equally wide
    coupling: bool  # whether neighbouring slices know each other
    ring_width: float  # m, of both rings
    hub_tilt_inertia: float | None = None  # kg m², about an axis across the shaft's; None: its slope is prescribed
    shaft_tilt_stiffness: float = 0.0  # N m/rad, of the shaft, against its slope

    @property
    def has_free_slope(self) -> bool:
        """Whether the hub's slope moves, and is not prescribed."""
        return self.hub_tilt_inertia is not None

    def centres(self, bearing: Bearing) -> ndarray:
        """z of the slices' middles from the roller's middle, (slices,), m."""
        return centres(bearing.roller_length, self.slices)

    def drops(self, bearing: Bearing) -> ndarray:
        """Drop of roller and raceway together at the slices' middles, inner and outer contact, (2, slices), m."""
        z, raceways = self.centres(bearing), (self.inner_raceway, self.outer_raceway)
        return np.stack([self.roller.drop(z, bearing) + raceway.drop(z, bearing) for raceway in raceways])

    def parts(self, bearing: Bearing) -> tuple[ndarray | None, ndarray | None]:
        """Which slices spalls of part of the length let sink, inner and outer contact, (slices,) each; None: no such.

        A spall takes the slices whose middles it goes over. All that one raceway's contacts meet take the same.
        """
        found: dict[str, ndarray] = {}
        for spall in bearing.faults:
            if isinstance(spall, Spall) and spall.is_part(bearing):
                for ring in ("inner_ring", "outer_ring") if spall.body == "roller" else (spall.body,):
                    found.setdefault(ring, slices_over(bearing, self.slices, spall))
        return found.get("inner_ring"), found.get("outer_ring")


@dataclass(frozen=True, kw_only=True, eq=False)
class Slices:
    """The slices of one contact. SI."""

    law: LineLaw  # of the whole length
    place: ndarray  # (n,), z of their middles
    drop: ndarray  # (n,), of roller and raceway together
    coupling: ndarray | None = None  # C, (n, n), m/N; None: each is alone
    part: ndarray | None = None  # (n,), bool, which of them spalls of part of the length let sink; None: none

    last_approach: ClassVar[float] = inf
    has_part: ClassVar[bool] = False

    @property
    def count(self) -> int:
        return self.place.size

    @property
    def bare(self) -> "Slices":
        """Those of a contact in whose part of the length that spalls take nothing bears."""
        return replace(self, drop=-self.approaches(0.0, 0.0, OUT_OF_REACH), part=None)

    def opening(self, slope) -> ndarray:
        """The approach, m, from which on a contact of this slope, rad, is closed."""
        return np.min(self.drop + np.asarray(slope)[..., None] * self.place, axis=-1)

    def approach_under(self, force, slope) -> ndarray:
        """Of contacts with slopes, rad, each under a force, N, of shapes that go together; m.

        Newton's method from above: the force is convex in the approach.
        """
        force, slope = np.broadcast_arrays(np.asarray(force, dtype=float), slope)
        place, way = self.opening(slope), FIRST + self.law.approach(force)
        while np.any(short := self.forces(place, slope).sum(axis=-1) < force):
            place, way = np.where(short, place + way, place), 2.0 * way
        for _ in range(STEPS):
            here = self.at(place, slope)
            step = (here.force - force) / np.where(here.stiffness > 0.0, here.stiffness, np.inf)
            place = place - step
            if np.all(np.abs(step) <= SETTLED * np.abs(place).max()):
                break
        return place

    def approaches(self, approach, slope, sunk=0.0) -> ndarray:
        """Of the slices, (..., n), m: δ − P − ψ z, less what those of `part` have sunk, (...,), m."""
        found = np.asarray(approach)[..., None] - self.drop - np.asarray(slope)[..., None] * self.place
        return found if self.part is None else found - np.asarray(sunk)[..., None] * self.part

    def forces(self, approach, slope, sunk=0.0) -> ndarray:
        """Of the slices, (..., n), N, by approach, m, slope, rad, and what those of `part` have sunk, m, (...,).

        RuntimeError: coupled slices do not settle; they are narrower than their contacts.
        """
        deep = self.approaches(approach, slope, sunk)
        if self.coupling is None:
            return self.law.force(deep) / self.count
        every = deep.reshape(-1, self.count)
        blocks = np.array_split(every, 1 + len(every) * self.count**2 // MATRICES)
        return np.concatenate([_coupled(self.law, self.coupling, each) for each in blocks]).reshape(deep.shape)

    def sums(self, approach, slope, sunk=0.0) -> TiltedContact:
        """Energy, force and moment of contacts, (...,), without the other derivatives."""
        return self._summed(self.approaches(approach, slope, sunk), self.forces(approach, slope, sunk))

    def _summed(self, deep, forces):
        if self.coupling is None:
            energy = self.law.potential(deep).mean(axis=-1)
        else:
            own = self.law.potential(self.law.approach(self.count * forces)).mean(axis=-1)
            energy = own + 0.5 * np.einsum("...k,kl,...l->...", forces, self.coupling, forces)
        return TiltedContact(energy, forces.sum(axis=-1), forces @ self.place)

    def at(self, approach, slope, sunk=0.0) -> TiltedContact:
        """The same with derivatives, as a table has them."""
        approach, slope = np.asarray(approach, dtype=float), np.asarray(slope, dtype=float)
        deep, forces = self.approaches(approach, slope, sunk), self.forces(approach, slope, sunk)
        if self.coupling is None:
            by_approach = self.law.slope(deep) / self.count
            by_slope = by_approach * self.place
        else:
            stiff = self.law.slope(deep - forces @ self.coupling)[..., None] / self.count * np.eye(self.count)
            stiff = np.linalg.solve(np.eye(self.count) + stiff @ self.coupling, stiff)  # K (1 + C K)⁻¹, symmetric
            by_approach, by_slope = stiff.sum(axis=-1), stiff @ self.place
        part = forces @ (np.zeros(self.count) if self.part is None else self.part)
        return self._summed(deep, forces)._replace(stiffness=by_approach.sum(axis=-1), cross=-by_slope.sum(axis=-1),
            tilt_stiffness=by_slope @ self.place, part=part)  # fmt: skip


def _coupled(law, coupling, deep):
    """Forces, (m, n), N, of slices that yield to each other too, by approaches, (m, n), m.

    Newton's method on w + C F(w) = d, w the approach that the plane law sees: slices with w < 0 are open.
    """
    n = coupling.shape[0]
    own, left = deep.copy(), np.arange(len(deep))
    for _ in range(STEPS):
        w = own[left]
        missing = deep[left] - w - law.force(w) @ coupling / n
        far = np.abs(missing).max(axis=1) > SETTLED * np.abs(deep[left]).max(axis=1)
        left, w, missing = left[far], w[far], missing[far]
        if not left.size:
            return law.force(own) / n
        matrix = np.eye(n) + coupling * (law.slope(w) / n)[:, None, :]
        own[left] = w + np.linalg.solve(matrix, missing[..., None])[..., 0]
    raise RuntimeError(f"{left.size} of {len(deep)} contacts of {n} coupled slices do not settle; lower axial.slices")


def contact_slices(
    bearing: Bearing, axial: Axial, laws: Laws, couplings: tuple[ndarray, ndarray] | None = None
) -> tuple[Slices, Slices]:
    """The slices of the inner and the outer contact.

    `laws` : of the whole length; `couplings` : (n, n) each, m/N, of slices; None: each is alone
    """
    of_sides = zip(laws, axial.drops(bearing), couplings or (None, None), axial.parts(bearing), strict=True)
    inner, outer = (Slices(law=law, place=axial.centres(bearing), drop=drop, coupling=coupling, part=part)
        for law, drop, coupling, part in of_sides)  # fmt: skip
    return inner, outer


def contact_tables(
    bearing: Bearing, axial: Axial, laws: Laws, largest_force: float, largest_slope: float,
    couplings: tuple[ndarray, ndarray] | None = None,
) -> tuple[ContactTable | SpalledTable, ContactTable | SpalledTable]:  # fmt: skip
    """Tables of the inner and the outer contact, where all rollers are alike; parameters beside `contact_slices`'s:

    largest_force : N, of a contact at rest; largest_slope : rad, of a roller to a ring, either way. RuntimeError:
    slices do not settle.
    """
    inner, outer = (spalled(each, tabulated(each, float(each.approach_under(MORE * largest_force, 0.0)), largest_slope))
        for each in contact_slices(bearing, axial, laws, couplings))  # fmt: skip
    return inner, outer


def spalled(slices: Slices, whole: ContactTable) -> ContactTable | SpalledTable:
    """The table with that of the slices which no spall takes, if any takes a part of the length."""
    if slices.part is None:
        return whole
    return SpalledTable(whole=whole, rest=without_part(slices, whole), share=float(slices.part.mean()))


def alone(slices: Slices) -> Slices | SpalledTable:
    """A contact of slices that stand alone, apart in those that spalls of part of the length take and the rest."""
    if slices.part is None:
        return slices
    return SpalledTable(whole=replace(slices, part=None), rest=slices.bare, share=float(slices.part.mean()))


def steepest_slope(bearing: Bearing, axial: Axial, misalignment: float, depth: float) -> float:
    """The largest slope, rad, of a roller to a ring: of the shaft, and as far as it can tilt between raceways.

    `depth` : m, largest approach of the contacts
    """
    play, ends = max(2.0 * bearing.radial_clearance, 0.0), np.minimum(axial.drops(bearing)[:, [0, -1]], 4.0 * depth)
    surfaces = profiles(bearing)
    if surfaces is not None:
        play += 2.0 * surfaces.deepest
    return abs(misalignment) + (play + float(ends.max(axis=1).sum()) + 2.0 * depth) / bearing.roller_length


def tabulated(slices: Slices, deepest: float, steepest: float) -> ContactTable:
    """The table of a contact's energy up to an approach, m, and to a slope, rad, either way.

    Of a light load on a roller that may tilt far the slopes are too many: then both steps are wider, in their ratio.
    """
    step, end = (deepest - float(slices.opening(np.zeros(1))[0])) / KNOTS, float(np.abs(slices.place).max())
    half = min(ceil(steepest * end / (COARSER * step)), MOST_SLOPES)
    step = max(step, steepest / half * end / COARSER)
    first = float(slices.opening(steepest / half * np.arange(-half, half + 1)).min()) - 2.0 * step
    return _on_grid(slices, first, step, ceil((deepest - first) / step) + 1, steepest / half, half)


def without_part(slices: Slices, whole: ContactTable) -> ContactTable:
    """The table on the same knots of a contact in whose part of the length that spalls take nothing bears."""
    rows, columns = (int(n) for n in np.subtract(whole.coefficients.shape, (2, 3)))
    return _on_grid(slices.bare, whole.first_approach, whole.approach_step, rows, whole.slope_step, columns // 2)


def _on_grid(slices, first, step, count, by_slope, half):
    """The table through u at knots: first approach, its step, m, and their number; step of slope, rad, either way.

    Where the contact is open u goes on as −u of the same depth beyond the opening: a spline would ring from a kink.
    """
    slope, drop = by_slope * np.arange(-half, half + 1), slices.drop
    is_symmetric = np.allclose(drop, drop[::-1], rtol=1e-12, atol=0.0)  # a slope and its opposite have the same energy
    opening = slices.opening(slope)
    signed = (first + step * np.arange(count))[:, None] - opening
    known = signed > -BELOW * step
    wanted = known & (slope >= 0.0) if is_symmetric else known
    at, energy = np.nonzero(wanted), np.zeros(signed.shape)
    energy[at] = slices.sums(opening[at[1]] + np.abs(signed[at]), slope[at[1]]).energy
    if is_symmetric:
        energy[:, :half] = energy[:, :half:-1]
    u = np.sign(signed) * np.sqrt(energy)
    least = np.where(known.any(axis=0), u.min(axis=0), u.min())
    u = np.where(known, u, least * signed / (-BELOW * step))
    return ContactTable(first_approach=first, first_slope=-half * by_slope, approach_step=step, slope_step=by_slope,
        coefficients=np.ascontiguousarray(spline_coefficients(spline_coefficients(u).T).T))  # fmt: skip


def write_slices(file: "h5py.File", slices: tuple[Slices, Slices]) -> None:
    """Add compliances and laws of both contacts' slices to a file."""
    variable(file, "slice", slices[0].place, ("slice",), "m", "middle of a slice along the roller")
    for side, each in zip(SIDES, slices, strict=True):
        name, about = f"{side}_slice_compliance", f"approach of a slice by the force of another, {side} contact"
        variable(file, name, each.coupling, ("slice", "slice"), "m/N", about)
        for key in LAW:
            file[name].attrs[f"law_{key}"] = getattr(each.law, key)


def read_slices(file: "h5py.File", bearing: Bearing, axial: Axial) -> tuple[Slices, Slices] | None:
    """The slices of a run with [axial]; None: the file holds none. Damaged: they are none of such a bearing."""
    names, n, found = [f"{side}_slice_compliance" for side in SIDES], axial.slices, []
    if not all(has(file, name) for name in names):
        return None
    for name in names:
        data = check_array(file, name, n, dimensions=(2,))
        numbers = [float(data.attrs[f"law_{key}"]) for key in LAW]
        coupling = data[:].astype(float) if data.shape == (n, n) else np.empty((0, 0))
        if not (coupling.size and np.isfinite(coupling).all() and np.isfinite(numbers).all() and min(numbers) > 0.0):
            raise Damaged(f"{name} is no compliance of {n} slices")
        S, B, most = numbers
        law = LogarithmicLaw(name="series", compliance=S, level=B, largest_force=most, source="plane series")
        found.append((law, coupling))
    laws, couplings = zip(*found, strict=True)
    return contact_slices(bearing, axial, laws, couplings)
