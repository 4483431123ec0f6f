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
resolved_bearing    the paper's bearing at rest, computed independently
load_distribution   Stribeck's and Sjövall's numbers
lagrange_equations  equations of motion derived by sympy

synthetic_run       trajectories with known errors, written as result files and tables
bad_scenes          scenes that must be refused
bad_files           files that must be refused
unchecked           copies of result files without checksums
recorded_disk       a disk that fails or is cut off at any write
"""
