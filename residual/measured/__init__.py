"""Records of accelerometers.

`formats` knows kinds of files, `signals` reads one channel of one, `diagnosis` finds lines in its envelope and judges
what they say of a bearing, `judged` adds levels and the width of damage; `checks` makes the whole of one record, two
(one of them simulated from a scene) or a series, and writes and prints it.
"""

from dataclasses import dataclass
from pathlib import Path

from lagrange.errors import InputError


@dataclass(frozen=True, kw_only=True)
class Question:
    """What options say: the bearing in one of four ways, its speed, how a record is read.

    Args:
        rate: sampling rate, Hz; default: the record's own
        channel: name, part of a name, or number of the channel
        unit: g, m/s2, mm/s, or V with --sensitivity; default: the file's
        sensitivity: sensitivity of a record in volts: 100mV/g
        bearing: standard bearing: NU206
        scene: scene file (TOML) of the bearing; its speed is the default
        elements: another bearing: number of rolling elements
        element_diameter: diameter of its rolling elements, mm
        pitch_diameter: its pitch diameter, mm
        contact_angle: its contact angle, degrees
        orders: its lines per turn of the shaft, in place of sizes: bpfo=3.05,bpfi=4.95,bsf=1.99,ftf=0.38
        speed: speed of the shaft, rpm
        speed_tolerance: uncertainty of the speed, per cent
    """

    rate: float | None = None
    channel: str | None = None
    unit: str | None = None
    sensitivity: str | None = None
    bearing: str | None = None
    scene: Path | None = None
    elements: int | None = None
    element_diameter: float | None = None
    pitch_diameter: float | None = None
    contact_angle: float = 0.0
    orders: str | None = None
    speed: float | None = None
    speed_tolerance: str = "1%"

    @property
    def tolerance(self) -> float:
        """That of the speed, relative."""
        try:
            return 1e-2 * float(self.speed_tolerance.strip().removesuffix("%"))
        except ValueError:
            given = f"--speed-tolerance {self.speed_tolerance}"
            raise InputError(f"{given}: must be a number of per cent, as 2%") from None
