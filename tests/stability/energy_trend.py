"""Whether the energy balance of a long run drifts: `python -m tests.stability.energy_trend`, about a minute."""

from dataclasses import dataclass

import numpy as np
from cyclopts import App
from rich.console import Console

from fem.solver.simulate import make_plan, run
from lagrange.scene.scene import read_scene


@dataclass(frozen=True, kw_only=True)
class Trend:
    """Energy imbalance of a run over its mean elastic and contact energy, by whole revolutions of the shaft."""

    means: np.ndarray  # (n_revolutions,)
    largest: float
    period: float  # s

    @property
    def slope(self) -> float:
        """Slope of the least-squares line through the means, 1/s."""
        return float(self._weights @ self.means)

    @property
    def uncertainty(self) -> float:
        """Standard error of the slope, 1/s, scatter of neighbouring means taken as related."""
        left = self.means - self.means.mean() - self.slope * self._time
        squares = float(left @ left) / (left.size - 2)
        related = float(left[1:] @ left[:-1]) / float(left @ left)
        longer = max(1.0, (1.0 + related) / max(1.0 - related, 1e-3))  # of an autoregressive scatter
        return float(np.sqrt(squares * longer * (self._weights @ self._weights)))

    @property
    def _time(self) -> np.ndarray:
        time = self.period * np.arange(self.means.size)
        return time - time.mean()

    @property
    def _weights(self) -> np.ndarray:
        return self._time / (self._time @ self._time)


def measure(overrides: tuple[str, ...], duration_ms: float) -> Trend:
    """Run a scene and take its imbalance apart into revolutions."""
    plan = make_plan(read_scene(None, (*overrides, f"numerics.duration_ms={duration_ms}")))
    imbalance, stored = [], []

    def write(samples) -> None:
        imbalance.append(samples.imbalance)
        stored.append(samples["energy_elastic"] + samples["energy_contact"])

    run(plan, write)
    left = np.concatenate(imbalance) / np.concatenate(stored).mean()
    period = 2.0 * np.pi / abs(plan.operation.speed)
    turn = (np.arange(left.size) * plan.interval / period).astype(int)
    means = np.bincount(turn, left) / np.bincount(turn)
    whole = int(left.size * plan.interval / period)
    return Trend(means=means[:whole], largest=float(np.abs(left).max()), period=period)


app = App(help=__doc__)


@app.default
def main(*, duration: float = 1000.0, mesh_size: float = 2.0, sets: tuple[str, ...] = ()) -> None:
    """Run the paper's scene for long and fit a line through its energy imbalance.

    Parameters
    ----------
    duration
        ms
    mesh_size
        mm
    sets
        further scene keys, as run-fem's --set takes them
    """
    found = measure((f"numerics.mesh_size_mm={mesh_size}", *sets), duration)
    console = Console(highlight=False)
    console.print(f"energy imbalance over {found.means.size} revolutions ({duration:g} ms), of the elastic energy:")
    console.print(f"largest {found.largest:.2e}, first revolution {found.means[0]:+.2e}, last {found.means[-1]:+.2e}")
    console.print(f"slope {found.slope:+.1e} ± {found.uncertainty:.1e} per second")


if __name__ == "__main__":
    app()
