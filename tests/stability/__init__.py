"""Random scenes over everything the program accepts: each must end well, or say what is wrong.

__main__   campaign of random bearings in random machines, through run-fem, judged by their files
machine    the draw of these scenes
campaign   how a scene ends, what is wrong with it
histories  kills, full disks, failing calls, flipped bits: random histories of a run
forked     both run their work by it
"""
