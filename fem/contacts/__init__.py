"""Contact models: how a mesh carries the contacts, and what is added that it can't see.

A scene's `contact.model` is chosen from MODELS; of two classes the first is for meshes finer than ONE_PATCH.

scene's name      class, module             the mesh carries a contact as       added to the mesh
subgrid           SubgridModel, subgrid     one patch of six nodes              a law Q(δ) below the grid, with ripples
subgrid, fine     SpreadModel, resolved     points, each spread over a patch    compliance the mesh lacks between points
resolved          ResolvedModel, resolved   points between two nodes            a stiff layer
penalty, faceted  PenaltyModel, resolved    one point between two nodes         nothing: the spring is the contact

Each is a `model.Model` and answers the same verbs:

build             mesh, bodies and laws of a bearing
reduced           what statics balance: points, their compliance, the bodies' fields under forces on them
springs           closed contacts in the critical step (`critical_step`)
kernel_data       what the time loop is given
carried, smeared, indentation, stress_note   what pictures must know of the nodes that carry a force
coarsest, has_law, is_made_for_a_force, give, failure_hint   limits, and what is said beyond them

A new model is a module with such a class, a line here, and its name in the scene's [contact].
`model` is what all models share, `points` what those of points do; `tilted` tabulates contacts of axes that tilt.
"""

MODELS = {  # a scene's name: modules and classes, imported when a scene takes them
    "subgrid": (("fem.contacts.resolved", "SpreadModel"), ("fem.contacts.subgrid", "SubgridModel")),
    "resolved": (("fem.contacts.resolved", "ResolvedModel"),),
    "penalty": (("fem.contacts.resolved", "PenaltyModel"),),
    "faceted": (("fem.contacts.resolved", "FacetedModel"),),
}
ONE_PATCH = 2.0  # least surface spacing over a contact's half-width at which one patch is far wider than the contact
