"""Where pictures, films and exports go, and the fields of other programs.

A file is put in the place of nothing, of one of its own kind, or by --force of any file. Meshes and fields: points
where the rigid motion takes them, displacement, the meshes' stress without what lies below the grid of a contact. A
series is one VTKHDF file, which ParaView opens; a single instant goes out in whatever `meshes.export` can write.
"""

import mmap
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lagrange.errors import UsageError
from lagrange.files.output import refuse_special, replaced

if TYPE_CHECKING:
    from fem.pictures.recover import Instant, StoredRun

MARK = "render-fem"  # in files that have room for a remark
FIELDS = b"von_mises", b"max_shear"  # of meshes with fields, in whatever format
MARKS = {".csv": (b"time_s,inner_ax_m_s2",), **dict.fromkeys((".png", ".gif", ".mp4", ".wav"), (MARK.encode(),))}
QUALITY = "18"  # x264's constant rate factor; text stays sharp
VTK_KINDS = {3: 5, 4: 9}  # triangle and quadrilateral, by corners
# VTK alone, since the libraries are what may be missing: importing pyvista would take most of the time
PROBE = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer
from vtkmodules.vtkRenderingCore import vtkRenderWindow, vtkWindowToImageFilter
sphere, mapper, actor = vtkSphereSource(), vtkPolyDataMapper(), vtkActor()
mapper.SetInputConnection(sphere.GetOutputPort())
actor.SetMapper(mapper)
renderer, window, image = vtkRenderer(), vtkRenderWindow(), vtkWindowToImageFilter()
renderer.AddActor(actor)
window.SetOffScreenRendering(True)
window.SetSize(32, 32)
window.AddRenderer(renderer)
window.Render()
image.SetInput(window)
image.Update()
low, high = image.GetOutput().GetPointData().GetScalars().GetRange(0)
assert high > low, "the picture is blank"
"""
CURE = "apt-get install --no-install-recommends libgl1 libegl1"
PATIENCE = 60.0  # s


def refuse_foreign(target: Path, force: bool) -> None:
    """Refuse to write where a file stands that this program has not written as such an export; an empty one may go.
    UsageError. OSError: it can't be read, or is no plain file."""
    refuse_special(target)
    if force or not target.exists() or target.stat().st_size == 0:
        return
    with open(target, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        if not all(data.find(mark) >= 0 for mark in MARKS.get(target.suffix.lower(), FIELDS)):
            raise UsageError(
                f"{target}: is there already and no export of render-fem; --force replaces it, or name another file"
            )


def check_rendering() -> None:
    """Draw a small picture in a process of its own. UsageError: it failed, with what cures it.
    Where system libraries are missing, VTK ends its process without a word."""
    environment = {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow", **os.environ}
    try:
        probe = [sys.executable, "-P", "-c", PROBE]  # -P: nothing is imported from the current folder
        done = subprocess.run(probe, env=environment, capture_output=True, text=True, timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        raise UsageError(rendering_failure(f"a trial picture was not finished in {PATIENCE:.0f} s")) from None
    except OSError as error:
        raise UsageError(rendering_failure(f"a trial could not be started: {error.strerror}")) from None
    if done.returncode in (-11, 139):
        raise UsageError(rendering_failure("a trial picture crashed: OpenGL libraries are missing"))
    if done.returncode != 0:
        said = [f": {line.strip()[:200]}" for line in done.stderr.splitlines() if line.strip()]
        raise UsageError(rendering_failure(f"a trial picture failed (exit {done.returncode})" + "".join(said[-1:])))


def rendering_failure(reason: str) -> str:
    """Say why nothing can be drawn, and what cures it."""
    return f"this machine can't draw off-screen ({reason}); install the system libraries:\n{CURE}"


def write_film(target: Path, images: Iterator[np.ndarray], frames_per_second: float, typical: np.ndarray) -> None:
    """Write the images, (height, width, 3) bytes, heights and widths even, as a film; whole or not at all.
    MP4 by ffmpeg, which imageio-ffmpeg brings along, or an animated GIF by Pillow. OSError: it can't be written.
    `typical` : one of them, whose colours are those of all frames of a GIF, so that they keep their meaning"""
    import imageio_ffmpeg
    from PIL import Image

    target.parent.mkdir(parents=True, exist_ok=True)
    with replaced(target) as part:
        if target.suffix.lower() == ".gif":
            colours = Image.fromarray(typical).quantize(method=Image.Quantize.MAXCOVERAGE)
            frames = (Image.fromarray(image).quantize(palette=colours, dither=Image.Dither.NONE) for image in images)
            next(frames).save(
                part, format="GIF", save_all=True, append_images=frames, duration=round(1e3 / frames_per_second),
                loop=0, optimize=False, comment=MARK.encode(),
            )  # fmt: skip
            return
        first = next(images)
        writer = imageio_ffmpeg.write_frames(
            str(part), first.shape[1::-1], fps=frames_per_second, codec="libx264", quality=None, macro_block_size=2,
            output_params=["-crf", QUALITY, "-movflags", "+faststart", "-fflags", "+bitexact",
                           "-metadata", f"comment={MARK}", "-f", "mp4"], ffmpeg_log_level="error",
        )  # fmt: skip
        try:
            writer.send(None)
            for image in chain([first], images):
                writer.send(np.ascontiguousarray(image))
        finally:
            writer.close()


def write_instant(run: "StoredRun", target: Path, sample: int) -> None:
    """One instant, in the format of the name's ending. UsageError: damaged run. OSError: it can't be written."""
    from meshes.export import write_fields

    instant = run.instant(sample)
    (points, data), (blocks, bodies) = fields(instant), _cells(instant)
    write_fields(target, points, blocks, data, {"body": bodies})


def write_series(run: "StoredRun", target: Path, samples: Sequence[int], count: Callable[[], None]) -> None:
    """All the samples, as .vtkhdf; `count` is called after each. Errors as `write_instant`."""
    from lagrange.files.hdf5 import hdf5_to_write

    target.parent.mkdir(parents=True, exist_ok=True)
    with replaced(target) as part, hdf5_to_write(part) as file:
        _write_vtkhdf(file, run, samples, count)


def fields(instant: "Instant") -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Points, (n, 2), m, and data at them: inner ring, outer ring, then the rollers; SI, fixed axes, single precision.
    displacement (n, 3); stress (n, 9), the tensor by rows; von_mises, max_shear (n,)"""
    from fem.elastic.bodies import max_shear, von_mises
    from fem.solver.elements.arrays import global_fields, rotated

    of_bodies, surfaces = global_fields(instant.model, instant), instant.surfaces
    places = zip(surfaces, (instant.hub, np.zeros(2), *instant.centres), strict=True)
    points = np.concatenate([rotated(body.points, turn) + place for (body, _, _, turn), place in places])
    parts = [of_bodies[name] for name in ("inner_ring", "outer_ring", "roller")]
    displacement, stress = (
        np.concatenate([part[k].reshape(-1, width) for part in parts]) for k, width in enumerate((2, 3))
    )
    ratios, counts = zip(*((body.material.poisson_ratio, len(body.points)) for body, *_ in surfaces), strict=True)
    poisson, tensor = np.repeat(ratios, counts), np.zeros((len(points), 3, 3))
    tensor[:, 0, 0], tensor[:, 1, 1], tensor[:, 0, 1] = stress.T
    tensor[:, 1, 0], tensor[:, 2, 2] = tensor[:, 0, 1], poisson * (tensor[:, 0, 0] + tensor[:, 1, 1])
    data = {
        "displacement": np.pad(displacement, ((0, 0), (0, 1))), "stress": tensor.reshape(-1, 9),
        "von_mises": von_mises(stress, poisson), "max_shear": max_shear(stress),
    }  # fmt: skip
    return points, {name: values.astype(np.float32) for name, values in data.items()}


def _cells(instant):
    """Cells of the rings and of the rollers, and the number of each one's body."""
    cells, numbers, first = [], [], 0
    for number, (body, *_) in enumerate(instant.surfaces):
        cells.append(body.cells + first)
        numbers.append(np.full(len(body.cells), number))
        first += len(body.points)
    blocks, bodies = ([np.concatenate(each[:2]), np.concatenate(each[2:])] for each in (cells, numbers))
    return blocks, bodies


def _write_vtkhdf(file, run, samples, count):
    """An unstructured grid whose cells stay and whose points move.
    Source: VTK file formats, "VTKHDF", version 2.0, transient data."""
    import h5py

    instant = run.instant(samples[0])
    blocks, bodies = _cells(instant)
    corners = np.concatenate([np.full(len(cells), cells.shape[1]) for cells in blocks])
    n_points, kind, n = len(fields(instant)[0]), "UnstructuredGrid", len(samples)
    root, steps = file.create_group("VTKHDF"), file.create_group("VTKHDF/Steps")
    root.attrs["Version"], steps.attrs["NSteps"] = (2, 0), n
    root.attrs.create("Type", kind.encode(), dtype=h5py.string_dtype("ascii", len(kind)))
    moving, still = n_points * np.arange(n), np.zeros(n, dtype=np.int64)
    for name, values in (
        ("NumberOfPoints", [n_points]), ("NumberOfCells", [len(corners)]),
        ("NumberOfConnectivityIds", [int(corners.sum())]),
        ("Connectivity", np.concatenate([cells.ravel() for cells in blocks])),
        ("Offsets", np.concatenate([[0], np.cumsum(corners)])),
        ("Types", np.array([VTK_KINDS[k] for k in corners], dtype=np.uint8)),
        ("CellData/body", np.concatenate(bodies).astype(np.int32)),
        ("Steps/Values", run.times[list(samples)]), ("Steps/PartOffsets", still), ("Steps/NumberOfParts", still + 1),
        ("Steps/PointOffsets", moving), ("Steps/CellOffsets", still[:, None]),
        ("Steps/ConnectivityIdOffsets", still[:, None]), ("Steps/CellDataOffsets/body", still),
    ):  # fmt: skip
        root.create_dataset(name, data=np.asarray(values))
    for step, sample in enumerate(samples):
        points, data = fields(run.instant(sample))
        rows = {"Points": np.pad(points, ((0, 0), (0, 1)))}
        rows |= {f"PointData/{name}": values for name, values in data.items()}
        for name, values in rows.items():
            if step == 0:
                packed = dict(chunks=values.shape, compression="gzip", compression_opts=4, shuffle=True)
                root.create_dataset(name, shape=(n_points * n, *values.shape[1:]), dtype=values.dtype, **packed)
                if name != "Points":
                    steps.create_dataset(name.replace("PointData", "PointDataOffsets"), data=moving)
            root[name][step * n_points : (step + 1) * n_points] = values
        count()
