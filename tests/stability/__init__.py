"""Random scenes over everything the program accepts: each must end well, or say what is wrong.

__main__       the command `python -m tests.stability`: campaign, tables, map of the time step
campaign       one scene after another, each watched to its end
random_scenes  the draw of the scenes
random_surfaces  random scenes with spalls, waves and unequal rollers (a command, too)
step_limit     energy drift against time step over critical step: where the true limit is (a command, too)
"""
