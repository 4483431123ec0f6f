"""What the live page takes: `python -m benchmarks.live`.

Processor time of the player for a second of the page in real time, and of a frame; then frames a second and the pace
reached in a headless browser that draws without a graphics card, on this machine as busy as it is. Makes docs/live.png
and docs/live_ratings.png.
"""

import asyncio
import json
import shutil
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from queue import Queue
from threading import Thread

from benchmarks import timed
from fem.live.player import Player
from fem.live.server import FRAME, LiveServer
from lagrange.scene.scene import read_scene
from tests.measurements import markdown_table

SCENES = {
    "paper": (), "clearance 40 µm": ("bearing.outer_raceway_diameter_mm=56.04",), "spall 1 mm": ("spall.0.width_mm=1",),
}  # fmt: skip
PACES = (1.0, 10.0, 50.0)
RATED = {"designation": "6206", "rated-axial_load_N-typed": "1000", "rated-viscosity_mm2_s-typed": "20"}  # of a picture
TURNS = 9
WARM, LOOK = 2.0, 4.0  # s


def player_of(settings: tuple[str, ...]) -> Player:
    return Player(read_scene(None, ("model=reduced", *settings)))


def costs(player: Player) -> list[str]:
    """Seconds of work in a second of the page in real time, and ms and kilobytes of a frame."""
    count = round(FRAME / player.plan.interval)
    work, frames = [], []
    for _ in range(TURNS):
        work.append(timed(player.advance, count)[0])
        seconds, frame = timed(player.frame)
        frames.append(seconds)
    return [f"{min(work) / FRAME:.2f}", f"{1e3 * min(frames):.1f}", f"{1e-3 * len(json.dumps(frame)):.0f}"]


@contextmanager
def page_of(browser, player: Player):
    """The page of a player that is served meanwhile."""
    server, addresses = LiveServer(player), Queue()
    thread = Thread(target=lambda: asyncio.run(server.run(addresses.put)))
    thread.start()
    try:
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        page.goto(addresses.get())
        page.wait_for_function("() => window.live && window.live.frames > 0")
        yield page
        page.close()
    finally:
        server.end()
        thread.join()


def watched(browser, player: Player, slowness: float) -> list[str]:
    """Frames a second that a page draws, and the slow motion reached."""
    with page_of(browser, player) as page:
        page.evaluate("pace => window.live.send({ pace: { slowness: pace, playing: true } })", slowness)
        time.sleep(WARM)
        look = "[window.live.frames, window.live.frame().time, performance.now()]"
        first = page.evaluate(look)
        time.sleep(LOOK)
        last = page.evaluate(look)
    frames, simulated, wall = (b - a for a, b in zip(first, last, strict=True))
    return [f"{1e3 * frames / wall:.1f}", f"1/{wall / simulated:.3g}"]


def main() -> None:
    rows = [[name, *costs(player_of(settings))] for name, settings in SCENES.items()]
    headings = ("scene", "work a second in real time, s", "a frame, ms", "kB")
    print("Processor time of the player", markdown_table(headings, rows), sep="\n\n")
    path = shutil.which("chromium") or shutil.which("google-chrome")
    if path is None:
        sys.exit("no browser here: apt-get install chromium")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        with page_of(browser, player_of(())) as page:  # the paper's bearing, on a desk
            page.wait_for_function("() => window.live.frame() && window.live.frame().record > 300")
            page.screenshot(path=Path(__file__).parents[1] / "docs" / "live.png", full_page=True)
            page.get_by_role("tab", name="Ratings").click()
            for field, value in RATED.items():
                page.locator(f"#{field}").fill(value)
                page.locator(f"#{field}").press("Tab")
            page.wait_for_function("() => ratings.found() && ratings.found().values.viscosity_mm2_s === 20")
            page.evaluate("window.scrollTo(0, 0)")
            page.screenshot(path=Path(__file__).parents[1] / "docs" / "live_ratings.png", full_page=True)
        rows = [
            [name, f"1/{slowness:g}", *watched(browser, player_of(settings), slowness)]
            for name, settings in SCENES.items()
            for slowness in PACES
        ]
        browser.close()
    headings = ("scene", "asked for", "frames a second", "reached")
    print("In a browser", markdown_table(headings, rows), sep="\n\n")


if __name__ == "__main__":
    main()
