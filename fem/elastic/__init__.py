"""The elastic bodies, and the exact solutions that contacts between them are calibrated on and held against.

assembly, bodies, stress  scikit-fem's matrices; a disc as rows of blocks, a ring as one sector's stencil; stresses
continuum                 exact series of discs and rings; `tangential`: under tangential tractions, and spinning
vibration                 own vibrations of discs and rings
cache                     matrices and step limits kept on disk between starts
rigid, outer_support      bodies declared rigid; rings held at points, or in a bore
"""
