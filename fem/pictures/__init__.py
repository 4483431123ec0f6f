"""Pictures, films and fields for other programs, from a result file.

stored_values                          a result's numbers, read guarded
recover                                displacements and loads of a stored instant
subsurface, near_contacts, peaks       stress below a contact that the mesh can't see; put into the mesh's; the largest
refine, render_bodies                  what is drawn
render, film                           off-screen pictures and films
render_bearing, render_closeup         the views
render_look, _scale, _legend, _canvas, _shapes   how they look; `surfaces`: spalls, waves, unequal rollers;
                                       `bearing`: the cage's bars
rendering_probe, own_process           whether this machine can render; a command that may crash
export                                 VTKHDF, PVD, XDMF
"""
