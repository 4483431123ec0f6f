"""The elastic bodies, the contacts between them, and the exact solutions both are calibrated on and held against.

assembly, bodies, stress  scikit-fem's matrices; a disc as rows of blocks, a ring as one sector's stencil; stresses
continuum                 exact series of discs and rings
quadratic                 the same bodies on quadratic elements that resolve the contacts
subgrid, spread           laws below the grid: of one patch, of points
resolved                  laws of contacts that the mesh resolves, and of penalty springs
points                    where pressure points are and which nodes they push
kept                      matrices and step limits kept on disk between starts
rigid                     bodies declared rigid
model                     the whole bearing
critical_step             2/ω_max with the contacts in it
"""
