"""Records of accelerometers.

`signals` reads one, `formats` knows kinds of files, `envelope` finds lines in it and `diagnosis` judges what
they say of a bearing, `strikes` measures pulses and the width of damage; `checks` and `report` make the whole of
one record or two, `simulated` the second from a scene, `trend` that of a series.
"""
