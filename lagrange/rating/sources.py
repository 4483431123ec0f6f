"""Where formulas of ratings come from, and how sure their constants are; what to say where one can't be used."""

# fmt: off
from typing import NamedTuple

from lagrange.errors import UsageError


class Unavailable(UsageError):
    """A rating that can't be computed; the text is the reason, for people."""


class NotAsked(Unavailable):
    """Of what only an option or a part of the scene that was not given would bring."""


class Source(NamedTuple):
    """Of a formula. `second_hand` says how its constants are known where not from the source itself; "" elsewhere."""

    name: str  # short
    text: str
    second_hand: str = ""

    def __str__(self) -> str:
        """All of it."""
        end = f" (second hand: {self.second_hand})" if self.second_hand else ""
        return f"{self.name}: {self.text}{end}"


_PROGRAMS = "constants as two independent programs quote them"
_ONE = "constants as one program quotes them"
_RECALLED = "constants not compared with the source"

DYNAMIC = Source("ISO 281",
    "2007, C = b_m f_c (i L_we cos α)^(7/9) Z^(3/4) D_we^(29/27), b_m = 1.1; f_c by ISO/TR 1281-1 (34); of balls "
    "1.3 f_c (i cos α)^0.7 Z^(2/3) D_w^1.8", f"{_ONE}; b_m not compared with the source")
KNOWN = Source("as stated", "C and C0 as given or by the maker's catalogue; C_u by ISO 281 from that C0, or given")
STATIC = Source("ISO 76",
    "2006, C0 = 44 (1 − D_we cos α/D_pw) i Z L_we D_we cos α; of balls f_0 i Z D_w² cos α; s0 = C0/P0",
    _RECALLED)
LOAD = Source("ISO 281",
    "2007 tables 3 and 7, P = X F_r + Y F_a; of flanged cylindrical rollers SKF's e = 0.2, X = 0.92, Y = 0.6 (series "
    "10, 2, 3, 4) or 0.3, 0.92, 0.4; of a duty cycle by Palmgren and Miner, (Σ n t P^(10/3)/Σ n t)^(3/10), of balls 3 "
    "for 10/3", f"{_PROGRAMS}, worked examples of NSK and NTN; SKF's read on its pages")
STATIC_LOAD = Source("ISO 76", "2006, P0 = max(X0 F_r + Y0 F_a, F_r)", f"{_RECALLED}; that of deep grooves as SKF's")
LEAST_LOAD = Source("makers", "rule of thumb: C/100 of balls, C/50 of rollers", "of rollers as on SKF's pages")
FLANGES = Source("SKF",
    "single row cylindrical roller bearings, dynamic axial load carrying capacity, oil: F_a ≤ 0.5 F_r, (1.5 C0 10⁴)/"
    "(n (d + D)) − 0.15 F_r, 0.0023 D^1.7 kN, of series 2 0.0045 D^1.5",
    "read on its pages; the formula in n as others quote it")
LIFE = Source("ISO 281", "2007, L10 = (C/P)^(10/3); of balls (C/P)³")
RELIABILITY = Source("ISO 281",
    "2007 table 12, between its values by ISO/TR 1281-2, three-parameter Weibull distribution",
    f"{_RECALLED}; both agree")
VISCOSITY = Source("ISO 281", "2007, κ = ν/ν1; ν1 = 45000 n^−0.83 D_pw^−½, from 1000 1/min 4500 (n D_pw)^−½", _PROGRAMS)
FATIGUE = Source("ISO 281",
    "annex B, C_u = C0/8.2, beyond D_pw = 100 mm times (100/D_pw)^0.3; of balls C0/22 and (100/D_pw)^0.5", _RECALLED)
A_ISO = Source("ISO 281", "2007 (34) to (36), radial roller bearings; (31) to (33), radial ball bearings",
    f"{_PROGRAMS}; those of balls not compared with the source")
CONTAMINATION = Source("ISO 281", "annex A, in-line filtered oil, β6(c) ≥ 200", _RECALLED)
REFERENCE = Source("ISO/TS 16281",
    "2008 (38) to (65), rollers in laminae; (19) to (29), balls at their own contact angles; rigid rings", _PROGRAMS)
MODIFIED_REFERENCE = Source("ISO 16281",
    "2025 (31), (33): a_ISO of each lamina's load; of balls of P_ref = C/L10r^(1/3)", _ONE)
LOAD_SHARING = Source("ISO/TS 16281", "2008 (58) to (65) with the roller loads of elastic rings", _PROGRAMS)
TILTED = Source("balance", "of hub and tilted rollers in slices, linearised at the operating point")
IN_SPACE = Source("ISO/TS 16281",
    "2008, balls at their own contact angles, rollers in laminae; rings rigid, at the first angle", _PROGRAMS)
HERTZ = Source("Hertz", "Johnson, Contact Mechanics (1985), 4.2: line contact, stress below (4.49); balls (4.24)")
STRESS_LIMITS = Source("ISO 76, ISO 281", "4000 MPa, of balls 4200 MPa, at C0; 1500 MPa at C_u", _RECALLED)
FILM = Source("Dowson, Higginson", "1968, h = 2.65 R U^0.70 G^0.54 W^−0.13; λ = h/rms roughness", "book not read")
SKF = Source("SKF",
    "Rolling Bearings catalogue, model of the frictional moment, cylindrical roller bearings with cage, R1 by series",
    "forms read in the catalogue; R1, S2, K_rs, K_z not compared with its tables")
PALMGREN = Source("Palmgren",
    "M0 = f0 (ν n)^(2/3) d_m³ 1e-7, M1 = f1 F d_m; f0 = 2.2 to 4, f1 = 2e-4 to 4e-4 by series (10, 2, 22, 3, 23)",
    _RECALLED)
BOTH_FRICTIONS = Source("SKF, Palmgren", f"{SKF.text}; {PALMGREN.text}", SKF.second_hand)
HEAT = Source("ISO 15312", "reference heat flow, 0.016 W/mm² of π B (d + D) at 70 °C against 20 °C", _RECALLED)
SCENE = Source("scene", "as it was given")
CLEARANCE = Source("scene, Lamé", "the scene's clearance; fits and temperatures of its [fit]; spin; the films")
FITS = Source("Lamé", "Harris, Rolling Bearing Analysis (4th ed. 2001), chapter 3: rings in plane stress",
    "book not read")
OF_RUN = Source("run", "normal forces and dissipated work of a result file; life by ISO/TS 16281 (58) to (65)",
    _PROGRAMS)
LINEARISED = Source("balance", "of hub and rollers, linearised at the operating point (implicit function theorem)")
