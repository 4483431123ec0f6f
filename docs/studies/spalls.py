"""A labelled set of spalls: `python spalls.py 1000` writes spalls.csv, `python spalls.py` classifies studies/spalls.

The classifier is a forest of trees on the levels of the envelope's lines; noise is put on the signals of both halves.
It needs scikit-learn, xarray and netCDF4: python -m pip install scikit-learn xarray netCDF4
"""

import sys
from importlib.util import find_spec

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
        if not sys.argv[1:]:  # points can be written and solved without
            sys.exit(2)
    points(int(sys.argv[1])) if sys.argv[1:] else classify()
