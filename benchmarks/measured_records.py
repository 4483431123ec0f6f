"""Verdicts on a folder of measured records: `python -m benchmarks.measured_records FOLDER` prints a table.

Each record is an .npz with `x` and `scale`, `rate` (Hz), `shaft` (nominal, Hz), `label` (outer, inner, element, none),
`width_mm`, and `geometry` (number of rolling elements, their diameter and the pitch diameter in mm, contact angle in
degrees); `--speed-tolerance` in per cent, for names that begin with a given word: `--wide O_=7`.
"""

import argparse
import sys
import time
from math import radians
from pathlib import Path

import numpy as np

from residual.measured.diagnosis import Geometry, diagnose
from residual.measured.signals import Signal


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--speed-tolerance", type=float, default=1.0)
    parser.add_argument("--wide", action="append", default=[])
    options = parser.parse_args()
    wide = dict(each.split("=") for each in options.wide)
    print("| record | true | verdict | line found / kinematic, Hz | clear | depth | width, mm | seconds |")
    print("|---|---|---|---|---|---|---|---|")
    for path in sorted(options.folder.glob("*.npz")):
        with np.load(path) as file:
            values, rate, shaft = file["x"] * float(file["scale"]), float(file["rate"]), float(file["shaft"])
            count, diameter, pitch, angle = map(float, file["geometry"])
            label, width = str(file["label"]), float(file["width_mm"])
        tolerance = next(
            (float(t) for start, t in wide.items() if path.name.startswith(start)), options.speed_tolerance
        )
        signal = Signal(name=path.stem, values=values - values.mean(), rate=rate, unit="")
        geometry = Geometry(
            elements=int(count), element_diameter=1e-3 * diameter, pitch_diameter=1e-3 * pitch,
            contact_angle=radians(angle),
        )  # fmt: skip
        begun = time.process_time()
        found = diagnose(signal, geometry, shaft, 1e-2 * tolerance)
        best, spent = found.findings[0], time.process_time() - begun
        true = label + ("" if label == "none" or not width > 0.0 else f", {width:.2f} mm")
        print(f"| {path.stem} | {true} | {found.verdict} | {best.name} {best.found:.2f} / {best.expected:.2f} | "
              f"{best.clear:.1f} | {best.depth:.2f} | - | {spent:.2f} |")  # fmt: skip
    return 0


if __name__ == "__main__":
    sys.exit(main())
