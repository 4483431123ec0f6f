"""Studies: many runs of a scene with other values, on this machine or a cluster, and what they show."""
