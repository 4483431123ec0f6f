"""The command `render-fem`. Imports little: everything heavy waits until a run has been found."""

from functools import partial
from math import inf
from pathlib import Path
from typing import Literal

from fem.commands.run_fem import RUNS
from fem.commands.start_up import count_display, run_app_main
from lagrange.commands import new_app
from lagrange.errors import UsageError
from lagrange.messages import shown, telling

FRAMES = 120  # of a film
SIGNALS, SERIES = (".csv", ".wav"), ".vtkhdf"  # endings of --export: accelerations, fields of many instants
WIDTH, FILM_WIDTH = 1600, 960

render_app = new_app(
    "render-fem",
    """Draw a run off-screen: the whole bearing or one roller between its raceways, at one instant or as a film.

Stress or displacement on the deformed bodies, with what lies below the grid of a contact; contact forces, load zone,
the hub's orbit. Or export mesh and fields for ParaView and others, or accelerations.

Example: render-fem runs/paper.nc --time 12.5
         render-fem runs/paper.nc --view close-up --field von-mises
         render-fem runs/paper.nc --animation paper.mp4 --start 10 --stop 20
         render-fem runs/paper.nc --export paper.vtkhdf
         render-fem runs/paper.nc --export paper.wav

Exit codes: 0 done; 2 unusable input; 130 interrupted.
""",
)


@render_app.default
def _render(
    run: Path | None = None, /, *, output: Path | None = None, time: float | None = None,
    view: Literal["bearing", "close-up", "axial"] = "bearing",
    field: Literal["von-mises", "max-shear", "displacement"] | None = None, roller: int | None = None,
    magnification: float | None = None, width: int | None = None, animation: Path | None = None,
    export: Path | None = None, start: float | None = None, stop: float | None = None, frames: int | None = None,
    fps: float = 25.0, force: bool = False, quiet: bool = False,
) -> int:  # fmt: skip
    """
    Args:
        run: result file; default: the newest runs/*.nc
        output: PNG file; default: <run>.png next to the run
        time: instant, ms; default: the last sample
        view: view; axial: pressure along the rollers
        field: quantity shown by colour; default: von-mises, in a close-up max-shear
        roller: roller of a close-up; default: the most loaded one
        magnification: magnification of the displacement; default: chosen and stated
        width: width, pixels; default: 1600, film 960
        animation: write a film, .mp4 or .gif, instead of a picture
        export: write mesh and fields instead of a picture: .vtkhdf (all instants) or a format of meshio (one instant:
            .vtu, .xdmf, ...); or accelerations of hub, housing and sensor: .csv, .wav
        start: start of a film or an export, ms
        stop: its end, ms
        frames: number of frames; default: those with stored fields, else 120
        fps: frames per second of a film
        force: replace a file that this program did not write
        quiet: show no progress
    """
    for option, value, low, high, unit in (
        ("--width", width, 200, 8000, " pixels"),
        ("--magnification", magnification, 0.0, 1e9, ""),
        ("--frames", frames, 2, 100_000, ""),
        ("--fps", fps, 0.1, 200.0, ""),
    ):
        if value is not None and not low <= value <= high:
            raise UsageError(f"{option} {value:g}: must lie between {low:g} and {high:g}{unit}")
    _check_targets(output, animation, export)
    kind = "" if export is None else export.suffix.lower()
    many, span = animation is not None or kind == SERIES, start is not None or stop is not None or frames is not None
    for wrong, words in (
        (kind in SIGNALS and (span or time is not None),
         "--time, --start, --stop, --frames: accelerations cover the whole run; leave them out"),
        (many and time is not None, "--time: not for a film or a series; give --start and --stop"),
        (span and not many, "--start, --stop, --frames: only for a film or a series; give --time"),
        (animation is not None and view == "axial", "--view axial: draws one instant; leave --animation out"),
    ):  # fmt: skip
        if wrong:
            raise UsageError(words)
    from lagrange.files.output import load_matplotlib

    load_matplotlib()
    from fem.pictures import output as exports
    from fem.pictures.recover import StoredRun

    if run is None:
        runs = sorted(RUNS.glob("*.nc"), key=lambda path: path.stat().st_mtime)
        if not runs:
            raise UsageError(f"no *.nc in {RUNS.resolve()}; run run-fem first, or name a result file")
        run = runs[-1]
    stored = StoredRun(run)
    target = output or animation or export or stored.path.with_suffix(".png")
    exports.refuse_foreign(target, force)
    done = f"Picture: {target}"
    if kind in SIGNALS:
        from fem.result.run_file import accelerations, write_accelerations

        found, rate = accelerations(stored.scene, stored.from_housing), stored.scene.output.acceleration_Hz
        try:
            write_accelerations(target, rate, found)
        except OSError as error:
            raise UsageError(f"--export {target}: can't be written: {error.strerror or error}") from None
        done = f"Accelerations: {target} ({', '.join(found)} at {rate} Hz)"
    else:
        samples = [stored.nearest(None if time is None else 1e-3 * time)]
        if many:
            samples = _samples(stored, start, stop, frames)
        if export is not None:
            done = f"Fields: {target}"
            with count_display("instants", len(samples), quiet) as count:
                if kind == SERIES:
                    exports.write_series(stored, target, samples, count)
                else:
                    exports.write_instant(stored, target, samples[0])
        elif view == "axial":
            from fem.pictures.axial import draw_axial

            draw_axial(stored, target, samples[0])
        else:
            exports.check_rendering()
            from fem.pictures.look import Request
            from fem.pictures.views import Renderer, draw

            width = width or (WIDTH if animation is None else FILM_WIDTH)
            request = Request(view=view, field=field, magnification=magnification, roller=roller, width=width)
            if animation is None:
                draw(stored, target, request, samples[0])
            else:
                lasts = float(stored.times[samples[-1]] - stored.times[samples[0]]) / (len(samples) - 1)
                slower = 1.0 / (fps * lasts) if lasts > 0.0 else inf
                with (
                    Renderer(stored, request, samples, f"{slower:.3g} × slower") as renderer,
                    count_display("frames", len(samples), quiet) as count,
                ):

                    def images():
                        for sample in samples:
                            yield renderer.image(sample)
                            count()

                    exports.write_film(target, images(), fps, renderer.image(samples[len(samples) // 2]))
                done = f"Film: {target} ({len(samples)} frames)"
    with telling():
        print(shown(done))
    return 0


def _check_targets(output, animation, export):
    """Whether what a file's name ends in can be written, before anything is computed; a run is never drawn over."""
    given = [(f"--{name} {path}", path) for name, path in
             (("output", output), ("animation", animation), ("export", export)) if path is not None]  # fmt: skip
    for option, path in given:
        if path.is_dir():
            raise UsageError(f"{option}: is a folder; name a file in it")
    if len(given) > 1:
        raise UsageError("--output, --animation, --export: give only one of them")
    if output is not None and output.suffix.lower() != ".png":
        raise UsageError(f"--output {output}: must end in .png")
    if animation is not None and animation.suffix.lower() not in (".mp4", ".gif"):
        raise UsageError(f"--animation {animation}: must end in .mp4 or .gif")
    if export is not None and export.suffix.lower() not in (SERIES, *SIGNALS):
        from meshes.export import FORMATS

        if export.suffix.lower() not in FORMATS:
            raise UsageError(
                f"--export {export}: must end in {SERIES}, {', '.join(SIGNALS)} or a format of meshio: "
                f"{', '.join(FORMATS)}"
            )


def _samples(stored, start, stop, frames):
    """Those of a film: in a span, evenly spaced, or those whose fields are stored."""
    import numpy as np

    first = 0 if start is None else stored.nearest(1e-3 * start)
    last = stored.nearest(None if stop is None else 1e-3 * stop)
    if last <= first:
        raise UsageError(
            f"--start, --stop: {1e3 * stored.times[first]:g} to {1e3 * stored.times[last]:g} ms contain no sample"
        )
    kept = stored.frames
    kept = kept[(kept >= first) & (kept <= last)]
    if frames is None and len(kept) > 1:
        return kept.tolist()
    return np.unique(np.linspace(first, last, frames or FRAMES).round().astype(int)).tolist()


render_main = partial(run_app_main, render_app)
