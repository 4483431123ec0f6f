"""Explicit elastic finite-element simulation of a roller bearing.

assembly, bodies      scikit-fem's matrices; a disc as rows of blocks, a ring as one sector's stencil
continuum, subgrid    exact compliances of discs and rings; the calibrated contact law below the grid
model                 a bearing made discrete
equilibrium, start    static equilibrium; the state a run starts from
critical_step         2/ω_max with the contacts in it
state, arrays         what the time loop works on, and how it is filled
patches, simd         B-spline patches; eight lanes as one value
*_kernels, time_loop  numba: bodies, contacts, leapfrog, samples
"""
