"""The picture: what is drawn where, the probe, and the command."""

import subprocess
from dataclasses import replace

import numpy as np
import pytest

from fem.cli import render_main, run_main
from fem.errors import UsageError
from fem.recover import read_instant
from fem.render_bodies import LARGEST_SHARE, chosen_magnification, drawn_bearing
from fem.rendering_probe import check_rendering

PAPER_RADIUS = 32.5e-3  # m, outside
WIDTH = 640


@pytest.fixture(scope="module")
def can_draw():
    try:
        check_rendering()
    except UsageError as error:
        pytest.skip(f"no off-screen rendering here: {error}")


@pytest.fixture(scope="module")
def instant(coarse_run):
    return read_instant(coarse_run)


@pytest.fixture(scope="module")
def image(can_draw, instant):
    from fem.render import picture

    return picture(instant, width=WIDTH)


def _near(image, colour, tolerance=12):
    return np.abs(image.astype(int) - colour).max(axis=-1) <= tolerance


def test_the_chosen_magnification_is_round_and_draws_the_largest_displacement_near_its_share(instant):
    drawn = drawn_bearing(instant)
    factor = chosen_magnification(drawn, PAPER_RADIUS)
    share = factor * drawn.largest_displacement / PAPER_RADIUS
    assert LARGEST_SHARE / 1.5 < share <= LARGEST_SHARE
    assert factor == float(f"{factor:.1e}")  # two digits say it


def test_what_is_drawn_is_linear_in_the_magnification(instant):
    body = drawn_bearing(instant).rollers[0]
    assert body.points(0.0) == pytest.approx(body.reference, abs=0.0)
    assert body.points(300.0) - body.reference == pytest.approx(300.0 * body.displacement, rel=1e-12, abs=1e-18)


def test_at_magnification_one_rollers_and_hub_are_where_the_file_has_them(instant):
    drawn = drawn_bearing(instant)
    centres = np.array([instant.model.roller.mass @ body.points(1.0) for body in drawn.rollers])
    # the drawn indentation moves a few surface nodes inward, by half a micrometre
    assert centres / instant.model.roller.total_mass == pytest.approx(instant.centres, abs=0.2e-6)
    bore = drawn.inner_ring.points(1.0)[drawn.inner_ring.edges[0]]
    assert bore.mean(axis=0) == pytest.approx(instant.hub, abs=1e-12)


def test_loaded_contacts_are_drawn_closed(instant):
    """Magnified, a raceway's node in the middle of a contact and the roller's surface there fall together."""
    model, factor = instant.model, 250.0
    drawn = drawn_bearing(instant)
    touched = 0
    for j in np.flatnonzero(instant.outer_force > 100.0):
        normal = np.array([np.cos(instant.outer_angle[j]), np.sin(instant.outer_angle[j])])
        outward = max(drawn.rollers[j].points(factor)[model.roller.first_surface_node :] @ normal)
        raceway = drawn.outer_ring.points(factor)[drawn.outer_ring.edges[0]]
        nearest = raceway[np.argmax(raceway @ normal)]
        # facets of 2 mm lie up to 0.1 mm inside their circle; hub and rollers are displaced by 0.9 mm
        assert nearest @ normal == pytest.approx(outward, abs=0.15e-3)
        touched += 1
    assert touched >= 4


def test_clearance_is_magnified_like_displacements(tmp_path):
    path = tmp_path / "loose.nc"
    loose = ["--mesh-size", "2", "--duration", "0", "--set", "bearing.outer_raceway_diameter_mm=56.02"]
    assert run_main([*loose, "--set", 'numerics.start="rest"', "--output", str(path), "--quiet"]) == 0
    drawn = drawn_bearing(read_instant(path))
    raceway = drawn.outer_ring.points(100.0)[drawn.outer_ring.edges[0]]
    assert np.hypot(*raceway.T) == pytest.approx(np.full(len(raceway), 28e-3 + 100.0 * 10e-6), abs=1e-9)


def test_forces_on_the_rollers_carry_the_load(can_draw, instant):
    from fem.render import contact_forces

    (inner_at, inner), (outer_at, outer), *_ = contact_forces(instant)
    operation = instant.operation
    expected = -operation.radial_load - operation.inner_mass * operation.gravity
    assert inner.sum(axis=0) == pytest.approx([0.0, expected], abs=0.02 * operation.radial_load)
    assert outer.sum(axis=0) == pytest.approx([0.0, -expected], abs=0.02 * operation.radial_load)
    assert np.all(np.sum(inner_at * inner, axis=1) <= 0.0)  # both push into the roller
    assert np.all(np.sum(outer_at * outer, axis=1) <= 0.0)


def test_an_arrow_ends_at_its_tip_and_its_border_surrounds_it(can_draw):
    from fem.render_shapes import arrow

    plain, border = (
        arrow((1.0, 2.0), (1.0, 2.5), 0.02, 0.0),
        arrow((1.0, 2.0), (1.0, 2.5), 0.02, 0.0, border=0.01),
    )
    assert plain.bounds[2:4] == pytest.approx((2.0, 2.5))
    assert plain.area == pytest.approx(0.02 * (0.5 - 0.064) + 0.5 * 0.06 * 0.064)
    assert border.bounds[0] < plain.bounds[0] - 0.0099 and border.bounds[3] > 2.51


def test_the_picture_shows_stress_forces_housing_and_text_on_white(image):
    assert image.shape == (480, WIDTH, 3)
    share = {
        name: _near(image, colour).mean()
        for name, colour in {
            "paper": (255, 255, 255),
            "unloaded": (68, 1, 84),  # viridis at 0
            "force": (0xD7, 0x30, 0x1F),
            "housing": (0xE3, 0xE3, 0xE3),
            "ink": (0x1A, 0x1A, 0x1A),
        }.items()
    }
    assert 0.4 < share["paper"] < 0.8
    assert 0.03 < share["unloaded"] < 0.3
    assert 0.0005 < share["force"] < 0.02
    assert 0.01 < share["housing"] < 0.1
    assert 0.005 < share["ink"] < 0.1
    # the scale's bar runs from viridis' one end to its other
    assert _near(image[:200, 440:], (253, 231, 37), 20).any()
    # stress under the loaded rollers, none above: greens lie in the lower half
    green = (image[..., 1] > 120) & (image[..., 0] < 110) & (image[..., 2] < 150)
    green[:, 430:] = False
    assert green[240:].sum() > 20 * max(1, green[:240].sum())


def test_the_same_instant_gives_the_same_picture_and_another_magnification_another(image, instant):
    from fem.render import picture

    assert np.array_equal(picture(instant, width=WIDTH), image)
    assert not np.array_equal(picture(instant, 1.0, WIDTH), image)


def test_an_unloaded_bearing_is_drawn_without_arrows(can_draw, instant):
    from fem.render import picture

    nothing = np.zeros(13)
    still = replace(
        instant,
        inner_force=nothing,
        outer_force=nothing,
        inner_traction=nothing,
        outer_traction=nothing,
        inner_ring=0.0 * instant.inner_ring,
        outer_ring=0.0 * instant.outer_ring,
        rollers=0.0 * instant.rollers,
    )
    assert not _near(picture(still, width=400), (0xD7, 0x30, 0x1F)).any()


def test_the_command_writes_a_png_of_the_width_asked_for(can_draw, coarse_run, tmp_path, capsys):
    from PIL import Image

    target = tmp_path / "new folder" / "bearing.png"
    arguments = [
        str(coarse_run),
        "--time",
        "2",
        "--output",
        str(target),
        "--width",
        "400",
        "--magnification",
        "100",
    ]
    assert render_main(arguments) == 0
    assert str(target) in capsys.readouterr().out
    with Image.open(target) as picture:
        assert picture.format == "PNG" and picture.size == (400, 300)


def test_the_probe_leaves_a_machine_that_draws_alone(can_draw):
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


def test_the_command_on_a_machine_that_cannot_draw_exits_2_and_leaves_no_picture(
    monkeypatch, coarse_run, tmp_path, capsys
):
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: subprocess.CompletedProcess([], -11, "", ""))
    target = tmp_path / "bearing.png"
    assert render_main([str(coarse_run), "--output", str(target)]) == 2
    told = capsys.readouterr().err
    assert "apt-get install" in told and "Traceback" not in told
    assert not target.exists()


@pytest.mark.parametrize(
    "options, words",
    [
        (["--time", "99"], "0 to 4 ms"),
        (["--width", "10"], "--width 10"),
        (["--magnification", "-1"], "--magnification -1"),
        (["--magnification", "nan"], "--magnification nan"),
        (["--output", "."], "is a folder"),
    ],
)
def test_unusable_options_exit_2_in_a_sentence(coarse_run, capsys, options, words):
    assert render_main([str(coarse_run), *options]) == 2
    told = capsys.readouterr().err
    assert words in told and "Traceback" not in told
