"""What tests and verification hold the program against.

bearings            bearings, bodies, loads, states of the time loop
contact_states      states of contacts in all regimes
line_contact        Hertz, Johnson, Carter: line contacts, impact on a rigid flat
half_plane          stress below pressures on a half-plane
edge_contact        a disc pressed on the bare profile of a spall
free_vibration      frequencies of free discs and held rings
disc_impact         a disc thrown at a flat, by its modes
resolved_roller     a squeezed disc on a refined quadratic mesh
resolved_crossing   a roller that crosses a spall, contacts resolved, in motion
resolved_bodies     its roller and rings: meshes, surfaces
modal_bodies        elastic bodies by modes and residual compliance, contacts without friction
graded_mesh         triangles whose boundary is given point by point
triangles           meshes of what gmsh holds, their plane-strain stiffness
resolved_bearing    the paper's bearing at rest, computed independently
load_distribution   Stribeck's and Sjövall's numbers
lagrange_equations  equations of motion derived by sympy
fitted_ring         an elastic ring in a bore by exact series
rocking             exact free vibrations of rollers that stick to both raceways
polar_navier        Navier's equations of one angular harmonic, collocated
unloaded_stiffness  of a bearing that nothing loads, by statics
toy_solver          a solver of its own kind, whole

synthetic_run       trajectories with known errors, written as result files and tables
bad_scenes          scenes that must be refused
bad_files           files that must be refused
unchecked           copies of result files without checksums
recorded_disk       a disk that fails or is cut off at any write
going_on            a run that goes on from where it was kept
operation_tables    tables of speed and load
bare_system         a process as on another system than Linux
commands, compiled, run_files, live_server  entry points, loops, runs and servers that tests share
"""
