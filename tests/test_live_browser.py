"""The live page as a student meets it, in a real browser, on a desk and on a phone."""

import re

import pytest

from lagrange.scene.scene import read_scene
from tests.reference.live_server import command_served
from tests.waiting import GIVE_UP

WIDTHS = (390, 1280)


@pytest.fixture(scope="module")
def live():
    with command_served() as address:
        yield address


@pytest.fixture(scope="module")
def page(browser, live, request):
    """The page of a width; what it asked for and complained of is kept. Tests leave it as they found it."""
    context = browser.new_context(viewport={"width": request.param, "height": 800})
    context.set_default_timeout(1e3 * GIVE_UP)
    page = context.new_page()
    page.asked, page.complaints = [], []
    page.on("request", lambda asked: page.asked.append(asked.url))
    page.on("console", lambda message: page.complaints.append(message.text))
    page.on("pageerror", lambda error: page.complaints.append(str(error)))
    page.goto(live)
    wait_for_frames(page)
    yield page
    assert page.complaints == []
    context.close()


everywhere = pytest.mark.parametrize("page", WIDTHS, indirect=True)
on_a_desk = pytest.mark.parametrize("page", [1280], indirect=True)


def wait_for_frames(page, count: int = 3) -> None:
    seen = page.evaluate("() => window.live ? window.live.frames : 0")
    page.wait_for_function("least => window.live && window.live.frames >= least", arg=seen + count)


def type_value(page, key: str, value: str) -> None:
    page.locator(f"#{key}-typed").fill(value)
    page.locator(f"#{key}-typed").press("Tab")


def wait_for_value(page, key: str, value: float) -> None:
    page.wait_for_function("([key, value]) => window.live.bearing().values[key] === value", arg=[key, value])


def coloured(page, canvas: str) -> int:
    """Pixels of a canvas that are orange or brown, as loads are."""
    return page.locator(canvas).evaluate(
        """canvas => { const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
        let found = 0;
        for (let i = 0; i < pixels.length; i += 4)
          if (pixels[i] > 120 && pixels[i] > 1.4 * pixels[i + 2] && pixels[i + 3] > 100) found++;
        return found; }"""
    )


@everywhere
def test_all_is_drawn_and_read_and_nothing_comes_from_elsewhere(page, live):
    assert [url for url in page.asked if not url.startswith(("data:", "blob:"))] == [live]
    wide, screen = page.evaluate("[document.documentElement.scrollWidth, innerWidth]")
    assert wide <= screen
    sizes = page.locator("p, label, dt, dd, button, small, figcaption").evaluate_all(
        "all => all.map(e => parseFloat(getComputedStyle(e).fontSize))"
    )
    assert min(sizes) > 12.0
    assert coloured(page, "#bearing") > 2000 and coloured(page, "#zone canvas") > 50
    for name in ("bearing", "zone .plot", "orbit .plot", "spectrum .plot", "envelope .plot"):
        box = page.locator(f"#{name}").bounding_box()
        assert box["width"] > 250 and box["height"] > 150
    page.wait_for_function("() => document.querySelector('#record').textContent.includes('Hz')")
    assert page.locator("#factor").inner_text().startswith("1/")
    assert page.locator("#loaded").inner_text().endswith("of 13")
    assert page.locator("#cautions").is_hidden() and page.locator("#refused").is_hidden()


@on_a_desk
def test_sliders_and_boxes_change_the_bearing(page):
    page.locator("#speed_rpm").fill("3000")
    wait_for_value(page, "speed_rpm", 3000)
    assert page.locator("#speed_rpm-typed").input_value() == "3000"
    type_value(page, "clearance_um", "12.5")
    wait_for_value(page, "clearance_um", 12.5)
    with page.expect_download() as saved:
        page.get_by_text("Save this scene").click()
    scene = read_scene(saved.value.path())
    assert scene.operation.speed_rpm == 3000.0 and scene.bearing.outer_raceway_diameter_mm == 56.0125
    assert scene.model == "reduced" and scene.numerics.duration_ms == 60.0
    page.get_by_role("button", name="Reset").click()
    wait_for_value(page, "speed_rpm", 4500)
    assert page.evaluate("window.live.bearing().values.clearance_um") == 0


@on_a_desk
def test_a_value_that_is_refused_is_explained_and_the_bearing_goes_on(page):
    type_value(page, "radial_load_N", "-5")
    refused = page.locator("#refused")
    refused.wait_for()
    assert "operation.radial_load_N = -5.0: must be greater than or equal to 0" in refused.inner_text()
    assert page.locator("#radial_load_N-typed").input_value() == "2000"
    wait_for_frames(page)
    type_value(page, "radial_load_N", "2500")
    wait_for_value(page, "radial_load_N", 2500)
    refused.wait_for(state="hidden")
    page.get_by_role("button", name="Reset").click()
    wait_for_value(page, "radial_load_N", 2000)


@on_a_desk
def test_a_spall_is_drawn_and_its_shocks_are_warned_of(page):
    type_value(page, "outer_ring_spall_mm", "0.8")
    wait_for_value(page, "outer_ring_spall_mm", 0.8)
    page.locator("#cautions").wait_for()
    page.wait_for_function("() => document.querySelector('#cautions').textContent.includes('elastic waves')")
    page.get_by_role("button", name="Reset").click()
    wait_for_value(page, "outer_ring_spall_mm", 0)
    page.locator("#cautions").wait_for(state="hidden")


@on_a_desk
def test_it_can_be_paused_slowed_down_and_taken_step_by_step(page):
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("button", name="Play").wait_for()
    page.locator("#slowness").fill("6")
    page.wait_for_function("() => document.querySelector('#factor').textContent === '1/100'")
    assert page.locator("#pace").inner_text().endswith("a twentieth of a second at 1/100.")
    page.get_by_role("button", name="Reset").click()
    page.wait_for_function("() => window.live.frame().time === 0")  # a paused run shows where it stands
    for wanted in (0.5, 1.0):  # ms
        page.get_by_role("button", name="Step").click()
        page.wait_for_function("wanted => window.live.frame().time > wanted - 0.1", arg=wanted)
        assert page.evaluate("window.live.frame().time") == pytest.approx(wanted)
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("() => window.live.frame().time > 2")
    assert page.locator("#pace").inner_text().startswith("One second here is")
    page.locator("#slowness").fill("5")


@on_a_desk
def test_numbers_of_an_axis_differ_however_small_its_steps(page):
    """An envelope of thousandths of g had the ticks 0, 0, 0."""
    shown = page.evaluate(
        "[[0, 2e-4, 4e-4], [-2.5, 0, 2.5], [0, 500, 1000]].map(v => charts.plain(null, v, 0, 0, v[1] - v[0]))"
    )
    assert shown == [["0.0000", "0.0002", "0.0004"], ["−2.5", "0.0", "2.5"], ["0", "500", "1000"]]


def test_the_bearing_stays_in_view_beside_many_controls_and_is_dark_where_all_is(browser):
    """Of a housing and spalls of all three bodies; on a phone it stays while the controls are moved."""
    spalls = ("spall.0.width_mm=0.5", "spall.1.body=inner_ring", "spall.2.body=roller", "spall.2.roller=1")
    with command_served(
        "--set", "support.kind=housing", *(part for key in spalls for part in ("--set", key))
    ) as address:
        for width, controls_at in ((1280, "0"), (390, "document.querySelector('#mass_kg').offsetTop - 500")):
            page = browser.new_page(viewport={"width": width, "height": 800}, color_scheme="dark")
            page.set_default_timeout(1e3 * GIVE_UP)
            page.goto(address)
            wait_for_frames(page)
            page.evaluate(f"window.scrollTo(0, {controls_at})")
            box = page.locator("#bearing").bounding_box()
            assert box["y"] >= -1.0 and box["y"] + box["height"] <= 800.0
            assert coloured(page, "#bearing") > 500
            colours = "[document.body, document.querySelector('.card')].map(e => getComputedStyle(e).backgroundColor)"
            light = [[int(part) for part in re.findall(r"\d+", colour)] for colour in page.evaluate(colours)]
            assert max(max(colour) for colour in light) < 60
            assert page.evaluate("live.bearing().spalls.map(spall => spall.body)") == [
                "outer_ring",
                "inner_ring",
                "roller",
            ]
            page.close()


@pytest.mark.slow  # another server and page
def test_the_page_says_when_the_program_has_ended(browser):
    with command_served() as address:
        page = browser.new_page()
        page.set_default_timeout(1e3 * GIVE_UP)
        page.goto(address)
        wait_for_frames(page, 1)
    page.locator("#ended").wait_for()
    assert "The program or the connection has ended" in page.locator("#ended").inner_text()
    page.close()
