"""The elastic bodies, and the exact solutions that contacts between them are calibrated on and held against.

`bodies` have matrices and stresses; `continuum` has the exact series of discs and rings,
`vibration` their own vibrations, `outer_support` rings held at points or in a bore; `cache` keeps matrices on disk.
"""
