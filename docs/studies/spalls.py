"""A labelled set of spalls: `python spalls.py 1000` writes spalls.csv, `python spalls.py` classifies studies/spalls.

`python spalls.py --records FOLDER` lets it answer for measured records too, in .npz files
of `x` and `scale`, `rate` and `shaft` (Hz), `label` and `geometry` (number, diameters in mm).
The classifier is a forest of trees on the levels of the envelope's lines; noise is put on the signals of both halves.
It needs scikit-learn, xarray and netCDF4: python -m pip install scikit-learn xarray netCDF4
"""

import sys
from collections import Counter
from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path

import numpy as np

BODIES = ["none", "outer_ring", "inner_ring", "roller"]
LINES = ["BPFO", "BPFI", "BSF", "FTF"]
NOISES = (0.0, 1.0, 3.0)  # rms over that of the signal


def points(count: int) -> None:
    """Write spalls of random body, place and size, at random speed and load."""
    rng = np.random.default_rng(1)
    with open("spalls.csv", "w") as file:
        file.write("operation.speed_rpm,operation.radial_load_N,spall.0.body,spall.0.roller,")
        file.write("spall.0.angle_deg,spall.0.width_mm,spall.0.depth_um\n")
        for i in range(count):
            body = BODIES[i % len(BODIES)]
            operation = f"{rng.uniform(1500, 4500):.1f},{rng.uniform(1000, 3000):.1f}"
            loaded = rng.uniform(-40, 40) if body == "outer_ring" else rng.uniform(-180, 180)
            spall = f"{loaded:.1f},{rng.choice([0.8, 1.0, 1.2, 1.5, 2.0])},100.0"
            roller = rng.integers(13) if body == "roller" else ""
            file.write(f"{operation},,,,,\n" if body == "none" else f"{operation},{body},{roller},{spall}\n")


def features(data, noise: float, rng) -> np.ndarray:
    """Levels of the envelope's spectrum at the kinematic lines and their doubles, over its median, (n_points, 8)."""
    signal = data.inner_ay.values
    signal = signal + noise * signal.std(axis=1, keepdims=True) * rng.standard_normal(signal.shape)
    step, n = float(data.time[1] - data.time[0]), signal.shape[1]
    beat = np.diff(signal, axis=1) ** 2  # shocks live at high frequencies
    spectrum = np.abs(np.fft.rfft((beat - beat.mean(axis=1, keepdims=True)) * np.hanning(n - 1)))
    frequency = np.fft.rfftfreq(n - 1, step)
    found = []
    for line in LINES:
        for harmonic in (1, 2):
            near = np.abs(frequency - harmonic * data[f"{line}_Hz"].values[:, None]) < 1.5 * frequency[1]
            found.append(np.where(near, spectrum, 0.0).max(axis=1) / np.median(spectrum, axis=1))
    return np.log(np.array(found).T)


def measured(folder: str, path: str = "studies/spalls/study.nc") -> None:
    """Train on all points; print answers for measured records, whole and by pieces as long as simulated signals."""
    import xarray
    from scipy.signal import resample_poly
    from sklearn.ensemble import RandomForestClassifier

    from residual.measured.diagnosis import Geometry

    data = xarray.open_dataset(path)
    data = data.isel(point=np.flatnonzero(data.status.values == "complete"))
    step, n = float(data.time[1] - data.time[0]), data.time.size
    for noise in NOISES[:2]:
        forest = RandomForestClassifier(300, random_state=0)
        forest.fit(features(data, noise, np.random.default_rng(2)), data.spall_body.values.astype(str))
        for record in sorted(Path(folder).glob("*.npz")):
            with np.load(record) as file:
                count, *sizes, angle = map(float, file["geometry"])
                ratio = Fraction(1.0 / step / float(file["rate"])).limit_denominator(1000)
                signal = resample_poly(file["x"] - file["x"].mean(), ratio.numerator, ratio.denominator)
                geometry = Geometry(
                    elements=int(count), element_diameter=sizes[0], pitch_diameter=sizes[1],
                    contact_angle=np.radians(angle),
                )  # fmt: skip
                lines, label = geometry.lines(float(file["shaft"])), str(file["label"])
            answers = []
            for pieces in (signal[None], signal[: len(signal) // n * n].reshape(-1, n)):
                of_lines = {f"{name}_Hz": ("point", np.full(len(pieces), lines[name])) for name in LINES}
                time = step * np.arange(pieces.shape[1])
                made = xarray.Dataset(of_lines | {"inner_ay": (("point", "time"), pieces)}, coords={"time": time})
                answers.append(Counter(forest.predict(features(made, 0.0, np.random.default_rng(3))).tolist()))
            pieces = ", ".join(f"{name} {count}" for name, count in answers[1].most_common())
            print(f"noise {noise:g}: {record.stem}, {label}: whole {answers[0].most_common(1)[0][0]}; pieces {pieces}")


def classify(path: str = "studies/spalls/study.nc") -> None:
    """Train on half of the points; print a confusion matrix of the other half for each noise, truth by rows."""
    import xarray
    from sklearn.ensemble import RandomForestClassifier
    from sklearn.metrics import confusion_matrix
    from sklearn.model_selection import train_test_split

    data = xarray.open_dataset(path)
    data = data.isel(point=np.flatnonzero(data.status.values == "complete"))
    for noise in NOISES:
        X, y = features(data, noise, np.random.default_rng(2)), data.spall_body.values.astype(str)
        X_train, X_test, y_train, y_test = train_test_split(X, y, test_size=0.5, random_state=0, stratify=y)
        forest = RandomForestClassifier(300, random_state=0).fit(X_train, y_train)
        told = forest.predict(X_test)
        print(f"noise {noise:g}: {np.mean(told == y_test):.1%} of {len(y_test)} right")
        print(confusion_matrix(y_test, told, labels=BODIES))


if __name__ == "__main__":
    if missing := [name for name in ("sklearn", "xarray", "netCDF4") if find_spec(name) is None]:
        print(f"needs {', '.join(missing)}: python -m pip install scikit-learn xarray netCDF4", file=sys.stderr)
        if sys.argv[1:2] in ([], ["--records"]):  # points can be written and solved without
            sys.exit(2)
    if sys.argv[1:2] == ["--records"]:
        measured(sys.argv[2])
    else:
        points(int(sys.argv[1])) if len(sys.argv) > 1 else classify()
