"""Studies: many runs of a scene with other values, on this machine or a cluster, and what they show.

study_file, parameters     the study's file and what it varies; their faults
sampling                   the points: grid, zip, Latin hypercube, Sobol sequence, list
points                     points as scenes: validated, named by digests
solving                    one point: scene -> numbers and signals
running, cluster, stuck    all points, here or by dask's workers; those that hang
folder                     what is kept on disk, so that a study can be gone on with
dataset                    the points' results as one NetCDF file
page, figures              the page of a study
"""
