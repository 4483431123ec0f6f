"""`python -m tests.paper [FOLDER] [--write]`: runs are kept in FOLDER (default runs/paper-variants) and used again."""

import sys
from pathlib import Path

from tests.measurements import DOCS
from tests.paper.figures import draw_records, draw_variants
from tests.paper.page import NEAREST, SIDEWAYS, publish_tables
from tests.paper.variants import COARSE, OUTSIDE_MM, SUPPORTED, SUPPORTS, VARIANTS, held, measure, record_of

if __name__ == "__main__":
    write = "--write" in sys.argv
    folder = Path(next((word for word in sys.argv[1:] if word != "--write"), "runs/paper-variants"))
    folder.mkdir(parents=True, exist_ok=True)
    runs, measured = {}, []
    for variant in VARIANTS:
        runs[variant.name] = record_of(variant, folder)
        measured.append((variant, measure(runs[variant.name])))
        print(variant.title, measured[-1][1], flush=True)
    fine = {variant.name: (variant.title, found) for variant, found in measured}
    pairs = [(*fine[name], measure(runs[name], COARSE)) for name in ("ours", NEAREST, SIDEWAYS)]
    supported = [(variant, measure(record_of(variant, folder))) for variant in SUPPORTED]
    drawn = [runs[name] for name in ("ours", NEAREST, SIDEWAYS)]
    draw_records(DOCS / "paper.png", *drawn, (fine[NEAREST][0], fine[SIDEWAYS][0]))
    draw_variants(DOCS / "paper-variants.png", measured)
    cases = [held(outside, name) for outside in OUTSIDE_MM for name in SUPPORTS]
    publish_tables(measured, cases, pairs, supported, write=write)
