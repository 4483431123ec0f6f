"""Which elements give the least work per error in an explicit step? `python -m benchmarks.elements`, minutes.

grids            meshes of a disc and a ring by the spacing of their surface nodes
discretisations  elements, stiffness, lumped masses
candidates       which element on which mesh
bodies           the paper's roller and rings, their exact values
measure          cost and errors of one candidate
compare          cost at equal error; tables and plot
page             docs/elements.md
"""
