"""Scenes and options that run-fem must refuse: name -> a function that writes them into a folder.

Each gives the command, its arguments and what the refusal must say.
"""

from fem.commands.run_fem import run_main


def scene(text, *words):
    """A scene file, and what the refusal must say besides its name."""

    def make(folder):
        path = folder / "scene.toml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return run_main, [str(path)], ["scene.toml", *words]

    return make


def setting(*settings, say):
    """Values given by --set."""
    return options(*(word for each in settings for word in ("--set", each)), say=say)


def options(*arguments, say):
    """Options of run-fem."""
    return lambda folder: (run_main, [str(a).format(folder=folder) for a in arguments], say.split(" & "))


BAD_SCENES = {
    # names and types
    "a key of many thousand parts": scene("a." * 30_000 + "a = 1", "'a.a.a.", "a key of more than 50 parts"),
    "a power law without stiffness": scene(
        '[lagrange]\nlaw = "power"\ncontact_exponent = 1.1\ncontact_stiffness_N_per_m_n = [5e-324, 1e9]',
        "lagrange.contact_stiffness_N_per_m_n.0 = 5e-324",
        "1000",
    ),
    "numbers next to 0": scene(
        "[operation]\nunbalance_g_mm = 5e-324\n[[waviness]]\namplitude_um = 1e-300",
        "operation: unbalance_g_mm = 4.94066e-324: must be 0, or at least 1e-15",
        "waviness.0: amplitude_um = 1e-300",
    ),
    "unknown key": scene("[operation]\nspeed_rmp = 4500", "operation.speed_rmp", "did you mean speed_rpm?"),
    "unknown table": scene("[bearings]\nrollers = 3", "bearings", "did you mean bearing?"),
    "misspelt key of a spall": scene("[[spall]]\nwidht_mm = 2", "spall.0.widht_mm", "did you mean width_mm?"),
    "a table where many may be": scene("[spall]\nwidth_mm = 2", "spall = {", "array of tables, [[spall]]"),
    "a spall that is no table": scene("spall = [3]", "spall.0 = 3", "[[spall]]"),
    "override of a spall that is not there": setting("spall.3.width_mm=2", say="spall.3.width_mm=2 & none of 0 tables"),
    "spalls that overlap": scene("[[spall]]\n[[spall]]\nangle_deg = 1.0", "spall.0 and spall.1 overlap"),
    "a spall of a roller that is not there": scene(
        '[[spall]]\nbody = "roller"\nroller = 13', "spall.0.roller = 13", "from 0 to 12"
    ),
    "a spall with resolved contacts": scene('[[spall]]\n[contact]\nmodel = "resolved"', "[[spall]]", '"resolved"'),
    "a spall on a mesh as fine as contacts": setting(
        "spall.0.width_mm=1", "numerics.mesh_size_mm=0.05", say="[[spall]] & points & at least"
    ),
    "unknown key without a likely one": scene(
        "[contact]\nzzz = 1", "contact.zzz", "known here: ", "friction_coefficient"
    ),
    "misspelt option of the model": scene("[lagrange]\nlow = 3.0", "lagrange.low", "law"),
    "misspelt table": scene("[operatoin]\nspeed_rpm = 1.0", "operatoin", "did you mean operation?"),
    "misspelt key of a support": scene("[support]\nfit_clearence_um = 1", "did you mean fit_clearance_um?"),
    "half a key's words": scene("[damping]\ncontact = 3.0", "damping.contact", "did you mean contact_N_s_m?"),
    "one word of a key": scene('[fit]\nshaft = "k5"', "fit.shaft: unknown key; did you mean shaft_interference_um?"),
    "key that stands elsewhere": scene("[bearing]\ncrown_um = 1", "did you mean axial.crown_um?"),
    "axial load": scene("[operation]\naxial_load_N = 1", "axial_load_N: not supported: axial loads; see docs/"),
    "hollow rollers": scene("[bearing]\nroller_bore_diameter_mm = 5", "not supported: hollow rollers; see docs/"),
    "temperature": scene("[operation]\ntemperature = 1", "not supported: temperature"),
    "settings of another program": scene("\n".join(f"key_{i} = {i}" for i in range(500)), "key_0", "and 485 more"),
    "numbers in quotes": scene(
        '[operation]\nradial_load_N = "2000 N"\n[bearing]\nrollers = "13"',
        "bearing.rollers = '13': must be a valid integer, without quotes and unit",
        "operation.radial_load_N = '2000 N': must be a valid number, without quotes and unit",
    ),
    "truth for a number": scene("[bearing]\nrollers = true", "bearing.rollers = True"),
    "date for a number": scene("[operation]\nspeed_rpm = 2007-06-18", "operation.speed_rpm"),
    "list for a number": scene("[operation]\nspeed_rpm = [1, 2]", "operation.speed_rpm = [1, 2]"),
    "table for a number": scene("[numerics.duration_ms]\nx = 1", "numerics.duration_ms", "number"),
    "number for a table": scene("bearing = 3", "bearing = 3: must be a table, [bearing]"),
    "list of tables": scene("[[bearing]]\nrollers = 3", "bearing = [{", "must be a table, [bearing]"),
    "number for a name": scene("name = 3", "name = 3", "string"),
    "number for a list": scene("[bearing]\nmissing_rollers = 3", "bearing.missing_rollers = 3: must be a valid list"),
    "list for a profile": scene("[axial]\nroller_profile = [1]", "axial.roller_profile = [1]: must be a valid string"),
    "number for a column": scene("[table]\ntime = 3", "table.time = 3"),
    # numbers that are none, or too large
    "not a number": scene("[operation]\nspeed_rpm = nan", "operation.speed_rpm = nan", "finite"),
    "infinite by overflow": scene("[operation]\nradial_load_N = 1e400", "operation.radial_load_N = inf", "finite"),
    "more digits than Python reads": scene(f"[bearing]\nrollers = {'9' * 5000}", "digits"),
    "as many digits as it reads": scene(f"[operation]\nspeed_rpm = {'9' * 4000}", "operation.speed_rpm = 999", "..."),
    "spring of no penalty": scene(
        "[contact]\npenalty_stiffness_N_per_m = 1e9", "penalty_stiffness_N_per_m = 1e+09", "faceted"
    ),
    "unit of no length": scene('[table]\ninner_x = "x [fortnight]"', "table.inner_x", "fortnight"),
    "unit with hidden characters": scene('[table]\ntime = "t [ms\ufeff\\u0001]"', "table.time", "ms??"),
    "column without a number": scene('[table]\nroller_x = "x"', "table.roller_x", "{j}"),
    "column with one too many": scene('[table]\ninner_x = "x{j}"', "table.inner_x", "{j}"),
    "name of a column without end": scene(f'[table]\ntime = "t{" " * 5000}"', "table.time", "200"),
    # values that contradict each other
    "too many rollers": scene("[bearing]\nrollers = 15", "rollers = 15", "at most 14"),
    "bore as large as raceway": scene("[bearing]\nbore_diameter_mm = 36.0", "bore_diameter_mm = 36.0", "inner_raceway"),
    "outside below raceway": scene("[bearing]\noutside_diameter_mm = 55", "outside_diameter_mm", "outer_raceway"),
    "too much preload": scene("[bearing]\nouter_raceway_diameter_mm = 55", "preload", "outer_raceway_diameter_mm"),
    "too much clearance": scene("[bearing]\nouter_raceway_diameter_mm = 59", "clearance", "outer_raceway_diameter_mm"),
    "raceways exchanged": scene(
        "[bearing]\ninner_raceway_diameter_mm = 56\nouter_raceway_diameter_mm = 36\noutside_diameter_mm = 70",
        "outer_raceway_diameter_mm = 36",
    ),
    "mass below the ring's": scene("[operation]\ninner_ring_and_shaft_kg = 0.03", "inner_ring_and_shaft_kg", "0.04137"),
    "heavy inner ring": scene("[material.inner_ring]\ndensity_kg_m3 = 30000", "inner_ring_and_shaft_kg = 0.078"),
    "mesh too coarse": scene("[numerics]\nmesh_size_mm = 4", "mesh_size_mm = 4", "at most"),
    "mesh too fine": scene("[numerics]\nmesh_size_mm = 0.014", "mesh_size_mm = 0.014", "at least"),
    "interval longer than the run": scene(
        "[numerics]\nduration_ms = 1\noutput_interval_us = 2000",
        "output_interval_us = 2000",
        "duration_ms = 1",
        "at most",
    ),
    "grooves of a roller bearing": scene("[bearing]\ninner_conformity = 0.52", "inner_conformity", 'type = "ball"'),
    "grooves tighter than the ball": scene(
        '[bearing]\ntype = "ball"\nouter_conformity = 0.5', "outer_conformity = 0.5"
    ),
    "law of balls for rollers": scene('[lagrange]\nlaw = "hertz"', "lagrange.law = 'hertz'", "'roller'", "harris"),
    "law of rollers for balls": scene('[bearing]\ntype = "ball"\n[lagrange]\nlaw = "harris"', "lagrange.law", "hertz"),
    # files that are no scenes
    "broken TOML": scene("[bearing\nrollers = 3", "TOML", "line 1"),
    "unfinished TOML": scene("name = ", "TOML"),
    "decimal comma": scene("operation.radial_load_N = 3,5", "TOML", "radial_load_N = 3,5: write a decimal point"),
    "text without quotes": scene("bearing.designation = NU206", "TOML", "designation = NU206: put text in quotes"),
    "key twice": scene("[bearing]\nrollers = 12\nrollers = 13", "TOML"),
    "JSON": scene('{"bearing": {"rollers": 13}}', "TOML"),
    "not text": scene(b"\xff\xfe\x00\x01", "UTF-8"),
    "text of another encoding": scene("name = 'Wälzlager'".encode("utf-16"), "UTF-8"),
    "zeros": scene(bytes(100), "TOML"),
    "arrays without end": scene(f"name = {'[' * 100_000}", "nested"),
    "tables without end": scene(f"{'a.' * 5000}b = 1", "a"),
    "a million spaces": scene(" " * 2**21, "larger than 1 MiB"),
    "name that leads elsewhere": scene("name = '../evil'", "name = '../evil'", "pattern"),
    "name without letters": scene("name = ''", "name = ''"),
    "name with a line break": scene('name = "a\\nb"', "name = 'a\\nb'"),
    "keys that move the cursor": scene('"\\u001b[2J" = 1', "\\x1b[2J", "unknown key"),
    "value of a million letters": scene(f"[bearing]\nrollers = '{'x' * 10**6}'", "bearing.rollers = 'xxx", "..."),
}

BAD_SETTINGS = {
    "no key": setting("speed", say="--set 'speed' & table.key=value"),
    "empty key": setting("=3", say="--set '=3'"),
    "half a key": setting("operation.=3", say="--set 'operation.=3'"),
    "table behind a value": setting("name=x", "name.first=1", say="--set 'name.first=1' & name is a value"),
    "unknown key by option": setting("operation.speed=1", say="operation.speed & did you mean speed_rpm?"),
    "word for a number by option": setting("operation.speed_rpm=fast", say="operation.speed_rpm = 'fast'"),
    "second key in a value": setting("operation.speed_rpm=1\nname='x'", say="operation.speed_rpm"),
    "comment for a value": setting("operation.speed_rpm=# 3", say="operation.speed_rpm"),
    "mesh size of nan": options("--mesh-size", "nan", say="numerics.mesh_size_mm = nan"),
    "mesh size in words": options("--mesh-size", "fine", say="--mesh-size"),
    "duration of nan": options("--duration", "nan", say="numerics.duration_ms = nan"),
    "duration in words": options("--duration", "long", say="--duration"),
    "negative seconds between checkpoints": options("--checkpoint", "-1", say="--checkpoint -1"),
    "checkpoint of nan": options("--checkpoint", "nan", say="--checkpoint nan"),
    "unknown model by option": options("--model", "spring", say="--model"),
    "misspelt option": options("--mesh-sise", "2", say="--mesh-sise"),
    "two scenes": options("a.toml", "b.toml", say="b.toml"),
    "no such scene": options("gone.toml", say="gone.toml & no such file; run-fem --example"),
    "folder for a scene": options("{folder}", say="can't be read"),
    "folder for a result": options("--output", "{folder}", say="--output & is a folder"),
    "folder that can't be made": options("--output", "/proc/nothing/x.nc", "--mesh-size", "2", say="/proc/nothing"),
    "nothing to resume": options(
        "--resume", "--mesh-size", "2", "--output", "none.nc", say="none.nc & nothing to resume"
    ),
    "nothing to resume of the Lagrangian model": options(
        "--model", "lagrange", "--resume", "--output", "none.nc", say="none.nc & nothing to resume"
    ),
    "error estimate without a mesh": options("--model", "lagrange", "--estimate-error", say="--estimate-error"),
    # sensible values of a bearing that can't be simulated
    "centrifugal strain": setting(
        "operation.speed_rpm=150000", "material.youngs_modulus_GPa=50", say="operation.speed_rpm & at most"
    ),
    "contacts beyond Hertz": setting("operation.radial_load_N=1e6", say="Hertz & radial_load_N"),
    "mesh coarser than a resolved contact": setting(
        "contact.model=resolved", "numerics.mesh_size_mm=0.2", say="contact.model & mesh_size_mm at most"
    ),
    "needle through the inner ring": setting(
        "bearing.bore_diameter_mm=0.5", "operation.inner_ring_and_shaft_kg=0.1", say="inner ring & edges"
    ),
    "ring thinner than an element": setting(
        "bearing.outside_diameter_mm=57", say="outer ring & 0.5 mm thick & mesh_size_mm"
    ),
    "more nodes than memory": setting(
        "operation.radial_load_N=1", "numerics.mesh_size_mm=0.03", say="mesh_size_mm = 0.03 & nodes & at most"
    ),
    "balls as plane sections": setting("model=fem", "bearing.type=ball", say='type = "ball" & --model lagrange'),
}
