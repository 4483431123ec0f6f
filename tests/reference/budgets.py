"""What a run's forces and energies add up to."""

import numpy as np

ROUND_OFF = 1e-9 * 2000.0  # N


def budget_terms(found) -> list[dict[str, np.ndarray]]:
    """Terms of the hub's two equations, which add up to their errors."""
    for direction in found.directions:
        terms = direction.budget.terms.values()
        np.testing.assert_allclose(sum(terms), direction.budget.error, rtol=0.0, atol=ROUND_OFF)
    return [direction.budget.terms for direction in found.directions]


def energy_left(result) -> np.ndarray:
    """What the energies and works of a run leave, J; constant where they balance."""
    energies = result.energies
    left = sum(energies[name] for name in energies if name.startswith("energy_"))
    return left - energies["work_external"] + energies["work_dissipated"]


def balance_of(result) -> float:
    """The same, its largest change over what is exchanged and dissipated."""
    left, energies = energy_left(result), result.energies
    passed = np.ptp(energies["energy_kinetic"]) + energies["work_dissipated"][-1]
    return np.abs(left - left[0]).max() / passed
