"""How long a child may take, by its own processor time, which a busy machine does not stretch; a page in a browser.

A limit of wall time says little on a machine with more work than cores; one far beyond any sensible wait is left
against a child that sleeps for ever.
"""

import math
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

ASLEEP = 30.0  # s of wall time for each s of processor time that is allowed
GIVE_UP = 600.0  # s of wall time for a child of which no processor time is limited


def limit_processor_time(seconds: float) -> None:
    """Let this process die of SIGXCPU (no core) after so much more processor time."""
    import resource  # of POSIX alone, as are those who call this

    used = resource.getrusage(resource.RUSAGE_SELF)
    most, hard = math.ceil(used.ru_utime + used.ru_stime + seconds), resource.getrlimit(resource.RLIMIT_CPU)[1]
    resource.setrlimit(resource.RLIMIT_CPU, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))


def give_up(*_) -> None:
    raise TimeoutError(f"nothing has happened for {GIVE_UP:.0f} s")


def wait_until(condition: Callable[[], object], process: subprocess.Popen | None = None, pause: float = 0.01) -> None:
    """Wait for a condition, or for the process that is to bring it about to end; TimeoutError: neither in GIVE_UP."""
    until = time.monotonic() + GIVE_UP
    while not condition() and (process is None or process.poll() is None):
        if time.monotonic() > until:
            give_up()
        time.sleep(pause)


@contextmanager
def no_endless_wait() -> Iterator[None]:
    """Raise TimeoutError in this thread where what is done here, such as the opening of a pipe, does not end."""
    before = signal.signal(signal.SIGALRM, give_up)
    signal.setitimer(signal.ITIMER_REAL, GIVE_UP)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


@contextmanager
def open_page(browser, address: str, width: int = 1280, **context) -> Iterator:
    """A page of some width, in a context of its own; what it asks for and complains of is kept."""
    context = browser.new_context(viewport={"width": width, "height": 800}, **context)
    context.set_default_timeout(1e3 * GIVE_UP)
    page = context.new_page()
    page.asked, page.complaints = [], []
    page.on("request", lambda asked: page.asked.append(asked.url))
    page.on("console", lambda message: page.complaints.append(message.text))
    page.on("pageerror", lambda error: page.complaints.append(str(error)))
    page.goto(address)
    yield page
    context.close()


def assert_readable(page, texts: str, least: float) -> None:
    """The page is no wider than its screen, and texts of these elements are larger than so many pixels."""
    wide, screen = page.evaluate("[document.documentElement.scrollWidth, innerWidth]")
    assert wide <= screen
    sizes = page.locator(texts).evaluate_all("all => all.map(e => parseFloat(getComputedStyle(e).fontSize))")
    assert min(sizes) > least


def coloured_pixels(page, canvas: str, *colours: str) -> list[int]:
    """Pixels of a canvas that have each of some colours, given as JavaScript of r, g, b."""
    tests = ", ".join(f"(r, g, b) => {colour}" for colour in colours)
    return page.locator(canvas).evaluate(
        f"""c => {{ const p = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
        return [{tests}].map(is => {{ let n = 0;
          for (let i = 0; i < p.length; i += 4) if (p[i + 3] > 100 && is(p[i], p[i + 1], p[i + 2])) n++;
          return n; }}); }}"""
    )
