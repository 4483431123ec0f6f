"""What tests and verification hold the program against.

kit                 bearings, loads, short runs, commands and files that tests share
compiled            kernels called from Python, states of contacts, runs of the Lagrangian model
forward_motion      equations of motion derived by sympy, and solved by scipy
continua            points that touch, half-planes and half-spaces, line contacts, edges, Navier's equations, Stribeck's
modes               free vibration of discs and rings, a disc thrown at a flat, rings in bores, rocking rollers: exact
quadratic           elastic bodies of quadratic triangles: a squeezed disc, a bearing at rest, a roller crossing a spall

synthetic_run, synthetic_record   trajectories and records with known errors, as files and tables
bare_system         a process as on another system than Linux
"""
