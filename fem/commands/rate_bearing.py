"""The command `rate-bearing`. Imports little: everything heavy waits until a scene has been read."""

from functools import partial
from pathlib import Path
from typing import Literal

from fem.commands.run_fem import result_name
from fem.commands.start_up import count_display, run_app_main, standard_bearing
from lagrange.commands import new_app
from lagrange.errors import UsageError

CYCLE = {"loads": "load_N", "speeds": "speed_rpm", "shares": "share", "axial_loads": "axial_load_N"}  # columns
LONGEST = 10_000_000  # bytes of a duty cycle
MOST = 4  # bearings side by side
PATIENCE = 2.0  # s without progress

rate_app = new_app(
    "rate-bearing",
    """Rate a roller bearing: load ratings, lives, stiffness for rotordynamics, contact stresses, film, friction.

Without a scene: the bearing of Rubio et al. (2007). Prints a sheet of six blocks and writes NAME-rating.json; with
--output a folder, and in it rating.html, which prints on A4, with figures. Every number of the page and of the file has
its source beside it; what could not be computed is null with its reason. Up to four bearings stand side by side under
the same load, in NAME-comparison.json and comparison.html.

Example: rate-bearing --bearing NU206 --set operation.radial_load_N=3000 --output rated
         rate-bearing motor.toml --viscosity 20 --ross coefficients.csv
         rate-bearing motor.toml --bearing 6206 --bearing NU206
         rate-bearing runs/motor.nc

Exit codes: 0 done; 2 unusable input; 130 interrupted; 143 terminated.
""",
)


@rate_app.default
def _rate(
    scene: Path | None = None, /, *, bearing: list[str] | None = None, set: list[str] | None = None,
    output: Path | None = None, ross: Path | None = None, cycle: Path | None = None, decimal: Literal[".", ","] = ".",
    viscosity: float | None = None, contamination: float | None = None, reliability: float = 90.0,
    life: float | None = None, roughness: float | None = None, width: float | None = None, quiet: bool = False,
) -> int:  # fmt: skip
    """
    Args:
        scene: scene file (TOML), or result file of run-fem; default: the paper's bearing
        bearing: standard bearing instead of the scene's, e.g. NU206/C3; up to four to compare
        set: any scene key: table.key=value; repeatable
        output: folder for the JSON file and rating.html
        ross: write coefficients over speed for ROSS to this CSV file
        cycle: duty cycle: CSV with columns load_N, speed_rpm, share of time, axial_load_N if any; or load_kN, share [%]
        decimal: decimal sign of numbers in --cycle
        viscosity: kinematic viscosity of the oil in operation, mm²/s; default: the scene's [lubricant]
        contamination: contamination factor e_C, 0 to 1; default: oil filtered in line
        reliability: reliability of the modified life, %, from 90 to 99.95
        life: wanted life, h: its reliability, and the C that it needs
        roughness: rms roughness of roller and raceway together, µm
        width: width of the bearing, mm; default: that of its designation
        quiet: print nothing
    """
    given = {"viscosity": (viscosity, 1e6), "contamination": (contamination, 1.0), "life": (life, 1e9),
             "roughness": (roughness, 1e3), "width": (width, 1e4)}  # fmt: skip
    for name, (value, largest) in given.items():
        if value is not None and not 0.0 < value <= largest:
            raise UsageError(f"--{name} {value:g}: must be above 0 and at most {largest:g}")
    bearings, settings = bearing or [], set or []
    if len(bearings) > MOST:
        raise UsageError(f"--bearing: {len(bearings)} bearings; at most {MOST} stand side by side")
    if len(bearings) > 1 and ross is not None:
        raise UsageError(f"--ross: coefficients are those of one bearing, not of {len(bearings)}; give one --bearing")
    from lagrange.messages import shown, telling
    from lagrange.rating.life import RELIABILITY
    from lagrange.rating.sources import Unavailable
    from lagrange.scene.scene import read_scene

    if not min(RELIABILITY) <= reliability <= max(RELIABILITY):
        raise UsageError(f"--reliability {reliability:g}: must be from {min(RELIABILITY):g} to {max(RELIABILITY):g}")
    run = None
    if scene is not None and scene.suffix == ".nc":
        if bearings or settings or cycle is not None:
            raise UsageError(f"{scene}: a run has its own scene and loads; leave out --bearing, --set and --cycle")
        from fem.result.run_file import RunFile
        from lagrange.rating.reference_life import COLUMNS, run_loads

        file = RunFile(scene)
        chosen, name, columns = [file.scene], scene.stem, {each: file.from_housing(each) for each in COLUMNS}
        run = run_loads(file.scene.perfect_bearing(), file.scene.ideal_operation(), columns)
    else:
        chosen = []
        for each in bearings or (None,):
            try:
                chosen.append(read_scene(scene, (*standard_bearing(each), *settings)))
            except UsageError as error:
                raise UsageError(f"--bearing {each}: {error}" if len(bearings) > 1 else str(error)) from None
        name = result_name("-".join(dict.fromkeys(each.name for each in chosen)), settings)
    steps = None
    if cycle is not None:  # a duty cycle from a file
        from lagrange.files.input import plain_text
        from lagrange.files.tables import TextTable
        from lagrange.files.tables import columns as table_columns
        from lagrange.load_history import UNITS
        from lagrange.rating.life import DutyCycle

        try:
            text = plain_text(cycle, LONGEST)
            axial = any(name.startswith("axial_load") for name in TextTable.named(text, decimal).names)
            table = table_columns(text, list(CYCLE.values())[: 3 + axial], decimal, UNITS).T
            steps = DutyCycle(**dict(zip(CYCLE, table, strict=False)))
        except ValueError as error:
            reason = str(error).replace('decimal = ","', "--decimal ,")  # tables of scenes have it as a key
            raise UsageError(f"--cycle {cycle}: {reason}") from None
    from fem.rating import report
    from fem.rating.answers import DECLARED, Case, Options, Rating

    folder = Path() if output is None else output
    folder.mkdir(parents=True, exist_ok=True)
    options = Options(
        name=name, viscosity=viscosity, contamination=contamination, reliability=reliability, roughness=roughness,
        width=width, life=life, cycle=steps, run=run, rotor=ross is not None,
    )  # fmt: skip
    several = len(chosen) > 1
    stem = name if several else result_name(chosen[0].name, settings)
    written = [folder / f"{stem}-{'comparison' if several else 'rating'}.json"]
    if output is not None:
        written.append(folder / ("comparison.html" if several else "rating.html"))
    with count_display("answers", len(chosen) * len(DECLARED), quiet, PATIENCE) as count:
        ratings = {each: Rating(Case(of, options._replace(name=each)), count=count)
                   for each, of in zip(bearings if several else [name], chosen, strict=True)}  # fmt: skip
        rated, *_ = ratings.values()
        if ross is not None:
            from fem.rating.ross import coefficients, write_coefficients

            try:
                write_coefficients(ross, coefficients(rated))
            except Unavailable as error:
                raise UsageError(f"--ross: {error}") from None
        if several:
            report.write_json(written[0], [{"bearing": each} | of.to_json() for each, of in ratings.items()])
            for path in written[1:]:
                report.write_comparison(path, name, ratings)
        else:
            report.write_json(written[0], rated.to_json())
            for path in written[1:]:
                report.write_page(path, rated)
    if not quiet:
        with telling():
            report.print_comparison(name, ratings) if several else report.print_rating(rated)
            for path in (*written, *filter(None, [ross])):
                print(f"wrote {shown(path)}")
    return 0


rate_main = partial(run_app_main, rate_app)

if __name__ == "__main__":  # as benchmarks.same_bits starts it
    raise SystemExit(rate_main())
