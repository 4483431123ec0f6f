"""Pictures: what is drawn where, the scales, the probe."""

from dataclasses import replace

import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.errors import UsageError
from fem.pictures.bodies import ARCS, drawn_bearing
from fem.pictures.look import LARGEST_SHARE, Request, Scale, chosen_look, chosen_magnification, quantity
from fem.pictures.recover import StoredRun
from fem.pictures.stress_below import FIRST_ROLLER, INNER_RING

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

    return Renderer(run, Request(**{"width": WIDTH, **request}), [sample]).image(sample)


@pytest.fixture(scope="module")
def image(run):
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


def test_forces_on_the_rollers_carry_the_load(instant):
    from fem.pictures.bearing import contact_forces

    (inner_at, inner), (outer_at, outer), *_ = contact_forces(instant)
    operation = instant.operation
    expected = -operation.radial_load - operation.inner_mass * operation.gravity
    assert inner.sum(axis=0) == pytest.approx([0.0, expected], abs=0.02 * operation.radial_load)
    assert outer.sum(axis=0) == pytest.approx([0.0, -expected], abs=0.02 * operation.radial_load)
    assert np.all(np.sum(inner_at * inner, axis=1) <= 0.0)  # both push into the roller
    assert np.all(np.sum(outer_at * outer, axis=1) <= 0.0)


def test_an_arrow_ends_at_its_tip():
    from fem.pictures.canvas import arrow

    x, y = arrow((1.0, 2.0), (1.0, 2.5), 0.02, 0.0).points.T
    assert (y.min(), y.max()) == pytest.approx((2.0, 2.5))
    area = 0.5 * abs(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))
    assert area == pytest.approx(0.02 * (0.5 - 0.064) + 0.5 * 0.06 * 0.064)


# ---- scales


def test_scales_end_at_round_numbers_and_label_their_ends():
    linear = Scale(field="von-mises", largest=347e6, logarithmic=False)
    assert linear.end == 400.0 and (linear.norm.vmin, linear.norm.vmax) == (0.0, 400.0)
    assert linear.ticks()[-1] == 400.0 and linear.ticks()[0] == 0.0
    logarithmic = Scale(field="max-shear", largest=230e6, logarithmic=True)
    assert logarithmic.end == 250.0 and logarithmic.norm(0.5) == pytest.approx(0.0, abs=1e-9)
    assert logarithmic.ticks() == pytest.approx([0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0])


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
    assert 0.003 < share["ink"] < 0.1
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


def test_a_frame_drawn_after_another_is_the_picture_of_its_instant(run, image):
    from fem.pictures.render import Renderer

    renderer = Renderer(run, Request(width=WIDTH), [SAMPLE])
    other = renderer.image(SAMPLE - 100)
    assert np.array_equal(renderer.image(SAMPLE), image)
    assert not np.array_equal(other, image)


def test_an_unloaded_bearing_is_drawn_without_arrows(coarse_run, monkeypatch):
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
def test_every_field_is_drawn(run, image, field):
    other = _image(run, field=field)
    assert other.shape == image.shape and not np.array_equal(other, image)


def test_a_close_up_shows_the_shear_below_both_contacts(run):
    picture = _image(run, view="close-up")
    assert picture.shape == (480, WIDTH, 3)
    # the contacts' panels: brightest (viridis' yellow and green) on both sides of the contact, off the surface
    for top, bottom in ((48, 200), (274, 428)):
        panel = picture[top:bottom, 392:548].astype(int)
        middle = panel[:, 76:82].mean(axis=1)
        bright = middle[:, 1] > 150
        half = len(bright) // 2
        assert bright[half - 35 : half - 5].sum() > 5 and bright[half + 5 : half + 35].sum() > 5
