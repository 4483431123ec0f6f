"""The scene file's [damping]: what takes energy out of contacts and bodies beside friction."""

from collections.abc import Iterator
from typing import Any

from pydantic import Field

from lagrange.contact_damping import ContactDamping
from lagrange.scene_faults import Check, Table

CONTACT_LAWS = ("contact_N_s_m", "contact_time_us", "hunt_crossley_s_m")
FORMER = "damping_N_s_m"  # of [lagrange], before all models had dampers: scenes of older results have it


class DampingTable(Table):
    """What takes energy beside friction. Of the contacts' three laws one may be given; none makes a contact pull."""

    contact_N_s_m: float = Field(0.0, ge=0.0, le=1e6, description="of every closed contact")
    contact_time_us: float = Field(0.0, ge=0.0, le=1000.0, description="or a time, times the contact's own stiffness")
    hunt_crossley_s_m: float = Field(
        0.0,
        ge=0.0,
        le=1000.0,
        description="or Hunt and Crossley's α: force times 1 + 3/2 α times the approach's rate",
    )
    bodies_1_s: float = Field(
        0.0, ge=0.0, le=1e6, description="mass proportional, of what bodies do beside moving and turning as a whole"
    )

    def checks(self) -> tuple[Check, ...]:
        return (self._one_law,)

    def _one_law(self) -> Iterator[str]:
        given = [f"{name} = {getattr(self, name):g}" for name in CONTACT_LAWS if getattr(self, name) > 0.0]
        if len(given) > 1:
            yield f"{' and '.join(given)}: contacts are damped by one law; leave all but one out"

    @property
    def acts(self) -> bool:
        return self != DampingTable()

    @property
    def words(self) -> str:
        """What damps, for captions."""
        contacts = f"contact damping {self.contacts.words}" if self.contacts.acts else "no contact damping"
        return contacts if self.bodies_1_s == 0.0 else f"{contacts}, bodies damped by {self.bodies_1_s:.4g} 1/s"

    @property
    def contacts(self) -> ContactDamping:
        """The law of the contacts, SI."""
        return ContactDamping(
            constant=self.contact_N_s_m, time=1e-6 * self.contact_time_us, hunt_crossley=self.hunt_crossley_s_m
        )


def with_former_name(data: dict[str, Any]) -> dict[str, Any]:
    """A scene's tables with `lagrange.damping_N_s_m` where it now stands; not where that says something already."""
    options, damping = data.get("lagrange"), data.get("damping", {})
    if not (isinstance(options, dict) and FORMER in options and isinstance(damping, dict)):
        return data
    if any(name in damping for name in CONTACT_LAWS):
        return data  # an unknown key: nobody has to guess which of the two is meant
    found = options[FORMER]
    moved = {} if found == 0.0 else {"damping": {"contact_N_s_m": found} | damping}
    return data | {"lagrange": {name: value for name, value in options.items() if name != FORMER}} | moved
