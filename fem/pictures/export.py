"""Meshes and fields for other programs: points where the rigid motion takes them, displacement, the meshes' stress.

A series is one VTKHDF file, which ParaView opens. A single instant goes out in whatever `meshes.export` can write.
Stress is the mesh's own, without what lies below the grid of a contact.
"""

from collections.abc import Callable, Sequence
from pathlib import Path

import h5py
import numpy as np

from fem.elastic.bodies import max_shear, von_mises
from fem.pictures.recover import Instant, StoredRun
from fem.pictures.stress_below import FIRST_ROLLER, INNER_RING, OUTER_RING
from fem.solver.frames import global_fields, rotated
from lagrange.files.hdf5 import hdf5_to_write
from lagrange.files.output import replaced
from meshes.export import write_fields

VTK_TRIANGLE, VTK_QUAD = 5, 9


def write_instant(run: StoredRun, target: Path, sample: int) -> None:
    """One instant, in the format of the name's ending. UsageError: damaged run. OSError: it can't be written."""
    instant = run.instant(sample)
    points, data = fields(instant)
    blocks, bodies = _cells(instant)
    write_fields(target, points, blocks, data, {"body": bodies})


def write_series(run: StoredRun, target: Path, samples: Sequence[int], count: Callable[[], None]) -> None:
    """All the samples, as .vtkhdf; `count` is called after each. Errors as `write_instant`."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with replaced(target) as part, hdf5_to_write(part) as file:
        _write_vtkhdf(file, run, samples, count)


def fields(instant: Instant) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Points, (n, 2), m, and data at them: inner ring, outer ring, then the rollers; SI, fixed axes, single precision.

    displacement (n, 3); stress (n, 9), the tensor by rows; von_mises, max_shear (n,)
    """
    model, found = instant.model, global_fields(instant.model, instant)
    inner, outer, disc = model.inner_ring, model.outer_ring, model.roller
    rollers = rotated(disc.points[None], instant.roller_turn[:, None]) + instant.centres[:, None]
    turned_ring = rotated(inner.points, instant.ring_turn) + instant.hub
    points = np.concatenate([turned_ring, rotated(outer.points, instant.outer_turn), rollers.reshape(-1, 2)])
    bodies = [found[name] for name in ("inner_ring", "outer_ring", "roller")]
    displacement = np.concatenate([moved.reshape(-1, 2) for moved, _ in bodies])
    stress = np.concatenate([strained.reshape(-1, 3) for _, strained in bodies])
    count = [len(inner.points), len(outer.points), instant.roller_turn.size * len(disc.points)]
    poisson = np.repeat([body.material.poisson_ratio for body in (inner, outer, disc)], count)
    tensor = np.zeros((len(points), 3, 3))
    tensor[:, 0, 0], tensor[:, 1, 1], tensor[:, 0, 1] = stress.T
    tensor[:, 1, 0], tensor[:, 2, 2] = tensor[:, 0, 1], poisson * (tensor[:, 0, 0] + tensor[:, 1, 1])
    data = {
        "displacement": np.column_stack([displacement, np.zeros(len(points))]),
        "stress": tensor.reshape(-1, 9),
        "von_mises": von_mises(stress, poisson),
        "max_shear": max_shear(stress),
    }
    return points, {name: values.astype(np.float32) for name, values in data.items()}


def _cells(instant: Instant) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Cells of the rings and of the rollers, and the number of each one's body."""
    model, n = instant.model, instant.roller_turn.size
    inner, outer, disc = model.inner_ring, model.outer_ring, model.roller
    first = len(inner.points) + len(outer.points)
    starts = first + len(disc.points) * np.arange(n)
    blocks = [
        np.concatenate([inner.cells, outer.cells + len(inner.points)]),
        (disc.cells[None] + starts[:, None, None]).reshape(-1, 3),
    ]
    rings = np.repeat([INNER_RING, OUTER_RING], [len(inner.cells), len(outer.cells)])
    return blocks, [rings, np.repeat(FIRST_ROLLER + np.arange(n), len(disc.cells))]


def _write_vtkhdf(file: h5py.File, run: StoredRun, samples: Sequence[int], count: Callable[[], None]) -> None:
    """An unstructured grid whose cells stay and whose points move.

    Source: VTK file formats, "VTKHDF", version 2.0, transient data.
    """
    instant = run.instant(samples[0])
    blocks, bodies = _cells(instant)
    corners = np.concatenate([np.full(len(cells), cells.shape[1]) for cells in blocks])
    kinds = {3: VTK_TRIANGLE, 4: VTK_QUAD}
    root = file.create_group("VTKHDF")
    root.attrs["Version"] = (2, 0)
    root.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", len("UnstructuredGrid")))
    n_points = len(fields(instant)[0])
    for name, value in (
        ("NumberOfPoints", [n_points]),
        ("NumberOfCells", [len(corners)]),
        ("NumberOfConnectivityIds", [int(corners.sum())]),
        ("Connectivity", np.concatenate([cells.ravel() for cells in blocks])),
        ("Offsets", np.concatenate([[0], np.cumsum(corners)])),
    ):
        root.create_dataset(name, data=np.asarray(value, dtype=np.int64))
    root.create_dataset("Types", data=np.array([kinds[k] for k in corners], dtype=np.uint8))
    root.create_dataset("CellData/body", data=np.concatenate(bodies).astype(np.int32))

    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = len(samples)
    steps.create_dataset("Values", data=run.times[list(samples)])
    moving, still = n_points * np.arange(len(samples)), np.zeros(len(samples), dtype=np.int64)
    for name, value in (
        ("PartOffsets", still), ("NumberOfParts", still + 1), ("PointOffsets", moving),
        ("CellOffsets", still[:, None]), ("ConnectivityIdOffsets", still[:, None]), ("CellDataOffsets/body", still),
    ):  # fmt: skip
        steps.create_dataset(name, data=value)
    for step, sample in enumerate(samples):
        points, data = fields(run.instant(sample))
        rows = {"Points": np.column_stack([points, np.zeros(n_points)])}
        rows |= {f"PointData/{name}": values for name, values in data.items()}
        for name, values in rows.items():
            if step == 0:
                shape = (n_points * len(samples), *values.shape[1:])
                root.create_dataset(
                    name, shape=shape, dtype=values.dtype, chunks=values.shape, compression="gzip",
                    compression_opts=4, shuffle=True,
                )  # fmt: skip
                if name != "Points":
                    steps.create_dataset(name.replace("PointData", "PointDataOffsets"), data=moving)
            root[name][step * n_points : (step + 1) * n_points] = values
        count()
