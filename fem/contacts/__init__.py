"""Contact models: how a mesh carries the contacts, and what is added that it can't see.

A scene's `contact.model` is chosen from MODELS: the first of its classes whose mesh is fine enough, or else the last.

scene's name      class, module             the mesh carries a contact as       added to the mesh
subgrid           SubgridModel, subgrid     one patch of six nodes              a law Q(δ) below the grid, with ripples
subgrid, fine     SpreadModel, spread       points, each spread over a patch    compliance the mesh lacks between points
resolved          ResolvedModel, resolved   points between two nodes            a stiff layer
penalty, faceted  PenaltyModel, springs     one point between two nodes         nothing: the spring is the contact

Each is a `model.Model` and answers the same verbs:

build             mesh, bodies and laws of a bearing
reduced           what statics balance: points, their compliance, the bodies' fields under forces on them
springs           closed contacts in the critical step (`critical_step`)
kernel_data       what the time loop is given
carried, smeared, indentation, stress_note   what pictures must know of the nodes that carry a force
coarsest, is_made_for_a_force, is_sized_by_forces, give, failure_hint   limits, and what is said beyond them

A new model is a module with such a class, a line here, and its name in the scene's [contact].
`points` is what models of pressure points share; `patch` which nodes carry a force; `contact_law`, `reduction` data.
"""

from fem.contacts.model import Model
from fem.contacts.resolved import ResolvedModel
from fem.contacts.spread import SpreadModel
from fem.contacts.springs import FacetedModel, PenaltyModel
from fem.contacts.subgrid import SubgridModel

MODELS: dict[str, tuple[type[Model], ...]] = {
    "subgrid": (SpreadModel, SubgridModel),
    "resolved": (ResolvedModel,),
    "penalty": (PenaltyModel,),
    "faceted": (FacetedModel,),
}

__all__ = ["MODELS", "FacetedModel", "Model", "PenaltyModel", "ResolvedModel", "SpreadModel", "SubgridModel"]
