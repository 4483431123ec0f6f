"""The report as a reader meets it, in a real browser without a network, on a desk and on a phone."""

import io
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from fem.commands.rate_bearing import rate_main
from lagrange.scene.scene import parse_scene
from residual.cli import main
from residual.measured.checks import Question, assumed, check_record, write_report
from tests.waiting import assert_readable, coloured_pixels, open_page

WIDTHS = (390, 1280)
BLOCKS = ["Bearing", "Loads", "Lives", "Stresses", "Stiffness", "Friction and film"]


@pytest.fixture(scope="module")
def report(coarse_run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    run = shutil.copy(coarse_run, folder / "run.nc")
    about = PngInfo()
    about.add_itxt("Source", "run.nc")
    about.add_itxt("Description", "A picture of the run.")
    Image.new("RGB", (800, 600), "#0072b2").save(folder / "run.png", pnginfo=about)
    assert main([str(run), "--quiet"]) == 0
    return folder / "run-residual" / "report.html"


@pytest.fixture
def page(browser, report, request):
    with open_page(browser, report.as_uri(), request.param, offline=True) as page:
        yield page


everywhere = pytest.mark.parametrize("page", WIDTHS, indirect=True)
on_a_desk = pytest.mark.parametrize("page", [1280], indirect=True)


@everywhere
def test_the_report_is_one_file_that_fetches_nothing_its_figures_are_seen_and_its_verdict_is_first(page, report):
    assert 100_000 < report.stat().st_size < 5_000_000
    page.wait_for_function("window.spectra !== undefined")
    outside = [url for url in page.asked if url != report.as_uri() and not url.startswith("data:")]
    assert outside == [] and page.complaints == []
    names = page.locator("figure").evaluate_all("all => all.map(figure => figure.id)")
    assert {"history", "picture", "orbit", "load_distribution", "passage", "energy", "budget", "spectra"} <= set(names)
    for image in page.locator("figure img").all():
        assert image.is_visible()
        box = image.bounding_box()
        assert box["width"] > 0.6 * min(page.viewport_size["width"], 750) and box["height"] > 80
        assert image.evaluate("image => image.complete && image.naturalWidth > 300")
    assert_readable(page, "p, li, td, th", 11.0)
    verdict = page.locator(".verdict")
    assert "The trajectories are sound" in verdict.inner_text() and "and at most" in verdict.inner_text()
    assert verdict.bounding_box()["y"] < 300
    leads = "all => all.map(a => document.querySelector(a.getAttribute('href')) !== null)"
    found = page.locator("nav a").evaluate_all(leads)
    assert len(found) >= 7 and all(found)


def _range(page):
    return page.evaluate("window.spectra.range()")


def _pressed(page, *names):
    for name in names:
        page.get_by_role("button", name=name).click()
    return _range(page)


@everywhere
def test_the_spectra_zoom_by_buttons_and_the_player_shows_where_it_is_told(page):
    low, high = _range(page)
    assert _pressed(page, "0-300 Hz")[1] <= 1001.0 and high > 40_000.0  # 4 ms: the fourth bin
    assert _pressed(page, "whole band") == pytest.approx([low, high])
    nearer = _pressed(page, "zoom in")
    assert low < nearer[0] < nearer[1] < high
    assert _pressed(page, "to higher frequencies")[0] > nearer[0] > _pressed(page, "log / linear", "zoom out")[0]
    box = page.locator("#player canvas").bounding_box()
    assert box["y"] < 700 and box["width"] > 0.85 * min(page.viewport_size["width"], 900) and box["height"] > 150
    first = page.locator("#player-state").inner_text()
    page.evaluate("window.player.show(1e9)")
    last = page.locator("#player-state").inner_text()
    assert first != last and "largest load" in last and last.startswith("4.00 ms")
    _pressed(page, "play")
    assert page.evaluate("window.player.playing()")
    page.wait_for_function("window.player.frame() > 2 && window.player.frame() < 20")
    _pressed(page, "pause")
    assert not page.evaluate("window.player.playing()")


@on_a_desk
def test_spectra_zoom_by_dragging_and_are_saved_curves_loads_and_paths_are_drawn_in_print_controls_are_gone(page):
    area = page.locator("#spectra .u-over")
    area.scroll_into_view_if_needed()
    box = area.bounding_box()
    whole = _range(page)
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 50)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 60, steps=5)
    page.mouse.up()
    part = _range(page)
    assert whole[0] < part[0] < part[1] < whole[1]
    area.dblclick()
    assert _range(page) == pytest.approx(whole)
    with page.expect_download() as saving:
        page.get_by_role("button", name="save as CSV").click()
    rows = Path(saving.value.path()).read_text(encoding="utf-8").splitlines()
    assert rows[0] == "frequency_Hz,psd_error_x,psd_error_y"
    values = [float(value) for value in rows[1].split(",")]
    assert len(values) == 3 and values[0] == pytest.approx(249.4, rel=0.01) and min(values) > 0.0
    page.locator("#spectra").scroll_into_view_if_needed()
    assert min(coloured_pixels(page, "#spectra canvas", "r < 40 && b > 150", "r > 190 && b < 60")) > 500
    bars, rollers = "r > 200 && g < 110 && b < 20", "r < 90 && b > 90 && b > r + 60"
    assert min(coloured_pixels(page, "#player canvas", bars, rollers)) > 300
    order = "player run loads-and-motion spectra vibration errors budget-of-errors appendix peaks"
    places = [page.locator(f"#{name}").bounding_box()["y"] for name in order.split()]
    assert places == sorted(places)
    page.emulate_media(media="print")
    assert not page.locator("nav").is_visible() and not page.get_by_role("button", name="zoom in").is_visible()
    styles = page.locator(".scroll").evaluate_all("all => all.map(e => getComputedStyle(e).overflowX)")
    assert set(styles) == {"visible"}


@everywhere
def test_a_comparison_fits_the_screen_too(page, coarse_run, tmp_path):
    out = tmp_path / "out"
    assert main([str(coarse_run), "--against", "palmgren", "--no-figures", "--output", str(out), "--quiet"]) == 0
    page.goto((out / "report.html").as_uri())
    table = page.locator("#against ~ .scroll").first
    assert table.is_visible() and "palmgren" in page.locator("#against").inner_text()
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


@on_a_desk
def test_in_the_dark_page_figures_and_canvases_are_dark_and_text_is_light(page):
    def brightness(name):  # mean of an element's pixels, 0 to 1, as it is seen
        return np.asarray(Image.open(io.BytesIO(page.locator(name).screenshot())).convert("L")).mean() / 255.0

    page.emulate_media(color_scheme="dark")
    for name in ("#orbit img", "#player canvas", "#spectra-plot", "#run + .scroll"):
        assert brightness(name) < 0.25, name
    assert brightness("#picture img") == pytest.approx(0.4, abs=0.1)  # a picture is as it is: #0072b2
    ink = page.evaluate("getComputedStyle(document.querySelector('.verdict')).color")
    assert min(int(part) for part in ink[4:-1].split(",")) > 200
    page.emulate_media(color_scheme="light")
    assert brightness("#orbit img") > 0.8


@pytest.fixture(scope="module")
def other_pages(tmp_path_factory):
    """Pages of a rating, and of a record beside a simulation whose assumed keys it lists."""
    folder = tmp_path_factory.mktemp("pages")
    assert rate_main([*"--bearing NU206 --set operation.radial_load_N=3000 --output".split(), str(folder / "a")]) == 0
    time = np.arange(20_000) / 20_000.0
    np.savez(folder / "record.npz", acc=np.sin(1e4 * time) * (1.0 + np.cos(1e3 * time)), rate=20_000.0)
    check = check_record(folder / "record.npz", None, Question(bearing="NU206", speed=1480.0))
    keys = tuple(assumed(parse_scene({"bearing": {"designation": "NU206"}, "spall": [{}]}, "")))
    write_report(check._replace(other=check.record, command="run-fem", assumed=keys), folder / "b", figures=False)
    return folder / "a" / "rating.html", folder / "b" / "vibration.html"


def test_on_a_phone_the_verdict_is_first_meanings_are_on_the_screen_and_no_word_is_broken(browser, other_pages):
    keys = []
    for path in other_pages:
        with open_page(browser, path.as_uri(), 390, offline=True) as page:
            assert page.locator(".verdict").bounding_box()["y"] < 200
            sizes = "all => all.map(e => [e.getBoundingClientRect().right, e.clientWidth, e.scrollWidth])"
            cells = page.locator(".words td").evaluate_all(sizes)
            assert len(cells) > 60 and all(right <= 390 and scroll <= client + 1 for right, client, scroll in cells)
            keys += page.locator(".keys td:first-child").evaluate_all("all => all.map(e => e.getClientRects().length)")
    assert set(keys) == {1}


def test_the_sheet_of_a_rating_prints_on_a4_black_on_white_with_all_its_inputs(browser, other_pages):
    with open_page(browser, other_pages[0].as_uri(), color_scheme="dark", offline=True) as page:
        page.emulate_media(media="print")
        look = "e => [getComputedStyle(e).color, getComputedStyle(e).breakInside]"
        assert page.locator("section").first.evaluate(look) == ["rgb(27, 31, 36)", "avoid"]
        assert page.locator("h2").all_inner_texts()[:6] == BLOCKS
        assert 'designation = "NU206"' in page.locator("pre").inner_text() and page.locator("pre").is_visible()
        printed = page.pdf(prefer_css_page_size=True)
        assert b"MediaBox [0 0 594.95" in printed or b"MediaBox [0 0 595" in printed
        assert 3 <= len(re.findall(rb"/Type /Page\b", printed)) <= 5
