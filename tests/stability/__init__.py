"""Random scenes over everything the program accepts: each must end well, or say what is wrong. Each is a command.

__main__       campaign of random bearings, with --surfaces of their spalls and waves; tables, map of the time step
random_scenes  the draw of these scenes
campaign       how a scene ends, what is wrong with it, the worker that runs one after another
machine        random bearings in random machines, through run-fem, and judged by their files
step_limit     energy drift against time step over critical step: where the true limit is
fault_loop     every call that a command makes of its own files fails once; forked: cheap starts of commands
histories      kills, full disks, flipped bits: random histories of a run
"""
