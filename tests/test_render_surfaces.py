"""Surfaces that are not perfect in pictures: where holes are cut, what charts show."""

from math import asin

import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.pictures.bodies import drawn_bearing
from fem.pictures.look import Request
from fem.pictures.recover import StoredRun
from fem.pictures.surfaces import Drawing, chart_factor, charts, holes, unequal_rollers

ORANGE = (0xFF, 0x99, 0x00)
SETTINGS = (
    "spall.0.angle_deg=90", "spall.0.depth_um=10", 'spall.1.body="inner_ring"', "spall.1.angle_deg=180",
    "spall.1.width_mm=2", 'spall.2.body="roller"', "spall.2.roller=3", "waviness.0.amplitude_um=2",
    "waviness.0.order=7", "unequal_roller.0.roller=5", "unequal_roller.0.diameter_deviation_um=-3",
)  # fmt: skip


def drawing(instant, drawn, magnification):
    return Drawing(instant=instant, drawn=drawn, magnification=magnification)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """At rest: no time loop is compiled."""
    path = tmp_path_factory.mktemp("faults") / "run.nc"
    words = [word for each in SETTINGS for word in ("--set", each)]
    options = ["--model", "lagrange", "--mesh-size", "2", "--duration", "0", "--quiet", "--output", str(path)]
    assert run_main([*options, *words]) == 0
    return StoredRun(path)


@pytest.fixture(scope="module")
def instant(run):
    return run.instant(0)


@pytest.fixture(scope="module")
def drawn(instant):
    return drawn_bearing(instant)


def test_holes_lie_where_spalls_are_and_are_as_deep(instant, drawn):
    """At their own scale: flat bottoms of 10 and 100 µm; as reached: the bottom, or 128.8 µm between two edges."""
    true = holes(drawing(instant, drawn, 1.0), 0.0, as_reached=False)
    reached = holes(drawing(instant, drawn, 1.0), 0.0, as_reached=True)
    hub = drawn.hub
    roller = drawn.roller_reference[3] + drawn.roller_shift[3]
    for k, centre, radius, direction, depths in (
        (0, (0.0, 0.0), 28e-3, 0.0, (10e-6, 10e-6)),
        (1, hub, 18e-3, 0.5 * np.pi, (-100e-6, -100e-6)),
        (2, roller, 5e-3, 0.0, (-100e-6, -20.6e-6)),
    ):
        for found, depth in zip((true[k], reached[k]), depths, strict=True):
            out = found.edge - centre
            middle = out[len(out) // 2]
            assert np.arctan2(*middle[::-1]) == pytest.approx(direction, abs=1e-9)
            assert np.hypot(*middle) - radius == pytest.approx(depth, rel=0.02)
            half = np.degrees(np.arctan2(*out[-1][::-1]) - direction)
            width = (1e-3, 2e-3, 1e-3)[k]
            assert half == pytest.approx(np.degrees(asin(0.5 * width * np.sqrt(1.02) / radius)), rel=1e-6)
    assert [hole.name for hole in true] == ["spall 1 mm", "spall 2 mm", "spall 1 mm"]


def test_rounded_edges_are_round_in_a_close_up(instant, drawn):
    """Of radius 0.1 mm, 10 µm deep: half a µm below the circle 10 µm from where it leaves it, x²/(2e)."""
    hole = holes(drawing(instant, drawn, 1.0), 0.0, as_reached=False)[0]
    depth, along = np.hypot(*hole.edge.T) - 28e-3, hole.edge[:, 1]
    opening = 0.5e-3 * np.sqrt(1.02)
    for x in (10e-6, 30e-6):
        assert np.interp(opening - x, along, depth) == pytest.approx(x**2 / 0.2e-3, rel=0.1, abs=0.1e-6)


def test_a_hole_is_never_drawn_deeper_than_its_body_bears_and_says_by_what_factor(instant, drawn):
    found = holes(drawing(instant, drawn, 1e4), 0.0, as_reached=True)
    depth = np.hypot(*found[0].edge.T) - np.hypot(*found[0].edge[0])
    assert depth.max() <= 1.5e-3 and found[0].name == "spall 1 mm, × 100"


def test_where_a_roller_has_sunk_in_it_is_not_cut_away(instant, drawn):
    """The spall's upper line is the roller's surface there, at any magnification."""
    for magnification in (1.0, 200.0):
        for hole in holes(drawing(instant, drawn, magnification), 1e-6, as_reached=True)[:1]:
            centres = drawn.roller_reference + magnification * drawn.roller_shift
            nearest = np.hypot(*(hole.top[:, None] - centres).transpose(2, 0, 1)).min(axis=1)
            assert nearest.min() > 5e-3 - 1e-9


def test_charts_magnify_heights_around_their_circles(instant, drawn):
    (chart,) = charts(drawing(instant, drawn, 100.0))
    factor = chart_factor(instant.model.bearing)
    centre = 100.0 * drawn.hub
    height = np.hypot(*(chart.curve - centre).T) - np.hypot(*(chart.circle - centre).T)
    assert np.abs(height).max() == pytest.approx(factor * 2e-6, rel=1e-3)
    assert 0.1 < factor * 2e-6 / 5.5e-3 <= 0.22
    crests = np.count_nonzero((height[:-1] > 0) & (height[1:] <= 0))
    assert crests == 7 and chart.name == "order 7, 2 µm"


def test_an_unequal_roller_is_named(instant, drawn):
    ((circle, name),) = unequal_rollers(drawing(instant, drawn, 1.0))
    assert (circle.roller, name) == (5, "Ø −3 µm")


@pytest.mark.parametrize("view", ["close-up", pytest.param("bearing", marks=pytest.mark.slow)])
def test_faults_are_seen(can_draw, run, view):
    from fem.pictures.render import Renderer

    with Renderer(run, Request(view=view, width=640, roller=3), [0]) as renderer:
        image = renderer.image(0)
    assert np.count_nonzero(np.abs(image.astype(int) - ORANGE).max(axis=-1) < 40) > (200 if view == "bearing" else 3)
