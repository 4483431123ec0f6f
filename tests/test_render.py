"""Pictures: what is drawn where, the scales, the command, surfaces that are not perfect, fields for other programs."""

import subprocess
from dataclasses import replace
from itertools import pairwise
from math import asin

import imageio_ffmpeg
import meshio
import numpy as np
import pytest
from PIL import Image, ImageSequence

from fem.commands.render_fem import render_main
from fem.commands.run_fem import run_main
from fem.elastic.bodies import von_mises
from fem.pictures.bodies import ARCS, Drawing, chart_factor, charts, drawn_bearing, holes, refined, unequal_rollers
from fem.pictures.look import LARGEST_SHARE, Request, Scale, chosen_look, chosen_magnification
from fem.pictures.output import PROBE, check_rendering, fields
from fem.pictures.recover import FIRST_ROLLER, INNER_RING, StoredRun
from lagrange.errors import UsageError
from meshes import Disc, mesh_of
from meshes.export import FORMATS
from tests.reference.kit import sets

PAPER_RADIUS = 32.5e-3  # m, outside
WIDTH = 640
SAMPLE = 400
FORCE, LOAD_ZONE, ORANGE = (0xD7, 0x30, 0x1F), (0xF5, 0xDC, 0xA8), (0xFF, 0x99, 0x00)


@pytest.fixture(scope="module")
def run(coarse_run):
    return StoredRun(coarse_run)


@pytest.fixture(scope="module")
def instant(run):
    return run.instant(SAMPLE)


@pytest.fixture(scope="module")
def drawn(instant):
    return drawn_bearing(instant)


def images_of(run, *samples, **request):
    from fem.pictures.views import Renderer

    with Renderer(run, Request(**{"width": WIDTH, **request}), [samples[0]]) as renderer:
        return [renderer.image(sample) for sample in samples]


@pytest.fixture(scope="module")
def image(can_draw, run):
    return images_of(run, SAMPLE)[0]


def near(image, colour, tolerance=12):
    return np.abs(image.astype(int) - colour).max(axis=-1) <= tolerance


def test_bodies_are_drawn_where_the_file_has_them_by_a_round_factor_and_loaded_contacts_closed(instant, drawn):
    largest = float(drawn.quantity("displacement").max())
    factor = chosen_magnification(largest, PAPER_RADIUS)
    assert LARGEST_SHARE / 1.5 < factor * largest / PAPER_RADIUS <= LARGEST_SHARE and factor == float(f"{factor:.1e}")
    assert drawn.points(0.0) == pytest.approx(drawn.reference, abs=0.0)
    once, often = drawn.points(1.0) - drawn.reference, drawn.points(300.0) - drawn.reference
    assert often == pytest.approx(300.0 * once, rel=1e-9, abs=1e-15)
    inner = drawn.quantity("displacement")[drawn.circles[0]]
    assert inner == pytest.approx(np.full(len(inner), np.hypot(*instant.hub)), rel=1e-9)
    # Magnified, a raceway and a roller's surface fall together in the middle of a contact.
    points, mass = drawn.points(1.0), instant.model.roller.mass
    rollers = points[drawn.body >= FIRST_ROLLER].reshape(13, -1, 2)
    centres = np.einsum("n,jnc->jc", mass, rollers) / mass.sum()
    # the drawn indentation moves a few surface nodes inward, by half a micrometre
    assert centres == pytest.approx(instant.centres, abs=0.2e-6)
    assert points[drawn.circles[0]].mean(axis=0) == pytest.approx(instant.hub, abs=1e-12)
    outlines, loaded = drawn.outlines(250.0), np.flatnonzero(instant.outer_force > 100.0)
    assert len(loaded) >= 4
    for j in loaded:
        normal = np.array([np.cos(instant.outer_angle[j]), np.sin(instant.outer_angle[j])])
        # hub and rollers are displaced by 0.9 mm; half the gap between nodes of a magnified curve remains
        assert max(outlines[2] @ normal) == pytest.approx(max(outlines[4 + j] @ normal), abs=0.1e-3)


def test_clearance_is_magnified_like_displacements_and_refined_outlines_and_nodes_lie_on_the_circles(drawn, tmp_path):
    loose = at_rest(tmp_path / "loose.nc", "bearing.outer_raceway_diameter_mm=56.02", "numerics.start=rest")
    raceway = drawn_bearing(loose.instant(0)).outlines(100.0)[2][::ARCS]  # its nodes
    assert np.hypot(*raceway.T) == pytest.approx(np.full(len(raceway), 28e-3 + 100.0 * 10e-6), abs=1e-9)
    fine = drawn.refined(1e-4, 4e-4, 0.3)
    for points, radius in ((fine.outlines(0.0)[0], 12.5e-3), (fine.outlines(0.0)[1], 18e-3)):
        assert np.hypot(*points.T) == pytest.approx(np.full(len(points), radius), rel=1e-9)
    ring = fine.reference[fine.body == INNER_RING]
    assert len(ring) > 2000 and np.hypot(*ring.T).max() == pytest.approx(18e-3, rel=1e-9)


def test_forces_on_the_rollers_carry_the_load_and_an_arrow_ends_at_its_tip(can_draw, instant, drawn):
    from fem.pictures.canvas import arrow

    operation = instant.operation
    carried = operation.radial_load + operation.inner_mass * operation.gravity
    for kind, sign in (("inner", -1.0), ("outer", 1.0)):
        loads = [item.load for item in drawn.loads if item.kind == kind and item.body >= FIRST_ROLLER]
        force = 1e-2 * np.sum([load.force for load in loads], axis=0)  # of rollers of 10 mm
        assert force == pytest.approx([0.0, sign * carried], abs=0.02 * operation.radial_load)
        assert all(load.force @ load.point < 0.0 for load in loads)  # into the roller
    x, y = arrow((1.0, 2.0), (1.0, 2.5), 0.02).T
    assert (y.min(), y.max()) == pytest.approx((2.0, 2.5))
    area = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    assert area == pytest.approx(0.02 * (0.5 - 0.064) + 0.5 * 0.06 * 0.064)


def test_scales_end_at_round_numbers_and_suit_the_most_loaded_frame_of_a_film(run):
    linear = Scale(field="von-mises", largest=347e6, logarithmic=False)
    assert linear.end == 400.0 and linear.limits == (0.0, 400.0)
    assert linear.ticks()[-1] == (1.0, "400") and linear.ticks()[0] == (0.0, "0")
    logarithmic = Scale(field="max-shear", largest=230e6, logarithmic=True)
    shares, labels = zip(*logarithmic.ticks(), strict=True)
    assert logarithmic.end == 250.0 and labels == ("0.5", "1", "2", "5", "10", "20", "50", "100", "200")
    assert shares[0] == pytest.approx(0.0, abs=1e-9) and shares[-1] == pytest.approx(np.log10(400) / np.log10(500))
    look, forces = chosen_look(run, Request(), range(0, 401, 40)), run.contact_forces(list(range(0, 401, 40)))
    assert look.largest_force == forces.max() > chosen_look(run, Request(), [200]).largest_force
    assert look.roller == forces[:, 0].max(axis=0).argmax()


def test_the_picture_shows_stress_forces_housing_load_zone_and_text_on_white(image):
    assert image.shape == (480, WIDTH, 3)
    for low, colour, high in (
        (0.4, (255, 255, 255), 0.8), (0.03, (68, 1, 84), 0.3),  # paper, viridis at 0
        (0.0005, FORCE, 0.02), (0.01, (0xE3, 0xE3, 0xE3), 0.1),  # forces, housing
        (0.01, LOAD_ZONE, 0.1), (0.005, (0x1A, 0x1A, 0x1A), 0.1),  # load zone, ink
    ):  # fmt: skip
        assert low < near(image, colour).mean() < high, colour
    assert near(image[:200, 440:], (253, 231, 37), 20).any()  # the scale's bar runs from viridis' one end to its other
    # stress under the loaded rollers, none above: greens lie in the lower half, as does the load zone
    green = (image[..., 1] > 120) & (image[..., 0] < 110) & (image[..., 2] < 150)
    green[:, 430:] = False
    assert green[240:].sum() > 20 * max(1, green[:240].sum())
    assert near(image[240:], LOAD_ZONE).sum() > 20 * near(image[:240], LOAD_ZONE).sum()


def test_the_same_instant_gives_the_same_picture_whatever_was_drawn_before_and_others_others(run, image):
    _, other, again = images_of(run, SAMPLE, SAMPLE - 100, SAMPLE)
    assert np.array_equal(again, image) and not np.array_equal(other, image)
    for request in ({"magnification": 1.0}, {"field": "max-shear"}, {"field": "displacement"}):
        (other,) = images_of(run, SAMPLE, **request)
        assert other.shape == image.shape and not np.array_equal(other, image), request


def test_an_unloaded_bearing_is_drawn_without_arrows(can_draw, coarse_run, monkeypatch):
    run = StoredRun(coarse_run)
    plain = run.instant(SAMPLE)
    names = "inner_force outer_force inner_traction outer_traction inner_ring outer_ring rollers".split()
    still = replace(plain, **{name: 0.0 * getattr(plain, name) for name in names})
    monkeypatch.setattr(run, "instant", lambda sample: still)
    monkeypatch.setattr(run, "contact_forces", lambda samples: np.zeros((1, 3, 13)))
    assert not near(images_of(run, 0, width=400)[0], FORCE).any()
    assert images_of(run, 0, width=400, view="close-up")[0].shape == (300, 400, 3)


def test_a_close_up_shows_the_shear_below_both_contacts(can_draw, run):
    """Brightest (viridis' yellow and green) on both sides of the contact in its panel, off the surface."""
    (picture,) = images_of(run, SAMPLE, view="close-up")
    assert picture.shape == (480, WIDTH, 3)
    for top, bottom in ((48, 200), (274, 428)):
        bright = picture[top:bottom, 468:474, 1].astype(int).mean(axis=1) > 150
        half = len(bright) // 2
        assert bright[half - 35 : half - 5].sum() > 5 and bright[half + 5 : half + 35].sum() > 5


@pytest.mark.parametrize(("code", "stderr", "words"), [
    (-11, "", "crashed"), (139, "", "crashed"), (None, "", "not finished in 60 s"),
    (1, "Traceback\nImportError: libX11.so.6: cannot open\n", "libX11"), ("blank", "", "the picture is blank"),
])  # fmt: skip
def test_a_failing_probe_is_answered_with_what_cures_it(can_draw, monkeypatch, code, stderr, words):
    def probe(*_, timeout, **__):
        if code is None:
            raise subprocess.TimeoutExpired("python", timeout)
        return subprocess.CompletedProcess([], code, "", stderr)

    if code == "blank":
        assert "renderer.AddActor(actor)" in PROBE
        monkeypatch.setattr("fem.pictures.output.PROBE", PROBE.replace("renderer.AddActor(actor)", ""))
    else:
        monkeypatch.setattr(subprocess, "run", probe)
    with pytest.raises(UsageError, match=words) as caught:
        check_rendering()
    assert "apt-get install --no-install-recommends libgl1 libegl1" in str(caught.value)


@pytest.mark.parametrize("view", ["bearing", "close-up"])
def test_the_command_writes_a_png_that_names_model_and_damping(coarse_run, tmp_path, capsys, monkeypatch, view):
    from fem.pictures.canvas import Panel

    drawn, text = [], Panel.text
    monkeypatch.setattr(Panel, "text", lambda panel, words, *where, **how: drawn.append(words) or text(
        panel, words, *where, **how))  # fmt: skip
    target = tmp_path / "new folder" / "picture.png"
    options = ["--time", "2", "--output", str(target), "--width", "400", "--magnification", "100", "--view", view]
    assert render_main([str(coarse_run), *options]) == 0 and str(target) in capsys.readouterr().out
    with Image.open(target) as picture:
        assert picture.format == "PNG" and picture.size == (400, 300)
        assert picture.text["Description"].endswith("; finite elements, no contact damping.")
    assert any("finite elements, no contact damping" in words for words in drawn)


def test_films_have_the_frames_asked_for_and_one_that_fails_leaves_nothing(coarse_run, tmp_path, capsys, monkeypatch):
    from fem.pictures.views import Renderer

    def filmed(name, *options):
        words = ["--animation", str(tmp_path / name), *" ".join(options).split(), "--quiet"]
        return render_main([str(coarse_run), *words]), tmp_path / name

    films = [filmed(name, "--frames 4 --fps 10 --width 400") for name in ("a.gif", "b.gif")]
    assert "4 frames" in capsys.readouterr().out
    assert len({path.read_bytes() for code, path in films if code == 0}) == 1
    with Image.open(films[0][1]) as film:
        assert film.n_frames == 4 and film.info["duration"] == 100
        frames = [np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(film)]
    assert np.all(frames[0][5, 5] == 255) and np.all(frames[-1][290, 5] == 255)  # white stays white
    assert frames[0].shape == (300, 400, 3) and all((a != b).any() for a, b in pairwise(frames))
    assert all(np.array_equal(frame[45:108, 275:310], frames[0][45:108, 275:310]) for frame in frames)
    code, film = filmed("film.mp4", "--start 1 --stop 2 --frames 3 --width 402 --view close-up")
    told, *images = imageio_ffmpeg.read_frames(str(film))
    assert code == 0 and told["size"] == (402, 302) and told["fps"] == 25.0 and len(images) == 3
    image = np.frombuffer(images[0], dtype=np.uint8).reshape(302, 402, 3)
    assert image[:20].mean() > 200 and image.std() > 20  # the title's white, and a picture

    def fail(self, sample):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Renderer, "image", fail)
    before = sorted(tmp_path.iterdir())
    assert filmed("c.gif", "--frames 3")[0] == 2 and sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize(("options", "words"), [
    ("--animation film.avi", "must end in .mp4 or .gif"), ("--magnification nan", "--magnification nan"),
    ("--export mesh.stl", "must end in .vtkhdf, .csv, .wav or a format of meshio: .vtu"),
    ("--animation film.mp4 --export mesh.vtu", "give only one of them"),
    ("--animation film.mp4 --time 1", "--time: not for a film"), ("--animation film.mp4 --frames 1", "--frames 1"),
    ("--start 1", "--start, --stop, --frames: only for a film"),
    ("--animation film.mp4 --start 3 --stop 2", "3 to 2 ms contain no sample"),
    ("--view close-up --roller 13", "--roller 13: the run has rollers 0 to 12"),
])  # fmt: skip
def test_unusable_options_exit_2_in_a_sentence(coarse_run, capsys, options, words):
    assert render_main([str(coarse_run), *options.split()]) == 2
    told = capsys.readouterr().err
    assert words in told and "Traceback" not in told


def test_refined_triangles_are_as_small_as_wanted_cover_the_area_once_and_hang_no_node_on_an_edge():
    mesh, contact = mesh_of(Disc(radius=5e-3, layers=5)), np.array([5e-3, 0.0])
    wanted = lambda middles: np.maximum(0.2 * np.hypot(*(middles - contact).T), 2e-5)  # noqa: E731
    plane = np.column_stack([mesh.points, mesh.points @ [3.0, -2.0] + 1.0])
    data, triangles = refined(plane, mesh.cells, wanted)
    sides = [np.diff(found[:, [0, 1, 2, 0]], axis=1) for found in (data[triangles, :2], mesh.points[mesh.cells])]
    longest = np.linalg.norm(sides[0], axis=2).max(axis=1)
    assert np.all(longest <= wanted(data[triangles, :2].mean(axis=1)))
    assert longest.min() < 2e-5 and longest.max() > 5e-4  # fine at the contact only
    covered, before = (0.5 * (x[:, 0] * y[:, 1] - y[:, 0] * x[:, 1]) for x, y in (np.moveaxis(s, 2, 0) for s in sides))
    assert covered.min() > 0.0 and covered.sum() == pytest.approx(before.sum(), rel=1e-12)
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    lone, normal = data[edges[count == 1], :2].mean(axis=1), 2.0 * np.pi * (np.arange(30) + 0.5) / 30
    height = np.max(lone @ [np.cos(normal), np.sin(normal)], axis=1)  # of edges at one triangle: on chords
    assert count.max() == 2 and height == pytest.approx(np.full(len(lone), 5e-3 * np.cos(np.pi / 30)), rel=1e-9)
    assert np.array_equal(data[: len(mesh.points), :2], mesh.points)  # columns are carried along
    assert data[:, 2] == pytest.approx(data[:, :2] @ [3.0, -2.0] + 1.0)


SAMPLES = [0, 200, 400]


@pytest.fixture(scope="module")
def expected_export(run):
    return [fields(run.instant(sample)) for sample in SAMPLES]


@pytest.fixture(scope="module")
def n_cells(run):
    return len(run.model.inner_ring.cells) + len(run.model.outer_ring.cells), 13 * len(run.model.roller.cells)


def test_points_are_where_rigid_motion_takes_them_and_the_tensor_and_von_mises_agree(instant, expected_export):
    points, data = expected_export[2]
    roller = instant.model.roller
    assert points[: len(instant.model.inner_ring.points)].mean(axis=0) == pytest.approx(instant.hub, abs=1e-9)
    innermost = points[-roller.n_nodes :][: roller.shape.rows[0].nodes]  # displaced by far below a micrometre
    assert innermost.mean(axis=0) == pytest.approx(instant.centres[12], abs=1e-7)
    assert np.abs(data["displacement"]).max() < 1e-6  # elastic only
    data = expected_export[1][1]
    tensor = data["stress"].reshape(-1, 3, 3).astype(float)
    assert np.array_equal(tensor, np.swapaxes(tensor, 1, 2))
    deviator = tensor - np.trace(tensor, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    assert data["von_mises"] == pytest.approx(np.sqrt(1.5 * np.sum(deviator**2, axis=(1, 2))), rel=1e-4, abs=10.0)
    assert data["von_mises"] == pytest.approx(von_mises(tensor[:, [0, 1, 0], [0, 1, 1]], 0.3), rel=1e-4, abs=10.0)


def test_a_vtkhdf_series_reads_back_in_vtk(run, n_cells, coarse_run, expected_export, tmp_path, capsys):
    pv, (rings, triangles), target = pytest.importorskip("pyvista"), n_cells, tmp_path / "run.vtkhdf"
    assert render_main([str(coarse_run), "--export", str(target), "--frames", "3", "--quiet"]) == 0
    assert str(target) in capsys.readouterr().out
    reader = pv.get_reader(target).reader  # VTK's
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == 3
    for step, (points, data) in enumerate(expected_export):
        reader.SetStep(step)
        reader.Update()
        grid = pv.wrap(reader.GetOutput())
        assert reader.GetTimeValue() == pytest.approx(run.times[SAMPLES[step]])
        assert grid.n_cells == rings + triangles and grid.celltypes[[0, rings]].tolist() == [9, 5]
        assert np.array_equal(grid.points[:, :2], points)
        for name, values in data.items():
            assert np.array_equal(grid.point_data[name], values)
        assert grid.cell_data["body"][[0, rings - 1, rings, -1]].tolist() == [0, 1, 2, 14]
        for cell in (0, rings + triangles - 1):  # corners of a cell lie together
            assert np.ptp(grid.get_cell(cell).points, axis=0).max() < 4e-3


@pytest.mark.parametrize("suffix", FORMATS)
def test_an_instant_reads_back_in_meshio(n_cells, coarse_run, expected_export, tmp_path, suffix):
    target = tmp_path / f"instant{suffix}"
    assert render_main([str(coarse_run), "--export", str(target), "--time", "2"]) == 0
    assert [path.name for path in tmp_path.iterdir()] == [target.name]
    mesh, (points, data), (rings, triangles) = meshio.read(target), expected_export[1], n_cells
    assert mesh.points[:, :2] == pytest.approx(points, abs=1e-12)
    assert {block.type: len(block.data) for block in mesh.cells} == {"quad": rings, "triangle": triangles}
    for name in ("displacement", "von_mises"):
        values = mesh.point_data[name].reshape(data[name].shape)
        assert values == pytest.approx(data[name], rel=1e-5, abs=1e-12)


SETTINGS = (
    "spall.0.angle_deg=90", "spall.0.depth_um=10", 'spall.1.body="inner_ring"', "spall.1.angle_deg=180",
    "spall.1.width_mm=2", 'spall.2.body="roller"', "spall.2.roller=3", "waviness.0.amplitude_um=2",
    "waviness.0.order=7", "unequal_roller.0.roller=5", "unequal_roller.0.diameter_deviation_um=-3",
)  # fmt: skip


def at_rest(path, *settings):
    options = ["--mesh-size", "2", "--duration", "0", "--quiet", "--output", str(path)]
    assert run_main([*options, *sets(*settings)]) == 0
    return StoredRun(path)


@pytest.fixture(scope="module")
def faulty(tmp_path_factory):
    return at_rest(tmp_path_factory.mktemp("faults") / "run.nc", "model=lagrange", *SETTINGS)


@pytest.fixture(scope="module")
def sketch(faulty):
    about = {"instant": (instant := faulty.instant(0)), "drawn": drawn_bearing(instant)}
    return lambda magnification=1.0: Drawing(**about, magnification=magnification)


def test_holes_lie_where_spalls_are_and_are_as_deep(sketch):
    """At their own scale: flat bottoms of 10 and 100 µm; as reached: the bottom, or 128.8 µm between two edges.
    Rounded edges of radius 0.1 mm, 10 µm deep: half a µm below the circle 10 µm from where it leaves it, x²/(2e)."""
    true, reached = (holes(sketch(), 0.0, as_reached=as_reached) for as_reached in (False, True))
    for k, centre, radius, direction, width, depths in (
        (0, (0.0, 0.0), 28e-3, 0.0, 1e-3, (10e-6, 10e-6)),
        (1, sketch().hub, 18e-3, 0.5 * np.pi, 2e-3, (-100e-6, -100e-6)),
        (2, sketch().centres[3], 5e-3, 0.0, 1e-3, (-100e-6, -20.6e-6)),
    ):
        for found, depth in zip((true[k], reached[k]), depths, strict=True):
            out = found.edge - centre
            middle = out[len(out) // 2]
            assert np.arctan2(*middle[::-1]) == pytest.approx(direction, abs=1e-9)
            assert np.hypot(*middle) - radius == pytest.approx(depth, rel=0.02)
            half = np.degrees(np.arctan2(*out[-1][::-1]) - direction)
            assert half == pytest.approx(np.degrees(asin(0.5 * width * np.sqrt(1.02) / radius)), rel=1e-6)
    assert [hole.name for hole in true] == ["spall 1 mm", "spall 2 mm", "spall 1 mm"]
    depth, along = np.hypot(*true[0].edge.T) - 28e-3, true[0].edge[:, 1]
    for x in (10e-6, 30e-6):
        assert np.interp(0.5e-3 * np.sqrt(1.02) - x, along, depth) == pytest.approx(x**2 / 0.2e-3, rel=0.1, abs=0.1e-6)


def test_holes_are_no_deeper_than_bodies_bear_nor_cut_rollers_away_charts_magnify_heights(sketch):
    found = holes(sketch(1e4), 0.0, as_reached=True)
    depth = np.hypot(*found[0].edge.T) - np.hypot(*found[0].edge[0])
    assert depth.max() <= 1.5e-3 and found[0].name == "spall 1 mm, × 100"
    for magnification in (1.0, 200.0):
        hole = holes(sketch(magnification), 1e-6, as_reached=True)[0]
        nearest = np.hypot(*(hole.top[:, None] - sketch(magnification).centres).transpose(2, 0, 1)).min(axis=1)
        assert nearest.min() > 5e-3 - 1e-9
    (chart,) = charts(sketch(100.0))
    factor, centre = chart_factor(sketch().bearing), sketch(100.0).hub
    height = np.hypot(*(chart.curve - centre).T) - np.hypot(*(chart.circle - centre).T)
    assert np.abs(height).max() == pytest.approx(factor * 2e-6, rel=1e-3) and 0.1 < factor * 2e-6 / 5.5e-3 <= 0.22
    assert np.count_nonzero((height[:-1] > 0) & (height[1:] <= 0)) == 7 and chart.name == "order 7, 2 µm"
    ((circle, name),) = unequal_rollers(sketch())
    assert (circle.roller, name) == (5, "Ø −3 µm")


@pytest.mark.parametrize("view", ["close-up", pytest.param("bearing", marks=pytest.mark.slow)])
def test_faults_are_seen(can_draw, faulty, view):
    (image,) = images_of(faulty, 0, view=view, roller=3)
    assert near(image, ORANGE, 39).sum() > (200 if view == "bearing" else 3)
