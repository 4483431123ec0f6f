"""A run that goes on for as long as it is watched, what a viewer may change of it, and the scene that follows."""

import tomllib
from collections.abc import Callable, Container
from contextlib import suppress
from math import degrees, pi, remainder
from typing import NamedTuple

import numpy as np

from fem.solver.rigid.state import LIMIT
from fem.solver.simulate import make_plan
from fem.solver.solver import Samples
from fem.statics.tilted_pressures import scene_slices, slice_pressures
from lagrange.errors import RunFailed, UsageError
from lagrange.kinematics import OUTER_RING, kinematics
from lagrange.messages import G
from lagrange.mounting import from_outer_ring
from lagrange.scene.run import IN_PLACE_OF
from lagrange.scene.scene import Scene, content_of, parse_scene
from lagrange.scene.surfaces import FROM_LOAD
from lagrange.surface.faults import Spall, own_radius

OWN = {  # controls of what not every scene has, by key of its table: table, label, unit, hint
    "contact_N_s_m": ("damping", "Contact damping", "N s/m", "every closed contact"),
    "contact_time_us": ("damping", "Contact damping", "µs", "multiplies the contact's stiffness"),
    "hunt_crossley_s_m": ("damping", "Contact damping", "s/m", "Hunt–Crossley coefficient α"),
    "mass_kg": ("support", "Housing's mass", "kg", "without the outer ring"),
    "stiffness_N_per_m": ("support", "Housing's stiffness", "N/m", "springs to the ground, x and y"),
    "damping_N_s_m": ("support", "Housing's damping", "N s/m", "dashpots parallel to the springs"),
    "frequency_Hz": ("sensor", "Sensor's frequency", "Hz", "undamped"),
    "damping_ratio": ("sensor", "Sensor's damping ratio", "", "of critical damping"),
}
TABLE_OF = {"friction_coefficient": "contact"} | {key: table for key, (table, *_) in OWN.items()}  # else [operation]
SPALLED = {"outer_ring": "Spall, outer raceway", "inner_ring": "Spall, inner raceway", "roller": "Spall of a roller"}
SPALL_KEYS = {"mm": "width_mm", "deg": "angle_deg"}
STEEPEST = 3.0  # mrad
LONGER = 4.0  # times the scene's own value: the end of such a slider
MM, UM, MPA = 1e-3, 1e-6, 1e6
LONGEST = 2**15  # samples that a spectrum is of
SHORTEST = 256
LOWEST, HIGHEST = 20.0, 20e3  # Hz, of the spectrum shown; beyond, bodies without mass are not those of steel
BANDS = 300
MOST_PLACES = 500  # of an orbit, a frame
ENVELOPE_FROM, ENVELOPE_TO = 3.0, 2.3  # the band demodulated, from so many BPFI to HIGHEST; the end over the last line
FEWEST_PASSES = 8.0  # of rolling elements over a place of the outer ring, for an envelope
SLOWER, FASTER = 0.02, 0.005  # shares of a line's frequency by which slip moves it
LONGEST_MS = 1e5  # simulated; then the run restarts
INTERVAL_US = 10.0  # between samples
STEPS_PER_BLOCK = 5000  # some milliseconds of work: how long an answer may take
UNBALANCED = f"the energy balance is off by more than {100 * LIMIT:g} %: results are approximate"
NO_ENERGY = 1e-9  # of the kinetic energy: less is not exchanged, it is round-off
LINES = {  # of the spectrum, by `Kinematics.frequencies`
    "shaft": "rotation of the shaft",
    OUTER_RING: "rotation of the outer ring",
    "FTF": "rotation of the cage",
    "BSF": "spin of a roller",
    "BPFO": "ball passes, outer ring",
    "BPFI": "ball passes, inner ring",
}


class Control(NamedTuple):
    """A slider and a box; values beyond the slider's ends can be typed."""

    key: str  # of `values_of`
    label: str
    unit: str
    hint: str
    low: float
    high: float
    step: float
    needs: str = ""  # another control: while that is 0, this one has no effect


def values_of(scene: Scene) -> dict[str, float]:
    """Values of all controls that the scene has."""
    b = scene.bearing
    clearance = (b.outer_raceway_diameter_mm - b.inner_raceway_diameter_mm) / b.cosine - 2.0 * b.roller_diameter_mm
    found = {
        "speed_rpm": scene.operation.speed_rpm,
        "radial_load_N": scene.operation.radial_load_N,
        "clearance_um": round(1e3 * clearance, 3),
        "friction_coefficient": scene.contact.friction_coefficient,
    }
    spalls = {spall.body: spall for spall in reversed(scene.spall)}  # the first of each body
    for body in SPALLED:
        if body != "roller" or not b.missing_rollers:  # of which a scene can have one
            found[f"{body}_spall_mm"] = spalls[body].width_mm if body in spalls else 0.0
    found["outer_ring_spall_deg"] = spalls["outer_ring"].angle_deg if "outer_ring" in spalls else 0.0
    if scene.axial is not None:
        found["misalignment_mrad"] = scene.operation.misalignment_mrad or 0.0
    own = {key: getattr(getattr(scene, table), key, None) for key, (table, *_) in OWN.items()}
    return found | {key: value for key, value in own.items() if value is not None}


def changed(scene: Scene, values: dict[str, float]) -> Scene:
    """The scene with other values; what is not changed keeps its digits. SceneError: there is no such scene."""
    data, before = tomllib.loads(scene.to_toml()), values_of(scene)
    if not scene.is_given("cage"):
        data.pop("cage", None)  # that a bearing of this kind has, which other values may take from it
    for key, value in values.items():
        if value == before[key]:
            continue
        if key == "clearance_um":
            del data["bearing"]["outer_raceway_diameter_mm"]
            data["bearing"][key] = value
        elif "_spall_" not in key:
            data.setdefault(TABLE_OF.get(key, "operation"), {})[key] = value
        else:
            spalls, (body, part) = data.setdefault("spall", []), key.split("_spall_")
            first = next((spall for spall in spalls if spall["body"] == body), None)
            if first is not None and (part == "deg" or value):
                first[SPALL_KEYS[part]] = value
            elif first is not None:
                spalls.remove(first)
            elif part == "mm":
                spalls.append({"body": body, "width_mm": value, **({"roller": 0} if body == "roller" else {})})
    content_of(data, scene.files)
    return parse_scene(data, "these values")


def controls(scene: Scene) -> tuple[Control, ...]:
    """Those of a scene, long enough for its own values."""
    values, b = values_of(scene), scene.bearing
    speed, load, play = values["speed_rpm"], values["radial_load_N"], values["clearance_um"]
    wide, fastest = b.roller_diameter_mm, 2.0 * abs(speed) or 3000.0
    slow, heaviest = min(0.0, -fastest * (speed < 0.0)), max(5.0 * load, 50.0 * wide * b.roller_length_mm)
    friction = max(0.3, values["friction_coefficient"])
    tight, loose = min(-2.0 * wide, play), max(10.0 * wide, play)
    found = [
        Control("speed_rpm", "Speed", "rpm", "inner ring", slow, fastest, 10.0),
        Control("radial_load_N", "Radial load", "N", "on the shaft, downwards", 0.0, heaviest, 10.0),
        Control("clearance_um", "Clearance", "µm", "diametral; below 0: preload", tight, loose, 1.0),
        Control("friction_coefficient", "Friction", "", "Coulomb coefficient, every contact", 0.0, friction, 0.01),
    ]
    if (tilt := values.get(key := "misalignment_mrad")) is not None:
        steepest = max(STEEPEST, abs(tilt))
        hint = "slope of the shaft; +z end towards the load"
        found.append(Control(key, "Misalignment", "mrad", hint, -steepest, steepest, 0.1))
    for key, (_, label, unit, hint) in OWN.items():
        if own := values.get(key):
            end = max(own, min(LONGER * own, 0.99)) if key == "damping_ratio" else LONGER * own
            found.append(Control(key, label, unit, hint, 0.01 * own, end, 0.01 * own))
    for body, label in SPALLED.items():
        if (own := values.get(key := f"{body}_spall_mm")) is not None:
            found.append(Control(key, label, "mm", "width; 0: none", 0.0, max(0.3 * wide, own), 0.05))
        if body == "outer_ring":
            at = "Angle of that spall", "°", "from the load, counter-clockwise", -180.0, 180.0, 1.0
            found.append(Control("outer_ring_spall_deg", *at, needs=key))
    return tuple(found)


def measured(names: Container[str]) -> tuple[str, str]:
    """Accelerations, x and y, that an accelerometer would show: of sensor, housing or hub, whichever there is first."""
    x = next(name for name in ("housing_ax", "inner_ax") if name in names)
    return x, next(name for name in ("sensor_ay", "housing_ay", "inner_ay") if name in names)


class Record:
    """The last samples of a run: acceleration for spectra, the hub's places since the last frame."""

    def __init__(self, interval: float):
        self._interval = interval  # s, between samples
        self._acceleration = self._way = np.zeros((2, 0))

    def add(self, samples: Samples) -> None:
        """Take the next samples."""
        found = np.array([samples[name] for name in measured(samples.values)])
        self._acceleration = np.concatenate([self._acceleration, found], axis=1)[:, -LONGEST:]
        place = np.array(from_outer_ring(samples, "inner"))
        self._way = np.concatenate([self._way, place], axis=1)[:, -LONGEST:]

    def orbit(self) -> np.ndarray:
        """Places of the hub since the last call, at most MOST_PLACES, evenly chosen, (2, n), m."""
        way, self._way = self._way, np.zeros((2, 0))
        return way[:, :: -(-way.shape[1] // MOST_PLACES) or 1]

    length = property(lambda self: self._acceleration.shape[1] * self._interval)  # time that the spectrum is of, s

    def spectrum(self) -> tuple[np.ndarray, np.ndarray]:
        """Amplitudes of the measured acceleration, (2, n), m/s², x and y, by frequencies, (n,), Hz.
        Each is the highest of its band, BANDS of equal ratio; none where the record is too short."""
        if self._acceleration.shape[1] < SHORTEST:
            return np.zeros(0), np.zeros((2, 0))
        from scipy.signal import periodogram  # costs a second to import

        frequency, power = periodogram(
            self._acceleration, 1.0 / self._interval, window="hann", detrend="constant", scaling="spectrum"
        )
        shown = (frequency >= LOWEST) & (frequency <= HIGHEST)
        frequency, amplitude = frequency[shown], np.sqrt(2.0 * power[:, shown])
        band = np.floor(np.log(frequency / LOWEST) / np.log(HIGHEST / LOWEST) * BANDS)
        first = np.flatnonzero(np.diff(band, prepend=-1.0))
        last = np.append(first[1:], frequency.size) - 1
        return np.sqrt(frequency[first] * frequency[last]), np.maximum.reduceat(amplitude, first, axis=1)

    def envelope(self, lines: dict[str, float]) -> tuple[float, np.ndarray, dict[str, float]]:
        """Spectrum of the envelope of the acceleration along y, from 3 BPFI to 20 kHz.
        Returns step between frequencies, Hz; amplitudes, (n,), m/s², from 0 to 2.3 times the highest line; that of each
        line in the band, m/s², the highest within its slip, up to 15 % low where it lies between two frequencies; none
        where the bearing stands or the record holds fewer than eight passes"""
        passing, inner, n = lines["BPFO"], lines["BPFI"], self._acceleration.shape[1]
        if passing * self.length < FEWEST_PASSES or ENVELOPE_FROM * inner >= HIGHEST:
            return 0.0, np.zeros(0), {}
        from scipy import fft

        transform = fft.rfft(self._acceleration[1])
        frequency = fft.rfftfreq(n, self._interval)
        step, window = float(frequency[1]), np.hanning(n)
        analytic = np.zeros(n, dtype=complex)
        inside = (frequency >= ENVELOPE_FROM * inner) & (frequency <= HIGHEST)
        analytic[: transform.size][inside] = 2.0 * transform[inside]
        level = np.abs(fft.ifft(analytic))
        amplitude = 2.0 * np.abs(fft.rfft((level - level.mean()) * window)) / window.sum()
        end = min(ENVELOPE_TO * max(lines.values()), HIGHEST)
        found = {}
        for name, line in lines.items():
            if line < HIGHEST:
                low, high = line * (1.0 - SLOWER) / step - 0.5, line * (1.0 + FASTER) / step + 0.5
                found[name] = float(amplitude[int(np.ceil(low)) : int(high) + 1].max())
        return step, amplitude[: int(end / step) + 1], found


class Player:
    """A scene, the values that viewers have chosen, and the run of both.
    New values begin a new run, from its own steady state (or from rest, if the scene says so) with roller 0 where it
    was: positions that belong to other values would be a blow that nobody has given."""

    def __init__(self, scene: Scene, tell: Callable[[str], None] | None = None):
        """Plan a scene's run; `tell` gets a sentence if that takes long. UsageError: the model can't take the scene.
        RunFailed: it has no start."""
        for key in IN_PLACE_OF:
            if (name := getattr(scene.operation, key)) is not None:
                raise UsageError(
                    f'operation.{key} = "{name}": run-live has sliders for speed and load; leave the table out, or use '
                    "run-fem"
                )
        self.given, self.controls = scene, controls(scene)
        self._begin(scene, scene.operation.first_roller_deg, tell)

    def change(self, values: dict[str, float], tell: Callable[[str], None] | None = None) -> None:
        """Begin with other values. SceneError, UsageError, RunFailed: they can't be used; the run is as before."""
        if values.keys() != values_of(self.given).keys():
            raise UsageError(f"values: give {', '.join(values_of(self.given))}, and no others")
        self._begin(changed(self.given, values), self._first_roller(), tell)

    def _begin(self, scene, first_roller, tell):
        operation = scene.operation.model_copy(update=dict(first_roller_deg=first_roller))
        numerics = scene.numerics.model_copy(update=dict(duration_ms=LONGEST_MS, output_interval_us=INTERVAL_US))
        played = scene.model_copy(update=dict(operation=operation, numerics=numerics))
        plan = make_plan(played)
        state = plan.prepare(tell)
        samples = _good(state.advance(1))
        self.scene, self.plan, self._state = scene, plan, state
        self.bearing, self._axial, self._cage = played.ideal_bearing(), scene.ideal_axial(), scene.ideal_cage()
        self._operation = played.ideal_operation()
        self._frequencies = kinematics(scene.perfect_bearing(), *self._operation.ring_speeds).frequencies
        self._pressures = None if self._axial is None else np.zeros((self.bearing.n_rollers, self._axial.slices))
        self._restarted: str | None = None
        self._start(samples)

    def _start(self, samples):
        self.record = Record(self.plan.interval)
        self.turn = np.zeros(self.bearing.n_rollers)  # rad, of rollers about their own axes
        self._worst = 0.0  # J
        self._take(samples)

    def _take(self, samples):
        self.record.add(samples)
        self.turn += samples["roller_spin"].sum(axis=0) * self.plan.interval
        self.now = {name: values[-1] for name, values in samples.values.items()}
        self._worst = max(self._worst, float(np.abs(samples.error).max()))
        least = NO_ENERGY * abs(float(samples["energy_kinetic"][-1]))
        self._imbalance = self._worst / max(float(samples.exchanged[-1]), least, 1e-30)
        return len(samples)

    def _first_roller(self):  # its angle from the load, degrees
        return degrees(remainder(float(self.now["roller_theta"][0]) - FROM_LOAD, 2.0 * pi))

    def advance(self, count: int, give_up: Callable[[], bool] = lambda: False) -> int:
        """Go on by so many samples, fewer if `give_up` says so between blocks of them; how many it were. RunFailed: the
        run went wrong numerically; it stands where it last was sound."""
        done = 0
        while done < count and not (done and give_up()):
            if self._state.done == self.plan.n_samples:
                self._begin(self.scene, self._first_roller(), None)
            per_block = max(1, STEPS_PER_BLOCK // self._state.steps_per_sample)
            block = self._state.advance(min(per_block, count - done, self.plan.n_samples - self._state.done))
            if block.restarts is not None:
                self._restarted = block.restarts
                self._start(_good(self._state.advance(1)))
            else:
                done += self._take(_good(block))
        return done

    def fault_lines(self) -> dict[str, float]:
        """Kinematic lines of damage of outer ring, inner ring and rolling element, Hz."""
        found = self._frequencies
        return {"BPFO": abs(found["BPFO"]), "BPFI": abs(found["BPFI"]), "2×BSF": 2.0 * abs(found["BSF"])}

    def warnings(self) -> tuple[str, ...]:
        """What plan and run warn of so far; not of samples, which are the page's own and which nobody stores."""
        kept = [sentence for sentence in self.plan.warnings if not sentence.startswith("numerics.output_interval_us")]
        late = (self._restarted, UNBALANCED if self._imbalance > LIMIT else None)
        return (*kept, *self._state.warnings, *filter(None, late))

    def facts(self) -> dict[str, object]:
        """What a page needs of a run that begins: lengths in mm, angles in rad, from +x; frequencies in Hz."""
        bearing, scene, axial = self.bearing, self.scene, self._axial
        return {
            "values": values_of(scene), "given": values_of(self.given),
            "rollers": bearing.n_rollers, "pockets": bearing.pockets, "roller": bearing.roller_radius / MM,
            "inner": bearing.inner_raceway_radius / MM, "outer": bearing.outer_raceway_radius / MM,
            "bore": bearing.core_radius / MM, "outside": bearing.outside_radius / MM,
            "play": None if self._cage is None else self._cage.pocket_clearance / MM,
            "spalls": [
                dict(body=fault.body, roller=fault.roller, angle=fault.angle,
                     half=fault.half_opening(bearing.roller_radius) / own_radius(bearing, fault))
                for fault in bearing.faults if isinstance(fault, Spall)
            ],
            "lines": [dict(name=k, frequency=f, meaning=LINES[k]) for k, f in self._frequencies.items() if f > 0.0],
            "faults": [dict(name=k, frequency=f) for k, f in self.fault_lines().items() if f > 0.0],
            "slices": None if axial is None else _short(axial.centres(bearing) / MM),
            "length": bearing.roller_length / MM, "step": self.plan.time_step / UM, "start": scene.numerics.start,
            "toml": scene.to_toml(),
        }  # fmt: skip

    def frame(self) -> dict[str, object]:
        """An instant: ms, µm, N, MPa, rad, m/s², envelope in g; angles of rollers from the load, counter-clockwise."""
        now = self.now
        if self._axial is not None:
            with suppress(ValueError, RuntimeError):  # a roller that all but lifts: the frame before is shown
                at = now | {"roller_turn": self.turn}
                self._pressures = slice_pressures(self.scene, "inner", scene_slices(self.scene)[0], at.__getitem__)[0]
        frequency, amplitude = self.record.spectrum()
        step, envelope, at_lines = self.record.envelope(self.fault_lines())
        shaft, ring = (float(np.remainder(speed * now["time"], 2.0 * pi)) for speed in self._operation.ring_speeds)
        cage = None
        if self._cage is not None:
            cage = float(np.remainder(self._operation.first_roller_angle + now["cage_angle"], 2.0 * pi))
        return {
            "time": float(now["time"]) / MM, "hub": _short(np.array(from_outer_ring(now, "inner")) / UM),
            "cage": cage, "shaft": shaft, "ring": ring,
            "angle": _short(np.remainder(now["roller_theta"] - FROM_LOAD + pi, 2.0 * pi) - pi, 5),
            "rise": _short((now["roller_rho"] - self.bearing.pitch_radius) / UM),
            "turn": _short(np.remainder(self.turn, 2.0 * pi), 4),
            "inner": _short(now["inner_force"], 2), "outer": _short(now["outer_force"], 2),
            "pressures": None if self._pressures is None else _short(self._pressures / MPA, 0),
            "orbit": _short(self.record.orbit() / UM, 4), "frequency": _short(frequency, 1),
            "amplitude": [[float(f"{value:.4g}") for value in axis] for axis in amplitude],
            "envelope": {
                "bin": step, "amplitude": [float(f"{value:.3g}") for value in envelope / G],
                "lines": {name: value / G for name, value in at_lines.items()},
            },
            "record": self.record.length / MM, "imbalance": self._imbalance, "balanced": self._imbalance <= LIMIT,
            "cautions": self.warnings(),
        }  # fmt: skip


def _short(values, digits=3):
    return np.round(values, digits).tolist()


def _good(block):
    if block.trouble is not None:
        raise RunFailed(block.trouble)
    return block.samples
