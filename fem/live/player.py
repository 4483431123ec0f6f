"""A run that goes on for as long as it is watched, and restarts where values are changed."""

from collections.abc import Callable, Container
from contextlib import suppress
from math import degrees, pi, remainder

import numpy as np

from fem.errors import RunFailed, UsageError
from fem.live.controls import Values
from fem.solver.reduced_state import LIMIT
from fem.solver.simulate import make_plan
from fem.solver.solver import Samples
from fem.statics.tilted_pressures import scene_slices, slice_pressures
from lagrange.kinematics import kinematics
from lagrange.mounting import from_outer_ring
from lagrange.scene.operation import TABLES
from lagrange.scene.scene import Scene

LONGEST = 2**15  # samples that a spectrum is of
SHORTEST = 256
LOWEST, HIGHEST = 20.0, 20e3  # Hz, of the spectrum shown; beyond, bodies without mass are not those of steel
BANDS = 300
MOST_PLACES = 500  # of an orbit, a frame
ENVELOPE_FROM, ENVELOPE_TO = 3.0, 2.3  # times BPFI: the band that is demodulated, up to HIGHEST; the spectrum shown
FEWEST_PASSES = 8.0  # of rolling elements over a place of the outer ring, for an envelope
SLOWER, FASTER = 0.02, 0.005  # shares of a line's frequency by which slip moves it


def measured(names: Container[str]) -> tuple[str, str]:
    """Accelerations, x and y, that an accelerometer would show: of sensor, housing or hub, whichever there is first."""
    x = next(name for name in ("housing_ax", "inner_ax") if name in names)
    return x, next(name for name in ("sensor_ay", "housing_ay", "inner_ay") if name in names)


class Record:
    """The last samples of a run, for charts: the hub's orbit since the last frame, the spectrum of an acceleration."""

    def __init__(self, interval: float):
        self._interval = interval  # s, between samples
        self._acceleration = np.zeros((2, 0))
        self._orbit = np.zeros((2, 0))

    def add(self, samples: Samples) -> None:
        """Take the next samples."""
        acceleration = np.array([samples[name] for name in measured(samples.values)])
        self._acceleration = np.concatenate([self._acceleration, acceleration], axis=1)[:, -LONGEST:]
        place = np.array(from_outer_ring(samples, "inner"))
        self._orbit = np.concatenate([self._orbit, place], axis=1)[:, -LONGEST:]

    def orbit(self) -> np.ndarray:
        """Places of the hub since the last call, at most MOST_PLACES, evenly chosen, (2, n), m."""
        way, self._orbit = self._orbit, np.zeros((2, 0))
        return way[:, :: -(-way.shape[1] // MOST_PLACES) or 1]

    @property
    def length(self) -> float:
        """Time that the spectrum is of, s."""
        return self._acceleration.shape[1] * self._interval

    def spectrum(self) -> tuple[np.ndarray, np.ndarray]:
        """Amplitudes of the measured acceleration, (2, n), m/s², x and y, by frequencies, (n,), Hz.

        Each is the highest of its band, BANDS of equal ratio; none where the record is too short.
        """
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

        Returns
        -------
        step between frequencies, Hz; amplitudes, (n,), m/s², from 0 to 2.3 BPFI; that of each line, m/s², the highest
        within its slip, up to 15 % low where it lies between two frequencies; none where the bearing stands or the
        record holds fewer than eight passes
        """
        passing, inner, n = lines["BPFO"], lines["BPFI"], self._acceleration.shape[1]
        if passing * self.length < FEWEST_PASSES or ENVELOPE_FROM * inner >= HIGHEST:
            return 0.0, np.zeros(0), {}
        from scipy import fft

        transform = fft.rfft(self._acceleration[1])
        frequency = fft.rfftfreq(n, self._interval)
        analytic = np.zeros(n, dtype=complex)
        inside = (frequency >= ENVELOPE_FROM * inner) & (frequency <= HIGHEST)
        analytic[: transform.size][inside] = 2.0 * transform[inside]
        level = np.abs(fft.ifft(analytic))
        window = np.hanning(n)
        step = float(frequency[1])
        amplitude = 2.0 * np.abs(fft.rfft((level - level.mean()) * window)) / window.sum()
        amplitude = amplitude[: int(ENVELOPE_TO * inner / step) + 1]
        at = step * np.arange(amplitude.size)
        found = {
            name: float(
                amplitude[(at > line * (1.0 - SLOWER) - 0.5 * step) & (at < line * (1.0 + FASTER) + 0.5 * step)].max()
            )
            for name, line in lines.items()
        }
        return step, amplitude, found


def fault_lines(scene: Scene) -> dict[str, float]:
    """Kinematic lines of damage of outer ring, inner ring and rolling element, Hz."""
    found = kinematics(scene.perfect_bearing(), *scene.ideal_operation().ring_speeds).frequencies
    return {"BPFO": abs(found["BPFO"]), "BPFI": abs(found["BPFI"]), "2×BSF": 2.0 * abs(found["BSF"])}


LONGEST_MS = 1e5  # simulated; then the run restarts
INTERVAL_US = 10.0  # between samples
STEPS_PER_BLOCK = 5000  # some milliseconds of work: how long an answer may take
UNBALANCED = (
    f"energy has not balanced to {100 * LIMIT:g} % of what was exchanged, where run-fem restarts with half the "
    "step: take what you see as rough"
)
NO_ENERGY = 1e-9  # of the kinetic energy: less is not exchanged, it is round-off
FROM_LOAD = -0.5 * pi  # rad, of the load's direction from +x


class Player:
    """A scene, the values that viewers have chosen, and the run of both.

    New values begin a new run, from its own steady state (or from rest, if the scene says so) with roller 0 where it
    was: positions that belong to other values would be a blow that nobody has given.
    """

    def __init__(self, scene: Scene, tell: Callable[[str], None] | None = None):
        """Plan a scene's run; `tell` gets a sentence if that takes long.

        Errors
        ------
        UsageError: the model can't take the scene. RunFailed: it has no start.
        """
        for key in TABLES:
            if (name := getattr(scene.operation, key)) is not None:
                raise UsageError(
                    f'operation.{key} = "{name}": run-live goes on without end, under a speed and a load that are '
                    "set by sliders; leave it out, or take run-fem"
                )
        self._given = scene
        self._begin(scene, scene.operation.first_roller_deg, tell)

    @property
    def values(self) -> Values:
        """Those in use."""
        return Values.of(self.scene)

    @property
    def given_values(self) -> Values:
        """Those of the scene as it was given."""
        return Values.of(self._given)

    def change(self, values: Values, tell: Callable[[str], None] | None = None) -> None:
        """Begin again with other values.

        Errors
        ------
        SceneError, UsageError, RunFailed: they can't be used; the run is as before.
        """
        self._begin(values.put_into(self._given), self._first_roller(), tell)

    def _begin(self, scene: Scene, first_roller: float, tell: Callable[[str], None] | None) -> None:
        numerics = {"duration_ms": LONGEST_MS, "output_interval_us": INTERVAL_US}
        played = scene.model_copy(
            update={
                "operation": scene.operation.model_copy(update={"first_roller_deg": first_roller}),
                "numerics": scene.numerics.model_copy(update=numerics),
            }
        )
        plan = make_plan(played)
        state = plan.prepare(tell)
        samples = _good(state.advance(1))
        self.scene, self.plan, self._state = scene, plan, state
        self.bearing = played.ideal_bearing()
        self._slices = None if (axial := scene.ideal_axial()) is None else scene_slices(scene)[0]
        self._pressures = None if axial is None else np.zeros((self.bearing.n_rollers, axial.slices))
        self._restarted = None
        self._start(samples)

    def _start(self, samples: Samples) -> None:
        self.record = Record(self.plan.interval)
        self.fault_lines = fault_lines(self.scene)
        self.turn = np.zeros(self.bearing.n_rollers)  # rad, of rollers about their own axes
        self._worst = 0.0  # J
        self._take(samples)

    def _take(self, samples: Samples) -> None:
        self.record.add(samples)
        self.turn += samples["roller_spin"].sum(axis=0) * self.plan.interval
        self.now = {name: values[-1] for name, values in samples.values.items()}
        self._worst = max(self._worst, float(np.abs(samples.error).max()))
        least = NO_ENERGY * abs(float(samples["energy_kinetic"][-1]))
        self.imbalance = self._worst / max(float(samples.exchanged[-1]), least, 1e-30)

    def _first_roller(self) -> float:
        """Angle of roller 0 from the load, degrees."""
        return degrees(remainder(float(self.now["roller_theta"][0]) - FROM_LOAD, 2.0 * pi))

    def advance(self, count: int, give_up: Callable[[], bool] = lambda: False) -> int:
        """Go on by so many samples, fewer if `give_up` says so between blocks of them; how many it were.

        Errors
        ------
        RunFailed: the run went wrong numerically; it stands where it last was sound.
        """
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
                self._take(_good(block))
                done += len(block.samples)
        return done

    def pressures(self) -> np.ndarray | None:
        """Pressures now along rollers on the inner raceway, (n_rollers, n_slices), Pa; None: axes stay parallel."""
        if self._slices is None:
            return None
        now = self.now | {"roller_turn": self.turn}
        with suppress(ValueError, RuntimeError):  # a roller that all but lifts: the frame before is shown
            self._pressures = slice_pressures(self.scene, "inner", self._slices, now.__getitem__)[0]
        return self._pressures

    @property
    def warnings(self) -> tuple[str, ...]:
        """What plan and run warn of so far; not of samples, which are the page's own and which nobody stores."""
        kept = (sentence for sentence in self.plan.warnings if not sentence.startswith("numerics.output_interval_us"))
        found = (*kept, *self._state.warnings)
        if self._restarted is not None:
            found = (*found, self._restarted)
        return found if self.is_balanced else (*found, UNBALANCED)

    @property
    def is_balanced(self) -> bool:
        """Whether the largest error of the run's energy is small beside what was exchanged."""
        return self.imbalance <= LIMIT


def _good(block) -> Samples:
    if block.trouble is not None:
        raise RunFailed(block.trouble)
    return block.samples
