"""Records of accelerometers.

`signals` reads one, `text` and `formats` know kinds of files, `envelope` finds lines in it and `diagnosis` judges what
they say of a bearing, `width` measures a ring's damage; `synthetic` makes records whose truth is known.
"""
