"""Pictures: what is drawn where, the scales, the probe."""

import subprocess
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from fem.commands.render_fem import render_main
from fem.commands.run_fem import run_main
from fem.elastic.bodies import von_mises
from fem.pictures.bodies import ARCS, drawn_bearing, refined
from fem.pictures.canvas import Panel
from fem.pictures.drawing_process import PROBE, check_rendering
from fem.pictures.export import fields
from fem.pictures.look import LARGEST_SHARE, Request, chosen_look, chosen_magnification
from fem.pictures.recover import StoredRun
from fem.pictures.scale import Scale, quantity
from fem.pictures.stress_below import FIRST_ROLLER, INNER_RING
from lagrange.errors import UsageError
from meshes import Disc, mesh_of
from meshes.export import FORMATS

PAPER_RADIUS = 32.5e-3  # m, outside
WIDTH = 640
SAMPLE = 400
FORCE, HOUSING, LOAD_ZONE = (0xD7, 0x30, 0x1F), (0xE3, 0xE3, 0xE3), (0xF5, 0xDC, 0xA8)


@pytest.fixture(scope="module")
def run(coarse_run):
    return StoredRun(coarse_run)


@pytest.fixture(scope="module")
def instant(run):
    return run.instant(SAMPLE)


@pytest.fixture(scope="module")
def drawn(instant):
    return drawn_bearing(instant)


def _image(run, sample=SAMPLE, **request):
    from fem.pictures.render import Renderer

    with Renderer(run, Request(**{"width": WIDTH, **request}), [sample]) as renderer:
        return renderer.image(sample)


@pytest.fixture(scope="module")
def image(can_draw, run):
    return _image(run)


def _near(image, colour, tolerance=12):
    return np.abs(image.astype(int) - colour).max(axis=-1) <= tolerance


def _largest_displacement(drawn):
    return float(np.hypot(*drawn.motion.T).max())


def test_the_chosen_magnification_is_round_and_draws_the_largest_displacement_near_its_share(drawn):
    factor = chosen_magnification(_largest_displacement(drawn), PAPER_RADIUS)
    share = factor * _largest_displacement(drawn) / PAPER_RADIUS
    assert LARGEST_SHARE / 1.5 < share <= LARGEST_SHARE
    assert factor == float(f"{factor:.1e}")  # two digits say it


def test_what_is_drawn_is_linear_in_the_magnification(drawn):
    assert drawn.points(0.0) == pytest.approx(drawn.reference, abs=0.0)
    once, often = drawn.points(1.0) - drawn.reference, drawn.points(300.0) - drawn.reference
    assert often == pytest.approx(300.0 * once, rel=1e-9, abs=1e-15)


def test_at_magnification_one_rollers_and_hub_are_where_the_file_has_them(instant, drawn):
    points, mass = drawn.points(1.0), instant.model.roller.mass
    rollers = points[drawn.body >= FIRST_ROLLER].reshape(13, -1, 2)
    centres = np.einsum("n,jnc->jc", mass, rollers) / mass.sum()
    # the drawn indentation moves a few surface nodes inward, by half a micrometre
    assert centres == pytest.approx(instant.centres, abs=0.2e-6)
    bore = points[drawn.circles[0]]
    assert bore.mean(axis=0) == pytest.approx(instant.hub, abs=1e-12)


def test_loaded_contacts_are_drawn_closed(instant, drawn):
    """Magnified, a raceway and a roller's surface fall together in the middle of a contact."""
    factor = 250.0
    outlines = drawn.outlines(factor)
    touched = 0
    for j in np.flatnonzero(instant.outer_force > 100.0):
        normal = np.array([np.cos(instant.outer_angle[j]), np.sin(instant.outer_angle[j])])
        outward = max(outlines[4 + j] @ normal)
        raceway = max(outlines[2] @ normal)
        # hub and rollers are displaced by 0.9 mm; half the gap between nodes of a magnified curve remains
        assert raceway == pytest.approx(outward, abs=0.1e-3)
        touched += 1
    assert touched >= 4


def test_clearance_is_magnified_like_displacements(tmp_path):
    path = tmp_path / "loose.nc"
    loose = ["--mesh-size", "2", "--duration", "0", "--set", "bearing.outer_raceway_diameter_mm=56.02"]
    assert run_main([*loose, "--set", 'numerics.start="rest"', "--output", str(path), "--quiet"]) == 0
    raceway = drawn_bearing(StoredRun(path).instant(0)).outlines(100.0)[2][::ARCS]  # its nodes
    assert np.hypot(*raceway.T) == pytest.approx(np.full(len(raceway), 28e-3 + 100.0 * 10e-6), abs=1e-9)


def test_refined_outlines_and_nodes_lie_on_the_circles(drawn):
    fine = drawn.refined(1e-4, 4e-4, 0.3)
    for points, radius in ((fine.outlines(0.0)[0], 12.5e-3), (fine.outlines(0.0)[1], 18e-3)):
        assert np.hypot(*points.T) == pytest.approx(np.full(len(points), radius), rel=1e-9)
    ring = fine.reference[fine.body == INNER_RING]
    assert len(ring) > 2000 and np.hypot(*ring.T).max() == pytest.approx(18e-3, rel=1e-9)


def test_forces_on_the_rollers_carry_the_load(can_draw, instant):
    from fem.pictures.bearing import contact_forces

    (inner_at, inner), (outer_at, outer), *_ = contact_forces(instant)
    operation = instant.operation
    expected = -operation.radial_load - operation.inner_mass * operation.gravity
    assert inner.sum(axis=0) == pytest.approx([0.0, expected], abs=0.02 * operation.radial_load)
    assert outer.sum(axis=0) == pytest.approx([0.0, -expected], abs=0.02 * operation.radial_load)
    assert np.all(np.sum(inner_at * inner, axis=1) <= 0.0)  # both push into the roller
    assert np.all(np.sum(outer_at * outer, axis=1) <= 0.0)


def test_an_arrow_ends_at_its_tip_and_its_border_surrounds_it(can_draw):
    from fem.pictures.canvas import arrow

    plain, border = (
        arrow((1.0, 2.0), (1.0, 2.5), 0.02, 0.0),
        arrow((1.0, 2.0), (1.0, 2.5), 0.02, 0.0, border=0.01),
    )
    assert plain.bounds[2:4] == pytest.approx((2.0, 2.5))
    assert plain.area == pytest.approx(0.02 * (0.5 - 0.064) + 0.5 * 0.06 * 0.064)
    assert border.bounds[0] < plain.bounds[0] - 0.0099 and border.bounds[3] > 2.51


# ---- scales


def test_scales_end_at_round_numbers_and_label_their_ends():
    linear = Scale(field="von-mises", largest=347e6, logarithmic=False)
    assert linear.end == 400.0 and linear.limits == (0.0, 400.0)
    assert linear.ticks()[-1] == (1.0, "400") and linear.ticks()[0] == (0.0, "0")
    logarithmic = Scale(field="max-shear", largest=230e6, logarithmic=True)
    assert logarithmic.end == 250.0
    shares, labels = zip(*logarithmic.ticks(), strict=True)
    assert labels == ("0.5", "1", "2", "5", "10", "20", "50", "100", "200")
    assert shares[0] == pytest.approx(0.0, abs=1e-9) and shares[-1] == pytest.approx(np.log10(400) / np.log10(500))


def test_displacement_is_measured_from_parts_that_just_touch(instant, drawn):
    inner = quantity("displacement", drawn)[drawn.circles[0]]
    assert inner == pytest.approx(np.full(len(inner), np.hypot(*instant.hub)), rel=1e-9)


def test_a_films_scales_suit_its_most_loaded_frame(run):
    look = chosen_look(run, Request(), range(0, 401, 40))
    forces = run.contact_forces(list(range(0, 401, 40)))
    assert look.largest_force == forces.max()
    assert chosen_look(run, Request(), [200]).largest_force < forces.max()
    assert look.roller == forces[:, 0].max(axis=0).argmax()


def test_an_unknown_roller_is_refused(run):
    with pytest.raises(UsageError, match=r"--roller 13: the run has rollers 0 to 12"):
        chosen_look(run, Request(view="close-up", roller=13), [0])


# ---- pictures


def test_the_picture_shows_stress_forces_housing_load_zone_and_text_on_white(image):
    assert image.shape == (480, WIDTH, 3)
    share = {
        name: _near(image, colour).mean()
        for name, colour in {
            "paper": (255, 255, 255),
            "unloaded": (68, 1, 84),  # viridis at 0
            "force": FORCE,
            "housing": HOUSING,
            "load zone": LOAD_ZONE,
            "ink": (0x1A, 0x1A, 0x1A),
        }.items()
    }
    assert 0.4 < share["paper"] < 0.8
    assert 0.03 < share["unloaded"] < 0.3
    assert 0.0005 < share["force"] < 0.02
    assert 0.01 < share["housing"] < 0.1
    assert 0.01 < share["load zone"] < 0.1
    assert 0.005 < share["ink"] < 0.1
    # the scale's bar runs from viridis' one end to its other
    assert _near(image[:200, 440:], (253, 231, 37), 20).any()
    # stress under the loaded rollers, none above: greens lie in the lower half, as does the load zone
    green = (image[..., 1] > 120) & (image[..., 0] < 110) & (image[..., 2] < 150)
    green[:, 430:] = False
    assert green[240:].sum() > 20 * max(1, green[:240].sum())
    assert (
        not _near(image[:240], LOAD_ZONE).any()
        or _near(image[240:], LOAD_ZONE).sum() > 20 * _near(image[:240], LOAD_ZONE).sum()
    )


def test_the_same_instant_gives_the_same_picture_and_another_magnification_another(image, run):
    assert np.array_equal(_image(run), image)
    assert not np.array_equal(_image(run, magnification=1.0), image)


def test_a_frame_drawn_after_another_is_the_picture_of_its_instant(can_draw, run, image):
    from fem.pictures.render import Renderer

    with Renderer(run, Request(width=WIDTH), [SAMPLE]) as renderer:
        other = renderer.image(SAMPLE - 100)
        assert np.array_equal(renderer.image(SAMPLE), image)
    assert not np.array_equal(other, image)


def test_an_unloaded_bearing_is_drawn_without_arrows(can_draw, coarse_run, monkeypatch):
    nothing = np.zeros(13)
    run = StoredRun(coarse_run)
    plain = run.instant(SAMPLE)
    still = replace(
        plain,
        inner_force=nothing,
        outer_force=nothing,
        inner_traction=nothing,
        outer_traction=nothing,
        inner_ring=0.0 * plain.inner_ring,
        outer_ring=0.0 * plain.outer_ring,
        rollers=0.0 * plain.rollers,
    )
    monkeypatch.setattr(run, "instant", lambda sample: still)
    monkeypatch.setattr(run, "contact_forces", lambda samples: np.zeros((1, 3, 13)))
    assert not _near(_image(run, width=400), FORCE).any()
    assert _image(run, width=400, view="close-up").shape == (300, 400, 3)


@pytest.mark.parametrize("field", ["max-shear", "displacement"])
def test_every_field_is_drawn(can_draw, run, image, field):
    other = _image(run, field=field)
    assert other.shape == image.shape and not np.array_equal(other, image)


def test_a_close_up_shows_the_shear_below_both_contacts(can_draw, run):
    picture = _image(run, view="close-up")
    assert picture.shape == (480, WIDTH, 3)
    # the contacts' panels: brightest (viridis' yellow and green) on both sides of the contact, off the surface
    for top, bottom in ((48, 200), (274, 428)):
        panel = picture[top:bottom, 392:548].astype(int)
        middle = panel[:, 76:82].mean(axis=1)
        bright = middle[:, 1] > 150
        half = len(bright) // 2
        assert bright[half - 35 : half - 5].sum() > 5 and bright[half + 5 : half + 35].sum() > 5


# ---- the probe


def test_the_probe_refuses_a_blank_picture(can_draw, monkeypatch):
    blank = PROBE.replace("renderer.AddActor(actor)", "")
    assert blank != PROBE
    monkeypatch.setattr("fem.pictures.drawing_process.PROBE", blank)
    with pytest.raises(UsageError, match="the picture is blank"):
        check_rendering()


@pytest.mark.parametrize(
    "code, said, words",
    [
        (-11, "", "crashed"),
        (139, "", "crashed"),
        (1, "Traceback\nImportError: libX11.so.6: cannot open\n", "libX11"),
    ],
)
def test_a_failing_probe_is_answered_with_what_cures_it(monkeypatch, code, said, words):
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: subprocess.CompletedProcess([], code, "", said))
    with pytest.raises(UsageError, match=words) as caught:
        check_rendering()
    assert "apt-get install --no-install-recommends libgl1 libegl1" in str(caught.value)


def test_a_probe_that_hangs_is_answered_too(monkeypatch):
    def hang(*_, timeout, **__):
        raise subprocess.TimeoutExpired("python", timeout)

    monkeypatch.setattr(subprocess, "run", hang)
    with pytest.raises(UsageError, match="not finished in 60 s"):
        check_rendering()


# The command render-fem: pictures, films, exports, and what it says of unusable options


def test_the_command_writes_a_png_of_the_width_asked_for(coarse_run, tmp_path, capsys):
    target = tmp_path / "new folder" / "bearing.png"
    options = ["--time", "2", "--output", str(target), "--width", "400", "--magnification", "100"]
    assert render_main([str(coarse_run), *options]) == 0
    assert str(target) in capsys.readouterr().out
    with Image.open(target) as picture:
        assert picture.format == "PNG" and picture.size == (400, 300)


def _frames(path):
    """A GIF's frames as arrays."""
    with Image.open(path) as film:
        frames = []
        for k in range(film.n_frames):
            film.seek(k)
            frames.append(np.asarray(film.convert("RGB")))
        return frames, film.info


def test_pictures_name_model_and_damping(coarse_run, tmp_path, monkeypatch):
    """In the picture itself and in the text of its file, which the report takes for its caption."""
    said, text = [], Panel.text
    monkeypatch.setattr(Panel, "text", lambda panel, words, *where, **how: said.append(words) or text(
        panel, words, *where, **how))  # fmt: skip
    for view in ("bearing", "close-up"):
        target = tmp_path / f"{view}.png"
        assert render_main([str(coarse_run), "--output", str(target), "--width", "320", "--view", view]) == 0
        with Image.open(target) as image:
            assert image.text["Description"].endswith("; finite elements, no contact damping.")
        assert any("finite elements, no contact damping" in words for words in said)
        said.clear()


def test_a_gif_has_the_frames_asked_for_each_another_and_the_same_each_time(coarse_run, tmp_path, capsys):
    films = [tmp_path / "a.gif", tmp_path / "b.gif"]
    for film in films:
        options = ["--animation", str(film), "--frames", "4", "--fps", "10", "--width", "400", "--quiet"]
        assert render_main([str(coarse_run), *options]) == 0
    assert "4 frames" in capsys.readouterr().out
    assert films[0].read_bytes() == films[1].read_bytes()
    frames, info = _frames(films[0])
    assert np.all(frames[0][5, 5] == 255) and np.all(frames[-1][290, 5] == 255)  # white stays white
    assert len(frames) == 4 and info["duration"] == 100 and frames[0].shape == (300, 400, 3)
    assert all((a != b).any() for a, b in pairwise(frames))
    # the scale beside the bearing stands still
    assert all(np.array_equal(frame[45:108, 275:310], frames[0][45:108, 275:310]) for frame in frames)


def test_an_mp4_has_the_frames_asked_for(coarse_run, tmp_path):
    import imageio_ffmpeg

    film = tmp_path / "film.mp4"
    options = ["--animation", str(film), "--start", "1", "--stop", "2", "--frames", "3", "--width", "402"]
    assert render_main([str(coarse_run), *options, "--view", "close-up", "--quiet"]) == 0
    frames = imageio_ffmpeg.read_frames(str(film))
    told = next(frames)
    images = [np.frombuffer(frame, dtype=np.uint8).reshape(302, 402, 3) for frame in frames]
    assert told["size"] == (402, 302) and told["fps"] == 25.0 and len(images) == 3
    assert images[0][:20].mean() > 200 and images[0].std() > 20  # the title's white, and a picture


def test_a_film_that_fails_leaves_nothing(coarse_run, tmp_path, monkeypatch):
    from fem.pictures.render import Renderer

    def fail(self, sample):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Renderer, "image", fail)
    assert render_main([str(coarse_run), "--animation", str(tmp_path / "film.gif"), "--frames", "3", "--quiet"]) == 2
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "options, words",
    [
        (["--time", "99"], "0 to 4 ms"),
        (["--width", "10"], "--width 10"),
        (["--magnification", "-1"], "--magnification -1"),
        (["--magnification", "nan"], "--magnification nan"),
        (["--output", "."], "is a folder"),
        (["--animation", "film.avi"], "must end in .mp4 or .gif"),
        (["--export", "mesh.stl"], "must end in .vtkhdf, .csv, .wav or a format of meshio: .vtu"),
        (["--animation", "film.mp4", "--export", "mesh.vtu"], "give only one of them"),
        (["--animation", "film.mp4", "--time", "1"], "--time: not for a film"),
        (["--start", "1"], "--start, --stop, --frames: only for a film"),
        (["--animation", "film.mp4", "--start", "3", "--stop", "2"], "3 to 2 ms contain no sample"),
        (["--animation", "film.mp4", "--frames", "1"], "--frames 1"),
    ],
)
def test_unusable_options_exit_2_in_a_sentence(coarse_run, capsys, options, words):
    assert render_main([str(coarse_run), *options]) == 2
    told = capsys.readouterr().err
    assert words in told and "Traceback" not in told


# Refined triangles of a picture


@pytest.fixture(scope="module")
def finer():
    mesh = mesh_of(Disc(radius=5e-3, layers=5))
    contact = np.array([5e-3, 0.0])

    def wanted(middles):
        return np.maximum(0.2 * np.hypot(*(middles - contact).T), 2e-5)

    plane = np.column_stack([mesh.points, mesh.points @ [3.0, -2.0] + 1.0])
    return mesh, wanted, *refined(plane, mesh.cells, wanted)


def _areas(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def test_triangles_are_as_small_as_wanted(finer):
    _, wanted, data, triangles = finer
    corners = data[triangles, :2]
    longest = np.hypot(*(corners - np.roll(corners, 1, axis=1)).transpose(2, 0, 1)).max(axis=1)
    assert np.all(longest <= wanted(corners.mean(axis=1)))
    assert longest.min() < 2e-5 and longest.max() > 5e-4  # fine at the contact only


def test_the_same_area_is_covered_once(finer):
    mesh, _, data, triangles = finer
    areas = _areas(data[:, :2], triangles)
    assert areas.min() > 0.0
    assert areas.sum() == pytest.approx(_areas(mesh.points, mesh.cells).sum(), rel=1e-12)


def test_no_node_hangs_on_an_edge(finer):
    mesh, _, data, triangles = finer
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    assert count.max() == 2
    lone = data[edges[count == 1], :2].mean(axis=1)
    rim = mesh.points[-30:]
    normals = rim + np.roll(rim, -1, axis=0)  # every edge at one triangle only lies on a chord of the circle
    normals /= np.hypot(*normals.T)[:, None]
    height = np.max(lone @ normals.T, axis=1)
    assert height == pytest.approx(np.full(len(lone), 5e-3 * np.cos(np.pi / 30)), rel=1e-9)


def test_columns_are_carried_along(finer):
    mesh, _, data, _ = finer
    assert np.array_equal(data[: len(mesh.points), :2], mesh.points)
    assert data[:, 2] == pytest.approx(data[:, :2] @ [3.0, -2.0] + 1.0)


# Fields for other programs, read back by those programs' own readers


SAMPLES = [0, 200, 400]


@pytest.fixture(scope="module")
def expected_export(run):
    return [fields(run.instant(sample)) for sample in SAMPLES]


def _cells(run):
    model = run.model
    rings = len(model.inner_ring.cells) + len(model.outer_ring.cells)
    return rings, 13 * len(model.roller.cells)


def test_points_are_where_rigid_motion_takes_them_and_the_hub_is_in_the_middle(run, expected_export):
    instant = run.instant(400)
    points, data = expected_export[2]
    ring = len(instant.model.inner_ring.points)
    assert points[:ring].mean(axis=0) == pytest.approx(instant.hub, abs=1e-9)
    last = points[-instant.model.roller.n_nodes :]
    innermost = instant.model.roller.shape.rows[0].nodes  # whose displacement is far below a micrometre
    assert last[:innermost].mean(axis=0) == pytest.approx(instant.centres[12], abs=1e-7)
    assert np.abs(data["displacement"]).max() < 1e-6  # elastic only


def test_the_tensor_and_von_mises_agree(expected_export):
    _, data = expected_export[1]
    tensor = data["stress"].reshape(-1, 3, 3).astype(float)
    assert np.array_equal(tensor, np.swapaxes(tensor, 1, 2))
    deviator = tensor - np.trace(tensor, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    assert data["von_mises"] == pytest.approx(np.sqrt(1.5 * np.sum(deviator**2, axis=(1, 2))), rel=1e-4, abs=10.0)
    assert data["von_mises"] == pytest.approx(
        von_mises(tensor[:, [0, 1, 0], [0, 1, 1]], 0.3), rel=1e-4, abs=10.0
    )  # fmt: skip


def test_a_vtkhdf_series_reads_back_in_vtk(run, coarse_run, expected_export, tmp_path, capsys):
    vtk = pytest.importorskip("vtkmodules.vtkIOHDF")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    target = tmp_path / "run.vtkhdf"
    assert render_main([str(coarse_run), "--export", str(target), "--frames", "3", "--quiet"]) == 0
    assert str(target) in capsys.readouterr().out
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(target))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == 3
    rings, triangles = _cells(run)
    for step, (points, data) in enumerate(expected_export):
        reader.SetStep(step)
        reader.Update()
        grid = reader.GetOutput()
        assert reader.GetTimeValue() == pytest.approx(run.times[SAMPLES[step]])
        assert grid.GetNumberOfCells() == rings + triangles
        assert grid.GetCellType(0) == 9 and grid.GetCellType(rings) == 5
        assert np.array_equal(vtk_to_numpy(grid.GetPoints().GetData())[:, :2], points)
        for name, values in data.items():
            assert np.array_equal(vtk_to_numpy(grid.GetPointData().GetArray(name)), values)
        body = vtk_to_numpy(grid.GetCellData().GetArray("body"))
        assert body[0] == 0 and body[rings - 1] == 1 and body[rings] == 2 and body[-1] == 14
        for cell in (0, rings + triangles - 1):  # corners of a cell lie together
            corners = np.array([grid.GetCell(cell).GetPoints().GetPoint(k)[:2] for k in range(3)])
            assert np.ptp(corners, axis=0).max() < 4e-3


@pytest.mark.parametrize("suffix", FORMATS)
def test_an_instant_reads_back_in_meshio(run, coarse_run, expected_export, tmp_path, suffix):
    import meshio

    target = tmp_path / f"instant{suffix}"
    assert render_main([str(coarse_run), "--export", str(target), "--time", "2"]) == 0
    assert [path.name for path in tmp_path.iterdir()] == [target.name]
    mesh = meshio.read(target)
    points, data = expected_export[1]
    assert mesh.points[:, :2] == pytest.approx(points, abs=1e-12)
    rings, triangles = _cells(run)
    assert {block.type: len(block.data) for block in mesh.cells} == {"quad": rings, "triangle": triangles}
    for name in ("displacement", "von_mises"):
        values = mesh.point_data[name].reshape(data[name].shape)
        assert values == pytest.approx(data[name], rel=1e-5, abs=1e-12)
