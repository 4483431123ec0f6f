"""Surfaces read from files: what rollers reach of them, what is refused, how they travel with a run."""

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.live import player as controls
from fem.pictures.recover import StoredRun
from lagrange.errors import InputError, UsageError
from lagrange.scene.scene import SceneError, parse_scene_text, read_scene
from lagrange.surface.deviation import Turns, profiles
from residual.sources import read_result
from tests.reference.kit import sets

HEADER = "angle_deg,height_um\n"
N = 8800  # points 20 µm apart on a raceway of 56 mm


def table(height, first=0.0, count=N):
    angle = first + 360.0 * np.arange(count) / count
    return HEADER + "".join(f"{a:.9g},{height(a):.9g}\n" for a in angle)


def scene_with(folder, text, *lines):
    (folder / "race.csv").write_text(text, encoding="utf-8")
    path = folder / "scene.toml"
    path.write_text("\n".join(['[[profile]]\nfile = "race.csv"', *lines]), encoding="utf-8")
    return path


BODIES = {
    "outer ring": ('body = "outer_ring"', "outer"), "inner ring": ('body = "inner_ring"', "inner"),
    "roller outside": ('body = "roller"\nroller = 3', "outer"),
    "roller inside": ('body = "roller"\nroller = 3', "inner"),
}  # fmt: skip


def sinkage(scene, raceway, angle):
    surfaces = profiles(scene.ideal_bearing())
    return np.array([getattr(surfaces, raceway)(np.full(13, a), Turns()).sinkage[3] for a in angle])


@pytest.mark.parametrize("where", BODIES)
def test_a_measured_wave_is_that_wave(where, tmp_path):
    """Where it slopes the circle touches beside the line of centres, and is lifted by slope²/(2 curvature)."""
    body, raceway = BODIES[where]
    wave = table(lambda a: 0.5 * np.cos(np.radians(12 * a + 30)), count=2400)
    measured = read_scene(scene_with(tmp_path, wave, body))
    named = parse_scene_text(f"[[waviness]]\n{body}\norder = 12\namplitude_um = 0.5\nphase_deg = 30.0\n", "s")
    angle = np.linspace(0.0, 7.0, 200)
    expected = sinkage(named, raceway, angle)
    assert np.ptp(expected) > 0.9e-6
    before, after = (sinkage(named, raceway, angle + step) for step in (-1e-4, 1e-4))
    slope = (after - before) / 2e-4 / {"outer ring": 28e-3, "inner ring": 18e-3}.get(where, 5e-3)
    curvature = 1 / 5e-3 - 1 / 28e-3 if raceway == "outer" else 1 / 5e-3 + 1 / 18e-3
    lifted = expected - slope**2 / (2.0 * curvature)
    np.testing.assert_allclose(sinkage(measured, raceway, angle), lifted, atol=0.2e-9)


@pytest.mark.parametrize(
    ("where", "deepest"), [("outer ring", 20.60e-6), ("inner ring", 32.01e-6), ("roller outside", 20.60e-6)]
)
def test_a_roller_sinks_into_a_measured_gap_as_into_a_sharp_one(where, deepest, tmp_path):
    """35 µm deep, 1 mm between the points at its edges: h = [r − √(r² − L²/4)] ∓ [R − √(R² − L²/4)]."""
    body, raceway = BODIES[where]
    radius, from_load = {"outer ring": (28.0, True), "inner ring": (18.0, True)}.get(where, (5.0, False))
    count = round(2000 * np.pi * radius / 20.0)  # points 20 µm apart
    gap = table(lambda a: -35.0 if abs(a * count / 360 - 100) < 24.5 else 0.0, count=count)
    middle, half = 2 * np.pi * 100 / count - 0.5 * np.pi * from_load, 0.5 / radius
    around = middle + half * np.linspace(-1.5, 1.5, 3001)
    found = sinkage(read_scene(scene_with(tmp_path, gap, body)), raceway, around)
    assert found.max() == pytest.approx(deepest, rel=0.01)
    assert abs(around[found.argmax()] - middle) < 0.01 * half and np.abs(found[[0, -1]]).max() < 1e-9


def test_what_stands_out_lifts_a_roller_before_it_is_there(tmp_path):
    """A crest 5 µm high, 0.2 mm wide: a circle of radius r in a bore R touches its edge from √(2h/(1/r − 1/R)) on."""
    scene = read_scene(scene_with(tmp_path, table(lambda a: 5.0 if abs(a) < 0.205 or a > 359.795 else 0.0)))
    beside = np.array([0.0, 0.05e-3, 0.2e-3, 0.5e-3]) / 28e-3
    x = np.maximum(beside * 28e-3 - 0.1e-3, 0.0)
    expected = -np.maximum(5e-6 - 0.5 * x**2 * (1 / 5e-3 - 1 / 28e-3), 0.0)
    np.testing.assert_allclose(sinkage(scene, "outer", beside - 0.5 * np.pi), expected, atol=0.3e-6)


def test_where_a_table_begins_and_how_it_is_written_does_not_matter(tmp_path):
    def height(a):
        return 2.0 * np.cos(np.radians(3 * a)) + 0.3 * np.sin(np.radians(20 * a))

    angle = np.linspace(0.0, 6.28, 100)
    plain = table(height, count=3600)
    expected = sinkage(read_scene(scene_with(tmp_path, plain)), "outer", angle)
    closed = plain + f"360,{height(0.0):.9g}\n"
    other = "# roundness\nname\theight_um\tangle_deg\n" + "".join(
        f"x\t{height(a):.9g}\t{a:.9g}\n" for a in -180.0 + 0.1 * np.arange(3600)
    )
    shifted = table(lambda a: height(a - 40.0), count=3600)
    commas = plain.replace(",", ";").replace(".", ",")
    written = ((closed,), (other.replace("\n", "\r\n"),), (shifted, "angle_deg = -40.0"), (commas, 'decimal = ","'))
    for text, *lines in (*written, (plain.replace(",", "  "),)):
        found = sinkage(read_scene(scene_with(tmp_path, text, *lines)), "outer", angle)
        np.testing.assert_allclose(found, expected, atol=2e-10)


ROUND = [f"{a},0.0" for a in range(0, 360)]
REFUSED = {
    "no header": ("\n".join(ROUND), "column angle_deg is missing"),
    "a column missing": ("angle_deg,z\n" + "\n".join(ROUND), "column height_um is missing"),
    "a column twice": ("angle_deg,height_um,height_um\n", "there twice"),
    "text in a row": (HEADER + "\n".join([*ROUND[:7], "7,high"]), "line 9"),
    "decimal commas": (HEADER + "\n".join(f"{a},0,5" for a in range(360)), "line 2: 3 cells"),
    "a thousands mark": (HEADER + "\n".join([*ROUND[:7], "7,-2_000"]), "height_um = '-2_000' is no number"),
    "a short row": (HEADER + "\n".join([*ROUND[:7], "7"]), "line 9"),
    "too few": (HEADER + "\n".join(ROUND[:9]), "9 rows"),
    "not finite": (HEADER + "\n".join([*ROUND[:-1], "359,nan"]), "not finite"),
    "falling angles": (HEADER + "\n".join([*ROUND[:50], "20,0.0"]), "after 49 comes 20"),
    "more than a turn": (HEADER + "\n".join([*ROUND, "360.5,0"]), "more than a turn"),
    "a seam that does not close": (HEADER + "\n".join([*ROUND, "360,3"]), "does not close"),
    "a gap at the seam": (HEADER + "\n".join(ROUND[:350]), "gap of 11 degrees at the seam"),
    "a gap": (HEADER + "\n".join(ROUND[:100] + ROUND[110:]), "gap of 11 degrees after 99"),
    "too coarse": (HEADER + "\n".join(ROUND[::2]), "too coarse"),
    "too deep": (HEADER + "\n".join([*ROUND[:-1], "359,-600"]), "range over 600 µm"),
    "a cliff": (table(lambda a: -100.0 * (a > 30)), "too steep"),
    "too high": (HEADER + "\n".join([*ROUND[:-1], "359,60"]), "60 µm is too high"),
    "nothing": ("", "missing"),
    "binary": (b"\xff\xfe\x00", "not UTF-8"),
    "too large": (b"0" * (4 * 2**20 + 1), "larger than 4 MiB"),
    "too many rows": (HEADER + "1,1\n" * 60_000, "more than 50000 rows"),
}  # fmt: skip


@pytest.mark.parametrize("why", REFUSED)
def test_tables_that_are_no_surface_are_refused(why, tmp_path, capsys):
    text, reason = REFUSED[why]
    path = scene_with(tmp_path, "")
    (tmp_path / "race.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    assert run_main([str(path), "--dry-run"]) == 2
    told = capsys.readouterr().err
    assert "profile.0" in told and '"race.csv"' in told and reason in told and "Traceback" not in told


@pytest.mark.parametrize(("lines", "reason"), [
    ('[[profile]]\nfile = "none.csv"', "No such file"), ("[[profile]]", "file"),
    ('[[profile]]\nfile = "race.csv"\nbody = "roller"', "roller = 0"),
    ('[[profile]]\nfile = "race.csv"\nbody = "roller"\nroller = 13', "counted from 0 to 12"),
    ('[[profile]]\nfile = "race.csv"\n[[profile]]\nfile = "race.csv"', "of the same surface"),
    ('[[profile]]\nfile = "race.csv"\ncontent = "x"', "profile.0.content: unknown key"),
    ('[[profile]]\nfile = "race.csv"\nheigt = 1', "known here: body, roller, file, sha256, angle_deg, decimal"),
    ('[[profile]]\nfile = "race.csv"\nsha256 = "' + 64 * "0" + '"', "another than the scene gives"),
])  # fmt: skip
def test_scenes_that_name_no_table_are_refused(lines, reason, tmp_path):
    (tmp_path / "race.csv").write_text(HEADER + "\n".join(ROUND), encoding="utf-8")
    (tmp_path / "scene.toml").write_text(lines, encoding="utf-8")
    with pytest.raises(SceneError, match=reason):
        read_scene(tmp_path / "scene.toml")


def test_the_table_travels_with_the_run_and_another_one_is_not_resumed(tmp_path, capsys):
    wave = table(lambda a: 0.5 * np.cos(np.radians(12 * a)), count=720)
    path, result, whole = scene_with(tmp_path, wave), tmp_path / "run.nc", tmp_path / "whole.nc"
    options = [str(path), "--model", "lagrange", "--quiet", *sets("numerics.output_interval_us=2"), "--output"]
    assert run_main([*options, str(result), "--duration", "0.1"]) == 0
    scene = read_scene(path, ("model=lagrange", "numerics.duration_ms=0.1", "numerics.output_interval_us=2"))
    (tmp_path / "race.csv").unlink()
    for found in (read_result(result).scene, StoredRun(result).scene):
        assert found.ideal_bearing() == scene.ideal_bearing() and found.profile == scene.profile
    with h5py.File(result) as file:
        assert file["outer_sinkage"][:].min() == pytest.approx(-0.5e-6, rel=0.01)
        assert '"kind": "profile"' in file.attrs["faults"] and "events" not in file
    scene_with(tmp_path, wave.replace("0,0.5", "0,0.499", 1))
    assert run_main([*options, str(result), "--duration", "0.1", "--resume"]) == 2
    assert "the scene has changed (profile was" in capsys.readouterr().err
    scene_with(tmp_path, wave)
    for target, more in ((result, ["--resume"]), (whole, [])):
        assert run_main([*options, str(target), "--duration", "0.12", *more]) == 0
    with h5py.File(result) as a, h5py.File(whole) as b:
        np.testing.assert_array_equal(a["outer_sinkage"][:], b["outer_sinkage"][:])
    scene = read_scene(path)  # a live scene keeps its table
    changed = controls.changed(scene, controls.values_of(scene) | {"speed_rpm": 3000.0})
    assert changed.profile == scene.profile and changed.operation.speed_rpm == 3000.0
    assert profiles(changed.ideal_bearing()) is not None


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stored")
    path, result = scene_with(folder, table(lambda a: 0.0, count=720)), folder / "run.nc"
    assert run_main([str(path), "--model", "lagrange", "--duration", "0.4", "--quiet", "--output", str(result)]) == 0
    return result


def put(value):
    return lambda file: file.__setitem__("scene_file_0", value)


FORGED = {  # in the place of the table's text in a result; None: its text is changed
    "another text": (None, "its text is not here"),
    "nothing": (lambda file: None, "its text is not here"),
    "numbers": (put(np.zeros(10)), "not an array of bytes"),
    "zeros": (lambda file: file.create_dataset("scene_file_0", (2**40,), "u1", chunks=(1024,)), "4194304 bytes"),
    "a link": (put(h5py.ExternalLink("/etc/passwd", "/")), "not followed"),
}


@pytest.mark.parametrize("what", FORGED)
def test_a_forged_table_in_a_result_is_noticed(stored, what, tmp_path):
    path, (forge, reason) = tmp_path / "run.nc", FORGED[what]
    path.write_bytes(stored.read_bytes())
    with h5py.File(path, "r+") as file:
        if forge is None:
            file["scene_file_0"][-2] = ord("7")
        else:
            del file["scene_file_0"]
            forge(file)
    for read, refusal in ((read_result, InputError), (StoredRun, (UsageError, SceneError))):
        with pytest.raises(refusal, match=reason):
            read(path)
