"""Short runs of the paper's bearing with rollers that tilt."""

import numpy as np

from fem.solver.simulate import make_plan
from lagrange.mounting import ENERGIES
from lagrange.scene.scene import Scene
from tests.reference.whole_run import whole_run


def scene(model, axial=(), **changes):
    """The paper's bearing for half a millisecond; `axial` : its table's keys, None: a plane section."""
    keys = {} if axial is None else {f"axial.{key}": value for key, value in {"slices": 11, **dict(axial)}.items()}
    fixed = {"model": model, "numerics.duration_ms": 0.5, "numerics.output_interval_us": 10.0}
    return Scene().varied(fixed | keys | {key.replace("__", "."): value for key, value in changes.items()})


def moved(found, said=None):
    """Columns of a run by name; `said` : a list that gets why it restarted."""
    return moved_by(make_plan(found), said)


def moved_by(plan, said):
    """The same of a plan."""
    return whole_run(plan, said=said).values


def missed(samples):
    """Largest energy error over the contacts' energy."""
    energy = sum(samples[f"energy_{kind}"] for kind in ("kinetic", "elastic", "contact"))
    energy = energy + sum(samples[name] for name in ENERGIES if name in samples)
    energy = energy - samples["work_external"] + samples["work_dissipated"]
    return np.abs(energy - energy[0]).max() / samples["energy_contact"].max()


def defects(half):
    """Tables of spalls of part of the length by its keys `half`, of one of all of it, of waves and a larger roller."""
    return {
        "spall": [
            {"body": "inner_ring", "angle_deg": -3.0, **half},
            {"body": "roller", "roller": 1, "angle_deg": 20.0, **half},
            {"body": "outer_ring", "angle_deg": 10.0, **half},
            {"body": "outer_ring", "angle_deg": 40.0, "width_mm": 0.3},
        ],
        "waviness": [{"order": 11}],
        "unequal_roller": [{"roller": 2}],
    }
