"""Contact laws ranked by the error force that each leaves, on samples that no law was fitted to."""

from dataclasses import dataclass

import numpy as np

from lagrange.contact.raceway_laws import contact_laws, law_names
from lagrange.equations import contact_resultant
from residual.budget import Budget
from residual.errors import InputError
from residual.fitted_laws import DampedLaw, Law, law_force
from residual.identification import Extra, Identification, fit_law
from residual.record import Record
from residual.spectrum import Statistics, rms

# name: what is fitted beside K and n
FITTED: dict[str, tuple[Extra, ...]] = {
    "fitted": (),
    "fitted_coupled": ("coupling",),
    "fitted_damped": ("damping",),
    "fitted_coupled_damped": ("coupling", "damping"),
}
ALIASES = ("tripp",)


@dataclass(frozen=True, kw_only=True)
class LawScore:
    """Error forces that one law leaves."""

    name: str
    errors: tuple[Statistics, Statistics]  # in x and y
    contact_rms: float | None  # N, of run − law per closed contact; None where the source holds no forces

    @property
    def rms(self) -> float:
        """Rms of the error force's magnitude, N: the ranking's measure."""
        return float(np.hypot(self.errors[0].rms, self.errors[1].rms))


def inner_law(name: str, record: Record) -> Law:
    """Named law of the inner contact, with the scene's damping of contacts."""
    law = contact_laws(name, record.bearing).inner
    damping = record.scene.damping.contacts
    return DampedLaw(spring=law, damping=damping) if damping.acts else law


def identify(record: Record, approach, closing_speed, bridge: int, name: str) -> Identification:
    """Fit the law `name`, a key of FITTED, to a run's own forces over the approach, m, and its rate, m/s.

    Errors
    ------
    InputError: the source holds no forces, or they fix no law.
    """
    if record.inner_force is None:
        raise InputError(
            f"{record.source}: the law {name} is fitted to the run's own contact forces, which this source does "
            "not tell; choose a named law"
        )
    try:
        return fit_law(approach, record.inner_force, bridge, FITTED[name], closing_speed)
    except InputError as error:
        raise InputError(f"{record.source}: {error}") from None


def rank_laws(record: Record, budget: Budget, identified: dict[str, Identification]) -> list[LawScore]:
    """Rank all laws by the error force on the held-back samples (all samples where nothing was fitted), smallest first.

    Parameters
    ----------
    identified : fitted laws by name
    """
    laws = {name: inner_law(name, record) for name in law_names(record.bearing)}
    laws |= {name: found.law for name, found in identified.items()}
    first = max((found.samples for found in identified.values()), default=0)
    late = slice(first, None)
    directions = (budget.x, budget.y)
    resultant = contact_resultant(budget.contacts, budget.law_force)
    inertia_and_load = [direction.error + push for direction, push in zip(directions, resultant, strict=True)]
    run_force = None if record.inner_force is None else record.inner_force[late]
    scores = []
    for name, law in laws.items():
        contacts = budget.contacts
        force = law_force(law, contacts.inner, budget.closing_speed, contacts.inner_compliance)
        pushes = contact_resultant(budget.contacts, force)
        contact_rms = None
        if run_force is not None and np.any(run_force > 0.0):
            contact_rms = rms((run_force - force[late])[run_force > 0.0])
        error_x, error_y = (Statistics.of((i - p)[late]) for i, p in zip(inertia_and_load, pushes, strict=True))
        scores.append(LawScore(name=name, errors=(error_x, error_y), contact_rms=contact_rms))
    return sorted(scores, key=lambda score: score.rms)
