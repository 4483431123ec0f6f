"""What runs in the time loop: numba over plain arrays.

state                           the arrays, as named tuples
time_loop                       leapfrog steps
disc_kernels, ring_kernels      forces and motion of rollers and rings
team_kernels                    these two shared out among threads
contact_kernels, patch_kernels  normal forces; what a contact reads from and writes to surface nodes
law, patches                    the law below the grid; B-spline patches
resolved_kernels                contacts as pressures on points, or penalty springs
point_kernels, spread_kernels   one point on one surface; forces of points spread over patches
facet_kernels                   polygons in place of circles
rigid_kernels                   bodies declared rigid
friction_kernels                Carter's creep and Coulomb's limit
sample_kernels                  what a stored sample holds
simd, lane_functions            eight lanes as one value, and functions of them
jit                             @kernel: compiled once per version of the code
"""
