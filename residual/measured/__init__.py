"""Records of accelerometers.

`formats` knows kinds of files, `signals` reads one channel of one, `diagnosis` finds lines in its envelope, judges what
they say of a bearing and measures the width of damage; `checks` makes the whole of one record, two (one of them
simulated from a scene) or a series, and writes and prints it.
"""
