"""`python -m tests.paper [FOLDER]`: runs are kept in FOLDER (default runs/paper-variants) and used again."""

import sys
from pathlib import Path

from tests.pages import DOCS
from tests.paper.figures import draw_records, draw_variants
from tests.paper.page import NEAREST, SIDEWAYS, page
from tests.paper.supports import held_cases
from tests.paper.variants import COARSE, SUPPORTED, VARIANTS, measure, record_of

if __name__ == "__main__":
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/paper-variants")
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
    (DOCS / "paper.md").write_text(page(measured, held_cases(), pairs, supported), encoding="utf-8")
