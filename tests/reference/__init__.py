"""What tests and verification hold the program against.

kit                 bearings, loads, short runs, commands and files that tests share
compiled            kernels called from Python, states of contacts, runs of the Lagrangian model, a toy solver
forward_motion      equations of motion derived by sympy, and solved by scipy
continua            half-planes and half-spaces, line contacts, edges, Navier's equations collocated, Stribeck's numbers
modes               free vibration of discs and rings, a disc thrown at a flat, rings in bores, rocking rollers
quadratic           the bearing at rest on refined quadratic meshes
resolved            a squeezed disc, and a roller that crosses a spall, with contacts resolved

synthetic_run, synthetic_record   trajectories and records with known errors, as files and tables
recorded_disk       a disk that fails or is cut off at any write
bare_system         a process as on another system than Linux
"""
