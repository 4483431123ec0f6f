"""What an engineer asks of a run's cage: where its centre goes, how it slips, how hard pockets and guide push."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import tau

import numpy as np

from lagrange.mounting import from_outer_ring

CAGE_COLUMNS = ("cage_x", "cage_y", "cage_angle", "cage_force", "cage_radial_force", "cage_guidance_x", "cage_guidance_y")
CENTRED = 1e-9  # m: nearer to the middle the centre has no direction


@dataclass
class SeenCage:
    """What is gathered of a cage's samples; SI."""

    samples: int = 0
    angles: tuple[float, float] = (0.0, 0.0)  # of the cage, first and last, rad
    last_direction: float = 0.0  # of the centre, rad
    whirled: float = 0.0  # by the centre about the bearing's, rad
    off: float = 0.0  # sum of the centre's distances from the bearing's, m
    farthest: float = 0.0  # m
    pushed: float = 0.0  # N, the largest force of a pocket
    guided: float = 0.0  # N, of the guide

    def add(self, samples: Mapping[str, np.ndarray]) -> None:
        """Take in some more samples, by the result file's names."""
        (x, y), angle = from_outer_ring(samples, "cage"), samples["cage_angle"]
        off, direction = np.hypot(x, y), np.arctan2(y, x)
        first = self.samples == 0
        turned = np.diff(direction, prepend=direction[0] if first else self.last_direction)
        turned -= tau * np.round(turned / tau)
        self.whirled += float(turned[off > CENTRED].sum())
        self.angles = float(angle[0]) if first else self.angles[0], float(angle[-1])
        self.last_direction = float(direction[-1])
        self.samples += x.size
        self.off += float(off.sum())
        self.farthest = max(self.farthest, float(off.max()))
        self.pushed = max(self.pushed, float(np.hypot(samples["cage_force"], samples["cage_radial_force"]).max()))
        self.guided = max(self.guided, float(np.hypot(samples["cage_guidance_x"], samples["cage_guidance_y"]).max()))

    def rows(self, seconds: float, ideal: float | None) -> dict[str, str]:
        """Names and values of what is asked, of a run that long, s.

        `ideal` : the cage's speed in rolling, rad/s, 0 where it stands; None: it turns both ways, and has no mean
        """
        found = {
            "cage's centre": f"mean {1e6 * self.off / self.samples:.3g} µm off the bearing's, at most "
            f"{1e6 * self.farthest:.3g} µm",
            "cage's forces": f"at most {self.pushed:.3g} N in a pocket"
            + (f", {self.guided:.3g} N by its guide" if self.guided > 0.0 else ""),
        }
        if seconds > 0.0 and ideal is not None:
            found["cage's centre"] += f", whirls at {self.whirled / seconds / tau:.3g} Hz"
            if ideal:
                speed = (self.angles[1] - self.angles[0]) / seconds
                found["cage's turning"] = f"{speed / tau:.4g} Hz, slip {100.0 * (1.0 - speed / ideal):.2g} % of rolling"
        return found
