"""What runs in the time loop: numba over plain arrays.

state                           the arrays, as named tuples: bodies, surfaces, pairs, contacts
time_loop, drive_kernels        leapfrog steps; the hub; `course_kernels`: speed and load that change; `ending`: how
                                time loops end
disc_kernels, ring_kernels      forces and motion of rollers and rings
node_kernels                    both in a step, of all bodies
surfaces                        what contacts ask of a surface: read, push, grip, sideways, push_along
disc_surface, ring_surface      the answers of elastic rollers and rings; `rigid_surfaces`: of rigid bodies
other_bodies                    what steps ask of every further body; `housing_kernels`: what carries the outer ring;
                                `support_kernels`: nodes held still; `bore_kernels`: play or a press fit;
                                `ground_dashpots`: dashpots under forces that are found after theirs
damping_kernels                 dampers of contacts; `reduced_damping`: the reduced model's; `body_damping`: of bodies
contact_kernels                 normal forces of pairs of bodies; law, patches: the law below the grid, B-spline patches
profile_kernels                 surfaces that are not perfect circles
resolved_kernels                contacts as pressures on points, or penalty springs
point_kernels, spread_kernels   one point on one surface; forces of points spread over patches
facet_kernels                   polygons in place of circles
friction_kernels                tractions of a pair, `creep` Carter's law; `friction_solution`: of all contacts together
shear_kernels                   tangential springs of contacts, in series with creep
sample_kernels                  what a stored sample holds
cage_kernels                    a cage in a step: `cage_pockets` rollers in it, `cage_guide` its guide,
                                `cage_contacts` a contact of either, `cage_state` its arrays
reduced_loop                    the reduced model's steps; `reduced_contacts` its normal forces, `reduced_kick` what
                                they give, `reduced_friction` tractions and rollers that touch each other,
                                `reduced_slopes` what surfaces that are not perfect add to both, `reduced_modes` its
                                bodies' vibrations, `reduced_radiation` what strikes lose to all others,
                                `reduced_samples` what a sample holds, `reduced_state` its arrays
lagrangian_loop                 the Lagrangian model's; likewise `lagrangian_forces`, `_state` and `_cage`
lanes, lane_functions           eight lanes as one value, and functions of them; `lane_memory`: in and out of memory
kernel_cache                    compiled kernels on disk; kernel_folder: where, and of which version of these modules
jit                             @kernel, @part, @verb, every: how all this is compiled
"""
