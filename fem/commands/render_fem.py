"""The command `render-fem`. Imports little: everything heavy waits until a run has been found."""

from functools import partial
from math import inf
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from fem.commands.run_fem import RUNS
from fem.commands.start_up import count_display, run_app_main
from lagrange.commands import entry, new_app
from lagrange.errors import UsageError
from lagrange.messages import shown, telling

FRAMES, FRAMES_PER_SECOND = 120, 25.0
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
    run: Annotated[Path | None, Parameter(help="result file; default: the newest runs/*.nc")] = None,
    /,
    *,
    output: Annotated[Path | None, Parameter(help="PNG file; default: <run>.png next to the run")] = None,
    time: Annotated[float | None, Parameter(help="instant, ms; default: the last sample")] = None,
    view: Annotated[
        Literal["bearing", "close-up", "axial"], Parameter(help="view; axial: pressure along the rollers")
    ] = "bearing",
    field: Annotated[
        Literal["von-mises", "max-shear", "displacement"] | None,
        Parameter(help="quantity shown by colour; default: von-mises, in a close-up max-shear"),
    ] = None,
    roller: Annotated[int | None, Parameter(help="roller of a close-up; default: the most loaded one")] = None,
    magnification: Annotated[
        float | None, Parameter(help="magnification of the displacement; default: chosen and stated")
    ] = None,
    width: Annotated[int | None, Parameter(help=f"width, pixels; default: {WIDTH}, film {FILM_WIDTH}")] = None,
    animation: Annotated[Path | None, Parameter(help="write a film, .mp4 or .gif, instead of a picture")] = None,
    export: Annotated[
        Path | None,
        Parameter(
            help="write mesh and fields instead of a picture: .vtkhdf (all instants) or a format of meshio (one "
            "instant: .vtu, .xdmf, ...); or accelerations of hub, housing and sensor: .csv, .wav"
        ),
    ] = None,
    start: Annotated[float | None, Parameter(help="start of a film or an export, ms")] = None,
    stop: Annotated[float | None, Parameter(help="its end, ms")] = None,
    frames: Annotated[
        int | None, Parameter(help=f"number of frames; default: those with stored fields, else {FRAMES}")
    ] = None,
    fps: Annotated[float, Parameter(help="frames per second of a film")] = FRAMES_PER_SECOND,
    force: Annotated[bool, Parameter(negative="", help="replace a file that this program did not write")] = False,
    quiet: Annotated[bool, Parameter(negative="", help="show no progress")] = False,
) -> int:
    for option, value, low, high, unit in (
        ("--width", width, 200, 8000, " pixels"),
        ("--magnification", magnification, 0.0, 1e9, ""),
        ("--frames", frames, 2, 100_000, ""),
        ("--fps", fps, 0.1, 200.0, ""),
    ):
        if value is not None and not low <= value <= high:
            raise UsageError(f"{option} {value:g}: must lie between {low:g} and {high:g}{unit}")
    _check_targets(output, animation, export)

    from lagrange.files.output import load_matplotlib

    load_matplotlib()
    from fem.pictures.output import refuse_foreign
    from fem.pictures.recover import StoredRun

    stored = StoredRun(run if run is not None else _newest())
    target = output or animation or export or stored.path.with_suffix(".png")
    refuse_foreign(target, force)
    kind = "" if export is None else export.suffix.lower()
    many = animation is not None or kind == SERIES
    if kind in SIGNALS and any(given is not None for given in (time, start, stop, frames)):
        raise UsageError("--time, --start, --stop, --frames: accelerations cover the whole run; leave them out")
    if many and time is not None:
        raise UsageError("--time: not for a film or a series; give --start and --stop")
    if not many and (start is not None or stop is not None or frames is not None):
        raise UsageError("--start, --stop, --frames: only for a film or a series; give --time")
    if kind in SIGNALS:
        done = _signals(stored, target)
    else:
        samples = [stored.nearest(None if time is None else 1e-3 * time)]
        if many:
            samples = _samples(stored, start, stop, frames)
        if export is not None:
            done = _export(stored, target, samples, quiet)
        elif view == "axial":
            if animation is not None:
                raise UsageError("--view axial: draws one instant; leave --animation out")
            from fem.pictures.axial import draw_axial

            draw_axial(stored, target, samples[0])
            done = f"Picture: {target}"
        else:
            from fem.pictures.look import Request
            from fem.pictures.output import check_rendering

            check_rendering()
            width = width or (WIDTH if animation is None else FILM_WIDTH)
            request = Request(view=view, field=field, magnification=magnification, roller=roller, width=width)
            if animation is not None:
                done = _film(stored, target, request, samples, fps, quiet)
            else:
                from fem.pictures.views import draw

                draw(stored, target, request, samples[0])
                done = f"Picture: {target}"
    with telling():
        print(shown(done))
    return 0


def _check_targets(output: Path | None, animation: Path | None, export: Path | None) -> None:
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


def _newest() -> Path:
    found = sorted(RUNS.glob("*.nc"), key=lambda path: path.stat().st_mtime)
    if not found:
        raise UsageError(f"no *.nc in {RUNS.resolve()}; run run-fem first, or name a result file")
    return found[-1]


def _samples(stored, start: float | None, stop: float | None, frames: int | None) -> list[int]:
    """Those of a film: in a span, evenly spaced, or those whose fields are stored."""
    import numpy as np

    first = 0 if start is None else stored.nearest(1e-3 * start)
    last = stored.nearest(None if stop is None else 1e-3 * stop)
    if last <= first:
        raise UsageError(
            f"--start, --stop: {1e3 * stored.times[first]:g} to {1e3 * stored.times[last]:g} ms contain no sample"
        )
    kept = stored.stored_samples
    kept = kept[(kept >= first) & (kept <= last)]
    if frames is None and len(kept) > 1:
        return kept.tolist()
    return np.unique(np.linspace(first, last, frames or FRAMES).round().astype(int)).tolist()


def _film(stored, target: Path, request, samples: list[int], fps: float, quiet: bool) -> str:
    from fem.pictures.output import write_film
    from fem.pictures.views import Renderer

    lasts = float(stored.times[samples[-1]] - stored.times[samples[0]]) / (len(samples) - 1)
    slower = 1.0 / (fps * lasts) if lasts > 0.0 else inf
    renderer = Renderer(stored, request, samples, f"{slower:.3g} × slower")
    with count_display("frames", len(samples), quiet) as count:

        def images():
            for sample in samples:
                yield renderer.image(sample)
                count()

        write_film(target, images(), fps, renderer.palette)
    return f"Film: {target} ({len(samples)} frames)"


def _export(stored, target: Path, samples: list[int], quiet: bool) -> str:
    from fem.pictures.output import write_instant, write_series

    with count_display("instants", len(samples), quiet) as count:
        if target.suffix.lower() == SERIES:
            write_series(stored, target, samples, count)
        else:
            write_instant(stored, target, samples[0])
    return f"Fields: {target}"


def _signals(stored, target: Path) -> str:
    from fem.result.run_file import accelerations, write_accelerations

    found, rate = accelerations(stored.scene, stored.column), stored.scene.output.acceleration_Hz
    try:
        write_accelerations(target, rate, found)
    except OSError as error:
        raise UsageError(f"--export {target}: can't be written: {error.strerror or error}") from None
    return f"Accelerations: {target} ({', '.join(found)} at {rate} Hz)"


render_main = partial(run_app_main, render_app)
render_fem = entry(render_main)

if __name__ == "__main__":
    render_fem()
