"""The result file.

durable                    files that appear whole or not at all
layout, store              what is in it; the file while it is written
fields, estimate_columns   what stands in it on request
surface_columns            what stands in it where surfaces are not perfect: sinkages, events, heights
earlier                    what is in its place before a run; changes: how two scenes differ
checkpoint                 the solver's state beside it
"""
